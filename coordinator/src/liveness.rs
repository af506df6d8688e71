//! Liveness: determines which robots are alive and which are lost.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;

/// The presence of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// It belongs to the team, and no message of it has arrived yet.
    Awaited,
    /// Its messages arrive.
    Alive {
        /// When the last message arrived.
        last_received: MissionTime,
    },
    /// It has left the network, or was silent for too long.
    Lost {
        /// When that was detected.
        since: MissionTime,
    },
}

/// The robots of the team, and all others that messages have arrived from.
#[derive(Clone, Debug)]
pub struct Liveness {
    lost_after: Duration,
    robots: BTreeMap<RobotId, Presence>,
}

impl Liveness {
    /// A team of these robots. A robot that is silent for longer than `lost_after` is lost.
    #[must_use]
    pub fn new(robots: impl IntoIterator<Item = RobotId>, lost_after: Duration) -> Self {
        let robots = robots.into_iter().map(|robot| (robot, Presence::Awaited)).collect();
        Self { lost_after, robots }
    }

    /// Records that a message of a robot has arrived; returns whether the robot was not alive before.
    pub fn received(&mut self, now: MissionTime, robot: RobotId) -> bool {
        let presence = self.robots.entry(robot).or_insert(Presence::Awaited);
        let was_alive = matches!(presence, Presence::Alive { .. });
        *presence = Presence::Alive { last_received: now };
        !was_alive
    }

    /// Records that a robot has left the network; returns whether it was alive before.
    pub fn left(&mut self, now: MissionTime, robot: RobotId) -> bool {
        match self.robots.get_mut(&robot) {
            Some(presence @ Presence::Alive { .. }) => {
                *presence = Presence::Lost { since: now };
                true
            }
            _ => false,
        }
    }

    /// Marks the robots that have been silent for too long as lost, and returns them.
    pub fn lose_silent(&mut self, now: MissionTime) -> Vec<RobotId> {
        let mut lost = Vec::new();
        for (&robot, presence) in &mut self.robots {
            if let Presence::Alive { last_received } = *presence
                && now > last_received + self.lost_after
            {
                *presence = Presence::Lost { since: now };
                lost.push(robot);
            }
        }
        lost
    }

    /// Robots that are alive, by number.
    pub fn alive(&self) -> impl Iterator<Item = RobotId> + '_ {
        let alive = self.robots.iter().filter(|(_, presence)| matches!(presence, Presence::Alive { .. }));
        alive.map(|(&robot, _)| robot)
    }

    /// Every robot of the team, and others that messages have arrived from, by number.
    pub fn robots(&self) -> impl Iterator<Item = (RobotId, Presence)> + '_ {
        self.robots.iter().map(|(&robot, &presence)| (robot, presence))
    }
}

/// `robot 3`, or `robots 1, 4 to 17`: ascending numbers, with runs of more than two in short.
#[must_use]
pub fn named(robots: &[RobotId]) -> String {
    let numbers: Vec<u16> = robots.iter().map(|robot| robot.number()).collect();
    let runs = numbers.chunk_by(|one, next| one + 1 == *next).map(|run| match run {
        [first, _, .., last] => format!("{first} to {last}"),
        _ => run.iter().map(u16::to_string).collect::<Vec<_>>().join(", "),
    });
    let plural = if numbers.len() == 1 { "" } else { "s" };
    format!("robot{plural} {}", runs.collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: RobotId = RobotId::FIRST;
    const PATIENCE: Duration = Duration::from_secs(10);

    fn at(seconds: u64) -> MissionTime {
        MissionTime::START + Duration::from_secs(seconds)
    }

    #[test]
    fn a_robot_is_awaited_alive_lost_in_silence_and_returns() {
        let mut liveness = Liveness::new([ONE], PATIENCE);
        let mut check = |act: fn(&mut Liveness) -> bool, expected: Presence| {
            assert!(act(&mut liveness), "no change to {expected:?}");
            assert_eq!(liveness.robots().collect::<Vec<_>>(), [(ONE, expected)]);
        };
        check(|liveness| liveness.lose_silent(at(100)).is_empty(), Presence::Awaited);
        check(|liveness| liveness.received(at(101), ONE), Presence::Alive { last_received: at(101) });
        check(|liveness| !liveness.received(at(102), ONE), Presence::Alive { last_received: at(102) });
        check(
            |liveness| liveness.lose_silent(at(112)).is_empty(),
            Presence::Alive { last_received: at(102) },
        );
        check(|liveness| liveness.lose_silent(at(113)) == [ONE], Presence::Lost { since: at(113) });
        check(|liveness| liveness.lose_silent(at(114)).is_empty(), Presence::Lost { since: at(113) });
        check(|liveness| liveness.received(at(115), ONE), Presence::Alive { last_received: at(115) });
        check(|liveness| liveness.left(at(116), ONE), Presence::Lost { since: at(116) });
        check(|liveness| !liveness.left(at(117), ONE), Presence::Lost { since: at(116) });
    }

    #[test]
    fn an_unannounced_robot_counts_once_a_message_arrives() {
        let mut liveness = Liveness::new([ONE], PATIENCE);
        assert!(!liveness.left(at(0), RobotId::new(7).unwrap()));
        assert!(liveness.received(at(0), RobotId::new(7).unwrap()));
        assert_eq!(liveness.alive().collect::<Vec<_>>(), [RobotId::new(7).unwrap()]);
    }
}
