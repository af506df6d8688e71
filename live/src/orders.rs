//! Acknowledgements: the operator's last commands, and the robots that are known to have received each.
//!
//! Robots send nothing for them. A heartbeat holds the directive and the version vector that its robot knows, which
//! include an order to all, an added area or a mark; a robot that knows verdicts, or orders to single robots, publishes
//! them. A command that reaches a robot through others is acknowledged too, once the coordinator receives a message of
//! that robot.

use std::collections::{BTreeSet, VecDeque};

use dragnet_coordinator::mission::Record;
use dragnet_proto::command::Mark;
use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::message::{Heartbeat, OrderReport, VerdictReport};
use dragnet_proto::orders::{NumberedOrder, RobotOrder, RobotOrders};
use dragnet_proto::verdict::{Verdict, Verdicts};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::{Observation, Origin, RobotId, Source};

/// Number of commands whose acknowledgement is followed.
const MOST: usize = 5;

/// A command of the operator, as robots receive it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// An order to all robots, with its number ([`Directive::number`]).
    Team(u64, TeamOrder),
    /// An order to one robot.
    Robot(RobotId, NumberedOrder),
    /// Cells are added to the search area.
    Area(BTreeSet<Cell>),
    /// A cell is marked.
    Mark {
        /// The mark.
        mark: Mark,
        /// The cell.
        cell: Cell,
        /// The origin of its observation.
        origin: Origin,
        /// Its number there.
        sequence: u64,
    },
    /// A find is confirmed or dismissed, or that is undone.
    Verdict(Cell, Verdict),
}

/// A command, and who has it.
#[derive(Clone, Debug)]
pub struct Acknowledged {
    /// When it was given.
    pub time: MissionTime,
    /// The command.
    pub order: Order,
    /// Robots that are known to have received it.
    pub has: BTreeSet<RobotId>,
}

/// The last commands, the newest first.
#[derive(Clone, Debug, Default)]
pub struct Orders {
    last: VecDeque<Acknowledged>,
    /// What the coordinator last knew.
    directive: Directive,
    to_robots: RobotOrders,
    verdicts: Verdicts,
}

impl Order {
    /// Whether a robot is to receive it.
    #[must_use]
    pub fn concerns(&self, robot: RobotId) -> bool {
        !matches!(self, Self::Robot(whom, _) if *whom != robot)
    }
}

impl Orders {
    /// The last commands, the newest first.
    pub fn iter(&self) -> impl Iterator<Item = &Acknowledged> {
        self.last.iter()
    }

    /// What a robot is to do, as far as the coordinator knows.
    #[must_use]
    pub fn current(&self, robot: RobotId) -> RobotOrder {
        self.to_robots.current(robot, &self.directive)
    }

    /// Applies a record of the coordinator at its time.
    pub(crate) fn take(&mut self, now: MissionTime, record: &Record) {
        match record {
            Record::Status(status) => self.direct(now, &status.directive),
            Record::Observation(observation) if observation.origin.source == Source::Operator => {
                self.mark(now, observation);
            }
            Record::Verdicts(report) => self.judge(now, report),
            Record::Orders(report) => self.direct_robots(now, report),
            Record::Heartbeat(heartbeat) => self.beat(heartbeat),
            _ => {}
        }
    }

    fn give(&mut self, time: MissionTime, order: Order) {
        self.last.push_front(Acknowledged { time, order, has: BTreeSet::new() });
        self.last.truncate(MOST);
    }

    fn direct(&mut self, now: MissionTime, directive: &Directive) {
        let Directive { number, order, added } = directive;
        if directive.numbered_order() != self.directive.numbered_order() {
            self.give(now, Order::Team(*number, *order));
        }
        let new: BTreeSet<Cell> = added.difference(&self.directive.added).copied().collect();
        if !new.is_empty() {
            self.give(now, Order::Area(new));
        }
        if *directive != self.directive {
            self.directive = directive.clone();
        }
    }

    fn mark(&mut self, now: MissionTime, observation: &Observation) {
        let Observation { origin, sequence, ref readings, .. } = *observation;
        for reading in readings {
            let mark = if reading.value < 0.5 { Mark::Searched } else { Mark::Clue };
            self.give(now, Order::Mark { mark, cell: reading.cell, origin, sequence });
        }
    }

    fn judge(&mut self, now: MissionTime, report: &VerdictReport) {
        if let Participant::Robot(robot) = report.from {
            self.acknowledge(robot, |order| match order {
                Order::Verdict(cell, verdict) => report.verdicts.includes(*cell, *verdict),
                _ => false,
            });
            return;
        }
        for (cell, verdict) in report.verdicts.iter() {
            if !self.verdicts.includes(cell, verdict) {
                self.give(now, Order::Verdict(cell, verdict));
            }
        }
        self.verdicts = report.verdicts.clone();
    }

    fn direct_robots(&mut self, now: MissionTime, report: &OrderReport) {
        if let Participant::Robot(robot) = report.from {
            self.acknowledge(robot, |order| match order {
                Order::Robot(whom, order) => report.orders.includes(*whom, *order),
                _ => false,
            });
            return;
        }
        for (robot, order) in report.orders.iter() {
            if !self.to_robots.includes(robot, order) {
                self.give(now, Order::Robot(robot, order));
            }
        }
        self.to_robots = report.orders.clone();
    }

    fn beat(&mut self, heartbeat: &Heartbeat) {
        let Heartbeat { directive, versions, .. } = heartbeat;
        self.acknowledge(heartbeat.robot, |order| match order {
            // A later order takes the place of this one.
            Order::Team(number, order) => directive.numbered_order() >= (*number, *order),
            Order::Area(cells) => cells.is_subset(&directive.added),
            Order::Mark { origin, sequence, .. } => {
                versions.iter().any(|version| version.origin == *origin && version.next > *sequence)
            }
            Order::Verdict(..) | Order::Robot(..) => false,
        });
    }

    fn acknowledge(&mut self, robot: RobotId, includes: impl Fn(&Order) -> bool) {
        for last in &mut self.last {
            if !last.has.contains(&robot) && includes(&last.order) {
                last.has.insert(robot);
            }
        }
    }
}
