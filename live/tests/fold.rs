//! The page shows the same of a running mission and of its recording at every time.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use dragnet_agent::agent::Agent;
use dragnet_coordinator::mission::{CoordinatorConfig, Mission, Record};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_coordinator::playback::Playback;
use dragnet_coordinator::record::{Header, Recorder};
use dragnet_coordinator::segment::{self, SegmentRow};
use dragnet_live::ask::Ask;
use dragnet_live::frame::{Frame, Hello, OrderFrame, Shown};
use dragnet_live::replay::{Replay, about};
use dragnet_live::view::{About, State, View};
use dragnet_proto::command::Command;
use dragnet_proto::directive::TeamOrder;
use dragnet_proto::message::{Message, OrderReport, VerdictReport};
use dragnet_proto::orders::RobotOrder;
use dragnet_proto::state_machine::{Effects, ParticipantError};
use dragnet_proto::state_machine::{Event, StateMachine};
use dragnet_proto::verdict::Decision;
use dragnet_proto::zones::Zone;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::detection::probability_of_detection;
use dragnet_search::evidence::Digest;
use dragnet_search::mark::{Clue, Mark, Searched};
use dragnet_search::observation::RobotId;
use dragnet_sim::episode;
use dragnet_sim::participants::{LocalParticipants, Participants};
use dragnet_sim::simulation::{End, Membership, Rules};

const SCENARIO: &str = "name = 'a'\nmap.file = 'map.txt'\nsensor.radius = 2\nobjects.count = 3\nrobots.count = 2\n\
                        [mission]\nbudget_seconds = 900.0\nheartbeat_seconds = 5.0\nliveness_timeout_seconds = 20.0\n";
const MAP: &str =
    "..........,,,\n..........,,,\n...##.....,,,\n..........,,,\n..........,,,\n..........,,,\n";

type Records = Arc<Mutex<Vec<(MissionTime, Record)>>>;

/// Participants whose coordinator receives commands at some of its steps.
struct Commanded<'a> {
    participants: LocalParticipants<'a>,
    /// The commands with their earliest times, the last first.
    commands: Vec<(u64, Command)>,
}

impl Participants for Commanded<'_> {
    type MessageRef = Message;
    type Error = ParticipantError;

    fn step(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let mut effects = self.participants.step(participant, now, event)?;
        if participant == Participant::Coordinator
            && self.commands.last().is_some_and(|it| now.as_seconds() >= it.0 as f64)
        {
            let (_, command) = self.commands.pop().unwrap();
            let more = self.participants.step(participant, now, Event::Commanded(command))?;
            effects.published.extend(more.published);
            effects.wake_at = more.wake_at;
        }
        Ok(effects)
    }

    fn digest(&mut self, participant: Participant, now: MissionTime) -> Result<Digest, ParticipantError> {
        self.participants.digest(participant, now)
    }
}

struct Played {
    scenario: Scenario,
    records: Vec<(MissionTime, Record)>,
    playback: Playback,
    added: Vec<Cell>,
}

/// A mission with a pause, marks, decisions about finds and cells that the operator adds, observed by a listener and recorded.
fn play() -> Played {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("map.txt"), MAP).unwrap();
    let scenario = Scenario::from_text(&folder.path().join("a.toml"), SCENARIO.to_owned()).unwrap();
    let file = folder.path().join("a.mcap");
    let agent_config = CoordinatorConfig::of(&scenario);
    let run = [
        ("scenario", "a"),
        ("robots", "2"),
        ("detection_threshold", "0.95"),
        ("sensor_radius", "1"),
        ("noise_variance", "0.005"),
    ];
    let header = Header {
        start_unix_ns: 946_684_800_000_000_000,
        terrain: Arc::clone(&agent_config.terrain),
        origin: scenario.origin(),
        prior: scenario.prior().clone(),
        scenario: SCENARIO.to_owned(),
        earth: scenario.earth(),
        run: run.into_iter().map(|(name, value)| (name.to_owned(), value.to_owned())).collect(),
    };
    let records = Records::default();
    let reported = Arc::clone(&records);
    let listener = Box::new(move |now, record: &Record| reported.lock().unwrap().push((now, record.clone())));
    let recorder = Recorder::create(&file, header).unwrap();
    let mut node =
        CoordinatorNode::new(Mission::new(agent_config), Some(recorder)).with_listener(Some(listener));
    let grid = scenario.terrain().grid();
    let added: Vec<Cell> =
        grid.cells().filter(|&cell| !scenario.terrain().is_searched(cell)).take(4).collect();
    let mut robots = episode::team(&scenario, 5, Agent::new);
    let cells = |numbers: &[u32]| numbers.iter().filter_map(|&number| grid.cell_numbered(number)).collect();
    let cell = grid.cell_numbered(3).unwrap();
    let clue = Mark::Clue(Clue { cell, ratio_thousandths: 5_000, radius_hundredths: 150 });
    let searched = |numbers: &[u32]| {
        let cells = numbers.iter().filter_map(|&number| grid.cell_numbered(number)).collect();
        Mark::Searched(Searched { cells, pod_thousandths: 700 })
    };
    let commands = vec![
        (270, Command::Team(TeamOrder::Search)),
        (260, Command::Team(TeamOrder::Return)),
        (250, Command::Team(TeamOrder::Search)),
        (240, Command::Robot(RobotId::new(2).unwrap(), RobotOrder::Search)),
        (220, Command::Robot(RobotId::FIRST, RobotOrder::Go(grid.cell_numbered(16).unwrap()))),
        (210, Command::Judge(Decision::Undone, grid.cell_numbered(5).unwrap())),
        (200, Command::Team(TeamOrder::Pause)),
        (180, Command::Unmark(152_500_000_000)),
        (170, Command::Judge(Decision::Dismissed, grid.cell_numbered(14).unwrap())),
        (160, Command::Judge(Decision::Confirmed, grid.cell_numbered(5).unwrap())),
        (155, Command::Zone(Zone::Open, cells(&[30, 31]))),
        (152, Command::Mark(searched(&[16, 17]), "withdrawn".to_owned())),
        (150, Command::Mark(searched(&[added[0].number(), 17]), "team 2".to_owned())),
        (140, Command::Zone(Zone::Skip, cells(&[31, 32]))),
        (130, Command::Zone(Zone::NoGo, cells(&[30, 31]))),
        (125, Command::Search(added.clone())),
        (100, Command::Mark(clue, "a glove".to_owned())),
    ];
    let participants = LocalParticipants::new(&mut robots, Some(&mut node));
    let mut participants = Commanded { participants, commands };
    let rules = Rules { end: End::Resting, coordinator: Membership::Present };
    let episode = episode::run_with(&scenario, 5, rules, &mut participants, &mut |_, _| ()).unwrap();
    assert!(participants.commands.is_empty(), "all commands were given");
    let objects: Vec<String> = episode.truth.objects().iter().map(|cell| cell.number().to_string()).collect();
    let digests: Vec<Digest> = robots.iter().map(|robot| robot.belief().digest()).collect();
    assert!(digests.iter().all(|&digest| digest == node.digest()), "all believe the same, marks too");
    let summary = BTreeMap::from([("object_cells".to_owned(), objects.join(","))]);
    node.finish(episode.outcome.ended, summary).unwrap();
    let records = std::mem::take(&mut *records.lock().unwrap());
    Played { scenario, records, playback: Playback::read(&file).unwrap(), added }
}

fn whole(view: &View) -> String {
    serde_json::to_string(&Frame::next(view, &mut Shown::default())).unwrap()
}

#[test]
fn a_recording_shows_at_every_time_the_same_as_the_running_mission() {
    let Played { scenario, records, playback, .. } = play();
    let live_about = About {
        name: "a".to_owned(),
        terrain: Arc::new(scenario.terrain().clone()),
        prior: About::prior_of(scenario.terrain(), scenario.prior()),
        sights: about(&playback).sights,
        sensors: about(&playback).sensors,
        speeds_meters_per_second: about(&playback).speeds_meters_per_second,
        subjects: scenario.subjects(),
        detection_threshold: scenario.mission().detection_threshold,
        team: scenario.robots().iter().map(|robot| robot.id).collect(),
        objects: about(&playback).objects,
        earth: scenario.earth(),
    };
    let mut live = View::new(Arc::new(live_about));
    let mut replay = Replay::new(Arc::new(playback));
    let end = replay.end();
    assert_eq!(Hello::new(&live, None), Hello::new(replay.view(), None));
    let mut taken = 0;
    let times: Vec<MissionTime> = (0..=60)
        .map(|part| MissionTime::START + Duration::from_nanos(end.0).mul_f64(f64::from(part) / 60.0))
        .collect();
    let mut shown = Vec::new();
    for &time in &times {
        while let Some((due, record)) = records.get(taken).filter(|(due, _)| *due <= time) {
            live.take(*due, record);
            taken += 1;
        }
        live.pass(time);
        replay.seek(time);
        assert_eq!(whole(&live), whole(replay.view()), "at {} s", time.as_seconds());
        shown.push(whole(&live));
    }
    for (&time, expected) in times.iter().zip(&shown).rev() {
        replay.seek(time);
        assert_eq!(&whole(replay.view()), expected, "back at {} s", time.as_seconds());
    }
    assert!(shown.iter().any(|frame| frame.contains("\"is_paused\":true") && frame.contains("\"paused\"")));
    assert!(shown.iter().any(|frame| frame.contains("\"state\":\"sent\",\"order\":\"go\"")));
    assert!(shown.iter().any(|frame| frame.contains("\"operator\":\"confirmed\"")));
    assert!(
        shown[60].contains("\"dismissed\":[{\"cell\":14,") && !shown[60].contains("confirmed\"}"),
        "{}",
        shown[60]
    );
    assert!(shown[60].contains("\"marks\":2") && shown[60].contains("\"added\":4"), "{}", shown[60]);
    assert!(shown[60].contains("\"note\":\"a glove\",\"cell\":3,\"ratio\":5.0,\"radius_meters\":"));
    assert!(shown[60].contains("\"note\":\"team 2\",\"cells\":") && shown[60].contains("\"pod\":0.7}"));
    assert!(
        shown.iter().any(|frame| frame.contains("\"note\":\"withdrawn\""))
            && !shown[60].contains("\"withdrawn\"")
    );
}

#[test]
fn the_segments_of_the_page_are_those_of_exports() {
    let Played { playback, .. } = play();
    let expected = segment::rows_of(&playback, None);
    let mut replay = Replay::new(Arc::new(playback));
    let before = Frame::next(replay.view(), &mut Shown::default()).segments.unwrap();
    replay.seek(replay.end());
    let mut shown = Shown::default();
    let given = Frame::next(replay.view(), &mut shown).segments.unwrap();
    assert_eq!(given, expected);
    let total = |rows: &[SegmentRow]| rows.last().unwrap().clone();
    let (before, total) = (total(&before), total(&given));
    assert!(
        total.name == "in all" && total.pod > before.pod && total.coverage > before.coverage,
        "{total:?}"
    );
    assert!(total.track_meters.unwrap() > 0.0 && total.sweep_width_meters.unwrap() > 0.0, "{total:?}");
    assert_eq!(Frame::next(replay.view(), &mut shown).segments, None, "nothing has changed");
}

#[test]
fn changes_and_a_whole_frame_come_to_the_same_picture() {
    let Played { records, playback, added, .. } = play();
    let mut view = View::new(Arc::new(about(&playback)));
    let mut shown = Shown::default();
    let first = Frame::next(&view, &mut shown);
    assert!(first.is_whole && first.levels.is_some());
    let decode =
        |text: &str| base64::Engine::decode(&base64::engine::general_purpose::STANDARD, text).unwrap();
    let mut levels = decode(first.levels.as_ref().unwrap());
    let mut searched = decode(first.searched.as_ref().unwrap());
    assert!(searched.iter().all(|&level| level == 0), "nothing is observed before the start");
    let (mut trail, mut deltas, mut wholes) = (0, 0, 0);
    for (number, (time, record)) in (1..).zip(&records) {
        view.take(*time, record);
        // A viewer that is slow at first, and then fast.
        if number < 40 {
            continue;
        }
        let frame = Frame::next(&view, &mut shown);
        assert!(!frame.is_whole);
        trail += frame.robots.iter().map(|robot| robot.trail.len()).sum::<usize>();
        if let Some(whole) = &frame.levels {
            levels = decode(whole);
            wholes += 1;
        }
        deltas += frame.changes.len();
        if let Some(whole) = &frame.searched {
            searched = decode(whole);
        }
        for (cell, level, searched_level) in frame.changes {
            levels[cell as usize] = level;
            searched[cell as usize] = searched_level;
        }
    }
    let last = Frame::next(&view, &mut Shown::default());
    assert_eq!(decode(&last.levels.unwrap()), levels);
    assert_eq!(decode(&last.searched.unwrap()), searched);
    assert!(levels[added[1].index()] > 0, "a cell that was added is searched");
    let fold = view.fold();
    assert!(added.iter().all(|&cell| fold.belief().log_odds_nats(cell).is_finite()), "in the belief");
    assert!(added.iter().all(|&cell| fold.belief().prior_probability(cell) > 0.0), "and in the prior");
    assert_eq!(last.robots.iter().map(|robot| robot.trail.len()).sum::<usize>(), trail);
    assert!(deltas > 20 && wholes > 0 && trail > 10, "{deltas} {wholes} {trail}");
}

/// The page updates it cell by cell; a whole computation must give the same.
#[test]
fn the_searched_layer_is_the_probability_of_detection() {
    let Played { records, playback, added, .. } = play();
    let mut view = View::new(Arc::new(about(&playback)));
    assert!(view.total_pod() <= 0.0 && view.terrain().grid().cells().all(|cell| view.pod(cell).is_none()));
    for (time, record) in &records {
        view.take(*time, record);
    }
    let (belief, terrain) = (view.belief(), view.terrain());
    let (mut mass, mut detected, mut unseen) = (0.0, 0.0, 0);
    for cell in terrain.searched_cells() {
        let evidence = belief.evidence().of(cell);
        let by_robots = probability_of_detection(belief.prior_log_odds_nats(cell), evidence, 0.95);
        let is_marked = cell == added[0] || cell.number() == 17;
        let expected = if is_marked { 1.0 - (1.0 - by_robots) * 0.3 } else { by_robots };
        match view.pod(cell) {
            Some(pod) => assert!((pod - expected).abs() < 1e-6, "{pod} {expected}"),
            None => unseen += 1,
        }
        assert_eq!(view.pod(cell).is_some(), evidence.precision > 0 || is_marked);
        mass += belief.prior_probability(cell);
        detected += belief.prior_probability(cell) * expected;
    }
    assert!((view.total_pod() - detected / mass).abs() < 1e-5, "{} {}", view.total_pod(), detected / mass);
    assert!(view.total_pod() > 0.3, "{}", view.total_pod());
    assert!(view.pod(added[0]).is_some(), "an added cell that is marked was searched");
    let outside = terrain.grid().cells().find(|&cell| !terrain.is_searched(cell)).unwrap();
    assert!(view.pod(outside).is_none() && unseen < terrain.searched_cells().count());
}

#[test]
fn finds_name_the_robot_that_made_them_and_a_recording_their_times() {
    let Played { records, playback, .. } = play();
    let mut replay = Replay::new(Arc::new(playback));
    let mut view = replay.view().clone();
    for (time, record) in &records {
        view.take(*time, record);
    }
    let last = Frame::next(&view, &mut Shown::default());
    assert!(!last.declared.is_empty());
    for object in &last.declared {
        assert!(object.robot.is_some_and(|robot| (1..=2).contains(&robot)), "{object:?}");
    }
    let seconds = replay.find_seconds();
    assert!(seconds.len() >= last.declared.len() && seconds.is_sorted(), "{seconds:?}");
    for &seconds in &seconds {
        let time = MissionTime::START + Duration::from_secs_f64(seconds);
        // Nothing is declared before the start.
        let before: Vec<Cell> = time.0.checked_sub(1_000_000).map_or_else(Vec::new, |before_ns| {
            replay.seek(MissionTime(before_ns));
            replay.view().declared().iter().map(|object| object.cell).collect()
        });
        replay.seek(time);
        let now = replay.view().declared();
        assert!(now.iter().any(|object| !before.contains(&object.cell)), "at {seconds} s");
    }
}

#[test]
fn a_recording_of_no_mission_is_rejected_by_name() {
    let error = Playback::read(Path::new("/no/such.mcap")).unwrap_err().to_string();
    assert!(error.contains("/no/such.mcap"), "{error}");
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), "no recording").unwrap();
    assert!(Playback::read(file.path()).is_err());
}

#[test]
fn a_silent_robot_is_shown_as_lost_without_a_plan() {
    let Played { records, playback, .. } = play();
    let mut view = View::new(Arc::new(about(&playback)));
    assert!(view.robots().all(|(.., state)| state == State::Awaited));
    let middle = records.len() / 4;
    for (time, record) in &records[..middle] {
        view.take(*time, record);
    }
    let planned = |view: &View| view.robots().filter(|(_, _, track, _)| track.plan.is_some()).count();
    assert_eq!(planned(&view), 2);
    let status = records[..middle].iter().rev().find_map(|(_, record)| match record {
        Record::Status(status) => Some(status.clone()),
        _ => None,
    });
    let mut status = status.unwrap();
    status.alive.retain(|robot| robot.number() == 2);
    status.doubled = vec![RobotId::FIRST];
    view.take(view.now(), &Record::Status(status));
    let is_lost: Vec<bool> = view.robots().map(|(.., state)| state == State::Lost).collect();
    assert_eq!(is_lost, [true, false]);
    assert_eq!(planned(&view), 1);
    let frame = Frame::next(&view, &mut Shown::default());
    assert_eq!(frame.robots.iter().map(|robot| robot.is_doubled).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn every_command_is_acknowledged_by_the_robots_that_have_it() {
    let Played { records, playback, .. } = play();
    let mut view = View::new(Arc::new(about(&playback)));
    let orders = |view: &View| Frame::next(view, &mut Shown::default()).orders.unwrap();
    let (mut waited, mut answered) = (BTreeSet::new(), BTreeSet::new());
    for (time, record) in &records {
        view.take(*time, record);
        for OrderFrame { what, robot, has, waits, .. } in orders(&view) {
            assert_eq!(has.len() + waits.len(), if robot.is_some() { 1 } else { 2 });
            waited.extend((waits.len() == 1).then_some(what));
            answered.extend(waits.is_empty().then_some(what));
        }
    }
    let all = [
        "area",
        "clue",
        "confirmed",
        "dismissed",
        "go",
        "no_go",
        "open",
        "pause",
        "resume",
        "return",
        "searched",
        "skip",
        "undone",
        "withdraw",
    ];
    assert_eq!(answered, all.into(), "all have it in the end");
    assert_eq!(waited, all.into(), "one robot has it before the other, and has it only after a while");
    assert_eq!(Frame::next(&view, &mut Shown::default()).zones.unwrap(), [[32, 1, 1]], "one cell is skipped");
    let last: Vec<_> = orders(&view).iter().map(|order| (order.what, order.robot, order.cell)).collect();
    let to_all = |what| (what, None, None);
    let to_one = [("resume", Some(2), None), ("go", Some(1), Some(16))];
    assert_eq!(last, [&["resume", "return", "resume"].map(to_all)[..], &to_one].concat());
}

#[test]
fn an_order_that_is_in_effect_is_answered_as_such() {
    let Played { records, playback, .. } = play();
    let mut view = View::new(Arc::new(about(&playback)));
    let answer = |view: &View, ask: Ask| ask.command(view).unwrap().1;
    let go = |view: &View| answer(view, Ask::Go { robot: 1, row: 1, column: 3 });
    let expected = "All robots search. Robots 1, 2 are not here: they follow once they are.";
    assert_eq!(answer(&view, Ask::Resume { robot: None }), expected, "they may know a pause");
    let mut left = records.iter().peekable();
    let mut take_until = |view: &mut View, seconds: f64| {
        while let Some((time, record)) = left.next_if(|(time, _)| time.as_seconds() < seconds) {
            view.take(*time, record);
        }
    };
    let paused = [(Some(2), "Robot 2 is paused already."), (None, "All robots are paused already.")];
    take_until(&mut view, 219.0);
    for (robot, expected) in paused {
        assert_eq!(answer(&view, Ask::Pause { robot }), expected);
    }
    assert_eq!(answer(&view, Ask::Return { robot: None }), "All robots are called back to their bases.");
    assert!(go(&view).ends_with("and stays there."), "{}", go(&view));
    take_until(&mut view, 239.0);
    assert_eq!(go(&view), "Robot 1 is sent to cell [1, 3] already.");
    assert_eq!(answer(&view, Ask::Pause { robot: None }), "All robots are paused.", "one is not");
    assert_eq!(answer(&view, Ask::Pause { robot: Some(2) }), "Robot 2 is paused already.");
}

#[test]
fn a_robot_that_is_cut_off_is_waited_for() {
    let Played { records, playback, .. } = play();
    let mut view = View::new(Arc::new(about(&playback)));
    let is_from_two = |record: &Record| match record {
        Record::Heartbeat(heartbeat) => heartbeat.robot.number() == 2,
        Record::Verdicts(VerdictReport { from, .. }) | Record::Orders(OrderReport { from, .. }) => {
            *from == Participant::Robot(RobotId::new(2).unwrap())
        }
        _ => false,
    };
    for (time, record) in records.iter().filter(|(_, record)| !is_from_two(record)) {
        view.take(*time, record);
    }
    let mut shown = Shown::default();
    for order in Frame::next(&view, &mut shown).orders.unwrap() {
        let expected = match order.robot {
            None => (vec![1], vec![2]),
            Some(1) => (vec![1], vec![]),
            Some(_) => (vec![], vec![2]),
        };
        assert_eq!((order.has, order.waits), expected, "{}", order.what);
    }
    assert_eq!(Frame::next(&view, &mut shown).orders, None, "nothing has changed");
    // It comes back.
    let last = |of: &dyn Fn(&Record) -> bool| records.iter().rev().find(|(_, record)| of(record)).unwrap();
    for (_, record) in [
        last(&|it| matches!(it, Record::Orders(_)) && is_from_two(it)),
        last(&|it| matches!(it, Record::Verdicts(_)) && is_from_two(it)),
        last(&|it| matches!(it, Record::Heartbeat(_)) && is_from_two(it)),
    ] {
        view.take(view.now(), record);
    }
    let orders = Frame::next(&view, &mut shown).orders.unwrap();
    assert!(orders.iter().all(|order| order.waits.is_empty()), "{orders:?}");
}
