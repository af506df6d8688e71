//! Logs the decisions, finds and declarations of a participant, a line each.

mod ending;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use dragnet_coordinator::finds::of_subject;
use dragnet_coordinator::news::{self, Given};
use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::marks::{Marked, Marks};
use dragnet_proto::message::{Activity, Detection, Heartbeat, Message, MissionStatus};
use dragnet_proto::newest::Numbered;
use dragnet_proto::orders::{NumberedOrder, RobotOrder, RobotOrders};
use dragnet_proto::state_machine::{Effects, Standstill, StateMachine};
use dragnet_proto::verdict::{Decision, Verdict, Verdicts};
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::Places;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Observation, RobotId, Source};

use self::ending::Ending;

/// Logs the actions of one participant.
pub(crate) struct Narrator {
    me: Participant,
    places: Places,
    /// Whether the number of objects is known.
    is_of_subjects: bool,
    /// What the coordinator has declared last.
    declared: Vec<Detection>,
    /// Positions of objects, as far as robots knew them when they were told.
    positions: BTreeMap<Cell, ObjectPosition>,
    /// Cells in which a robot has found an object, or the coordinator has declared one.
    found: BTreeSet<Cell>,
    /// The operator's verdicts that the coordinator has published.
    verdicts: Verdicts,
    /// The operator's order to all robots that the coordinator has published, with its number.
    order: (u64, TeamOrder),
    /// Cells that the operator has added to the search area, as the coordinator has published them.
    added: BTreeSet<Cell>,
    /// The operator's orders to single robots that the coordinator has published.
    orders: RobotOrders,
    /// The operator's zones that the coordinator has published.
    zones: Zones,
    /// The operator's marks that the coordinator has published.
    marks: Marks,
    /// The last activity of each robot that the coordinator received.
    ending: Ending,
    /// Robots that stand, as the coordinator has told.
    standing: BTreeSet<RobotId>,
}

impl Narrator {
    pub(crate) fn new(me: Participant, places: Places) -> Self {
        Self {
            me,
            is_of_subjects: places.is_of_subjects(),
            places,
            declared: Vec::new(),
            positions: BTreeMap::new(),
            found: BTreeSet::new(),
            verdicts: Verdicts::default(),
            order: (0, TeamOrder::Search),
            added: BTreeSet::new(),
            orders: RobotOrders::default(),
            zones: Zones::default(),
            marks: Marks::default(),
            ending: Ending::default(),
            standing: BTreeSet::new(),
        }
    }

    /// Handles the activity of a robot: the coordinator logs once that all robots rest, or that the search waits for the
    /// operator.
    pub(crate) fn receive(&mut self, machine: &dyn StateMachine, heartbeat: &Heartbeat) {
        self.ending.receive(heartbeat.robot, heartbeat.activity);
        self.tell_end(machine);
    }

    /// A robot is here.
    pub(crate) fn expect(&mut self, robot: RobotId) {
        self.ending.expect(robot);
    }

    /// A robot has left; returns what the coordinator logs of one that was not done, and was last in a cell.
    pub(crate) fn lose(
        &mut self,
        machine: &dyn StateMachine,
        robot: RobotId,
        last: Option<Cell>,
    ) -> Option<String> {
        let was_busy = self.ending.lose(robot).is_some_and(|activity| !activity.is_rest());
        self.tell_end(machine);
        let last = last.filter(|_| was_busy && self.me == Participant::Coordinator)?;
        let place = self.places.on_earth(last);
        Some(format!(
            "robot {robot} is lost: it has left before its search was over, and was last in {place}"
        ))
    }

    fn tell_end(&mut self, machine: &dyn StateMachine) {
        for line in self.end(machine) {
            tracing::info!("{line}");
        }
    }

    fn end(&mut self, machine: &dyn StateMachine) -> Vec<String> {
        if self.me != Participant::Coordinator {
            return Vec::new();
        }
        let done = self.ending.rests().map(|rest| self.done(machine, &rest));
        done.into_iter().chain(self.ending.waits()).collect()
    }

    fn done(&self, machine: &dyn StateMachine, rest: &str) -> String {
        let (objects, by_hand) = (self.found.len(), self.by_hand());
        let mut parts = vec![format!("done: {rest}; objects declared: {objects}{by_hand}")];
        parts.extend(machine.left().map(|left| left.to_string()));
        if self.is_of_subjects {
            parts.extend(self.declared.iter().map(|object| self.find(object)));
        }
        parts.join("; ")
    }

    /// A declared find of a subject.
    fn find(&self, object: &Detection) -> String {
        let operator = self.verdicts.decision(object.cell);
        of_subject(&self.place(object.cell), object.probability, operator)
    }

    /// Where the object of a cell is.
    fn place(&self, cell: Cell) -> String {
        self.places.object(cell, self.positions.get(&cell))
    }

    /// Takes the positions of the objects of cells.
    fn locate(&mut self, machine: &dyn StateMachine, cells: impl IntoIterator<Item = Cell>) {
        let known = cells.into_iter().filter_map(|cell| Some((cell, *machine.position(cell)?)));
        self.positions.extend(known);
    }

    /// Numbers of declared objects that the operator has confirmed, and of others that were dismissed.
    fn by_hand(&self) -> String {
        let count = |decision, is_declared| {
            let decided = self.verdicts.iter().filter(|(_, verdict)| verdict.decision == decision);
            decided.filter(|(cell, _)| self.found.contains(cell) == is_declared).count()
        };
        let (confirmed, dismissed) = (count(Decision::Confirmed, true), count(Decision::Dismissed, false));
        let confirmed = (confirmed > 0).then(|| format!(", of them {confirmed} confirmed by hand"));
        let dismissed = (dismissed > 0).then(|| format!("; {dismissed} dismissed"));
        [confirmed, dismissed].into_iter().flatten().collect()
    }

    /// Logs the effects of the last event of a state machine.
    pub(crate) fn tell(&mut self, machine: &dyn StateMachine, effects: &Effects<Message>) {
        for line in self.lines(machine, effects) {
            tracing::info!("{} {line}", self.me);
        }
        for line in self.orders(machine, effects) {
            tracing::info!("{line}");
        }
        let [stand, go_on] = self.standstills(&machine.standstills());
        for line in stand {
            tracing::warn!("{line}");
        }
        for line in go_on {
            tracing::info!("{line}");
        }
    }

    /// That robots enter no cell, and that this is over.
    fn standstills(&mut self, now: &[Standstill]) -> [Vec<String>; 2] {
        let before = std::mem::replace(&mut self.standing, now.iter().map(|it| it.robot).collect());
        let new = now.iter().filter(|it| !before.contains(&it.robot)).map(|it| {
            let (robot, seconds, place) = (it.robot, it.lasts.as_secs(), self.places.on_earth(it.cell));
            format!("robot {robot} has entered no cell for {seconds} s and is in {place}: see that nothing is in its way")
        });
        let over = before.difference(&self.standing);
        [
            new.collect(),
            over.map(|robot| format!("robot {robot} goes on, or is to stay where it is")).collect(),
        ]
    }

    /// What this participant does.
    fn lines(&mut self, machine: &dyn StateMachine, effects: &Effects<Message>) -> Vec<String> {
        let mut lines = match self.me {
            Participant::Robot(robot) => self.finds(robot, machine, &effects.kept),
            // It stores observations to record them, and declares finds.
            Participant::Coordinator => Vec::new(),
        };
        let statuses = effects.published.iter().filter_map(|(_, message)| match message {
            Message::MissionStatus(status) => Some(status),
            _ => None,
        });
        for status in statuses {
            self.locate(machine, status.declared.iter().map(|object| object.cell));
            lines.extend(self.declares(status));
        }
        lines.extend(self.decides(effects));
        lines
    }

    /// What the operator wants, as the coordinator publishes it, and what that waits for.
    fn orders(&mut self, machine: &dyn StateMachine, effects: &Effects<Message>) -> Vec<String> {
        let mut lines: Vec<String> = self.ending.awaits(machine.awaited()).into_iter().collect();
        for (_, message) in &effects.published {
            match message {
                Message::MissionStatus(status) => {
                    lines.extend(self.orders_all(MissionTime(status.time_ns), &status.directive));
                    lines.extend(news::added(&mut self.added, &status.directive, &self.places));
                }
                Message::Verdicts(report) if self.me == Participant::Coordinator => {
                    lines.extend(self.judges(MissionTime(report.time_ns), &report.verdicts));
                }
                Message::Orders(report) if self.me == Participant::Coordinator => {
                    lines.extend(self.orders_robots(MissionTime(report.time_ns), &report.orders));
                }
                Message::Zones(report) if self.me == Participant::Coordinator => {
                    lines.extend(self.closes(MissionTime(report.time_ns), &report.zones));
                }
                Message::Marks(report) if self.me == Participant::Coordinator => {
                    lines.extend(self.marks(MissionTime(report.time_ns), &report.marks));
                }
                _ => {}
            }
        }
        lines
    }

    fn decides(&self, effects: &Effects<Message>) -> Option<String> {
        let route = effects.route.as_ref()?;
        let Some(&waypoint) = route.last() else {
            let what = match effects.activity {
                Activity::Waiting => "waiting",
                Activity::Holding => "holding",
                Activity::Paused => "paused",
                activity if activity.is_rest() => "resting",
                _ => "staying",
            };
            return Some(format!("{what}: {}", effects.activity.reason()));
        };
        match effects.activity {
            Activity::Returning => {
                return Some(format!("returning to its base at {}", self.places.cell(waypoint)));
            }
            Activity::Sent => return Some(format!("sent to {}", self.places.cell(waypoint))),
            Activity::GivingWay => {
                return Some(format!("making way for its teammates, to {}", self.places.cell(waypoint)));
            }
            Activity::Leaving => {
                return Some(format!("leaving a no-go zone, to {}", self.places.cell(waypoint)));
            }
            _ => {}
        }
        let cells = if route.len() == 1 { "1 cell".to_owned() } else { format!("{} cells", route.len()) };
        let took = effects.decision.map(|took| format!(", in {:.1} ms", took.as_secs_f64() * 1e3));
        Some(format!("decided: {cells} to {}{}", self.places.cell(waypoint), took.unwrap_or_default()))
    }

    /// A robot has new observations: its own, or those of others, who find too.
    fn finds(
        &mut self,
        robot: RobotId,
        machine: &dyn StateMachine,
        observations: &[Arc<Observation>],
    ) -> Vec<String> {
        // With the source of the last reading of each cell.
        let cells: BTreeMap<Cell, Source> = observations
            .iter()
            .flat_map(|observation| {
                observation.readings.iter().map(|reading| (reading.cell, observation.origin.source))
            })
            .collect();
        self.locate(machine, cells.keys().copied().filter(|&cell| machine.is_found(cell)));
        let change = |(cell, source)| match (machine.is_found(cell), self.found.contains(&cell)) {
            (true, false) => {
                self.found.insert(cell);
                let object = format!("an object at {}", self.place(cell));
                Some(if source == Source::Robot(robot) {
                    format!("found: {object}")
                } else {
                    format!("learned from {source}: {object}")
                })
            }
            (false, true) => {
                self.found.remove(&cell);
                Some(format!("doubts: an object at {}, found before", self.place(cell)))
            }
            _ => None,
        };
        cells.into_iter().filter_map(change).collect()
    }

    /// The coordinator has published a status.
    fn declares(&mut self, status: &MissionStatus) -> Vec<String> {
        let declared: BTreeSet<Cell> = status.declared.iter().map(|object| object.cell).collect();
        let before = std::mem::replace(&mut self.found, declared);
        self.declared.clone_from(&status.declared);
        let new = news::declared(&before, status).filter_map(|(object, given)| {
            let what = if self.is_of_subjects {
                self.find(object)
            } else {
                let (place, probability) = (self.place(object.cell), object.probability);
                format!("an object at {place}, probability {probability:.3}")
            };
            Some(format!("declared{}: {what}", when(given)?))
        });
        let withdrawn = before.difference(&self.found);
        let withdrawn = withdrawn.map(|&cell| format!("withdrawn: an object at {}", self.place(cell)));
        new.chain(withdrawn).collect()
    }

    /// The coordinator has published the operator's directive.
    fn orders_all(&mut self, now: MissionTime, directive: &Directive) -> Option<String> {
        let before = std::mem::replace(&mut self.order, directive.numbered_order());
        let what = match directive.order {
            TeamOrder::Search => "all robots search",
            TeamOrder::Return => "all robots return to their bases",
            TeamOrder::End => "the mission ends, and all robots return to their bases",
            TeamOrder::Pause => "all robots pause",
        };
        Some(format!("ordered{}: {what}", when(news::to_all(before, directive, now)?)?))
    }

    /// The coordinator has published the operator's orders to single robots.
    fn orders_robots(&mut self, now: MissionTime, orders: &RobotOrders) -> Vec<String> {
        let before = std::mem::replace(&mut self.orders, orders.clone());
        let line = |(robot, NumberedOrder { value: order, .. }, given)| {
            let what = match order {
                RobotOrder::Search => "searches".to_owned(),
                RobotOrder::Go(there) => format!("goes to {}", self.places.on_earth(there)),
                RobotOrder::Return => "returns to its base".to_owned(),
                RobotOrder::Pause => "pauses".to_owned(),
            };
            Some(format!("ordered{}: robot {robot} {what}", when(given)?))
        };
        news::to_robots(&before, orders, now).filter_map(line).collect()
    }

    /// The coordinator has published the operator's zones.
    fn closes(&mut self, now: MissionTime, zones: &Zones) -> Vec<String> {
        let before = std::mem::replace(&mut self.zones, zones.clone());
        let line = |(zone, cells, given): (Numbered<Zone>, BTreeSet<Cell>, _)| {
            let some = self.places.some(&cells);
            Some(format!("ordered{}: {some} {}", when(given)?, zone.value.said_of(cells.len())))
        };
        news::zones(&before, zones, now).filter_map(line).collect()
    }

    /// The coordinator has published the operator's marks.
    fn marks(&mut self, now: MissionTime, marks: &Marks) -> Vec<String> {
        let before = std::mem::replace(&mut self.marks, marks.clone());
        let line = |(_, entry, given): (_, Numbered<Arc<Marked>>, _)| {
            let (what, when) = (entry.value.said(&self.places), when(given)?);
            let done = if entry.value.is_withdrawn { "withdrawn" } else { "marked" };
            Some(format!("{done} by the operator{when}: {what}"))
        };
        news::marks(&before, marks, now).filter_map(line).collect()
    }

    /// The coordinator has published the operator's verdicts.
    fn judges(&mut self, now: MissionTime, verdicts: &Verdicts) -> Vec<String> {
        let before = std::mem::replace(&mut self.verdicts, verdicts.clone());
        let line = |(cell, verdict, given): (_, Verdict, _)| {
            let (when, find) = (when(given)?, format!("the find at {}", self.place(cell)));
            Some(match verdict.decision.word() {
                Some(word) => format!("{word} by the operator{when}: {find}"),
                None => format!("undone by the operator{when}: the decision about {find}"),
            })
        };
        news::verdicts(&before, verdicts, now).filter_map(line).collect()
    }
}

/// What is told of the time of an order or verdict; none of one that was told already.
fn when(given: Given) -> Option<String> {
    match given {
        Given::Now => Some(String::new()),
        Given::Before(time) => Some(format!(" before, at {:.1} s", time.as_seconds())),
        Given::Anew(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::time::Duration;

    use dragnet_agent::agent::{Agent, AgentConfig};
    use dragnet_coordinator::node::CoordinatorNode;
    use dragnet_proto::command::Command;
    use dragnet_proto::state_machine::Event;
    use dragnet_scenario::Scenario;
    use dragnet_search::cell::Position;
    use dragnet_search::evidence::Reading;

    use super::*;
    use crate::team::recording::Existing;
    use crate::team::{self, Options};

    /// A robot, on four cells in a row of which the last holds an object, and its coordinator.
    fn scenario() -> Scenario {
        let text = "name = 'lane'\nmap = { shape = 'all_traversable', rows = 1, columns = 4, cell_meters = 10.0, \
                    origin = { latitude_degrees = 0.0, longitude_degrees = 2.0 } }\n\
                    objects.count = 1\nsensor.radius = 2\nrobots = { count = 1, policy = 'greedy' }\n\
                    [mission]\nbudget_seconds = 900.0\nstop_when_expected_remaining = 0.9\n";
        Scenario::from_text(Path::new("lane.toml"), text.to_owned()).unwrap()
    }

    fn node(scenario: &Scenario) -> CoordinatorNode {
        team::recording::node(scenario, 1, &Options::default(), Existing::Rejected, None).unwrap()
    }

    #[test]
    fn a_coordinator_says_once_that_all_robots_rest_or_wait_for_the_operator() {
        let (mut narrator, node) =
            (Narrator::new(Participant::Coordinator, scenario().places()), node(&scenario()));
        let [first, second] = [1, 2].map(|robot| RobotId::new(robot).unwrap());
        let mut end = |robot, activity| {
            narrator.ending.receive(robot, activity);
            narrator.end(&node)
        };
        assert_eq!(end(first, Activity::Searching), [""; 0]);
        assert_eq!(end(second, Activity::Holding), [""; 0]);
        let waits = "the search waits for robot 2, which holds by your order: resume it, or call it back";
        assert_eq!(end(first, Activity::Cleared), [waits]);
        // Nobody has told yet what it can see.
        let done = "done: all robots that are here (2) rest, too little is left for it to find; objects declared: 0; \
                    1.00 more expected in reach";
        assert_eq!(end(second, Activity::Cleared), [done]);
        assert_eq!(end(second, Activity::Cleared), [""; 0], "once");
    }

    #[test]
    fn a_find_of_the_one_subject_is_told_as_probable() {
        let text = scenario().source().text.replace("[mission]", "prior.rest_of_world = 0.1\n[mission]");
        let scenario = Scenario::from_text(Path::new("lane.toml"), text).unwrap();
        let mut narrator = Narrator::new(Participant::Coordinator, scenario.places());
        let node = node(&scenario);
        let cell = scenario.terrain().grid().cell(Position { row: 0, column: 3 }).unwrap();
        let object = Detection { cell, probability: 0.9812, time_ns: 0 };
        let status = MissionStatus { declared: vec![object], ..node.mission().status(MissionTime::START) };
        let advice = "probable find (98.1 %) at [0, 3] at latitude 0.000045, longitude 2.000314, not confirmed by hand: \
                      look before you stand down";
        assert_eq!(narrator.declares(&status), [format!("declared: {advice}")]);
        let mut again = Narrator::new(Participant::Coordinator, scenario.places());
        let status = MissionStatus { time_ns: 120_000_000_000, ..status };
        assert_eq!(again.declares(&status), [format!("declared before, at 0.0 s: {advice}")]);
        narrator.ending.receive(RobotId::FIRST, Activity::Cleared);
        let done = narrator.end(&node);
        assert!(done[0].contains("objects declared: 1; the subject: in a declared cell"), "{done:?}");
        assert!(done[0].ends_with(advice), "{done:?}");
    }

    #[test]
    fn a_robot_that_leaves_before_its_search_is_over_is_lost_and_its_last_cell_is_told() {
        let mut narrator = Narrator::new(Participant::Coordinator, scenario().places());
        let (node, robot) = (node(&scenario()), RobotId::FIRST);
        let cell = scenario().terrain().grid().cell(Position { row: 0, column: 2 });
        let mut lose = |activity| {
            narrator.ending.receive(robot, activity);
            narrator.lose(&node, robot, cell)
        };
        let expected = "robot 1 is lost: it has left before its search was over, and was last in [0, 2] at latitude 0.000045, \
                        longitude 2.000225";
        assert_eq!(lose(Activity::Searching).unwrap(), expected);
        assert_eq!(lose(Activity::Cleared), None);
        assert_eq!(narrator.lose(&node, robot, cell), None, "it has not told what it does");
    }

    #[test]
    fn a_robot_that_stands_is_told_once_and_that_it_goes_on() {
        let mut narrator = Narrator::new(Participant::Coordinator, scenario().places());
        let cell = scenario().terrain().grid().cell(Position { row: 0, column: 2 }).unwrap();
        let stands = |number, seconds| Standstill {
            robot: RobotId::new(number).unwrap(),
            cell,
            lasts: Duration::from_secs(seconds),
        };
        assert_eq!(narrator.standstills(&[]), [const { Vec::<String>::new() }; 2]);
        let [new, over] = narrator.standstills(&[stands(2, 75)]);
        let expected = "robot 2 has entered no cell for 75 s and is in [0, 2] at latitude 0.000045, longitude 2.000225: see that \
                        nothing is in its way";
        assert_eq!((new, over.len()), (vec![expected.to_owned()], 0));
        let [new, over] = narrator.standstills(&[stands(1, 75), stands(2, 80)]);
        assert!(new.len() == 1 && new[0].starts_with("robot 1 ") && over.is_empty(), "{new:?} {over:?}");
        let [new, over] = narrator.standstills(&[stands(1, 80)]);
        assert_eq!((new.len(), over), (0, vec!["robot 2 goes on, or is to stay where it is".to_owned()]));
    }

    /// A robot and the coordinator, and what both tell.
    struct Pair {
        agent: Agent,
        node: CoordinatorNode,
        of_robot: Narrator,
        of_coordinator: Narrator,
        lines: Vec<String>,
    }

    impl Pair {
        fn of(scenario: &Scenario) -> Self {
            Self {
                agent: Agent::new(AgentConfig::of_team(scenario, 1).remove(0)),
                node: team::recording::node(scenario, 1, &Options::default(), Existing::Rejected, None)
                    .unwrap(),
                of_robot: Narrator::new(Participant::Robot(RobotId::FIRST), scenario.places()),
                of_coordinator: Narrator::new(Participant::Coordinator, scenario.places()),
                lines: Vec::new(),
            }
        }

        /// The robot handles an event, and the coordinator what it then says; returns the robot's observations.
        fn pass(&mut self, now: MissionTime, event: Event<Message>) -> Vec<Arc<Observation>> {
            let effects = self.agent.handle(now, event).unwrap();
            self.lines.extend(self.of_robot.lines(&self.agent, &effects));
            let from = Participant::Robot(RobotId::FIRST);
            for (_, message) in effects.published {
                let effects = self.node.handle(now, Event::Received { from, message }).unwrap();
                self.lines.extend(self.of_coordinator.lines(&self.node, &effects));
            }
            effects.kept
        }
    }

    #[test]
    fn a_mission_is_labeled_with_four_words() {
        let scenario = scenario();
        let grid = scenario.terrain().grid();
        let [from, object] = [2, 3].map(|column| grid.cell(Position { row: 0, column }).unwrap());
        let variance = scenario.sensor().variance(1);
        let sensed = |value: f32| Event::Sensed {
            cell: from,
            readings: vec![Reading { cell: object, value, variance }],
        };
        let mut pair = Pair::of(&scenario);
        // It observes the object, and then an empty cell.
        for (number, value) in (1..).zip([0.5].into_iter().chain([1.0; 10]).chain([0.0; 20])) {
            pair.pass(MissionTime(number * 20_000_000_000), sensed(value));
        }
        let lines: Vec<&str> = pair.lines.iter().map(|line| line.split(", in ").next().unwrap()).collect();
        assert!(lines[0].starts_with("decided: 1 cell to [0, "), "{lines:#?}");
        // It rests once the object is found, and again once the cell is known to be empty.
        let expected = [
            ("found: an object at [0, 3] at latitude 0.000045, longitude 2.000314", 1),
            ("resting: too little is left for it to find", 2),
            ("doubts: an object at [0, 3] at latitude 0.000045, longitude 2.000314, found before", 1),
            ("withdrawn: an object at [0, 3] at latitude 0.000045, longitude 2.000314", 1),
        ];
        for (line, times) in expected {
            assert_eq!(
                lines.iter().filter(|reported| **reported == line).count(),
                times,
                "{line}: {lines:#?}"
            );
        }
        let declared = "declared: an object at [0, 3] at latitude 0.000045, longitude 2.000314, probability ";
        assert_eq!(lines.iter().filter(|reported| reported.starts_with(declared)).count(), 1, "{lines:#?}");
    }

    #[test]
    fn an_object_that_a_robot_has_located_is_told_with_its_position_and_accuracy() {
        let scenario = scenario();
        let grid = scenario.terrain().grid();
        let [from, object] = [2, 3].map(|column| grid.cell(Position { row: 0, column }).unwrap());
        let reading = Reading { cell: object, value: 1.0, variance: scenario.sensor().variance(1) };
        let position = ObjectPosition::new(object, [32.5, 8.0], [0.09, 0.0, 0.04]).unwrap();
        let mut pair = Pair::of(&scenario);
        pair.agent.handle(MissionTime::START, Event::Located(vec![position])).unwrap();
        for number in 1..12 {
            let sensed = Event::Sensed { cell: from, readings: vec![reading] };
            let kept = pair.pass(MissionTime(number * 20_000_000_000), sensed);
            let carried = kept.iter().map(|observation| observation.positions.len()).sum::<usize>();
            assert_eq!(carried, usize::from(number == 1), "the next observation carries it");
        }
        let lines = pair.lines;
        let place = "an object at [0, 3] at latitude 0.000072, longitude 2.000292 (within 0.8 m with 95 % probability)";
        for said in [format!("found: {place}"), format!("declared: {place}, probability ")] {
            assert_eq!(lines.iter().filter(|line| line.starts_with(&said)).count(), 1, "{said}: {lines:#?}");
        }
    }

    #[test]
    fn an_order_to_a_robot_is_told_by_the_coordinator_once_and_by_the_robot() {
        let scenario = scenario();
        let [here, there] =
            [0, 3].map(|column| scenario.terrain().grid().cell(Position { row: 0, column }).unwrap());
        let mut agent = Agent::new(AgentConfig::of_team(&scenario, 1).remove(0));
        let mut node =
            team::recording::node(&scenario, 1, &Options::default(), Existing::Rejected, None).unwrap();
        let mut of_robot = Narrator::new(Participant::Robot(RobotId::FIRST), scenario.places());
        let mut of_coordinator = Narrator::new(Participant::Coordinator, scenario.places());
        let now = MissionTime(20_000_000_000);
        agent.handle(now, Event::Sensed { cell: here, readings: Vec::new() }).unwrap();
        let command = |order| Event::Commanded(Command::Robot(RobotId::FIRST, order));
        let ordered = node.handle(now, command(RobotOrder::Go(there))).unwrap();
        let place = "[0, 3] at latitude 0.000045, longitude 2.000314";
        assert_eq!(of_coordinator.orders(&node, &ordered), [format!("ordered: robot 1 goes to {place}")]);
        assert!(of_coordinator.orders(&node, &ordered).is_empty(), "once");
        let from = Participant::Coordinator;
        let told = ordered.published.into_iter().flat_map(|(_, message)| {
            let effects = agent.handle(now, Event::Received { from, message }).unwrap();
            of_robot.lines(&agent, &effects)
        });
        assert_eq!(told.collect::<Vec<_>>(), ["sent to [0, 3]"]);
        let paused = node.handle(now, Event::Commanded(Command::Team(TeamOrder::Pause))).unwrap();
        assert_eq!(of_coordinator.orders(&node, &paused), ["ordered: all robots pause"]);
        assert!(of_coordinator.orders(&node, &paused).is_empty(), "once");
    }

    #[test]
    fn what_robots_knew_before_is_told_with_its_time_and_what_is_dated_anew_is_not() {
        let mut narrator = Narrator::new(Participant::Coordinator, scenario().places());
        let cell = scenario().terrain().grid().cells().last().unwrap();
        let at = |seconds: u64| MissionTime(seconds * 1_000_000_000);
        let mut told = |number: MissionTime, order| {
            let directive = Directive { number: number.0, order, ..Directive::default() };
            narrator.orders_all(at(200), &directive)
        };
        assert_eq!(told(at(120), TeamOrder::Pause).unwrap(), "ordered before, at 120.0 s: all robots pause");
        assert_eq!(told(at(150), TeamOrder::Pause), None);
        assert_eq!(told(at(200), TeamOrder::Search).unwrap(), "ordered: all robots search");
        let order = NumberedOrder { number: at(110).0, value: RobotOrder::Pause };
        let orders = [(RobotId::FIRST, order)].into_iter().collect();
        assert_eq!(narrator.orders_robots(at(200), &orders), ["ordered before, at 110.0 s: robot 1 pauses"]);
        let (decision, log_odds_units) = (Decision::Confirmed, Verdict::CONFIRMED_UNITS);
        let verdict = |number: MissionTime| {
            [(cell, Verdict { number: number.0, decision, log_odds_units })].into_iter().collect()
        };
        let find = "the find at [0, 3] at latitude 0.000045, longitude 2.000314";
        assert_eq!(
            narrator.judges(at(200), &verdict(at(115))),
            [format!("confirmed by the operator before, at 115.0 s: {find}")]
        );
        assert_eq!(
            narrator.judges(at(200), &verdict(at(200))),
            [format!("confirmed by the operator: {find}")]
        );
    }
}
