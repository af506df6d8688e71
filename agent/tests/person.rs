//! A robot's reactions to an operator who pauses, marks or extends the search, through the coordinator or another
//! robot.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::marks::Marks;
use dragnet_proto::message::{
    Activity, MarkReport, Message, MissionStatus, OrderReport, VerdictReport, ZoneReport,
};
use dragnet_proto::newest::Numbered;
use dragnet_proto::orders::{NumberedOrder, RobotOrder};
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_proto::verdict::{Decision, Verdicts};
use dragnet_proto::zones::Zone;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::mark::{Clue, Mark};
use dragnet_search::observation::{Observation, Origin, RobotId, Versions};

const SECOND: u64 = 1_000_000_000;
const ROBOT: RobotId = RobotId::FIRST;

/// A robot on a map whose two western columns are searched, and whose eastern ones are only traversable.
struct Field {
    scenario: Scenario,
    robot: Agent,
}

impl Field {
    fn new(mission: &str) -> Self {
        Self::on("..,,,,\n..,,,,\n..,,,,\n", mission)
    }

    fn on(map: &str, mission: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("map.txt"), map).unwrap();
        let text = format!(
            "name = 'a'\nmap.file = 'map.txt'\nsensor.radius = 1\nobjects.density = 0.2\n[mission]\n{mission}\n"
        );
        let scenario = Scenario::from_text(&folder.path().join("a.toml"), text).unwrap();
        let robot = Agent::new(AgentConfig::of_team(&scenario, 0).remove(0));
        Self { scenario, robot }
    }

    fn cell(&self, number: u32) -> Cell {
        self.scenario.terrain().grid().cell_numbered(number).unwrap()
    }

    fn at(seconds: u64) -> MissionTime {
        MissionTime(seconds * SECOND)
    }

    fn sense(&mut self, seconds: u64, number: u32) -> Effects<Message> {
        let cell = self.cell(number);
        self.robot.react(Self::at(seconds), Event::Sensed { cell, readings: Vec::new() })
    }

    fn receive(&mut self, seconds: u64, message: Message) -> Effects<Message> {
        self.robot.react(Self::at(seconds), Event::Received { from: Participant::Coordinator, message })
    }

    /// The coordinator publishes the operator's directive.
    fn order(&mut self, seconds: u64, number: u64, order: TeamOrder, added: &[u32]) -> Effects<Message> {
        let added = added.iter().map(|&number| self.cell(number)).collect();
        self.receive(
            seconds,
            Message::MissionStatus(MissionStatus {
                time_ns: seconds * SECOND,
                declared: Vec::new(),
                expected_remaining: 1.0,
                alive: vec![ROBOT],
                observations: 0,
                versions: Versions::default(),
                digest: Digest(0),
                directive: Directive { number, order, added },
                doubled: Vec::new(),
            }),
        )
    }
}

impl Field {
    /// The coordinator publishes its orders to single robots: robot and number of each.
    fn order_one(&mut self, seconds: u64, orders: &[(u16, u64, RobotOrder)]) -> Effects<Message> {
        let given = orders.iter().map(|&(robot, number, order)| {
            (RobotId::new(robot).unwrap(), NumberedOrder { number, value: order })
        });
        let (from, orders) = (Participant::Coordinator, given.collect());
        self.receive(seconds, Message::Orders(OrderReport { from, time_ns: seconds * SECOND, orders }))
    }

    /// The coordinator publishes its zones: cell, number and zone of each.
    fn close(&mut self, seconds: u64, zones: &[(u32, u64, Zone)]) -> Effects<Message> {
        let given = zones
            .iter()
            .map(|&(cell, number, value)| (self.cell(cell), Numbered { number, value }))
            .collect();
        let (from, zones) = (Participant::Coordinator, given);
        self.receive(seconds, Message::Zones(ZoneReport { from, time_ns: seconds * SECOND, zones }))
    }

    /// The robot enters the cells of a path, 15 s each.
    fn drive(&mut self, mut seconds: u64, path: Vec<Cell>) -> (u64, Effects<Message>) {
        let mut effects = Effects::default();
        for cell in path {
            seconds += 15;
            effects = self.sense(seconds, cell.number());
        }
        (seconds, effects)
    }
}

fn is_nothing(effects: &Effects<Message>) -> bool {
    let Effects { wake_at, activity, .. } = *effects;
    *effects == Effects { wake_at, activity, ..Effects::default() }
}

/// The directive and the activity of the published heartbeat.
fn heartbeat(effects: &Effects<Message>) -> (Directive, Activity) {
    let said = effects.published.iter().find_map(|(_, message)| match message {
        Message::Heartbeat(heartbeat) => Some((heartbeat.directive.clone(), heartbeat.activity)),
        _ => None,
    });
    said.unwrap()
}

#[test]
fn a_paused_robot_stays_and_reports_it_until_resumed() {
    let mut field = Field::new("budget_seconds = 1e6");
    assert!(!field.sense(0, 0).route.unwrap().is_empty());
    let paused = field.order(1, 5, TeamOrder::Pause, &[]);
    assert_eq!(paused.route, Some(Vec::new()));
    let is_told = |message: &Message| matches!(message, Message::Intent(intent) if intent.path.is_empty());
    assert!(paused.published.iter().any(|(_, message)| is_told(message)));
    assert!(is_nothing(&field.order(2, 5, TeamOrder::Pause, &[])), "what is known is no news");
    assert!(is_nothing(&field.order(2, 4, TeamOrder::Search, &[])), "an older order comes late");
    assert_eq!(field.sense(3, 1).route, None, "it looks, and does not go");
    let wake = field.robot.wake_at();
    let (directive, activity) = heartbeat(&field.robot.react(wake, Event::Woke));
    assert_eq!((directive.number, directive.order, activity), (5, TeamOrder::Pause, Activity::Paused));
    assert!(!field.order(60, 6, TeamOrder::Search, &[]).route.unwrap().is_empty());
    assert_eq!(field.robot.activity(), Activity::Searching);
}

#[test]
fn a_robot_that_starts_into_a_pause_waits() {
    let mut field = Field::new("budget_seconds = 1e6");
    assert_eq!(field.order(0, 5, TeamOrder::Pause, &[]).route, None, "it does not know yet where it is");
    assert_eq!(field.sense(1, 0).route, Some(Vec::new()));
    assert_eq!(field.robot.activity(), Activity::Paused);
    assert!(!field.order(2, 6, TeamOrder::Search, &[]).route.unwrap().is_empty());
}

#[test]
fn a_robot_that_is_called_back_returns_to_where_it_started_until_it_is_told_to_search() {
    let mut field = Field::new("budget_seconds = 1e6");
    let path = field.sense(0, 0).route.unwrap();
    for (step, cell) in (1..).zip(&path[..3]) {
        field.sense(15 * step, cell.number());
    }
    let mut way = field.order(46, 5, TeamOrder::Return, &[]).route.unwrap();
    assert_eq!((field.robot.activity(), way.len()), (Activity::Returning, 3));
    assert!(is_nothing(&field.order(47, 5, TeamOrder::Return, &[])), "what is known is no news");
    for (step, cell) in (4..).zip(way.drain(..)) {
        field.sense(15 * step, cell.number());
    }
    assert_eq!(field.robot.activity(), Activity::Recalled);
    field.order(200, 6, TeamOrder::Pause, &[]);
    assert_eq!(field.robot.activity(), Activity::Paused);
    assert!(!field.order(300, 7, TeamOrder::Search, &[]).route.unwrap().is_empty());
    assert_eq!(field.robot.activity(), Activity::Searching);
}

#[test]
fn a_robot_goes_where_it_is_sent_and_holds_there_until_it_is_told_to_search() {
    let mut field = Field::new("budget_seconds = 1e6");
    let there = field.cell(17);
    field.sense(0, 0);
    assert!(is_nothing(&field.order_one(1, &[(2, 5, RobotOrder::Go(there))])), "another robot is sent there");
    let way = field.order_one(2, &[(1, 6, RobotOrder::Go(there))]).route.unwrap();
    assert_eq!((way.last(), field.robot.activity()), (Some(&there), Activity::Sent));
    let (now, _) = field.drive(2, way);
    assert_eq!(field.robot.activity(), Activity::Holding);
    assert_eq!(field.sense(now + 1, 17).route, None, "it stays");
    let wake = field.robot.wake_at();
    let beat = field.robot.react(wake, Event::Woke);
    let told = beat.published.iter().find_map(|(_, message)| match message {
        Message::Orders(report) => Some(report.orders.iter().collect::<Vec<_>>()),
        _ => None,
    });
    let told: Vec<_> = told.unwrap().into_iter().map(|(robot, it)| (robot.number(), it.number)).collect();
    assert_eq!(told, [(1, 6), (2, 5)], "it passes on what it knows");
    assert!(
        is_nothing(&field.order_one(now + 60, &[(1, 5, RobotOrder::Pause)])),
        "an older order comes late"
    );
    field.order_one(now + 61, &[(1, 7, RobotOrder::Search)]);
    assert_eq!(field.robot.activity(), Activity::Searching);
}

#[test]
fn of_the_orders_to_all_and_to_one_robot_the_newest_counts() {
    let mut field = Field::new("budget_seconds = 1e6");
    field.sense(0, 0);
    field.order_one(1, &[(1, 5, RobotOrder::Pause)]);
    assert_eq!(field.robot.activity(), Activity::Paused);
    assert_eq!(field.order(2, 4, TeamOrder::Return, &[]).route, None, "it was given before");
    assert_eq!(field.robot.activity(), Activity::Paused);
    field.order(3, 6, TeamOrder::Search, &[]);
    assert_eq!(field.robot.activity(), Activity::Searching);
    field.order(4, 7, TeamOrder::Pause, &[]);
    field.order_one(5, &[(1, 8, RobotOrder::Search)]);
    assert_eq!(field.robot.activity(), Activity::Searching, "it alone");
}

#[test]
fn a_robot_goes_no_farther_than_its_way_home_allows() {
    // Cells of 30 m: with a reserve of a tenth the budget is 6 cells.
    let mut field = Field::new("budget_meters = 200.0\nreturn_to_base = true");
    field.sense(0, 0);
    let (base, there) = (field.cell(0), field.cell(5));
    let way = field.order_one(1, &[(1, 5, RobotOrder::Go(there))]).route.unwrap();
    assert!(!way.is_empty() && way.len() < 5, "{way:?}");
    let (now, turned) = field.drive(1, way);
    assert_eq!((turned.route.unwrap().last(), field.robot.activity()), (Some(&base), Activity::Returning));
    field.order_one(now + 1, &[(1, 6, RobotOrder::Go(base))]);
    assert_eq!(field.robot.activity(), Activity::Sent);
}

#[test]
fn a_robot_holds_where_it_is_if_no_path_leads_where_it_is_sent() {
    let mut field = Field::on("..#\n..#\n.#.\n", "budget_seconds = 1e6");
    field.sense(0, 0);
    let there = field.cell(2);
    assert_eq!(field.order_one(1, &[(1, 5, RobotOrder::Go(there))]).route, Some(Vec::new()));
    assert_eq!(field.robot.activity(), Activity::Holding);
}

const OPEN: &str = "......\n......\n......\n";

#[test]
fn a_robot_goes_around_cells_that_are_closed_before_it() {
    let mut field = Field::on(OPEN, "budget_seconds = 1e6");
    field.sense(0, 0);
    let there = field.cell(5);
    let way = field.order_one(1, &[(1, 5, RobotOrder::Go(there))]).route.unwrap();
    assert_eq!(way.len(), 5, "along the southern edge");
    // A wall with a gap in the north.
    let closed = [2, 8].map(|cell| (cell, 6, Zone::NoGo));
    let around = field.close(2, &closed).route.unwrap();
    assert_eq!((around.last(), around.len()), (Some(&there), 9), "{around:?}");
    assert!(closed.iter().all(|&(cell, ..)| !around.contains(&field.cell(cell))));
    assert!(is_nothing(&field.close(3, &closed)), "what is known is no news");
    assert!(is_nothing(&field.close(3, &[(2, 5, Zone::Open)])), "an older zone comes late");
    // The gap is closed too, and then all is opened again.
    assert_eq!(field.close(4, &[(14, 7, Zone::NoGo)]).route, Some(Vec::new()));
    assert_eq!(field.robot.activity(), Activity::Holding, "no way leads there");
    assert_eq!(field.close(5, &[2, 8, 14].map(|cell| (cell, 8, Zone::Open))).route.unwrap().len(), 5);
}

#[test]
fn a_robot_in_a_no_go_zone_leaves_it_by_the_shortest_way_and_says_so() {
    let mut field = Field::on(OPEN, "budget_seconds = 1e6");
    field.sense(0, 7);
    let closed = [0, 1, 2, 6, 7, 8, 12, 13, 14].map(|cell| (cell, 5, Zone::NoGo));
    let way = field.close(1, &closed).route.unwrap();
    assert_eq!(
        (way.as_slice(), field.robot.activity()),
        (&[8, 9].map(|it| field.cell(it))[..], Activity::Leaving)
    );
    let beat = field.robot.react(field.robot.wake_at(), Event::Woke);
    let told =
        beat.published.iter().any(|(_, it)| matches!(it, Message::Zones(it) if it.zones.iter().len() == 9));
    assert!(told, "it passes on what it knows");
    let (_, out) = field.drive(1, way);
    let path = out.route.unwrap();
    assert_eq!(field.robot.activity(), Activity::Searching);
    assert!(
        path.iter().all(|cell| closed.iter().all(|&(closed, ..)| field.cell(closed) != *cell)),
        "{path:?}"
    );
}

#[test]
fn a_paused_robot_in_a_no_go_zone_stays_until_it_is_resumed() {
    let mut field = Field::on(OPEN, "budget_seconds = 1e6");
    field.sense(0, 0);
    field.order_one(1, &[(1, 5, RobotOrder::Pause)]);
    assert_eq!(field.close(2, &[(0, 6, Zone::NoGo)]).route, None);
    field.order_one(3, &[(1, 7, RobotOrder::Search)]);
    assert_eq!(field.robot.activity(), Activity::Leaving);
}

#[test]
fn cells_that_are_skipped_are_searched_only_when_they_are_opened_again() {
    let mut field = Field::new("budget_seconds = 1e6\nstop_when_expected_remaining = 0.5");
    field.sense(0, 0);
    let searched = [0, 1, 6, 7, 12, 13];
    let belief = field.robot.belief().digest();
    assert_eq!(field.close(1, &searched.map(|cell| (cell, 5, Zone::Skip))).route, None);
    // In the next cell it decides again.
    let rest = field.sense(15, 1);
    assert_eq!((rest.route, field.robot.activity()), (Some(Vec::new()), Activity::Cleared));
    assert_eq!(field.robot.belief().digest(), belief, "no zone is evidence");
    assert!((field.robot.belief().probability(field.cell(0)) - 0.2).abs() < 1e-9);
    assert!(
        !field
            .close(60, &[(13, 6, Zone::Open), (12, 6, Zone::Open), (6, 6, Zone::Open)])
            .route
            .unwrap()
            .is_empty()
    );
    // What is added meanwhile keeps its prior where it is skipped, and is searched elsewhere.
    field.order(61, 0, TeamOrder::Search, &[0, 2]);
    assert!((field.robot.belief().probability(field.cell(0)) - 0.2).abs() < 1e-9);
}

#[test]
fn a_robot_returns_to_the_cell_nearest_to_its_closed_base() {
    let mut field = Field::on(OPEN, "budget_seconds = 1e6\nreturn_to_base = true");
    let path = field.sense(0, 0).route.unwrap();
    let (now, _) = field.drive(0, path);
    field.close(now + 1, &[(0, 5, Zone::NoGo)]);
    let way = field.order(now + 2, 6, TeamOrder::Return, &[]).route.unwrap();
    let last = way.last().copied();
    assert!(last == Some(field.cell(1)) || last == Some(field.cell(6)), "{way:?}");
    let (now, _) = field.drive(now + 2, way);
    assert_eq!(field.robot.activity(), Activity::Recalled);
    let home = field.close(now + 1, &[(0, 7, Zone::Open)]).route.unwrap();
    assert_eq!(home, [field.cell(0)]);
}

#[test]
fn a_robot_that_is_cut_off_from_its_base_searches_on_and_returns_as_near_as_it_can() {
    let mut field = Field::on(OPEN, "budget_seconds = 1e6\nreturn_to_base = true");
    field.sense(0, 0);
    let there = field.cell(5);
    let way = field.order_one(1, &[(1, 5, RobotOrder::Go(there))]).route.unwrap();
    let (now, _) = field.drive(1, way);
    // A wall through the whole map.
    field.close(now + 1, &[2, 8, 14].map(|cell| (cell, 6, Zone::NoGo)));
    let search = field.order_one(now + 2, &[(1, 7, RobotOrder::Search)]).route.unwrap();
    assert_eq!((search.is_empty(), field.robot.activity()), (false, Activity::Searching));
    let back = field.order_one(now + 3, &[(1, 8, RobotOrder::Return)]).route.unwrap();
    assert_eq!(back, [4, 3].map(|it| field.cell(it)), "to the foot of the wall");
    let (now, _) = field.drive(now + 3, back);
    assert_eq!(field.robot.activity(), Activity::Recalled);
    let home = field.close(now + 1, &[(2, 9, Zone::Open)]).route.unwrap();
    assert_eq!(home.last(), Some(&field.cell(0)));
}

#[test]
fn a_robot_with_a_low_battery_goes_to_its_base_and_searches_again_once_it_is_charged() {
    let mut field = Field::new("budget_seconds = 1e6");
    let path = field.sense(0, 0).route.unwrap();
    let (now, _) = field.drive(0, path[..3].to_vec());
    let tell =
        |field: &mut Field, seconds, must| field.robot.react(Field::at(seconds), Event::MustReturn(must));
    let way = tell(&mut field, now + 1, true).route.unwrap();
    assert_eq!((way.last(), field.robot.activity()), (Some(&field.cell(0)), Activity::Returning));
    let there = field.cell(17);
    assert!(is_nothing(&field.order_one(now + 2, &[(1, 5, RobotOrder::Go(there))])), "it goes nowhere else");
    let (now, _) = field.drive(now + 2, way);
    assert_eq!(field.robot.activity(), Activity::Spent);
    tell(&mut field, now + 600, false);
    assert_eq!(field.robot.activity(), Activity::Sent, "now it does what it was told");
    field.order(now + 601, 6, TeamOrder::Pause, &[]);
    assert!(is_nothing(&tell(&mut field, now + 602, true)), "a paused robot stays where it is");
}

#[test]
fn a_pause_does_not_outlast_the_budget() {
    let mut field = Field::new("budget_seconds = 100.0");
    field.sense(0, 0);
    field.order(1, 5, TeamOrder::Pause, &[]);
    while field.robot.wake_at() < Field::at(120) {
        let now = field.robot.wake_at();
        field.robot.react(now, Event::Woke);
    }
    assert_eq!(field.robot.activity(), Activity::Spent);
}

#[test]
fn cells_that_the_operator_adds_are_searched_and_end_a_rest() {
    let mut field = Field::new("budget_seconds = 1e6\nstop_when_expected_remaining = 2.0");
    field.sense(0, 0);
    assert_eq!(field.robot.activity(), Activity::Cleared, "little enough is expected");
    let added: Vec<u32> = vec![2, 3, 4, 5, 8, 9, 10, 11];
    assert!(field.robot.belief().probability(field.cell(3)).abs() < 1e-12);
    let effects = field.order(1, 0, TeamOrder::Search, &added);
    assert!(!effects.route.unwrap().is_empty(), "more is expected now");
    assert!((field.robot.belief().probability(field.cell(3)) - 0.2).abs() < 1e-9);
    assert!((field.robot.belief().probability(field.cell(0)) - 0.2).abs() < 1e-9);
    assert!(field.robot.belief().probability(field.cell(14)).abs() < 1e-12, "and nowhere else");
}

fn marks(marks: &Marks) -> Message {
    Message::Marks(MarkReport { from: Participant::Coordinator, time_ns: SECOND, marks: marks.clone() })
}

#[test]
fn a_mark_counts_once_until_it_is_withdrawn_and_is_passed_on_beside_heartbeats() {
    let mut field = Field::new("budget_seconds = 1e6");
    field.sense(0, 0);
    let (cell, before) = (field.cell(7), field.robot.belief().digest());
    let mut made = Marks::default();
    let clue = Clue { cell, ratio_thousandths: 3_000, radius_hundredths: 0 };
    made.make(3, Mark::Clue(clue), "a glove".to_owned());
    let odds = |field: &Field| field.robot.belief().log_odds_nats(cell);
    let prior = odds(&field);
    assert_eq!(field.receive(1, marks(&made)).route, None, "not between cells");
    assert!((odds(&field) - prior - 3_f64.ln()).abs() < 1e-4);
    assert!(is_nothing(&field.receive(2, marks(&made))));
    let wake = field.robot.wake_at();
    let passed_on = field.robot.react(wake, Event::Woke).published.into_iter().find_map(|(_, it)| match it {
        Message::Marks(report) => Some(report),
        _ => None,
    });
    let report = MarkReport { from: Participant::Robot(ROBOT), time_ns: wake.0, marks: made.clone() };
    assert_eq!(passed_on, Some(report));
    assert!(made.withdraw(4, 3));
    field.receive(3, marks(&made));
    assert_eq!(field.robot.belief().digest(), before);
}

#[test]
fn a_clue_makes_a_robot_search_that_rests() {
    let mut field = Field::new("budget_seconds = 1e6\nstop_when_expected_remaining = 1.3");
    let resting = field.sense(0, 0);
    assert!(resting.activity.is_rest(), "{resting:?}");
    let mut made = Marks::default();
    for number in [6, 7, 11] {
        let clue = Clue { cell: field.cell(number), ratio_thousandths: 50_000, radius_hundredths: 0 };
        made.make(3, Mark::Clue(clue), String::new());
    }
    let sent = field.receive(1, marks(&made));
    assert!(sent.route.is_some_and(|route| !route.is_empty()) && sent.activity == Activity::Searching);
}

/// Verdicts on a cell, one after the other.
fn decided(field: &Field, cell: Cell, decisions: &[Decision]) -> Verdicts {
    let (mut belief, mut known) = (field.robot.belief().clone(), Verdicts::default());
    for (time, &decision) in (1..).zip(decisions) {
        let next = known.with(time, cell, decision, &belief);
        known.take(next.iter(), &mut belief);
    }
    known
}

fn verdicts(from: Participant, verdicts: &Verdicts) -> Message {
    Message::Verdicts(VerdictReport { from, time_ns: SECOND, verdicts: verdicts.clone() })
}

/// Verdicts in published messages.
fn passed_on(effects: &Effects<Message>) -> Vec<Verdicts> {
    let reports = effects.published.iter().filter_map(|(_, message)| match message {
        Message::Verdicts(report) => Some(report.verdicts.clone()),
        _ => None,
    });
    reports.collect()
}

/// A reading of the robot before it restarted, which speaks for an object.
fn seen(cell: Cell, sequence: u64) -> Message {
    let origin = Origin { source: ROBOT.into(), incarnation: 7 };
    let readings = vec![Reading { cell, value: 1.0, variance: 0.125 }];
    let time_ns = sequence * SECOND;
    Message::Observation(Arc::new(Observation {
        origin,
        sequence,
        time_ns,
        from: cell,
        readings,
        positions: Box::default(),
    }))
}

#[test]
fn a_robot_believes_a_verdict_and_passes_it_on_beside_its_heartbeats() {
    let mut field = Field::new("budget_seconds = 1e6");
    field.sense(0, 0);
    let wake = field.robot.wake_at();
    assert_eq!(passed_on(&field.robot.react(wake, Event::Woke)), [], "there is none");
    let cell = field.cell(7);
    (0..2).for_each(|sequence| drop(field.receive(60, seen(cell, sequence))));
    assert!(field.robot.is_found(cell));
    let dismissed = decided(&field, cell, &[Decision::Confirmed, Decision::Dismissed]);
    field.receive(61, verdicts(Participant::Coordinator, &dismissed));
    assert!(!field.robot.is_found(cell) && field.robot.belief().probability(cell) < 1e-3);
    let wake = field.robot.wake_at();
    assert_eq!(passed_on(&field.robot.react(wake, Event::Woke)), std::slice::from_ref(&dismissed));
    let older = decided(&field, cell, &[Decision::Confirmed]);
    assert!(
        is_nothing(&field.receive(62, verdicts(Participant::Coordinator, &older))),
        "an older one comes late"
    );
    assert!(
        is_nothing(&field.receive(63, verdicts(Participant::Coordinator, &dismissed))),
        "what is known is no news"
    );
    let undone = decided(&field, cell, &[Decision::Confirmed, Decision::Dismissed, Decision::Undone]);
    field.receive(64, verdicts(Participant::Coordinator, &undone));
    assert!(field.robot.is_found(cell));
}

#[test]
fn a_robot_that_joins_late_has_the_belief_of_the_others() {
    let mut early = Field::new("budget_seconds = 1e6");
    early.sense(0, 0);
    let cell = early.cell(7);
    (0..2).for_each(|sequence| drop(early.receive(1, seen(cell, sequence))));
    let confirmed = decided(&early, cell, &[Decision::Confirmed]);
    early.receive(2, verdicts(Participant::Coordinator, &confirmed));
    // It hears of the verdict before the readings, and from nobody but this robot.
    let mut late = Field::new("budget_seconds = 1e6");
    let wake = early.robot.wake_at();
    let heard = passed_on(&early.robot.react(wake, Event::Woke)).remove(0);
    let from = Participant::Robot(ROBOT);
    late.robot.react(wake, Event::Received { from, message: verdicts(from, &heard) });
    (0..2).for_each(|sequence| drop(late.receive(60, seen(cell, sequence))));
    late.sense(61, 0);
    assert_eq!(late.robot.replica().log().len(), 3);
    assert_eq!(late.robot.replica().knowledge().verdicts(), &confirmed);
    assert_eq!(late.robot.belief().digest(), early.robot.belief().digest());
}

#[test]
fn a_verdict_makes_a_robot_decide_again_in_its_next_cell() {
    let mut field = Field::new("budget_seconds = 1e6");
    let first = *field.sense(0, 0).route.unwrap().first().unwrap();
    let dismissed = decided(&field, field.cell(7), &[Decision::Dismissed]);
    assert_eq!(
        field.receive(1, verdicts(Participant::Coordinator, &dismissed)).route,
        None,
        "not between cells"
    );
    assert!(field.sense(2, first.number()).route.is_some());
}

/// With nobody to be heard, it would drive on although the operator has paused it, or through what is closed.
#[test]
fn a_restarted_robot_still_follows_what_it_was_told() {
    let mut field = Field::on(OPEN, "budget_seconds = 1e6");
    let mut kept = field.sense(0, 0).kept;
    let mut known = Marks::default();
    let clue = Clue { cell: field.cell(4), ratio_thousandths: 3_000, radius_hundredths: 0 };
    known.make(SECOND, Mark::Clue(clue), "a glove".to_owned());
    field.receive(1, marks(&known));
    field.close(2, &[(1, 5, Zone::NoGo), (2, 5, Zone::Skip)]);
    field.order(3, 6, TeamOrder::Pause, &[17]);
    field.order_one(4, &[(1, 7, RobotOrder::Go(field.cell(12))), (2, 8, RobotOrder::Return)]);
    let confirmed = decided(&field, field.cell(3), &[Decision::Confirmed]);
    field.receive(5, verdicts(Participant::Coordinator, &confirmed));
    kept.extend(field.sense(6, 0).kept);
    let wake = field.robot.wake_at();
    let said = field.robot.react(wake, Event::Woke).published;

    let mut again = Field::on(OPEN, "budget_seconds = 1e6");
    for observation in &kept {
        again.robot.recall(observation);
    }
    for (_, message) in &said {
        again.robot.recall_instructions(Field::at(60), message);
    }
    assert_eq!(again.robot.belief().digest(), field.robot.belief().digest());
    let way = again.sense(61, 0).route.unwrap();
    assert_eq!((way.last(), again.robot.activity()), (Some(&again.cell(12)), Activity::Sent));
    let wake = again.robot.wake_at();
    let repeated = again.robot.react(wake, Event::Woke).published;
    let instructions = |(_, message): &(_, Message)| message.instructions().map(|it| format!("{it:?}"));
    let [before, after] =
        [&said, &repeated].map(|all| all.iter().filter_map(instructions).collect::<Vec<_>>());
    assert_eq!((before.len(), &before), (5, &after));
    assert!(again.order_one(62, &[(1, 9, RobotOrder::Pause)]).route.unwrap().is_empty());
    let way = again.order_one(63, &[(1, 10, RobotOrder::Go(again.cell(2)))]).route.unwrap();
    assert!(way.len() > 2 && !way.contains(&again.cell(1)), "around the zone: {way:?}");
}
