//! Acknowledgements: the operator's last commands, and the robots that are known to have received each.
//!
//! Robots send nothing for them. A heartbeat holds the directive that its robot knows, with an order to all and added
//! areas; a robot that knows verdicts, orders to single robots, zones or marks publishes them. A command that reaches a robot through others is acknowledged too, once the coordinator receives a
//! message of that robot. A later order in the place of another acknowledges that one only if it is one of these
//! commands: robots may know an order of a later number that is older than any.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use dragnet_coordinator::mission::Record;
use dragnet_coordinator::news::{self, Given};
use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::marks::{MarkId, Marked, Marks};
use dragnet_proto::message::{Heartbeat, MarkReport, OrderReport, VerdictReport, ZoneReport};
use dragnet_proto::newest::Numbered;
use dragnet_proto::orders::{NumberedOrder, RobotOrder, RobotOrders};
use dragnet_proto::verdict::{Verdict, Verdicts};
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

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
    /// Cells are taken out of the search, or opened again.
    Zone(Numbered<Zone>, BTreeSet<Cell>),
    /// Something is marked, or the mark withdrawn.
    Mark(MarkId, Numbered<Arc<Marked>>),
    /// A find is confirmed or dismissed, or that is undone.
    Verdict(Cell, Verdict),
}

/// A command, and who has it.
#[derive(Clone, Debug)]
pub struct Acknowledged {
    /// When it was given; of one that is dated anew, the later time.
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
    has_heard: bool,
    zones: Zones,
    marks: Marks,
}

impl Order {
    /// Whether a robot is to receive it.
    #[must_use]
    pub fn concerns(&self, robot: RobotId) -> bool {
        !matches!(self, Self::Robot(whom, _) if *whom != robot)
    }

    /// Whether two orders differ in nothing but their number.
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Team(_, one), Self::Team(_, other)) => one == other,
            (Self::Zone(one, some), Self::Zone(other, cells)) => one.value == other.value && some == cells,
            (Self::Robot(robot, one), Self::Robot(whom, other)) => robot == whom && one.value == other.value,
            _ => false,
        }
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

    /// Whether an order to all robots is in effect: giving it again changes nothing. Of robots that were never heard only
    /// orders are known that were given here.
    #[must_use]
    pub fn is_given_to_all(&self, order: TeamOrder) -> bool {
        let Directive { number, order: last, .. } = self.directive;
        last == order && self.to_robots.newest() <= number && (number > 0 || self.has_heard)
    }

    /// The same of an order to one robot.
    #[must_use]
    pub fn is_given(&self, robot: RobotId, order: RobotOrder) -> bool {
        let is_own = self.to_robots.of(robot).is_some();
        self.current(robot) == order && (is_own || self.directive.number > 0 || self.has_heard)
    }

    /// Applies a record of the coordinator at its time.
    pub(crate) fn take(&mut self, now: MissionTime, record: &Record) {
        match record {
            Record::Status(status) => self.direct(now, &status.directive),
            Record::Verdicts(report) => self.judge(now, report),
            Record::Orders(report) => self.direct_robots(now, report),
            Record::Zones(report) => self.zone(now, report),
            Record::Marks(report) => self.mark(now, report),
            Record::Heartbeat(heartbeat) => self.beat(heartbeat),
            _ => {}
        }
    }

    fn list(&mut self, now: MissionTime, given: Given, order: Order) {
        let has = BTreeSet::new();
        match given {
            Given::Now => self.last.push_front(Acknowledged { time: now, order, has }),
            Given::Before(time) => {
                let place = self.last.iter().position(|later| later.time <= time).unwrap_or(self.last.len());
                self.last.insert(place, Acknowledged { time, order, has });
            }
            Given::Anew(time) => {
                if let Some(known) = self.last.iter_mut().find(|known| known.order.is_same(&order)) {
                    *known = Acknowledged { time, order, has };
                }
            }
        }
        self.last.truncate(MOST);
    }

    fn direct(&mut self, now: MissionTime, directive: &Directive) {
        let Directive { number, order, added } = directive;
        if let Some(given) = news::to_all(self.directive.numbered_order(), directive, now) {
            self.list(now, given, Order::Team(*number, *order));
        }
        let new: BTreeSet<Cell> = added.difference(&self.directive.added).copied().collect();
        if !new.is_empty() {
            // When others were added is not known.
            self.list(now, Given::Now, Order::Area(new));
        }
        if *directive != self.directive {
            self.directive = directive.clone();
        }
    }

    fn mark(&mut self, now: MissionTime, report: &MarkReport) {
        if let Participant::Robot(robot) = report.from {
            self.acknowledge(robot, |order| match order {
                Order::Mark(id, entry) => report.marks.includes(*id, entry),
                _ => false,
            });
            return;
        }
        let before = std::mem::replace(&mut self.marks, report.marks.clone());
        for (id, entry, given) in news::marks(&before, &report.marks, now) {
            self.list(now, given, Order::Mark(id, entry));
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
        let before = std::mem::replace(&mut self.verdicts, report.verdicts.clone());
        for (cell, verdict, given) in news::verdicts(&before, &report.verdicts, now) {
            self.list(now, given, Order::Verdict(cell, verdict));
        }
    }

    fn direct_robots(&mut self, now: MissionTime, report: &OrderReport) {
        if let Participant::Robot(robot) = report.from {
            let mut known: Vec<(RobotId, NumberedOrder)> = report.orders.iter().collect();
            known.retain(|&(whom, order)| self.lists(&Order::Robot(whom, order)));
            self.acknowledge(robot, |order| match order {
                Order::Robot(whom, order) => known.iter().any(|known| known.0 == *whom && known.1 >= *order),
                _ => false,
            });
            return;
        }
        let before = std::mem::replace(&mut self.to_robots, report.orders.clone());
        for (robot, order, given) in news::to_robots(&before, &report.orders, now) {
            self.list(now, given, Order::Robot(robot, order));
        }
    }

    fn zone(&mut self, now: MissionTime, report: &ZoneReport) {
        if let Participant::Robot(robot) = report.from {
            self.acknowledge(robot, |order| match order {
                Order::Zone(zone, cells) => cells.iter().all(|&cell| report.zones.includes(cell, zone)),
                _ => false,
            });
            return;
        }
        let before = std::mem::replace(&mut self.zones, report.zones.clone());
        for (zone, cells, given) in news::zones(&before, &report.zones, now) {
            self.list(now, given, Order::Zone(zone, cells));
        }
    }

    fn beat(&mut self, heartbeat: &Heartbeat) {
        let directive = &heartbeat.directive;
        self.has_heard = true;
        let known = directive.numbered_order();
        let is_listed = self.lists(&Order::Team(known.0, known.1));
        self.acknowledge(heartbeat.robot, |order| match order {
            Order::Team(number, order) => is_listed && known >= (*number, *order),
            Order::Area(cells) => cells.is_subset(&directive.added),
            Order::Verdict(..) | Order::Robot(..) | Order::Zone(..) | Order::Mark(..) => false,
        });
    }

    fn lists(&self, order: &Order) -> bool {
        self.last.iter().any(|known| known.order == *order)
    }

    fn acknowledge(&mut self, robot: RobotId, includes: impl Fn(&Order) -> bool) {
        for last in &mut self.last {
            if !last.has.contains(&robot) && includes(&last.order) {
                last.has.insert(robot);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::time::Duration;

    use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
    use dragnet_proto::command::Command;
    use dragnet_proto::message::{Activity, Intent, Message};
    use dragnet_proto::state_machine::Event;
    use dragnet_proto::verdict::Decision;
    use dragnet_scenario::Scenario;
    use dragnet_search::evidence::Digest;

    use super::*;

    const ONE: RobotId = RobotId::FIRST;
    const TWO: RobotId = RobotId::new(2).unwrap();

    /// A coordinator, and the commands that its page lists.
    struct Desk {
        cell: Cell,
        mission: Mission,
        orders: Orders,
    }

    impl Desk {
        fn new() -> Self {
            let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 2, columns = 4 }\nrobots.count = 2\n\
                        objects.count = 1\nsensor.radius = 2\nmission.budget_seconds = 900.0\n";
            let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
            Self {
                cell: scenario.terrain().grid().cell_numbered(5).unwrap(),
                mission: Mission::new(CoordinatorConfig::of(&scenario)),
                orders: Orders::default(),
            }
        }

        fn step(&mut self, seconds: u64, event: Event<Message>) {
            for record in self.mission.react(at(seconds), event).records {
                self.orders.take(at(seconds), &record);
            }
        }

        fn command(&mut self, seconds: u64, command: Command) {
            self.step(seconds, Event::Commanded(command));
        }

        fn beat(&mut self, seconds: u64, robot: RobotId, order: (u64, TeamOrder)) {
            let (time_ns, cell) = (at(seconds).0, self.cell);
            let intent = Intent { robot, incarnation: 0, decision: 1, time_ns, path: Vec::new().into() };
            let message = Message::Heartbeat(Heartbeat {
                robot,
                time_ns,
                activity: Activity::Paused,
                cell,
                path_meters: 0.0,
                intent,
                versions: Vec::new().into(),
                digest: Digest(0),
                directive: Directive { number: order.0, order: order.1, added: BTreeSet::new() },
            });
            self.step(seconds, Event::Received { from: Participant::Robot(robot), message });
        }

        fn report(&mut self, seconds: u64, robot: RobotId, orders: &[(RobotId, u64, RobotOrder)]) {
            let orders =
                orders.iter().map(|&(to, number, order)| (to, NumberedOrder { number, value: order }));
            let (from, orders) = (Participant::Robot(robot), orders.collect());
            let message = Message::Orders(OrderReport { from, time_ns: at(seconds).0, orders });
            self.step(seconds, Event::Received { from, message });
        }

        /// Times, seconds, and robots that have it.
        fn listed(&self) -> Vec<(f64, Vec<RobotId>)> {
            self.orders
                .iter()
                .map(|it| (it.time.as_seconds().floor(), it.has.iter().copied().collect()))
                .collect()
        }
    }

    fn at(seconds: u64) -> MissionTime {
        MissionTime::START + Duration::from_secs(seconds)
    }

    #[test]
    fn an_order_of_a_young_clock_is_not_acknowledged_by_an_older_one() {
        let mut desk = Desk::new();
        desk.command(3, Command::Team(TeamOrder::Pause));
        assert_eq!(desk.listed(), [(3.0, vec![])]);
        desk.beat(200, ONE, (at(100).0, TeamOrder::Search));
        assert_eq!(desk.listed(), [(100.0, vec![])], "the same entry, dated anew");
        desk.beat(201, TWO, (at(3).0, TeamOrder::Pause));
        desk.beat(202, TWO, (at(100).0, TeamOrder::Search));
        assert_eq!(desk.listed(), [(100.0, vec![])]);
        desk.beat(203, ONE, (at(100).0 + 1, TeamOrder::Pause));
        assert_eq!(desk.listed(), [(100.0, vec![ONE])]);
        desk.command(210, Command::Team(TeamOrder::Search));
        desk.beat(211, TWO, (at(210).0, TeamOrder::Search));
        assert_eq!(desk.listed(), [(210.0, vec![TWO]), (100.0, vec![ONE, TWO])], "it has a later order");
    }

    #[test]
    fn an_order_to_a_robot_by_a_young_clock_is_not_acknowledged_by_an_older_one() {
        let mut desk = Desk::new();
        desk.command(3, Command::Robot(ONE, RobotOrder::Pause));
        desk.report(200, ONE, &[(ONE, at(100).0, RobotOrder::Return)]);
        assert_eq!(desk.listed(), [(100.0, vec![])], "the same entry, dated anew");
        desk.report(201, ONE, &[(ONE, at(100).0 + 1, RobotOrder::Pause)]);
        assert_eq!(desk.listed(), [(100.0, vec![ONE])]);
    }

    #[test]
    fn what_robots_knew_before_is_listed_with_its_own_time() {
        let mut before = Desk::new();
        before.command(130, Command::Judge(Decision::Confirmed, before.cell));
        let mut desk = Desk::new();
        desk.beat(200, ONE, (at(120).0, TeamOrder::Pause));
        desk.command(205, Command::Robot(TWO, RobotOrder::Search));
        let verdicts = before.mission.verdicts().clone();
        let message =
            Message::Verdicts(VerdictReport { from: Participant::Robot(ONE), time_ns: at(209).0, verdicts });
        desk.step(209, Event::Received { from: Participant::Robot(ONE), message });
        desk.report(210, ONE, &[(ONE, at(110).0, RobotOrder::Return)]);
        let times: Vec<f64> = desk.listed().into_iter().map(|(time, _)| time).collect();
        assert_eq!(times, [205.0, 130.0, 120.0, 110.0], "the newest first");
    }

    #[test]
    fn an_order_is_in_effect_if_it_was_given_or_robots_were_heard() {
        let mut desk = Desk::new();
        let given = |desk: &Desk, order: TeamOrder| {
            (desk.orders.is_given_to_all(order), desk.orders.is_given(TWO, order.into()))
        };
        assert_eq!(given(&desk, TeamOrder::Search), (false, false), "robots may know a pause");
        desk.command(3, Command::Robot(TWO, RobotOrder::Search));
        assert_eq!(given(&desk, TeamOrder::Search), (false, true));
        desk.command(4, Command::Team(TeamOrder::Search));
        assert_eq!(given(&desk, TeamOrder::Search), (true, true));
        desk.command(5, Command::Robot(TWO, RobotOrder::Pause));
        assert_eq!(given(&desk, TeamOrder::Search), (false, false));
        assert_eq!(given(&desk, TeamOrder::Pause), (false, true));
    }
}
