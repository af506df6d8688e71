//! The autopilot's clock, which counts from its boot: when its messages were true, which of them are late, and reboots.

use std::collections::BTreeMap;

/// How far a stamp may lie behind the latest of a message that was overtaken, milliseconds.
const MAX_LATE_MS: u32 = 5000;
/// How fast the smallest delay is forgotten, nanoseconds a second: clocks drift by less.
const FORGOTTEN_NS_PER_SECOND: u64 = 200_000;
/// Time within which a second and a third reboot are those of another autopilot, nanoseconds.
const TWINS_NS: u64 = 10_000_000_000;
/// Reboots within that time that mean two autopilots.
const TWINS: usize = 3;

/// The clock of an autopilot.
#[derive(Clone, Debug, Default)]
pub(super) struct BootClock {
    latest_ms: Option<u32>,
    /// The latest stamp of each kind of message: an attitude may be newer than a position that is sent after it.
    latest_by_kind_ms: BTreeMap<u32, u32>,
    /// Time of boot by the caller's clock, by the message with the smallest delay.
    boot_ns: i128,
    /// When that was last adjusted.
    adjusted_ns: u64,
    /// The latest time that was returned.
    returned_ns: u64,
    /// The last reboots.
    reboots_ns: Vec<u64>,
}

/// What a stamp says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stamped {
    /// The message was true then, nanoseconds of the caller's time, and is newer than all before it.
    New(u64),
    /// A newer one came before it.
    Late,
    /// The autopilot has started again; the message was true at this time.
    Rebooted(u64),
}

impl BootClock {
    /// A message of a kind arrives that is stamped with milliseconds since boot.
    pub(super) fn read(&mut self, now_ns: u64, kind: u32, stamp_ms: u32) -> Stamped {
        if self.latest_ms.is_some_and(|latest| latest.saturating_sub(stamp_ms) > MAX_LATE_MS) {
            self.reboots_ns.retain(|&reboot_ns| now_ns.saturating_sub(reboot_ns) < TWINS_NS);
            if self.reboots_ns.len() < TWINS {
                self.reboots_ns.push(now_ns);
            }
            self.latest_ms = None;
            self.latest_by_kind_ms = BTreeMap::from([(kind, stamp_ms)]);
            return Stamped::Rebooted(self.time_ns(now_ns, stamp_ms));
        }
        let latest = self.latest_by_kind_ms.entry(kind).or_insert(0);
        if stamp_ms <= *latest && *latest > 0 {
            return Stamped::Late;
        }
        *latest = stamp_ms;
        Stamped::New(self.time_ns(now_ns, stamp_ms))
    }

    /// Milliseconds since boot, by the last message.
    pub(super) fn latest_ms(&self) -> u32 {
        self.latest_ms.unwrap_or(0)
    }

    /// Whether the stamps go back and forth, as those of two autopilots do.
    pub(super) fn has_twin(&self, now_ns: u64) -> bool {
        let is_recent = |&&reboot_ns: &&u64| now_ns.saturating_sub(reboot_ns) < TWINS_NS;
        self.reboots_ns.iter().filter(is_recent).count() >= TWINS
    }

    /// Messages wait on their way, so that the earliest arrival relative to its stamp is nearest to the truth.
    fn time_ns(&mut self, now_ns: u64, stamp_ms: u32) -> u64 {
        let since_boot_ns = i128::from(stamp_ms) * 1_000_000;
        let boot_ns = i128::from(now_ns) - since_boot_ns;
        let passed_ns = now_ns.saturating_sub(self.adjusted_ns);
        let forgotten_ns = i128::from(passed_ns / 1_000_000 * FORGOTTEN_NS_PER_SECOND / 1000);
        self.boot_ns = match self.latest_ms {
            Some(_) => boot_ns.min(self.boot_ns + forgotten_ns),
            None => boot_ns,
        };
        self.adjusted_ns = now_ns;
        self.latest_ms = self.latest_ms.max(Some(stamp_ms));
        let time_ns = u64::try_from(self.boot_ns + since_boot_ns).unwrap_or(0).min(now_ns);
        // A smaller delay than all before must not turn time back.
        self.returned_ns = time_ns.max(self.returned_ns);
        self.returned_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn delays_that_vary_do_not_move_the_time_of_messages() {
        let mut clock = BootClock::default();
        let mut stamped = Vec::new();
        for (number, delay_ms) in [30, 5, 80, 6, 40, 5].into_iter().enumerate() {
            let stamp_ms = 60_000 + 100 * u32::try_from(number).unwrap();
            let sent_ns = 1000 * MS + 100 * MS * number as u64;
            stamped.push(clock.read(sent_ns + delay_ms * MS, 33, stamp_ms));
        }
        let times: Vec<u64> = stamped
            .into_iter()
            .map(|stamped| match stamped {
                Stamped::New(time_ns) => time_ns / MS,
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(times, [1030, 1105, 1205, 1305, 1405, 1505]);
    }

    #[test]
    fn messages_that_were_overtaken_are_late_and_a_reboot_is_none() {
        let mut clock = BootClock::default();
        assert_eq!(clock.read(10 * MS, 33, 60_000), Stamped::New(10 * MS));
        assert_eq!(clock.read(20 * MS, 33, 59_900), Stamped::Late);
        assert_eq!(clock.read(20 * MS, 33, 60_000), Stamped::Late, "repeated");
        // Of another kind it is the newest; time does not turn back for it.
        assert_eq!(clock.read(20 * MS, 30, 59_990), Stamped::New(10 * MS));
        assert_eq!(clock.read(4000 * MS, 33, 1000), Stamped::Rebooted(4000 * MS));
        assert_eq!(clock.read(4100 * MS, 33, 1100), Stamped::New(4100 * MS));
        assert!(!clock.has_twin(4100 * MS));
    }

    #[test]
    fn two_autopilots_are_not_one_that_reboots() {
        let mut clock = BootClock::default();
        for number in 0..10 {
            let now_ns = number * 100 * MS;
            clock.read(now_ns, 33, if number % 2 == 0 { 900_000 } else { 10_000 });
        }
        assert!(clock.has_twin(1000 * MS));
        assert!(!clock.has_twin(12_000 * MS));
    }
}
