//! The simulated network between the participants, with its faults.

use std::ops::AddAssign;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::seed::{Purpose, Stream, stream};
use rand::RngExt;

use crate::faults::OneWayLoss;

/// Determines the arrival times of each message at each receiver.
pub(crate) struct Network {
    faults: dragnet_scenario::Network,
    mute: Vec<OneWayLoss>,
    random: Stream,
    tally: Tally,
}

/// Numbers of messages by outcome; a message counts once for each receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Tally {
    /// Messages sent.
    pub sent: u64,
    /// Lost by chance.
    pub lost: u64,
    /// Lost by a partition.
    pub cut: u64,
    /// Arrived twice.
    pub duplicated: u64,
    /// Delayed so that later messages overtake it.
    pub reordered: u64,
    /// Lost on a one-way link.
    pub muted: u64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.sent += other.sent;
        self.lost += other.lost;
        self.cut += other.cut;
        self.duplicated += other.duplicated;
        self.reordered += other.reordered;
        self.muted += other.muted;
    }
}

impl Network {
    pub(crate) fn new(faults: dragnet_scenario::Network, seed: u64) -> Self {
        let random = stream(seed, Purpose::Network, 0);
        Self { faults, mute: Vec::new(), random, tally: Tally::default() }
    }

    pub(crate) fn mute(&mut self, mute: Vec<OneWayLoss>) {
        self.mute = mute;
    }

    /// Stops all faults.
    pub(crate) fn heal(&mut self) {
        self.faults = dragnet_scenario::Network::default();
        self.mute.clear();
    }

    pub(crate) const fn tally(&self) -> Tally {
        self.tally
    }

    /// Arrival times of a message that is sent now: none, one or two.
    pub(crate) fn arrivals(
        &mut self,
        now: MissionTime,
        from: Participant,
        to: Participant,
    ) -> impl Iterator<Item = MissionTime> + use<> {
        let [mut first, mut second] = [None; 2];
        self.tally.sent += 1;
        if self.faults.is_cut(now, from, to) {
            self.tally.cut += 1;
        } else if self.mute.iter().any(|it| (it.from, it.to) == (from, to) && it.during.contains(&now)) {
            self.tally.muted += 1;
        } else if self.happens(self.faults.loss) {
            self.tally.lost += 1;
        } else {
            first = Some(self.arrival(now));
            if self.happens(self.faults.duplication) {
                self.tally.duplicated += 1;
                second = Some(self.arrival(now));
            }
        }
        first.into_iter().chain(second)
    }

    fn arrival(&mut self, now: MissionTime) -> MissionTime {
        let mut arrival = now + self.faults.delay;
        if !self.faults.jitter.is_zero() {
            arrival = arrival + self.faults.jitter.mul_f64(self.random.random());
        }
        if self.happens(self.faults.reorder) {
            self.tally.reordered += 1;
            arrival = arrival + self.faults.reorder_delay;
        }
        arrival
    }

    fn happens(&mut self, probability: f64) -> bool {
        probability > 0.0 && self.random.random::<f64>() < probability
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use dragnet_search::observation::RobotId;

    use super::*;

    const A: Participant = Participant::Robot(RobotId::FIRST);
    const B: Participant = Participant::Robot(RobotId::new(2).unwrap());

    fn send(faults: dragnet_scenario::Network, count: u64) -> (Network, Vec<Vec<MissionTime>>) {
        let mut network = Network::new(faults, 5);
        let arrivals = (0..count).map(|time| network.arrivals(MissionTime(time), A, B).collect()).collect();
        (network, arrivals)
    }

    #[test]
    fn a_faultless_network_delivers_at_once() {
        let (network, arrivals) = send(dragnet_scenario::Network::default(), 3);
        assert_eq!(arrivals, [[MissionTime(0)], [MissionTime(1)], [MissionTime(2)]]);
        assert_eq!(network.tally(), Tally { sent: 3, ..Tally::default() });
    }

    #[test]
    fn every_fault_comes_as_often_as_asked() {
        let faults = dragnet_scenario::Network {
            loss: 0.5,
            delay: Duration::from_secs(1),
            jitter: Duration::from_secs(1),
            duplication: 0.25,
            reorder: 0.1,
            reorder_delay: Duration::from_mins(1),
            bytes_per_second: None,
            partitions: Vec::new(),
        };
        let (mut network, arrivals) = send(faults, 10_000);
        let tally = network.tally();
        assert!((4_800..5_200).contains(&tally.lost), "{tally:?}");
        assert!((1_100..1_400).contains(&tally.duplicated), "{tally:?}");
        assert!((550..700).contains(&tally.reordered), "{tally:?}");
        assert!(arrivals.iter().flatten().all(|time| time.0 >= 1_000_000_000));
        network.heal();
        assert_eq!(network.arrivals(MissionTime(7), A, B).collect::<Vec<_>>(), [MissionTime(7)]);
    }
}
