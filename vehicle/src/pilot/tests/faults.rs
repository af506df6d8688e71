//! Missing or invalid input: the vehicle stops or continues as configured, a diagnostic is published, evidence is not
//! affected.

use super::*;
use crate::mentions::assert_mentions;
use crate::settings::{FaultResponse, OnFault};
use dragnet_lattice::costmap::LETHAL;
use dragnet_lattice::maneuvers::{Headings, Maneuvers};
use dragnet_lattice::mprim;
use std::collections::BTreeSet;

const ROUTE: [(u32, u32); 5] = [(2, 3), (2, 4), (2, 5), (2, 6), (2, 7)];

/// A vehicle that is driving, with this response to every fault.
fn under_way(response: FaultResponse) -> Drive {
    let mut settings = settings();
    settings.safety.on_fault =
        OnFault { pose: response, camera: response, clock: response, path: response, map: response };
    let mut drive = Drive::new(&settings);
    drive.step();
    drive.go(&ROUTE);
    drive.steps(2);
    drive
}

/// The same fault under both settings: the vehicle stands or drives; both report it.
fn check_both(fault: impl Fn(&mut Drive) -> Vec<Action>, expected: &str) {
    for response in [FaultResponse::Stop, FaultResponse::Continue] {
        let mut drive = under_way(response);
        let actions = fault(&mut drive);
        assert!(reported(&actions).contains(&expected.to_owned()), "{response:?}: {:?}", reported(&actions));
        assert_eq!(is_hold(&actions), response == FaultResponse::Stop, "{response:?}: {actions:?}");
        assert_eq!(drive.path.is_empty(), response == FaultResponse::Stop, "{response:?}");
    }
}

/// Given frames of one camera, correct ones of the others.
fn with_front(
    drive: &mut Drive,
    seconds: u64,
    front: impl Fn(CameraFrame) -> Option<CameraFrame>,
) -> Vec<Action> {
    let frame = |drive: &Drive, camera: &Camera| {
        let frame = drive.frame(camera);
        if frame.camera == "front" { front(frame) } else { Some(frame) }
    };
    (0..seconds * 5).flat_map(|_| drive.step_with(frame)).collect()
}

#[test]
fn a_camera_that_stops() {
    check_both(|drive| with_front(drive, 4, |_| None), "silence of front Error");
    let mut drive = under_way(FaultResponse::Stop);
    with_front(&mut drive, 4, |_| None);
    assert!(drive.path.is_empty());
    assert!(drive.step().is_empty(), "not believed yet");
    let actions = drive.steps(4);
    assert!(reported(&actions).contains(&"silence of front Ok".to_owned()) && is_drive(&actions));
    assert_eq!(sensed(&drive.steps(40)).last(), cells(&ROUTE).last());
}

#[test]
fn a_detector_that_returns_no_numbers_or_ten_thousand_boxes() {
    let no_number = |frame: CameraFrame| {
        let bad = DetectionBox { left: f64::NAN, top: 1.0, right: 9.0, bottom: 9.0 };
        let good = DetectionBox { left: 1.0, top: 1.0, right: 9.0, bottom: 9.0 };
        Some(CameraFrame { detections: CameraDetections::Boxes(vec![good, bad]), ..frame })
    };
    let many = |frame: CameraFrame| {
        let boxed = |n: u32| DetectionBox { left: f64::from(n) / 10.0, top: 0.0, right: 1500.0, bottom: 9.0 };
        Some(CameraFrame { detections: CameraDetections::Boxes((0..10_000).map(boxed).collect()), ..frame })
    };
    let bearing = |frame: CameraFrame| {
        Some(CameraFrame { detections: CameraDetections::Bearings(vec![0.0, f64::INFINITY]), ..frame })
    };
    // Beside the vehicle, out of this camera's view.
    let elsewhere =
        |frame: CameraFrame| Some(CameraFrame { detections: CameraDetections::Bearings(vec![2.5]), ..frame });
    check_both(|drive| with_front(drive, 4, no_number), "camera front Warning");
    check_both(|drive| with_front(drive, 4, many), "silence of front Error");
    for (bad, expected) in [
        (&no_number as &dyn Fn(CameraFrame) -> Option<CameraFrame>, "box 1 of 2 .. not a number"),
        (&many, "10000 boxes .. 256"),
        (&bearing, "bearing 1 .. no number"),
        (&elsewhere, "bearing 0 .. 2.5 radians"),
    ] {
        let mut drive = under_way(FaultResponse::Continue);
        drive.steps(5);
        let actions = with_front(&mut drive, 10, bad);
        assert_mentions(&message(&actions), expected);
        assert!(drive.pilot.tracks().is_empty(), "nothing came of it");
        // Cells out of the other cameras' view do not read as empty, once the last observation with good frames is
        // over.
        let ahead = readings(&actions).iter().filter(|it| it.cell == cells(&[(2, 9)])[0]).count();
        assert!(ahead <= 1, "{expected}: {ahead}");
    }
}

#[test]
fn a_detector_with_more_false_alarms_than_its_settings_say() {
    let mut drive = under_way(FaultResponse::Stop);
    let alarm = |frame: CameraFrame| {
        // Far from each other, so that no track explains two of them.
        let bearing = (frame.time_ns / STEP_NS % 7) as f64 / 4.0 - 0.75;
        Some(CameraFrame { detections: CameraDetections::Bearings(vec![bearing]), ..frame })
    };
    assert_eq!(reported(&with_front(&mut drive, 19, alarm)), Vec::<String>::new(), "too few frames to say");
    let actions = with_front(&mut drive, 20, alarm);
    assert_eq!(reported(&actions), ["false alarms of front Warning"]);
    assert_mentions(&message(&actions), "false alarms a frame .. tracker.false_alarms_per_frame is 0.05");
    assert!(!is_hold(&actions), "it goes on");
}

#[test]
fn dirt_on_a_lens() {
    let mut drive = under_way(FaultResponse::Stop);
    let dirt =
        |frame: CameraFrame| Some(CameraFrame { detections: CameraDetections::Bearings(vec![0.2]), ..frame });
    let mut actions = Vec::new();
    for _ in 0..60 {
        drive.path.clear();
        drive.pose.heading_radians = wrapped_radians(drive.pose.heading_radians + 0.3);
        actions.extend(with_front(&mut drive, 1, dirt));
    }
    assert!(reported(&actions).contains(&"lens of front Warning".to_owned()), "{:?}", reported(&actions));
}

#[test]
fn a_pose_that_jumps_and_one_outside_of_the_map() {
    let jumped = |drive: &mut Drive, pose: Pose| {
        drive.now_ns += STEP_NS;
        let fix = PoseEstimate { pose, ..drive.fix() };
        drive.tell(Event::Pose(fix))
    };
    let at = |x, y| Pose::new(x, y, 0.0);
    check_both(|drive| jumped(drive, at(95.0, 95.0)), "pose Error");
    check_both(|drive| jumped(drive, at(-30.0, 25.0)), "pose Error");
    check_both(|drive| jumped(drive, at(f64::NAN, 25.0)), "pose Error");
    check_both(
        |drive| {
            drive.now_ns += STEP_NS;
            let fix = PoseEstimate { deviation_meters: 40.0, ..drive.fix() };
            drive.tell(Event::Pose(fix))
        },
        "pose Error",
    );
    let mut drive = under_way(FaultResponse::Stop);
    assert!(message(&jumped(&mut drive, at(95.0, 95.0))).contains("jumped farther than the vehicle drives"));
    assert!(drive.step().is_empty(), "not believed yet");
    assert!(is_drive(&drive.steps(4)), "one wrong pose does no harm");
}

#[test]
fn after_a_jump_that_lasts_all_begins_anew() {
    let mut drive = under_way(FaultResponse::Stop);
    drive.objects = vec![Vector2::new(45.0, 45.0)];
    drive.steps(6);
    assert_eq!(drive.pilot.tracks().len(), 1);
    drive.pose = Pose::new(95.0, 95.0, 0.0);
    drive.objects.clear();
    let actions = drive.steps(2);
    assert!(sensed(&actions).is_empty() && is_hold(&actions), "not believed yet");
    let actions = drive.steps(4);
    assert_eq!(sensed(&actions).first(), cells(&[(9, 9)]).first());
    assert!(drive.pilot.tracks().is_empty(), "where it was seen from meant nothing");
    assert!(readings(&actions[..]).is_empty(), "nothing seen before the jump is told from there");
}

#[test]
fn poses_that_stop() {
    check_both(
        |drive| {
            drive.now_ns += 2 * SECOND;
            drive.tell(Event::Tick)
        },
        "pose Error",
    );
    let mut drive = Drive::new(&settings());
    drive.tell(Event::Tick);
    drive.now_ns += 2 * SECOND;
    assert_eq!(message(&drive.tell(Event::Tick)), "no pose arrives", "not even the first");
    let mut drive = under_way(FaultResponse::Continue);
    let before = drive.actions.len();
    for _ in 0..20 {
        drive.now_ns += STEP_NS;
        let frame = drive.frame(&drive.cameras[0].clone());
        drive.tell(Event::Frame(frame));
    }
    assert!(sensed(&drive.actions[before..]).is_empty(), "nobody knows from where that was seen");
}

/// A minute of poses and frames 20 times per second, with given stamps.
fn stamped(drive: &mut Drive, stamp: impl Fn(&Drive) -> u64) -> Vec<Action> {
    let before = drive.actions.len();
    for _ in 0..60 * 20 {
        drive.now_ns += SECOND / 20;
        let time_ns = stamp(drive);
        let (fix, frame) = (drive.fix(), drive.frame(&drive.cameras[0].clone()));
        drive.tell(Event::Pose(PoseEstimate { time_ns, ..fix }));
        drive.tell(Event::Frame(CameraFrame { time_ns, ..frame }));
    }
    drive.actions[before..].to_vec()
}

type Stamp = fn(&Drive) -> u64;

/// The reports of a subject, in order.
fn messages(actions: &[Action], subject: &str) -> Vec<String> {
    let of_subject = |action: &Action| match action {
        Action::Tell(diagnostic) if diagnostic.name == subject => Some(diagnostic.message.clone()),
        _ => None,
    };
    actions.iter().filter_map(of_subject).collect()
}

#[test]
fn stamps_that_cannot_be_of_now_are_one_alarm_that_names_its_cause() {
    let frozen = "stamps stand still; set `stamps = \"arrival\"` if this computer's clock should count";
    let zero = "stamped before the mission began, or not at all; set `stamps = \"arrival\"` if";
    let old = "stamped 20.0 s before this computer's clock; set `stamps";
    let ahead = "stamped 20.0 s ahead of this computer's clock; set `stamps";
    let cases: [(Stamp, &str); 4] = [
        (|_| 100 * SECOND + STEP_NS, frozen),
        (|_| 0, zero),
        (|drive| drive.now_ns - 20 * SECOND, old),
        (|drive| drive.now_ns + 20 * SECOND, ahead),
    ];
    for (stamp, cause) in cases {
        let mut drive = Drive::new(&settings());
        drive.now_ns = 100 * SECOND;
        drive.step();
        let actions = stamped(&mut drive, stamp);
        for subject in ["pose", "camera front"] {
            let reported = messages(&actions, subject);
            assert!(reported.last().unwrap().starts_with(cause), "{subject}: {reported:?}");
            assert!(
                reported.len() <= 2 && !reported.contains(&"well again".to_owned()),
                "{subject}: {reported:?}"
            );
        }
        assert_eq!(messages(&actions, "silence of front"), ["no frame comes that can be used"]);
        let refused = |source: &InputSource| {
            actions
                .iter()
                .filter(|action| matches!(action, Action::Refuse(from, _) if from == source))
                .count()
        };
        assert!(refused(&InputSource::Pose) > 1000, "{cause}");
        assert!(refused(&InputSource::Camera("front".to_owned())) > 1000, "{cause}");
        assert!(readings(&actions).is_empty(), "{cause}");
    }
}

#[test]
fn a_pose_that_is_good_and_bad_in_turn_stops_the_vehicle_once() {
    let mut drive = under_way(FaultResponse::Stop);
    let before = drive.actions.len();
    for turn in 0..40 * 60 {
        drive.now_ns += SECOND / 40;
        let fix = drive.fix();
        let x_meters = if turn % 2 == 0 { f64::NAN } else { fix.pose.x_meters };
        drive.tell(Event::Pose(PoseEstimate { pose: Pose { x_meters, ..fix.pose }, ..fix }));
        for camera in drive.cameras.clone() {
            drive.tell(Event::Frame(drive.frame(&camera)));
        }
    }
    let actions = &drive.actions[before..];
    assert_eq!(reported(actions), ["pose Error"]);
    assert_eq!(actions.iter().filter(|action| matches!(action, Action::Hold)).count(), 1);
    assert!(!is_drive(actions));
    let actions = drive.steps(4);
    assert!(reported(&actions) == ["pose Ok"] && is_drive(&actions));
}

#[test]
fn time_that_runs_backwards() {
    check_both(
        |drive| {
            drive.now_ns -= SECOND;
            drive.tell(Event::Tick)
        },
        "clock Error",
    );
    let mut drive = under_way(FaultResponse::Stop);
    drive.steps(5);
    drive.now_ns = 0;
    let actions = drive.steps(8);
    assert_eq!(
        reported(&actions)[..2],
        ["clock Error", "clock Ok"],
        "a clock that was set is believed in the end"
    );
    assert!(is_drive(&actions));
    assert_eq!(sensed(&drive.steps(40)).last(), cells(&ROUTE).last());
    // A sensor's clock may run backward too.
    let late = PoseEstimate { time_ns: drive.now_ns - SECOND, ..drive.fix() };
    assert_eq!(reported(&drive.tell(Event::Pose(late))), ["pose Error"]);
}

#[test]
fn frames_wait_for_their_pose_and_unknown_cameras_are_reported() {
    let mut drive = Drive::new(&settings());
    drive.step();
    let mut frame = drive.frame(&drive.cameras[0].clone());
    frame.camera = "rear".to_owned();
    let actions = drive.tell(Event::Frame(frame));
    assert_eq!(reported(&actions), ["camera rear Warning"]);
    assert!(message(&actions).ends_with("there are front, left, right"), "{actions:?}");
    drive.objects = vec![Vector2::new(45.0, 25.0)];
    drive.now_ns += STEP_NS;
    let early = drive.frame(&drive.cameras[0].clone());
    drive.tell(Event::Frame(early));
    assert!(drive.pilot.tracks().is_empty());
    drive.step_with(|_, _| None);
    assert!(drive.pilot.tracks().is_empty(), "the other cameras may tell of that time yet");
    (0..5).for_each(|_| drop(drive.step_with(|_, _| None)));
    assert_eq!(drive.pilot.tracks().len(), 1, "the pose before and the one after tell where that was");
}

/// Cells that the path to the end of a straight run enters, around an obstacle in the middle of it.
fn entered_with_closed(closed: &[(u32, u32)]) -> BTreeSet<Cell> {
    let mut drive = Drive::new(&settings());
    drive.step();
    let mut map = CostMap::from_terrain(scenario().terrain(), 8).unwrap();
    let grid = map.grid();
    for cell in grid.cells() {
        let Position { row, column } = grid.position(cell);
        if (16..24).contains(&row) && (32..40).contains(&column) {
            map.set(cell, LETHAL).unwrap();
        }
    }
    drive.tell(Event::Map(map));
    drive.tell(Event::Closed(cells(closed).into_iter().collect()));
    let actions = drive.go(&[(2, 3), (2, 4), (2, 5), (2, 6)]);
    let plan = actions.iter().find_map(|it| if let Action::Drive(plan) = it { Some(plan) } else { None });
    let whole = CostMap::from_terrain(scenario().terrain(), 1).unwrap();
    plan.unwrap().poses.iter().filter_map(|pose| whole.cell_at(pose.x_meters, pose.y_meters)).collect()
}

#[test]
fn a_path_around_an_obstacle_avoids_closed_cells() {
    for row in [1, 3] {
        let closed: Vec<(u32, u32)> = (0..12).map(|column| (row, column)).collect();
        let entered = entered_with_closed(&closed);
        let [south, north] =
            [1, 3].map(|row| (0..12).any(|column| entered.contains(&cells(&[(row, column)])[0])));
        assert_eq!([south, north], [row == 3, row == 1], "{entered:?}");
    }
}

/// A map on which nothing leads into column 5.
fn walled() -> CostMap {
    let mut map = CostMap::from_terrain(scenario().terrain(), 8).unwrap();
    let grid = map.grid();
    for cell in grid.cells() {
        if (40..48).contains(&grid.position(cell).column) {
            map.set(cell, LETHAL).unwrap();
        }
    }
    map
}

#[test]
fn a_goal_that_cannot_be_reached() {
    check_both_ways(FaultResponse::Stop);
    check_both_ways(FaultResponse::Continue);
}

fn check_both_ways(response: FaultResponse) {
    let mut drive = under_way(response);
    let actions = drive.tell(Event::Map(walled()));
    assert_eq!(reported(&actions), ["path Warning"]);
    assert!(is_hold(&actions) && drive.path.is_empty(), "there is no other run");
    assert!(message(&actions).contains("no path leads"), "{actions:?}");
    // When it continues, it asks the agent again, by reporting its cell.
    let actions = drive.steps(12);
    let asked = sensed(&actions);
    assert_eq!(asked.is_empty(), response == FaultResponse::Stop, "{asked:?}");
    assert!(asked.len() <= 2, "no more often than it could enter cells");
    let failed = actions
        .iter()
        .filter_map(|it| if let Action::RouteFailed { blocked } = it { Some(blocked) } else { None });
    let expected: Vec<Vec<Cell>> = asked
        .iter()
        .enumerate()
        .map(|(time, _)| if time == 0 { cells(&ROUTE[4..]) } else { Vec::new() })
        .collect();
    assert_eq!(failed.cloned().collect::<Vec<_>>(), expected, "told once");
    with_front(&mut drive, 4, |_| None);
    let asked = sensed(&drive.steps(12));
    assert_eq!(asked.is_empty(), response == FaultResponse::Stop, "after another fault too");
    let actions = drive.tell(Event::Map(CostMap::from_terrain(scenario().terrain(), 8).unwrap()));
    if response == FaultResponse::Stop {
        assert!(is_drive(&actions), "the way is free again");
        assert_eq!(reported(&drive.steps(4)), ["path Ok"]);
    }
    let mut drive = under_way(response);
    drive.tell(Event::Map(walled()));
    let actions = drive.go(&[(2, 3), (2, 4), (2, 5), (1, 5), (1, 4)]);
    assert!(is_hold(&actions) || drive.path.is_empty() == (response == FaultResponse::Stop), "{actions:?}");
}

#[test]
fn a_map_that_changes_its_size() {
    let mut drive = under_way(FaultResponse::Stop);
    // Finer, and of a larger area: generated motion primitives fit any resolution.
    let grid = dragnet_search::cell::Grid::new(400, 300).unwrap();
    let finer = CostMap::new(grid, 0.5, (-10.0, -10.0), vec![0; grid.cell_count()]).unwrap();
    let actions = drive.tell(Event::Map(finer));
    assert!(is_drive(&actions) && reported(&actions).is_empty(), "planned anew");
    assert_eq!(sensed(&drive.steps(40)).last(), cells(&ROUTE).last());

    // Motion primitives from a file fit one resolution only.
    let maneuvers = Maneuvers {
        resolution_meters: 1.25,
        headings: Headings::Sixteen,
        turning_radius_meters: 3.0,
        reverse: None,
        turn_in_place: None,
    };
    let text = mprim::write(&maneuvers.primitives().unwrap());
    for response in [FaultResponse::Stop, FaultResponse::Continue] {
        let motion = toml::from_str("kind = 'lattice'\nprimitives = 'a.mprim'").unwrap();
        let mut settings = Settings { motion, ..settings() };
        settings.safety.on_fault.map = response;
        let mut drive = Drive::new(&super::settings());
        let map = CostMap::from_terrain(scenario().terrain(), 8).unwrap();
        let checked = settings.check(Some(&text)).unwrap();
        drive.pilot =
            Pilot::new(checked, scenario().terrain().clone(), scenario().sensor().clone(), &map).unwrap();
        drive.step();
        drive.go(&ROUTE);
        let small = CostMap::from_terrain(scenario().terrain(), 4).unwrap();
        let actions = drive.tell(Event::Map(small));
        assert_eq!(reported(&actions), ["map Error"]);
        assert_mentions(&message(&actions), "primitives .. 1.25 m .. 2.5 m");
        assert_eq!(
            (is_hold(&actions), drive.path.is_empty()),
            (response == FaultResponse::Stop, response == FaultResponse::Stop)
        );
        let same = CostMap::from_terrain(scenario().terrain(), 8).unwrap();
        let mut actions = drive.tell(Event::Map(same));
        actions.extend(drive.steps(4));
        assert!(reported(&actions) == ["map Ok"] && is_drive(&actions));
    }
}

#[test]
fn a_vehicle_on_blocked_ground_reports_no_cell() {
    let drawing = "............\n".repeat(9) + "..#.........\n" + &"............\n".repeat(2);
    let terrain = Terrain::from_ascii(&drawing, 10.0).unwrap();
    let mut drive = Drive::on(&settings(), &terrain, 8);
    let actions = drive.step();
    assert!(sensed(&actions).is_empty());
    assert_eq!(reported(&actions), ["ground Warning"]);
    drive.pose = Pose::new(25.0, 15.4, 0.0);
    drive.now_ns += 60 * SECOND;
    assert_eq!(sensed(&drive.step()), cells(&[(1, 2)]));
}

/// An emergency stop acts whatever the settings say of faults; released, the vehicle goes on at once.
#[test]
fn an_interlock_stops_the_vehicle_until_it_is_released() {
    let pressed = || {
        let message = "it is pressed".to_owned();
        Some(InterlockFault { kind: "pressed", message })
    };
    for interlock in [Interlock::EmergencyStop, Interlock::Battery] {
        let mut drive = under_way(FaultResponse::Continue);
        let actions = drive.tell(Event::Interlock(interlock, pressed()));
        assert!(is_hold(&actions) && message(&actions).contains("it is pressed"), "{actions:?}");
        let place = drive.pose;
        let again: Vec<Action> = (0..50)
            .flat_map(|_| {
                let mut actions = drive.tell(Event::Interlock(interlock, pressed()));
                actions.extend(drive.step());
                actions
            })
            .collect();
        assert!(reported(&again).is_empty() && !is_drive(&again) && !is_hold(&again), "{again:?}");
        assert_eq!(drive.pose, place);
        let actions = drive.tell(Event::Interlock(interlock, None));
        assert!(is_drive(&actions), "{:?}", reported(&actions));
        assert!(reported(&actions)[0].ends_with(" Ok"), "{:?}", reported(&actions));
        assert_eq!(sensed(&drive.steps(40)).last(), cells(&ROUTE).last());
    }
}

/// The vehicle's own map has walls in cells in which it could stand by that of the search.
#[test]
fn of_cells_that_are_too_narrow_all_are_told_with_the_first() {
    let mut drive = Drive::new(&settings());
    let terrain = scenario().terrain().clone();
    let mut map = CostMap::from_terrain(&terrain, 8).unwrap();
    let narrow = cells(&[(2, 4), (7, 7), (11, 0)]);
    for square in map.grid().cells() {
        let (x_meters, y_meters) = map.center_meters(square);
        if terrain.grid().cell_at(x_meters / 10.0, y_meters / 10.0).is_some_and(|cell| narrow.contains(&cell))
        {
            map.set(square, LETHAL).unwrap();
        }
    }
    drive.step();
    drive.tell(Event::Map(map));
    drive.go(&[(2, 3), (2, 4)]);
    let actions = drive.steps(10);
    let failed: Vec<&Vec<Cell>> = actions
        .iter()
        .filter_map(|action| if let Action::RouteFailed { blocked } = action { Some(blocked) } else { None })
        .collect();
    assert_eq!(failed.first(), Some(&&narrow), "{:?}", reported(&actions));
}

#[test]
fn the_agent_is_told_what_the_walls_of_a_map_hide_once() {
    let mut drive = Drive::new(&settings());
    let told = |actions: &[Action]| {
        let told = |action: &Action| match action {
            Action::LineOfSight(line_of_sight) => Some(line_of_sight.clone()),
            _ => None,
        };
        actions.iter().filter_map(told).collect::<Vec<_>>()
    };
    assert_eq!(told(&drive.step()), []);
    let [ref line_of_sight] = told(&drive.tell(Event::Map(walled())))[..] else { panic!("not told once") };
    let grid = scenario().terrain().grid();
    let [west, wall, east] = [4, 5, 6].map(|column| cells(&[(2, column)])[0]);
    assert!(!line_of_sight.hides(west, grid.offset(west, wall)));
    assert!(line_of_sight.hides(west, grid.offset(west, east)));
    assert!(line_of_sight.hides(east, grid.offset(east, west)));
    assert_eq!(told(&drive.tell(Event::Map(walled()))), [], "nothing has changed");
    assert_eq!(told(&drive.steps(4)), []);
}

#[test]
fn a_vehicle_that_no_longer_moves_gives_its_run_up_unless_it_is_to_stop() {
    for (response, is_given_up) in [(FaultResponse::Continue, true), (FaultResponse::Stop, false)] {
        let mut drive = under_way(response);
        let mut stand = |seconds: u64| {
            let end_ns = drive.now_ns + seconds * SECOND;
            let mut actions = Vec::new();
            while drive.now_ns < end_ns {
                // Whatever it is told to drive.
                drive.path.clear();
                actions.extend(drive.step());
            }
            actions
        };
        assert!(reported(&stand(28)).is_empty(), "it may wait for something that passes");
        let actions = stand(5);
        assert_eq!(reported(&actions).contains(&"path Warning".to_owned()), is_given_up, "{actions:?}");
        if is_given_up {
            assert!(message(&actions).contains("it has not moved for 30 s"), "{actions:?}");
        }
    }
    // One that has never moved may still be about to start.
    let mut settings = settings();
    settings.safety.on_fault.path = FaultResponse::Continue;
    let mut drive = Drive::new(&settings);
    drive.step();
    drive.go(&ROUTE);
    for _ in 0..400 {
        drive.path.clear();
        assert!(reported(&drive.step()).is_empty());
    }
}
