//! The battery's charge, as far as it can be believed.

use std::collections::BTreeMap;

/// Change between two readings that no battery makes, percent.
const MAX_STEP_PERCENT: i16 = 20;
/// Time after which readings that agree count again, nanoseconds.
const SETTLED_NS: u64 = 5_000_000_000;
/// Maximum number of batteries.
const MAX_BATTERIES: usize = 16;

/// The batteries of a vehicle, by number.
#[derive(Clone, Debug, Default)]
pub struct Batteries {
    charges: BTreeMap<u8, Charge>,
}

#[derive(Clone, Copy, Debug)]
struct Charge {
    /// The last charge that was believed, percent.
    percent: i16,
    /// The first and the last of readings that contradict it and agree with each other, and since when.
    other: Option<(i16, u64)>,
}

impl Batteries {
    /// A reading, percent; -1 is none.
    ///
    /// # Errors
    /// If no battery can have it: what is wrong.
    pub fn read(&mut self, now_ns: u64, number: u8, percent: i8) -> Result<(), String> {
        let percent = i16::from(percent);
        if percent == -1 {
            return Ok(());
        }
        if !(0..=100).contains(&percent) {
            return Err(format!("battery {number} is at {percent} %; allowed is 0 to 100, or -1 if unknown"));
        }
        if !self.charges.contains_key(&number) && self.charges.len() == MAX_BATTERIES {
            return Err(format!("battery {number} is one too many; allowed are {MAX_BATTERIES}"));
        }
        let charge = self.charges.entry(number).or_insert(Charge { percent, other: None });
        let before = charge.percent;
        if (percent - before).abs() <= MAX_STEP_PERCENT {
            *charge = Charge { percent, other: None };
            return Ok(());
        }
        let agreeing = charge.other.filter(|(last, _)| (percent - last).abs() <= MAX_STEP_PERCENT);
        let since_ns = agreeing.map_or(now_ns, |(_, since_ns)| since_ns);
        if now_ns.saturating_sub(since_ns) >= SETTLED_NS {
            *charge = Charge { percent, other: None };
            return Ok(());
        }
        charge.other = Some((percent, since_ns));
        Err(format!("battery {number} jumps from {before} to {percent} %"))
    }

    /// The lowest charge, percent, if any is known.
    #[must_use]
    pub fn lowest_percent(&self) -> Option<i16> {
        self.charges.values().map(|charge| charge.percent).min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mentions::assert_mentions;

    #[test]
    fn charges_that_jump_count_only_when_they_stay() {
        let mut batteries = Batteries::default();
        let mut read = |seconds: u64, percent: i8| {
            let result = batteries.read(seconds * 1_000_000_000, 0, percent);
            (result.err().unwrap_or_default(), batteries.lowest_percent())
        };
        assert_eq!(read(0, -1), (String::new(), None));
        assert_eq!(read(1, 80), (String::new(), Some(80)));
        let (reason, lowest) = read(2, 12);
        assert_mentions(&reason, "battery 0 jumps from 80 to 12 %");
        assert_eq!(lowest, Some(80));
        assert_eq!(read(3, 79), (String::new(), Some(79)));
        assert_mentions(&read(4, 120).0, "120 % .. 0 to 100");
        for second in 5..10 {
            assert_eq!(read(second, 13).1, Some(79), "{second}");
        }
        assert_eq!(read(10, 13), (String::new(), Some(13)));
    }
}
