//! Faults of the simulated network.

use std::time::Duration;

use dragnet_search::observation::RobotId;

use super::check::{self, Invalid};
use super::file::{MemberField, NetworkTable, PartitionTable};
use crate::participant::Participant;
use crate::time::MissionTime;

/// The slowest radio, bytes per second: a robot's heartbeat takes seconds, and no plan reaches anyone in time below it.
pub(super) const MIN_BYTES_PER_SECOND: f64 = 10.0;
/// The fastest radio, bytes per second.
pub(super) const MAX_BYTES_PER_SECOND: f64 = 1e9;

/// Size of a packed plan of 300 cells, bytes.
const LONG_PLAN_BYTES: f64 = 300.0;

/// Faults of the simulated network. The default has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Network {
    /// Probability that a message to one receiver is lost, at least 0 and below 1.
    pub loss: f64,
    /// Delay of every message.
    pub delay: Duration,
    /// Maximum additional delay of a message, uniformly distributed.
    pub jitter: Duration,
    /// Probability that a message is delivered twice, at least 0 and below 1.
    pub duplication: f64,
    /// Probability that a message is delayed by `reorder_delay`, at least 0 and below 1.
    pub reorder: f64,
    /// The additional delay; above 0 if `reorder` is.
    pub reorder_delay: Duration,
    /// Rate at which each participant sends, bytes per second, 10 to 1e9;
    /// `None`: messages take no time.
    pub bytes_per_second: Option<f64>,
    /// Times at which groups are disconnected from each other.
    pub partitions: Vec<Partition>,
}

/// A time at which groups are disconnected from each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Partition {
    /// Begin, included.
    pub from: MissionTime,
    /// End, excluded; after the begin.
    pub to: MissionTime,
    /// Disjoint groups, each in order. All participants in none of them form one more group.
    pub groups: Vec<Vec<Participant>>,
}

impl Network {
    /// Whether two participants are disconnected from each other at a time.
    #[must_use]
    pub fn is_cut(&self, now: MissionTime, a: Participant, b: Participant) -> bool {
        self.partitions.iter().any(|partition| {
            (partition.from..partition.to).contains(&now) && partition.group(a) != partition.group(b)
        })
    }

    /// The time that a long plan takes over a radio; 0 without radios.
    pub(super) fn plan_time(&self) -> Duration {
        self.bytes_per_second.map_or(Duration::ZERO, |rate| Duration::from_secs_f64(LONG_PLAN_BYTES / rate))
    }

    pub(super) fn new(table: &NetworkTable, robots: u16) -> Result<Self, Invalid> {
        let reorder = check::chance("network.reorder", table.reorder)?;
        let reorder_delay = check::seconds("network.reorder_seconds", table.reorder_seconds)?;
        if reorder > 0.0 && reorder_delay.is_zero() {
            let allowed = "above 0 where network.reorder is above 0";
            return Err(Invalid::new("network.reorder_seconds", table.reorder_seconds, allowed));
        }
        Ok(Self {
            loss: check::chance("network.loss", table.loss)?,
            delay: check::seconds("network.delay_seconds", table.delay_seconds)?,
            jitter: check::seconds("network.jitter_seconds", table.jitter_seconds)?,
            duplication: check::chance("network.duplication", table.duplication)?,
            reorder,
            reorder_delay,
            bytes_per_second: table.bytes_per_second.map(rate).transpose()?,
            partitions: (0..)
                .zip(&table.partitions)
                .map(|(index, partition)| Partition::new(index, partition, robots))
                .collect::<Result<_, _>>()?,
        })
    }
}

fn rate(found: f64) -> Result<f64, Invalid> {
    check::within("network.bytes_per_second", found, MIN_BYTES_PER_SECOND, MAX_BYTES_PER_SECOND)
}

impl Partition {
    /// Index of a participant's group; of those in none, one past the last.
    fn group(&self, participant: Participant) -> usize {
        let is_member = |group: &Vec<Participant>| group.contains(&participant);
        self.groups.iter().position(is_member).unwrap_or(self.groups.len())
    }

    fn new(index: usize, table: &PartitionTable, robots: u16) -> Result<Self, Invalid> {
        let key = format!("network.partitions[{index}]");
        let from = check::seconds(format!("{key}.from_seconds"), table.from_seconds)?;
        let to = check::seconds(format!("{key}.to_seconds"), table.to_seconds)?;
        if from >= to {
            let allowed = format!("above from_seconds, {}", table.from_seconds);
            return Err(Invalid::new(format!("{key}.to_seconds"), table.to_seconds, allowed));
        }
        let groups = groups(&format!("{key}.groups"), &table.groups, robots)?;
        Ok(Self { from: MissionTime::START + from, to: MissionTime::START + to, groups })
    }
}

fn groups(key: &str, fields: &[Vec<MemberField>], robots: u16) -> Result<Vec<Vec<Participant>>, Invalid> {
    if fields.is_empty() {
        return Err(Invalid::new(key, "empty", "at least one group"));
    }
    let mut groups: Vec<Vec<Participant>> = Vec::new();
    for (index, members) in fields.iter().enumerate() {
        let mut group = Vec::new();
        for (place, field) in members.iter().enumerate() {
            let key = format!("{key}[{index}][{place}]");
            let participant = member(&key, field, robots)?;
            if group.contains(&participant) || groups.iter().any(|other| other.contains(&participant)) {
                let found = shown(field);
                return Err(Invalid::new(key, found, "each participant once in all groups"));
            }
            group.push(participant);
        }
        group.sort_unstable();
        groups.push(group);
    }
    Ok(groups)
}

fn member(key: &str, field: &MemberField, robots: u16) -> Result<Participant, Invalid> {
    let robot = |number| u16::try_from(number).ok().filter(|&number| number <= robots).and_then(RobotId::new);
    match field {
        MemberField::Robot(number) => robot(*number).map(Participant::Robot),
        MemberField::Word(word) => (word == "coordinator").then_some(Participant::Coordinator),
    }
    .ok_or_else(|| {
        let allowed = format!("a robot from 1 to {robots}, or \"coordinator\"");
        Invalid::new(key, shown(field), allowed)
    })
}

fn shown(field: &MemberField) -> String {
    match field {
        MemberField::Robot(number) => number.to_string(),
        MemberField::Word(word) => format!("{word:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_that_no_radio_has_is_reported() {
        for rate in [0.0, -1.0, 9.99, 1e-300, 1.1e9, f64::INFINITY, f64::NAN] {
            let table = NetworkTable { bytes_per_second: Some(rate), ..NetworkTable::default() };
            let error = Network::new(&table, 4).unwrap_err().to_string();
            assert!(error.starts_with("network.bytes_per_second is "), "{error}");
            assert!(error.ends_with("allowed is from 10 to 1000000000"), "{error}");
        }
        let table = NetworkTable { bytes_per_second: Some(125.0), ..NetworkTable::default() };
        assert_eq!(Network::new(&table, 4).unwrap().bytes_per_second, Some(125.0));
    }

    #[test]
    fn those_not_named_are_one_more_group_while_it_lasts() {
        let robot = |number| Participant::Robot(RobotId::new(number).unwrap());
        let table = NetworkTable {
            partitions: vec![PartitionTable {
                from_seconds: 1.0,
                to_seconds: 2.0,
                groups: vec![
                    vec![MemberField::Robot(1), MemberField::Robot(2)],
                    vec![MemberField::Word("coordinator".to_owned())],
                ],
            }],
            ..NetworkTable::default()
        };
        let network = Network::new(&table, 4).unwrap();
        let during = MissionTime(1_000_000_000);
        for (a, b, is_cut) in [
            (robot(1), robot(2), false),
            (robot(1), robot(3), true),
            (robot(3), robot(4), false),
            (robot(3), Participant::Coordinator, true),
        ] {
            assert_eq!(network.is_cut(during, a, b), is_cut, "{a:?} {b:?}");
            assert!(!network.is_cut(MissionTime(999_999_999), a, b));
            assert!(!network.is_cut(MissionTime(2_000_000_000), a, b));
        }
    }
}
