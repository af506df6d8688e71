use dragnet_proto::command::Command;
use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::marks::Marks;
use dragnet_proto::message::{Activity, SyncReply, SyncRequest};
use dragnet_proto::orders::{NumberedOrder, RobotOrder};
use dragnet_proto::picture::PictureFacts;
use dragnet_proto::verdict::Decision;
use dragnet_proto::zones::{Zone, Zones};
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::mark::{Clue, Mark};
use dragnet_search::observation::{Origin, Source, Version};

use super::*;

const SECOND: Duration = Duration::from_secs(1);
const ONE: RobotId = RobotId::FIRST;
const TWO: RobotId = RobotId::new(2).unwrap();

fn at(seconds: u64) -> MissionTime {
    MissionTime::START + Duration::from_secs(seconds)
}

fn terrain() -> Arc<Terrain> {
    Arc::new(Terrain::from_ascii("....\n....", 10.0).unwrap())
}

fn cell(number: u32) -> Cell {
    terrain().grid().cell_numbered(number).unwrap()
}

/// Status every second, lost after 5, belief every 3.
fn mission() -> Mission {
    let terrain = terrain();
    Mission::new(CoordinatorConfig {
        limits: limits(),
        prior: Belief::uniform(&terrain, 0.1).unwrap(),
        terrain,
        subjects: None,
        detection_threshold: 0.95,
        robots: vec![ONE, TWO],
        speeds_meters_per_second: vec![1.0; 2],
        heartbeat: SECOND,
        lost_after: 5 * SECOND,
        belief_period: 3 * SECOND,
        max_observations: SyncReply::MAX_OBSERVATIONS,
    })
}

/// Fast enough for all robots of these tests.
fn limits() -> Limits {
    let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 2, columns = 4 }\nrobots.count = 2\nsensor.radius = 4\n\
                objects.count = 1\nmission = { budget_seconds = 60.0, speed_meters_per_second = 1e6 }\n";
    let scenario = Scenario::from_text(std::path::Path::new("a.toml"), text.to_owned()).unwrap();
    Limits::of(&scenario)
}

/// A robot's observation of a cell: log-odds that the reading adds, nats.
fn observation(robot: RobotId, sequence: u64, seen: u32, nats: f32) -> Arc<Observation> {
    let readings = vec![Reading { cell: cell(seen), value: 0.5 + nats, variance: 1.0 }];
    let time_ns = at(sequence).0;
    Arc::new(Observation {
        origin: Origin::first(robot),
        sequence,
        time_ns,
        from: cell(0),
        readings,
        positions: Box::default(),
    })
}

fn intent(robot: RobotId, decision: u64, path: std::ops::Range<u32>) -> Intent {
    Intent { robot, incarnation: 0, decision, time_ns: 0, path: path.map(cell).collect() }
}

fn heartbeat(robot: RobotId, now: MissionTime, versions: Vec<Version>) -> Message {
    Message::Heartbeat(Heartbeat {
        robot,
        time_ns: now.0,
        activity: Activity::Searching,
        cell: cell(0),
        path_meters: 0.0,
        intent: intent(robot, 1, 1..4),
        versions: versions.into(),
        digest: Digest(0),
        directive: Directive::default(),
    })
}

fn receive(mission: &mut Mission, now: MissionTime, from: RobotId, message: Message) -> Outcome {
    mission.react(now, Event::Received { from: Participant::Robot(from), message })
}

fn see(mission: &mut Mission, now: MissionTime, observation: &Arc<Observation>) -> Outcome {
    let Source::Robot(from) = observation.origin.source else { panic!("{observation:?}") };
    receive(mission, now, from, Message::Observation(Arc::clone(observation)))
}

/// Published statuses; each is recorded as well.
fn statuses(outcome: &Outcome) -> Vec<&MissionStatus> {
    let recorded = outcome.records.iter().filter(|record| matches!(record, Record::Status(_))).count();
    let published: Vec<&MissionStatus> = outcome
        .effects
        .published
        .iter()
        .filter_map(|said| match said {
            (Audience::All, Message::MissionStatus(status)) => Some(status),
            _ => None,
        })
        .collect();
    assert_eq!(published.len(), recorded);
    published
}

fn observations(outcome: &Outcome) -> Vec<(Source, u64)> {
    let records = outcome.records.iter().filter_map(|record| match record {
        Record::Observation(observation) => Some((observation.origin.source, observation.sequence)),
        _ => None,
    });
    let kept =
        outcome.effects.kept.iter().map(|observation| (observation.origin.source, observation.sequence));
    assert!(records.clone().eq(kept));
    records.collect()
}

fn plans(outcome: &Outcome) -> Vec<(RobotId, usize)> {
    let records = outcome.records.iter().filter_map(|record| match record {
        Record::Plan { robot, path } => Some((*robot, path.len())),
        _ => None,
    });
    records.collect()
}

fn is_nothing(outcome: &Outcome) -> bool {
    let effects = Effects { wake_at: outcome.effects.wake_at, ..Effects::default() };
    *outcome == Outcome { effects, records: Vec::new() }
}

#[test]
fn an_object_is_declared_and_withdrawn_and_each_is_published_at_once() {
    let mut mission = mission();
    see(&mut mission, at(0), &observation(ONE, 0, 5, 0.0));
    let declaring = see(&mut mission, at(1), &observation(ONE, 1, 5, 6.0));
    let [status] = statuses(&declaring)[..] else { panic!("{declaring:?}") };
    let [object] = status.declared[..] else { panic!("{status:?}") };
    assert_eq!((object.cell, object.time_ns), (cell(5), at(1).0));
    assert!(object.probability > 0.95);
    assert!((status.expected_remaining - 0.7).abs() < 1e-9, "seven cells of a tenth are left");

    let wavering = see(&mut mission, at(2), &observation(TWO, 0, 5, -2.0));
    assert_eq!(statuses(&wavering).len(), 1, "robot two is new");
    assert_eq!(mission.declared().count(), 1);
    let withdrawing = see(&mut mission, at(3), &observation(TWO, 1, 5, -2.5));
    let [status] = statuses(&withdrawing)[..] else { panic!("{withdrawing:?}") };
    assert_eq!(status.declared, []);
    assert!(statuses(&see(&mut mission, at(4), &observation(TWO, 2, 5, -1.0))).is_empty());
}

#[test]
fn a_gap_is_repaired_by_another_robot_and_each_observation_counts_once() {
    let mut mission = mission();
    let seen: Vec<_> = (0..3).map(|sequence| observation(ONE, sequence, 2, 1.0)).collect();
    see(&mut mission, at(0), &seen[0]);
    let outcome = see(&mut mission, at(2), &seen[2]);
    let request = SyncRequest { from: Participant::Coordinator, of: Origin::first(ONE), first: 1 };
    let asks = |whom| (Audience::One(Participant::Robot(whom)), Message::SyncRequest(request));
    assert!(outcome.effects.published.contains(&asks(ONE)), "{outcome:?}");

    mission.react(at(3), Event::Lost(ONE));
    let versions = vec![Version { origin: Origin::first(ONE), next: 3 }];
    let outcome = receive(&mut mission, at(3), TWO, heartbeat(TWO, at(3), versions));
    assert!(outcome.effects.published.contains(&asks(TWO)), "{outcome:?}");

    let reply = Message::SyncReply(SyncReply { observations: seen[1..].to_vec() });
    let outcome = receive(&mut mission, at(4), TWO, reply.clone());
    assert_eq!(observations(&outcome), [(ONE.into(), 1), (ONE.into(), 2)], "the third was early");
    assert_eq!(observations(&receive(&mut mission, at(4), TWO, reply)), []);
    assert_eq!(mission.alive().collect::<Vec<_>>(), [TWO], "who is quoted is not heard");

    let mut expected = Belief::uniform(&terrain(), 0.1).unwrap();
    seen.iter().flat_map(|observation| &observation.readings).for_each(|reading| expected.add(reading));
    assert_eq!(mission.belief(), &expected);
    assert_eq!(mission.status(at(4)).observations, 3);
}

#[test]
fn any_order_of_messages_leads_to_the_same_belief() {
    let seen: Vec<_> = [ONE, TWO]
        .into_iter()
        .flat_map(|robot| (0..8).map(move |step| observation(robot, u64::from(step), step, 0.3)))
        .collect();
    let (mut forward, mut backward) = (mission(), mission());
    for observation in &seen {
        see(&mut forward, at(9), observation);
    }
    // Early observations are sent again, until each has arrived after all before it.
    for _ in 0..8 {
        for observation in seen.iter().rev() {
            see(&mut backward, at(9), observation);
        }
    }
    assert_eq!(backward.replica().log().len(), 16);
    assert_eq!(forward.belief().digest(), backward.belief().digest());
    assert_ne!(forward.belief().digest(), mission().belief().digest());
}

#[test]
fn observations_of_a_lost_robot_spread() {
    let mut mission = mission();
    let seen = observation(ONE, 0, 2, 1.0);
    see(&mut mission, at(0), &seen);
    mission.react(at(1), Event::Lost(ONE));
    let request = SyncRequest { from: Participant::Robot(TWO), of: Origin::first(ONE), first: 0 };
    let outcome = receive(&mut mission, at(2), TWO, Message::SyncRequest(request));
    let reply = Message::SyncReply(SyncReply { observations: vec![seen] });
    assert!(outcome.effects.published.contains(&(Audience::One(Participant::Robot(TWO)), reply)));
}

#[test]
fn robots_of_one_number_are_reported_as_long_as_they_are_there() {
    let mut mission = mission();
    let doubled = |outcome: &Outcome| statuses(outcome).pop().map(|status| status.doubled.clone());
    let outcome = mission.react(at(1), Event::Doubled(BTreeSet::from([TWO])));
    assert_eq!(doubled(&outcome), Some(vec![TWO]));
    assert_eq!(mission.status(at(2)).doubled, [TWO]);
    assert_eq!(doubled(&mission.react(at(3), Event::Doubled(BTreeSet::new()))), Some(vec![]));
}

#[test]
fn the_best_picture_of_a_find_is_recorded() {
    let mut mission = mission();
    let facts = PictureFacts {
        robot: ONE,
        time_ns: 5,
        cell: cell(2),
        camera: "front".to_owned(),
        label: String::new(),
        score: 1.0,
        quality: 20.0,
    };
    let of_quality = |quality| {
        Arc::new(Picture { facts: PictureFacts { quality, ..facts.clone() }, jpeg: [1, 2].as_slice().into() })
    };
    let mut receive = |quality| mission.react(at(1), Event::Pictured(of_quality(quality))).records;
    for (quality, is_recorded) in [(20.0, true), (20.0, false), (10.0, false), (30.0, true)] {
        let expected: Vec<Record> =
            is_recorded.then(|| Record::Picture(of_quality(quality))).into_iter().collect();
        assert_eq!(receive(quality), expected, "{quality}");
    }
    assert_eq!(mission.pictures().collect::<Vec<_>>(), [&of_quality(30.0)]);
}

#[test]
fn a_robot_is_lost_in_silence_or_by_leaving_and_returns() {
    let mut mission = mission();
    let alive = |outcome: &Outcome| statuses(outcome).pop().map(|status| status.alive.clone());
    assert_eq!(alive(&receive(&mut mission, at(0), ONE, heartbeat(ONE, at(0), vec![]))), Some(vec![ONE]));
    assert_eq!(
        alive(&receive(&mut mission, at(0), TWO, heartbeat(TWO, at(0), vec![]))),
        Some(vec![ONE, TWO])
    );
    assert_eq!(alive(&receive(&mut mission, at(3), ONE, heartbeat(ONE, at(3), vec![]))), None);

    let outcome = mission.react(at(6), Event::Woke);
    assert_eq!(alive(&outcome), Some(vec![ONE]), "robot two was silent");
    assert_eq!(plans(&outcome), [(TWO, 0)], "its plan lapses");

    let outcome = mission.react(at(6), Event::Lost(ONE));
    assert_eq!((alive(&outcome), plans(&outcome)), (Some(vec![]), vec![(ONE, 0)]));
    assert!(is_nothing(&mission.react(at(6), Event::Lost(ONE))), "nobody is lost twice");

    let outcome = receive(&mut mission, at(7), TWO, heartbeat(TWO, at(7), vec![]));
    assert_eq!((alive(&outcome), plans(&outcome)), (Some(vec![TWO]), vec![(TWO, 3)]));
}

#[test]
fn a_status_comes_every_heartbeat_and_the_belief_at_its_period_and_at_the_end() {
    let mut mission = mission();
    let mut reported = Vec::new();
    while mission.wake_at() <= at(6) {
        let now = mission.wake_at();
        let outcome = mission.react(now, Event::Woke);
        let has_belief = outcome.records.iter().any(|record| matches!(record, Record::Belief(_)));
        reported.push((now, statuses(&outcome).len(), has_belief));
    }
    let expected: Vec<_> = (1..=6).map(|second| (at(second), 1, second % 3 == 0)).collect();
    assert_eq!(reported, expected);

    see(&mut mission, at(7), &observation(ONE, 0, 5, 6.0));
    let outcome = mission.finish(at(7));
    let last = Record::Belief(Arc::new(mission.belief().clone()));
    assert!(outcome.records.contains(&last));
    assert_eq!(statuses(&outcome)[0].declared.len(), 1);
}

#[test]
fn a_pose_is_recorded_when_a_robot_moves_and_a_late_message_moves_none_back() {
    let mut mission = mission();
    let poses = |outcome: Outcome| {
        let poses = outcome.records.into_iter().filter_map(|record| match record {
            Record::Pose { cell, time, .. } => Some((cell.number(), time)),
            _ => None,
        });
        poses.collect::<Vec<_>>()
    };
    let moved = |mission: &mut Mission, sequence, number| {
        let mut seen = Arc::unwrap_or_clone(observation(ONE, sequence, 0, 0.0));
        seen.from = cell(number);
        poses(see(mission, at(9), &Arc::new(seen)))
    };
    assert_eq!(moved(&mut mission, 0, 0), [(0, at(0))]);
    assert_eq!(moved(&mut mission, 1, 2), [(2, at(1))]);
    let late = heartbeat(ONE, at(0), Vec::new());
    assert_eq!(poses(receive(&mut mission, at(9), ONE, late)), []);
    assert_eq!(moved(&mut mission, 2, 2), []);
}

#[test]
fn certain_cells_of_the_prior_are_declared_from_the_start() {
    let terrain = terrain();
    let mut probability = vec![0.1; 8];
    probability[3] = 0.99;
    let prior = Belief::new(&terrain, &probability).unwrap();
    let mission = Mission::new(CoordinatorConfig { prior, ..mission().config });
    assert_eq!(mission.declared().map(|object| object.cell).collect::<Vec<_>>(), [cell(3)]);
}

#[test]
fn of_two_finds_of_one_subject_at_most_one_is_true() {
    let prior = Belief::uniform(&terrain(), 0.1).unwrap();
    let subjects = Subjects::new(1, 0.2);
    let mut mission = Mission::new(CoordinatorConfig { prior, subjects, ..mission().config });
    let probabilities = |mission: &Mission| -> Vec<String> {
        mission.status(at(9)).declared.iter().map(|it| format!("{:.2}", it.probability)).collect()
    };
    assert!((mission.status(at(0)).expected_remaining - 0.8).abs() < 1e-9);
    // Searched in vain: what is left is elsewhere, and the more outside.
    for (sequence, seen) in [1, 2, 3].into_iter().enumerate() {
        see(&mut mission, at(0), &observation(ONE, sequence as u64, seen, -7.0));
    }
    let standing = mission.standing().unwrap();
    assert!((standing.rest_of_world - 0.2 / 0.7).abs() < 1e-3, "{standing:?}");
    assert!((mission.status(at(1)).expected_remaining - 0.5 / 0.7).abs() < 1e-3);
    see(&mut mission, at(2), &observation(ONE, 3, 5, 7.0));
    assert_eq!(probabilities(&mission), ["0.99"]);
    assert!(mission.status(at(2)).expected_remaining < 0.01 && mission.standing().unwrap().found > 0.99);
    see(&mut mission, at(3), &observation(TWO, 0, 7, 7.0));
    assert_eq!(probabilities(&mission), ["0.50", "0.50"]);
    assert!(mission.belief().probability(cell(7)) > 0.99, "by its own readings it is declared");
    assert!((mission.shown_belief().probability(cell(7)) - 0.5).abs() < 0.01);
}

#[test]
fn a_robot_that_reuses_numbers_is_noticed() {
    let mut mission = mission();
    see(&mut mission, at(0), &observation(ONE, 0, 2, 1.0));
    let before = mission.belief().digest();
    assert_eq!(observations(&see(&mut mission, at(1), &observation(ONE, 0, 3, 1.0))), []);
    assert_eq!((mission.replica().rejected().values().sum::<u64>(), mission.belief().digest()), (1, before));
}

fn command(mission: &mut Mission, now: MissionTime, command: Command) -> Outcome {
    mission.react(now, Event::Commanded(command))
}

#[test]
fn a_pause_is_published_at_once_and_the_newest_order_counts() {
    let mut mission = mission();
    let reported = command(&mut mission, at(3), Command::Team(TeamOrder::Pause));
    assert_eq!(statuses(&reported)[0].directive.order, TeamOrder::Pause);
    let again = command(&mut mission, at(4), Command::Team(TeamOrder::Pause));
    assert_eq!(statuses(&again)[0].directive.number, at(4).0, "robots that are away may know a newer order");
    for robot in [ONE, TWO] {
        receive(&mut mission, at(4), robot, heartbeat(robot, at(4), vec![]));
    }
    assert!(
        is_nothing(&command(&mut mission, at(5), Command::Team(TeamOrder::Pause))),
        "all are paused already"
    );
    let resumed = command(&mut mission, at(5), Command::Team(TeamOrder::Search));
    assert_eq!(statuses(&resumed)[0].directive.order, TeamOrder::Search);
    assert_eq!(mission.directive().number, at(5).0);
}

#[test]
fn an_order_to_one_robot_is_recorded_published_and_ended_by_an_order_to_all() {
    let mut mission = mission();
    receive(&mut mission, at(0), ONE, heartbeat(ONE, at(0), vec![]));
    let to_one = |order| Command::Robot(ONE, order);
    let orders = |outcome: &Outcome| -> Vec<RobotOrders> {
        let published = outcome.effects.published.iter();
        published
            .filter_map(|(_, it)| if let Message::Orders(it) = it { Some(it.orders.clone()) } else { None })
            .collect()
    };
    assert!(orders(&mission.react(at(1), Event::Commanded(Command::Team(TeamOrder::Pause)))).is_empty());
    let sent = command(&mut mission, at(3), to_one(RobotOrder::Go(cell(5))));
    let recorded =
        |record: &Record| matches!(record, Record::Orders(it) if it.from == Participant::Coordinator);
    assert_eq!((orders(&sent).len(), sent.records.iter().filter(|it| recorded(it)).count()), (1, 1));
    let current =
        |mission: &Mission| [ONE, TWO].map(|robot| mission.orders().current(robot, mission.directive()));
    assert_eq!(current(&mission), [RobotOrder::Go(cell(5)), RobotOrder::Pause]);
    assert!(
        is_nothing(&command(&mut mission, at(4), to_one(RobotOrder::Go(cell(5))))),
        "it goes there already"
    );
    // All are paused, and one of them is not: the order is given again. The clock is behind.
    command(&mut mission, at(2), Command::Team(TeamOrder::Pause));
    assert_eq!(current(&mission), [RobotOrder::Pause; 2]);
    // A robot knows an order that this coordinator forgot.
    let mut others = mission.orders().clone();
    others.order(at(9).0, TWO, RobotOrder::Return, mission.directive());
    let report = OrderReport { from: Participant::Robot(ONE), time_ns: at(9).0, orders: others };
    let told = orders(&receive(&mut mission, at(9), ONE, Message::Orders(report)));
    assert_eq!(told.last(), Some(mission.orders()));
    assert_eq!(current(&mission), [RobotOrder::Pause, RobotOrder::Return]);
}

#[test]
fn zones_are_recorded_published_and_lifted() {
    let mut mission = mission();
    let zones = |outcome: &Outcome| -> Vec<Zones> {
        let published = outcome.effects.published.iter();
        published
            .filter_map(|(_, it)| if let Message::Zones(it) = it { Some(it.zones.clone()) } else { None })
            .collect()
    };
    let zone = |zone| Command::Zone(zone, vec![cell(4), cell(5)]);
    assert!(is_nothing(&command(&mut mission, at(1), zone(Zone::Open))), "they are open already");
    let closed = command(&mut mission, at(2), zone(Zone::NoGo));
    let recorded =
        |record: &Record| matches!(record, Record::Zones(it) if it.from == Participant::Coordinator);
    assert_eq!((zones(&closed).len(), closed.records.iter().filter(|it| recorded(it)).count()), (1, 1));
    assert!(is_nothing(&command(&mut mission, at(3), zone(Zone::NoGo))), "they are closed already");
    let expected = mission.status(at(3)).expected_remaining;
    // A robot knows a zone that this coordinator forgot. The clock is behind when that is lifted.
    let mut others = mission.zones().clone();
    others.give(at(9).0, cell(6), Zone::Skip);
    let report = ZoneReport { from: Participant::Robot(ONE), time_ns: at(9).0, zones: others };
    let told = zones(&receive(&mut mission, at(9), ONE, Message::Zones(report)));
    assert_eq!(told.last(), Some(mission.zones()));
    command(&mut mission, at(5), Command::Zone(Zone::Open, vec![cell(6), cell(7)]));
    let current = [4, 5, 6, 7].map(|number| mission.zones().of(cell(number)));
    assert_eq!(current, [Some(Zone::NoGo), Some(Zone::NoGo), Some(Zone::Open), None]);
    let now = mission.status(at(9)).expected_remaining;
    assert!((now - expected).abs() < 1e-12, "no zone is evidence");
}

#[test]
fn a_coordinator_that_starts_again_learns_of_a_pause_and_can_end_it() {
    let mut before = mission();
    command(&mut before, at(100), Command::Team(TeamOrder::Pause));
    let mut again = mission();
    let Message::Heartbeat(beat) = heartbeat(ONE, at(1), Vec::new()) else { panic!("no heartbeat") };
    let beat = Heartbeat { directive: before.directive().clone(), ..beat };
    let learned = receive(&mut again, at(1), ONE, Message::Heartbeat(beat));
    assert_eq!(statuses(&learned)[0].directive.order, TeamOrder::Pause, "a pause is not lifted by a restart");
    // Its clock is far behind that of the one before.
    command(&mut again, at(2), Command::Team(TeamOrder::Search));
    let mut robot = before.directive().clone();
    assert!(robot.merge(at(2), again.directive()) && robot.order == TeamOrder::Search);
}

/// A robot's heartbeat with what it was ordered last, and its report of the orders to single robots.
fn told(
    mission: &mut Mission,
    now: MissionTime,
    order: (u64, TeamOrder),
    orders: &[(RobotId, u64, RobotOrder)],
) -> Outcome {
    let Message::Heartbeat(beat) = heartbeat(TWO, now, Vec::new()) else { panic!("no heartbeat") };
    let directive = Directive { number: at(order.0).0, order: order.1, added: BTreeSet::new() };
    let mut outcome = receive(mission, now, TWO, Message::Heartbeat(Heartbeat { directive, ..beat }));
    let orders = orders
        .iter()
        .map(|&(robot, seconds, order)| (robot, NumberedOrder { number: at(seconds).0, value: order }));
    let report = OrderReport { from: Participant::Robot(TWO), time_ns: now.0, orders: orders.collect() };
    let more = receive(mission, now, TWO, Message::Orders(report));
    outcome.records.extend(more.records);
    outcome.effects.published.extend(more.effects.published);
    outcome
}

/// What each robot is to do.
fn current(mission: &Mission) -> [RobotOrder; 2] {
    [ONE, TWO].map(|robot| mission.orders().current(robot, mission.directive()))
}

#[test]
fn an_order_that_was_given_before_any_robot_was_heard_is_later_than_what_robots_bring() {
    // The robots know an order to all of second 100, and one to a robot of second 110; the mission is at second 200.
    let old = (100, TeamOrder::Search);
    let go = RobotOrder::Go(cell(5));
    let to_one = [(ONE, 110, RobotOrder::Return)];
    let check = |given: &[Command], brought: &[(RobotId, u64, RobotOrder)], expected: [RobotOrder; 2]| {
        let mut mission = mission();
        for (seconds, it) in (3..).zip(given) {
            command(&mut mission, at(seconds), it.clone());
        }
        let outcome = told(&mut mission, at(200), old, brought);
        assert_eq!(current(&mission), expected, "{given:?}");
        let status = statuses(&outcome).pop().unwrap();
        assert_eq!(status.directive, *mission.directive(), "it is published");
        let published = outcome.effects.published.iter().rev();
        let orders = published
            .filter_map(|(_, it)| if let Message::Orders(it) = it { Some(&it.orders) } else { None });
        let recorded = outcome.records.iter().rev().filter_map(|record| match record {
            Record::Orders(report) if report.from == Participant::Coordinator => Some(&report.orders),
            _ => None,
        });
        if !mission.orders().is_empty() {
            assert_eq!(
                (orders.into_iter().next(), recorded.into_iter().next()),
                (Some(mission.orders()), Some(mission.orders()))
            );
        }
        mission
    };
    let [pause, resume] = [TeamOrder::Pause, TeamOrder::Search].map(Command::Team);
    let paused = check(std::slice::from_ref(&pause), &[], [RobotOrder::Pause; 2]);
    assert_eq!(paused.directive().number, at(100).0 + 1);
    let paused = check(std::slice::from_ref(&pause), &to_one, [RobotOrder::Pause; 2]);
    assert_eq!(paused.directive().number, at(110).0 + 1, "it was given after the order to the one robot too");
    let sent = check(&[Command::Robot(ONE, go)], &to_one, [go, RobotOrder::Search]);
    assert_eq!(sent.orders().iter().map(|(_, it)| it.number).collect::<Vec<_>>(), [at(110).0 + 1]);
    check(&[Command::Robot(ONE, go)], &[], [go, RobotOrder::Search]);
    check(&[Command::Robot(ONE, go), pause.clone()], &to_one, [RobotOrder::Pause; 2]);
    check(&[pause.clone(), Command::Robot(ONE, go)], &to_one, [go, RobotOrder::Pause]);
    // Nothing is known yet that it would change, but the robots may know otherwise.
    let paused = [(ONE, 110, RobotOrder::Pause), (TWO, 120, RobotOrder::Pause)];
    check(&[resume], &paused, [RobotOrder::Search; 2]);
    check(&[Command::Robot(ONE, RobotOrder::Search)], &paused, [RobotOrder::Search, RobotOrder::Pause]);
}

#[test]
fn only_the_last_order_before_any_robot_was_heard_is_dated_anew() {
    let mut mission = mission();
    command(&mut mission, at(3), Command::Team(TeamOrder::Pause));
    told(&mut mission, at(200), (100, TeamOrder::Search), &[]);
    assert_eq!(current(&mission), [RobotOrder::Pause; 2]);
    // Another robot that was cut off, which knows a newer one.
    told(&mut mission, at(201), (150, TeamOrder::Return), &[]);
    assert_eq!((current(&mission), mission.directive().number), ([RobotOrder::Pause; 2], at(150).0 + 1));
    // An order to a robot that was given since stays the newer one.
    command(&mut mission, at(210), Command::Robot(ONE, RobotOrder::Search));
    told(&mut mission, at(211), (160, TeamOrder::Return), &[]);
    assert_eq!(current(&mission), [RobotOrder::Search, RobotOrder::Pause]);
    // The operator's next order to all is dated rightly by itself: what is newer counts.
    command(&mut mission, at(220), Command::Team(TeamOrder::Search));
    told(&mut mission, at(240), (230, TeamOrder::Pause), &[]);
    assert_eq!(current(&mission), [RobotOrder::Pause; 2]);
}

/// Robots that were away bring orders of before, dated by a clock that has counted longer.
#[test]
fn orders_that_were_dated_by_a_clock_that_was_behind_go_forward_with_it() {
    let mut mission = mission();
    let zone = |mission: &Mission, cell| mission.zones().numbered(cell).map(|it| (it.number, it.value));
    told(&mut mission, at(1), (0, TeamOrder::Search), &[(ONE, 0, RobotOrder::Search)]);
    command(&mut mission, at(5), Command::Team(TeamOrder::Pause));
    command(&mut mission, at(6), Command::Robot(TWO, RobotOrder::Return));
    command(&mut mission, at(7), Command::Zone(Zone::NoGo, vec![cell(4)]));
    let outcome = mission.react(at(760), Event::ClockSet(Duration::from_secs(750)));
    assert_eq!(mission.directive().number, at(755).0);
    assert_eq!(statuses(&outcome)[0].directive, *mission.directive(), "it is published and recorded");
    let recorded = |of: fn(&Record) -> bool| outcome.records.iter().any(of);
    assert!(recorded(|it| matches!(it, Record::Orders(_))) && recorded(|it| matches!(it, Record::Zones(_))));
    told(&mut mission, at(761), (119, TeamOrder::Search), &[(TWO, 120, RobotOrder::Search)]);
    assert_eq!(current(&mission), [RobotOrder::Pause, RobotOrder::Return]);
    assert_eq!(mission.orders().newest(), at(756).0);
    assert_eq!(zone(&mission, cell(4)), Some((at(757).0, Zone::NoGo)));
    // What another operator has ordered since stays as it is dated.
    told(&mut mission, at(762), (761, TeamOrder::Return), &[]);
    mission.react(at(860), Event::ClockSet(Duration::from_secs(90)));
    assert_eq!((mission.directive().number, mission.orders().newest()), (at(761).0, at(846).0));
    assert!(is_nothing(&self::mission().react(at(9), Event::ClockSet(Duration::from_secs(9)))));
}

fn clue(number: u32) -> Command {
    let clue = Clue { cell: cell(number), ratio_thousandths: 55_000, radius_hundredths: 0 };
    Command::Mark(Mark::Clue(clue), "a glove".to_owned())
}

/// The marks that an outcome publishes, and the number of its records of the coordinator's own.
fn mark_reports(outcome: &Outcome) -> (Vec<Marks>, usize) {
    let published = outcome.effects.published.iter().filter_map(|said| match said {
        (Audience::All, Message::Marks(report)) => Some(report.marks.clone()),
        _ => None,
    });
    let is_own =
        |record: &&Record| matches!(record, Record::Marks(report) if report.from == Participant::Coordinator);
    (published.collect(), outcome.records.iter().filter(is_own).count())
}

#[test]
fn marks_are_published_beside_each_status_and_a_restarted_coordinator_learns_them_from_a_robot() {
    let mut mission = mission();
    assert_eq!(mark_reports(&mission.react(at(6), Event::Woke)), (Vec::new(), 0), "nothing is said of none");
    let (made, recorded) = mark_reports(&command(&mut mission, at(7), clue(2)));
    assert_eq!((made.len(), made[0].iter().next().map(|(id, _)| id), recorded), (1, Some(at(7).0), 1));
    assert_eq!(mark_reports(&mission.react(at(30), Event::Woke)), (made, 0));
    assert_eq!((mission.tracks().count(), mission.robots().count()), (0, 2), "a person is no robot");

    // Restarted at the same time; a robot sends it the earlier mark.
    let mut again = self::mission();
    let report = |marks: &Marks| {
        let from = Participant::Robot(ONE);
        Message::Marks(MarkReport { from, time_ns: at(7).0, marks: marks.clone() })
    };
    let (learned, recorded) = mark_reports(&receive(&mut again, at(7), ONE, report(mission.marks())));
    assert_eq!((&learned[0], recorded), (mission.marks(), 1));
    assert_eq!(again.belief().digest(), mission.belief().digest());
    command(&mut again, at(7), clue(3));
    assert_eq!(again.marks().standing().count(), 2);
    let undone = command(&mut again, at(8), Command::Unmark(at(7).0));
    assert_eq!((mark_reports(&undone).1, again.marks().standing().count()), (1, 1));
    assert!(is_nothing(&command(&mut again, at(9), Command::Unmark(at(7).0))), "it was withdrawn already");
    assert!(is_nothing(&command(&mut again, at(9), Command::Unmark(5))), "there is none");
    receive(&mut mission, at(9), ONE, report(again.marks()));
    assert_eq!(mission.belief().digest(), again.belief().digest());
}

#[test]
fn a_clue_declares_an_object_only_with_what_was_seen_and_cells_that_are_searched_stay_as_they_are() {
    let mut mission = mission();
    for _ in 0..9 {
        assert_eq!(statuses(&command(&mut mission, at(0), clue(4)))[0].declared, []);
    }
    see(&mut mission, at(0), &observation(ONE, 0, 5, 3.0));
    assert_eq!(mission.declared().count(), 0);
    let declaring = command(&mut mission, at(1), clue(5));
    assert_eq!(statuses(&declaring)[0].declared.len(), 1);
    let withdrawn = command(&mut mission, at(1), Command::Unmark(at(1).0));
    assert_eq!(statuses(&withdrawn)[0].declared.len(), 1, "what was seen makes it more likely than not");
    assert!(is_nothing(&command(&mut mission, at(2), Command::Search(vec![cell(1), cell(5)]))));
    assert!(mission.directive().added.is_empty());
}

/// The reports of verdicts that an outcome publishes, and the number of its records of the coordinator's own.
fn verdict_reports(outcome: &Outcome) -> (Vec<VerdictReport>, usize) {
    let published = outcome.effects.published.iter().filter_map(|said| match said {
        (Audience::All, Message::Verdicts(report)) => Some(report.clone()),
        _ => None,
    });
    let is_own = |record: &&Record| matches!(record, Record::Verdicts(report) if report.from == Participant::Coordinator);
    (published.collect(), outcome.records.iter().filter(is_own).count())
}

#[test]
fn a_dismissed_find_is_withdrawn_and_undoing_declares_it_again() {
    let mut mission = mission();
    see(&mut mission, at(0), &observation(ONE, 0, 5, 6.0));
    assert_eq!(mission.declared().count(), 1);
    assert_eq!(
        verdict_reports(&mission.react(at(1), Event::Woke)),
        (Vec::new(), 0),
        "nothing is said of none"
    );
    let before = mission.belief().digest();
    let dismissed = command(&mut mission, at(2), Command::Judge(Decision::Dismissed, cell(5)));
    assert_eq!(statuses(&dismissed)[0].declared, []);
    let (reports, recorded) = verdict_reports(&dismissed);
    assert_eq!((reports.len(), recorded), (1, 1));
    assert_eq!(reports[0].verdicts.of(cell(5)).unwrap().time(), at(2));
    assert!(is_nothing(&command(&mut mission, at(3), Command::Judge(Decision::Dismissed, cell(5)))));
    let (again, recorded) = verdict_reports(&mission.react(at(4), Event::Woke));
    assert_eq!((again[0].verdicts.clone(), recorded), (reports[0].verdicts.clone(), 0), "beside each status");

    see(&mut mission, at(5), &observation(ONE, 1, 5, 6.0));
    assert_eq!(mission.declared().count(), 0);
    (2..4).for_each(|sequence| drop(see(&mut mission, at(6), &observation(ONE, sequence, 5, 6.0))));
    assert_eq!(mission.declared().count(), 1, "new evidence warrants it");
    command(&mut mission, at(7), Command::Judge(Decision::Dismissed, cell(5)));
    assert_eq!(mission.declared().count(), 0, "it can be dismissed again");
    let undone = command(&mut mission, at(8), Command::Judge(Decision::Undone, cell(5)));
    assert_eq!(statuses(&undone)[0].declared.len(), 1);
    assert_ne!(mission.belief().digest(), before, "with what was read meanwhile");
    assert!(is_nothing(&command(&mut mission, at(9), Command::Judge(Decision::Undone, cell(5)))));
}

#[test]
fn a_confirmed_find_is_never_withdrawn_and_a_restarted_coordinator_learns_of_it_from_a_robot() {
    let mut before = mission();
    see(&mut before, at(100), &observation(ONE, 0, 5, 6.0));
    command(&mut before, at(100), Command::Judge(Decision::Confirmed, cell(5)));
    (1..90).for_each(|sequence| drop(see(&mut before, at(100), &observation(ONE, sequence, 5, -6.0))));
    assert!(before.replica().rejected().is_empty() && before.replica().log().len() == 90);
    assert_eq!(before.declared().map(|object| object.probability).collect::<Vec<_>>(), [1.0]);

    let mut again = mission();
    let from = Participant::Robot(ONE);
    let report = VerdictReport { from, time_ns: at(1).0, verdicts: before.verdicts().clone() };
    let learned = receive(&mut again, at(1), ONE, Message::Verdicts(report.clone()));
    assert!(learned.records.contains(&Record::Verdicts(report.clone())), "the robot has it");
    let (reports, recorded) = verdict_reports(&learned);
    assert_eq!((reports[0].verdicts.clone(), recorded), (before.verdicts().clone(), 1));
    assert_eq!(again.declared().count(), 1);
    assert_eq!(verdict_reports(&receive(&mut again, at(2), ONE, Message::Verdicts(report))), (Vec::new(), 0));
    // Its clock is far behind that of the one before.
    command(&mut again, at(3), Command::Judge(Decision::Dismissed, cell(5)));
    assert_eq!(again.declared().count(), 0);
    assert!(again.verdicts().of(cell(5)) > before.verdicts().of(cell(5)));
}

#[test]
fn a_find_is_dated_by_what_was_read_whenever_and_in_whatever_order_it_arrives() {
    // Read at 0, 3 and 9 s: the second reading makes it a find.
    let seen = |robot, sequence, seconds, nats| {
        let observation = Observation::clone(&observation(robot, sequence, 5, nats));
        Arc::new(Observation { time_ns: at(seconds).0, ..observation })
    };
    let seen = [seen(ONE, 0, 0, 2.0), seen(TWO, 0, 3, 4.0), seen(ONE, 1, 9, 1.0)];
    let since = |order: [usize; 3], arrivals: [u64; 3]| {
        let mut mission = mission();
        for (index, seconds) in order.into_iter().zip(arrivals) {
            see(&mut mission, at(seconds), &seen[index]);
        }
        mission.declared().map(|object| object.time_ns).collect::<Vec<_>>()
    };
    assert_eq!(since([0, 1, 2], [0, 3, 9]), [at(3).0], "at once");
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2]] {
        assert_eq!(since(order, [100; 3]), [at(3).0], "{order:?}");
    }
}

/// A robot rests, and has told so with the mission's order to all as it knows it.
fn rests(mission: &mut Mission, now: MissionTime, robot: RobotId, seen: u64) {
    let versions = vec![Version { origin: Origin::first(robot), next: seen }];
    let Message::Heartbeat(mut beat) = heartbeat(robot, now, versions) else { unreachable!() };
    (beat.activity, beat.directive) = (Activity::Recalled, mission.directive().clone());
    receive(mission, now, robot, Message::Heartbeat(beat));
}

#[test]
fn a_mission_that_is_ended_is_over_once_all_robots_are_back_and_all_they_saw_is_here() {
    let mut mission = mission();
    rests(&mut mission, at(1), ONE, 0);
    rests(&mut mission, at(1), TWO, 0);
    command(&mut mission, at(2), Command::Team(TeamOrder::End));
    assert_eq!(mission.awaited(), Some(vec![ONE, TWO]), "they rested before they knew");
    rests(&mut mission, at(3), ONE, 1);
    assert_eq!((mission.awaited(), mission.is_over()), (Some(vec![TWO]), false));
    mission.react(at(4), Event::Lost(TWO));
    assert!(!mission.is_over(), "one that is away is waited for");
    rests(&mut mission, at(5), TWO, 0);
    assert_eq!((mission.awaited(), mission.is_over()), (Some(vec![]), false), "an observation is missing");
    mission.react(at(6), Event::Lost(ONE));
    see(&mut mission, at(7), &observation(ONE, 0, 5, 1.0));
    assert!(mission.is_over());
    receive(&mut mission, at(8), TWO, heartbeat(TWO, at(8), vec![]));
    assert!(!mission.is_over(), "one drives again");
    rests(&mut mission, at(8), TWO, 0);
    command(&mut mission, at(9), Command::Robot(TWO, RobotOrder::Search));
    assert_eq!(mission.awaited(), Some(vec![TWO]), "it rests where its search ends");
    command(&mut mission, at(9), Command::Team(TeamOrder::Search));
    assert_eq!((mission.awaited(), mission.is_over()), (None, false));
}

#[test]
fn a_mission_is_ended_at_once_by_its_own_operator_alone() {
    let mut mission = mission();
    rests(&mut mission, at(1), ONE, 0);
    command(&mut mission, at(2), Command::EndNow);
    assert_eq!((mission.awaited(), mission.is_over()), (Some(vec![ONE, TWO]), true));

    // Started again: it ends no mission that it was not told to end.
    let mut again = self::mission();
    again.directive = mission.directive.clone();
    rests(&mut again, at(1), ONE, 0);
    rests(&mut again, at(1), TWO, 0);
    assert_eq!((again.awaited(), again.is_over()), (Some(vec![]), false));
    command(&mut again, at(3), Command::Team(TeamOrder::End));
    assert!(!again.is_over(), "robots are told anew");
    rests(&mut again, at(4), ONE, 0);
    rests(&mut again, at(4), TWO, 0);
    assert!(again.is_over());
    command(&mut again, at(5), Command::EndNow);
    command(&mut again, at(6), Command::Team(TeamOrder::Pause));
    assert!(!again.is_over(), "it is resumed before the coordinator has ended");

    // Started again while a robot drives back: it goes on with the ending.
    let mut amid = self::mission();
    let Message::Heartbeat(mut beat) = heartbeat(ONE, at(1), vec![]) else { unreachable!() };
    (beat.activity, beat.directive) = (Activity::Returning, mission.directive().clone());
    receive(&mut amid, at(1), ONE, Message::Heartbeat(beat));
    rests(&mut amid, at(2), TWO, 0);
    assert_eq!((amid.awaited(), amid.is_over()), (Some(vec![ONE]), false));
    rests(&mut amid, at(3), ONE, 0);
    assert!(amid.is_over());
}
