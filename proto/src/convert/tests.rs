use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Observation, Origin, RobotId, Source, Version};

use super::*;
use crate::directive::{Directive, TeamOrder};
use crate::mentions::assert_mentions;
use crate::message::{Activity, Heartbeat, Intent, SyncReply};

fn grid() -> Grid {
    Grid::new(2, 3).unwrap()
}

fn cell(number: u32) -> Cell {
    grid().cell_numbered(number).unwrap()
}

fn observation(robot: u16, sequence: u64) -> Observation {
    let readings = vec![Reading { cell: cell(4), value: 0.5, variance: 0.25 }];
    Observation {
        origin: Origin::first(RobotId::new(robot).unwrap()),
        sequence,
        time_ns: 9,
        from: cell(5),
        readings,
        positions: Box::default(),
    }
}

fn intent(robot: u16) -> Intent {
    Intent {
        robot: RobotId::new(robot).unwrap(),
        incarnation: 8,
        decision: 1,
        time_ns: 2,
        path: vec![cell(0), cell(3)].into(),
    }
}

fn heartbeat() -> Heartbeat {
    Heartbeat {
        robot: RobotId::new(7).unwrap(),
        time_ns: 3,
        activity: Activity::Stuck,
        cell: cell(1),
        path_meters: 60.0,
        intent: intent(7),
        versions: vec![Version { origin: Origin::first(RobotId::new(7).unwrap()), next: 4 }].into(),
        digest: Digest(0x0123_4567_89ab_cdef_0011_2233_4455_6677),
        directive: Directive {
            number: 5,
            order: TeamOrder::Return,
            added: [0, 1, 4].into_iter().map(cell).collect(),
        },
    }
}

/// The codec's error for an invalid wire struct.
fn refusal<T: RosMessage>(kind: MessageKind, message: &T) -> String {
    Codec::new(grid()).decode(kind, &cdr::encode(message)).unwrap_err().to_string()
}

#[test]
fn an_observation_has_the_bytes_that_its_definition_gives_it() {
    let mut expected = vec![0, 1, 0, 0, 5, 0]; // header; version and its padding
    expected.extend([2, 1, 0, 0, 0, 0]); // robot 258 and padding to 8
    expected.extend([0, 0, 0, 0, 0, 0, 0, 0]); // incarnation
    expected.extend([3, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0]); // sequence, time
    expected.extend([5, 0, 0, 0]); // cell
    expected.extend([1, 0, 0, 0, 4, 0, 0, 0]); // cells
    expected.extend([1, 0, 0, 0, 0, 0, 0, 0x3f]); // values
    expected.extend([1, 0, 0, 0, 0, 0, 0x80, 0x3e]); // variances
    let mut earlier = expected.clone();
    expected.extend([0, 0, 0, 0]); // positions
    let read = |bytes: &[u8]| Codec::new(grid()).decode(MessageKind::Observation, bytes).unwrap();
    let message = Message::Observation(Arc::new(observation(258, 3)));
    assert_eq!(encode(&message), expected);
    assert_eq!(read(&expected), message);
    // As recordings and journals of version 4 have it.
    earlier[4] = 4;
    assert_eq!(read(&earlier), message);
    let located =
        Message::Observation(Arc::new(Observation { positions: [position()].into(), ..observation(258, 3) }));
    let end = expected.len() - 4;
    expected[end] = 1;
    expected.extend([5, 0, 0, 0, 4, 0, 0, 0]); // version and its padding, cell
    expected.extend([0, 0, 0, 0, 0, 0, 0xf8, 0x3f, 0, 0, 0, 0, 0, 0, 0x04, 0x40]); // 1.5 and 2.5 m
    expected.extend([0, 0, 0x80, 0x3f, 0, 0, 0, 0x3f, 0, 0, 0, 0x40]); // 1, 0.5 and 2 m2
    assert_eq!(encode(&located), expected);
    assert_eq!(read(&expected), located);
}

fn position() -> ObjectPosition {
    ObjectPosition::new(cell(4), [1.5, 2.5], [1.0, 0.5, 2.0]).unwrap()
}

#[test]
fn impossible_positions_of_objects_are_rejected_by_field() {
    let check = |change: fn(&mut wire::ObjectPosition), expected: &str| {
        let mut wire = wire::Observation::from(&Observation {
            positions: [ObjectPosition::new(cell(2), [0.0; 2], [1.0; 3]).unwrap(), position()].into(),
            ..observation(7, 0)
        });
        change(&mut wire.positions[1]);
        let refused = refusal(MessageKind::Observation, &wire);
        assert_mentions(&refused, &format!("dragnet_msgs/msg/Observation: positions[1] .. {expected}"));
    };
    check(|wire| wire.version = 4, "4 .. 5");
    check(|wire| wire.cell = 6, "6 .. 0 to 5");
    check(|wire| wire.cell = 2, "2 after 2 .. ascending");
    check(|wire| wire.east_meters = f64::NAN, "NaN .. finite");
    check(|wire| wire.north_meters = f64::INFINITY, "inf .. finite");
    check(|wire| wire.covariance_square_meters[0] = -1.0, "-1.0 .. semi-definite");
    check(|wire| wire.covariance_square_meters[1] = 1.5, "1.5 .. semi-definite");
    check(|wire| wire.covariance_square_meters[2] = 2e6, "2000000 .. 1000000");
    let mut many = wire::Observation::from(&observation(7, 0));
    many.positions = vec![wire::ObjectPosition::from(&position()); 17];
    assert_mentions(&refusal(MessageKind::Observation, &many), "positions .. 17 .. 16");
}

#[test]
fn a_position_takes_few_bytes_of_a_packed_message_and_none_takes_none() {
    let scenario = Scenario::from_text(
        std::path::Path::new("a.toml"),
        "name = 'a'\nmap = { shape = 'all_traversable', rows = 2, columns = 3 }\nobjects.count = 1\n\
         network.bytes_per_second = 1000.0\nrobots.count = 1\n\
         sensor.radius = 1\nmission.budget_seconds = 60.0\n"
            .to_owned(),
    );
    let codec = Codec::of(&scenario.unwrap());
    let bytes = |positions: &[ObjectPosition]| {
        let observation = Observation { positions: positions.into(), ..observation(1, 0) };
        let message = Message::Observation(Arc::new(observation));
        let bytes = codec.encode(&message);
        assert_eq!(codec.decode(MessageKind::Observation, &bytes).unwrap(), message);
        bytes
    };
    let (without, with) = (bytes(&[]), bytes(&[position()]));
    assert_eq!(with.len() - without.len(), 30, "number, cell, two numbers of 8 bytes and three of 4");
    // Those of earlier programs.
    assert_eq!(without[..2], [0xD7, 1]);
    assert_eq!(without.len(), 15);
}

#[test]
fn the_length_of_a_message_is_that_of_its_bytes() {
    let codec = Codec::new(grid());
    for robots in 0..5 {
        let version = |robot| Version { origin: Origin::first(RobotId::new(robot).unwrap()), next: 4 };
        for path in [vec![], vec![cell(0)], vec![cell(0), cell(3)]] {
            let versions: Vec<Version> = (1..=robots).map(version).collect();
            let intent = Intent { path: path.into(), ..intent(7) };
            let message = Message::Heartbeat(Heartbeat { intent, versions: versions.into(), ..heartbeat() });
            assert_eq!(codec.encoded_len(&message), codec.encode(&message).len());
        }
    }
}

#[test]
fn a_digest_travels_upper_half_first() {
    let wire = wire::Heartbeat::from(&heartbeat());
    assert_eq!(wire.digest, [0x0123_4567_89ab_cdef, 0x0011_2233_4455_6677]);
}

#[test]
fn an_observation_out_of_range_is_rejected_by_field() {
    let check = |change: fn(&mut wire::Observation), expected: &str| {
        let mut wire = wire::Observation::from(&observation(7, 0));
        change(&mut wire);
        assert_mentions(
            &refusal(MessageKind::Observation, &wire),
            &format!("dragnet_msgs/msg/Observation .. {expected}"),
        );
    };
    check(|wire| wire.version = 1, "version .. 1 .. 5");
    check(|wire| wire.cell = 6, "cell .. 6 .. 0 to 5");
    check(|wire| wire.cells[0] = 99, "cells[0] .. 99 .. 0 to 5");
    check(|wire| wire.values[0] = f32::NAN, "values[0] .. NaN .. 0.25 .. -1000 to 1000 .. 0.000001 to 10000");
    check(|wire| wire.variances.push(1.0), "variances .. 2 .. 1 .. `cells`");
    check(
        |wire| {
            wire.cells = vec![0; 20_202];
            wire.values = vec![0.0; 20_202];
            wire.variances = vec![1.0; 20_202];
        },
        "cells .. 20202 .. 20201",
    );
}

#[test]
fn another_version_is_named_even_if_its_fields_are_others() {
    let error = Codec::new(grid()).decode(MessageKind::SyncRequest, &[0, 1, 0, 0, 9, 8, 7]);
    let expected = "dragnet_msgs/msg/SyncRequest .. version .. 9 .. 4";
    assert_mentions(&error.unwrap_err().to_string(), expected);
}

#[test]
fn a_heartbeat_out_of_range_is_rejected_by_field() {
    let check = |change: fn(&mut wire::Heartbeat), expected: &str| {
        let mut wire = wire::Heartbeat::from(&heartbeat());
        change(&mut wire);
        assert_mentions(
            &refusal(MessageKind::Heartbeat, &wire),
            &format!("dragnet_msgs/msg/Heartbeat .. {expected}"),
        );
    };
    check(|wire| wire.activity = 12, "activity .. 12 .. 0 searching .. 11 giving way");
    check(|wire| wire.directive.order = 4, "directive.order .. 4 .. 0 search, 1 pause, 2 return, 3 end");
    check(|wire| wire.path_meters = f64::INFINITY, "path_meters .. inf .. from 0");
    check(|wire| wire.intent.robot = 8, "intent.robot .. 8 .. 7");
    check(|wire| wire.intent.version = 0, "intent.version .. 0 .. 4");
    check(|wire| wire.intent.path = vec![0; 7], "intent.path .. 7 .. 6");
    check(|wire| wire.intent.path[1] = 6, "intent.path[1] .. 6 .. 0 to 5");
    check(|wire| wire.version_vector[0].version = 1, "version_vector[0].version .. 1 .. 4");
    let known = |robot, incarnation| wire::Version { version: wire::VERSION, robot, incarnation, next: 1 };
    let mut wire = wire::Heartbeat::from(&heartbeat());
    let mut check = |before: (u16, u64), after: (u16, u64), expected: &str| {
        wire.version_vector = [before, after].map(|(robot, incarnation)| known(robot, incarnation)).to_vec();
        let expected = format!("dragnet_msgs/msg/Heartbeat .. version_vector[1].{expected} .. ascending");
        assert_mentions(&refusal(MessageKind::Heartbeat, &wire), &expected);
    };
    check((3, 0), (2, 9), "robot .. 2 .. 3");
    check((3, 5), (3, 5), "incarnation .. 5 .. 5");
}

#[test]
fn no_list_is_longer_than_the_team_can_make_it() {
    let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 2, columns = 3 }\nobjects.count = 1\nsensor.radius = 1\n\
                mission = { budget_seconds = 60.0, speed_meters_per_second = 1.0 }\nrobots.count = 2\n";
    let codec = Codec::of(&Scenario::from_text(std::path::Path::new("a.toml"), text.to_owned()).unwrap());
    let known = |count: u64| {
        let version = |incarnation| wire::Version { version: wire::VERSION, robot: 7, incarnation, next: 1 };
        (0..count).map(version).collect::<Vec<_>>()
    };
    let heartbeat =
        |count| wire::Heartbeat { version_vector: known(count), ..wire::Heartbeat::from(&heartbeat()) };
    let decode = |count| codec.decode(MessageKind::Heartbeat, &cdr::encode(&heartbeat(count)));
    assert!(decode(3 * 1024).is_ok());
    let refused = decode(3 * 1024 + 1).unwrap_err().to_string();
    assert_mentions(&refused, "dragnet_msgs/msg/Heartbeat .. version_vector .. 3073 .. 3072");
    let mut status = wire::MissionStatus {
        version: wire::VERSION,
        time_ns: 0,
        declared: Vec::new(),
        expected_remaining: 1.0,
        alive: Vec::new(),
        observations: 0,
        version_vector: known(3 * 1024 + 1),
        digest: [0; 2],
        directive: wire::Heartbeat::from(&self::heartbeat()).directive,
        doubled: Vec::new(),
    };
    let refused = codec.decode(MessageKind::MissionStatus, &cdr::encode(&status)).unwrap_err().to_string();
    assert_mentions(&refused, "dragnet_msgs/msg/MissionStatus .. version_vector .. 3073 .. 3072");
    (status.version_vector, status.alive) = (Vec::new(), vec![1, 2, 3]);
    let refused = codec.decode(MessageKind::MissionStatus, &cdr::encode(&status)).unwrap_err().to_string();
    assert_mentions(&refused, "dragnet_msgs/msg/MissionStatus .. alive .. 3 .. 2");
    (status.alive, status.doubled) = (Vec::new(), vec![1, 2, 3]);
    let refused = codec.decode(MessageKind::MissionStatus, &cdr::encode(&status)).unwrap_err().to_string();
    assert_mentions(&refused, "dragnet_msgs/msg/MissionStatus .. doubled .. 3 .. 2");
}

#[test]
fn a_directive_travels_in_runs_and_is_rejected_by_field() {
    let wire = wire::Heartbeat::from(&heartbeat()).directive;
    assert_eq!((&wire.firsts[..], &wire.counts[..]), (&[0, 4][..], &[2, 1][..]));
    let check = |firsts: &[u32], counts: &[u32], expected: &str| {
        let mut wire = wire::Heartbeat::from(&heartbeat());
        (wire.directive.firsts, wire.directive.counts) = (firsts.to_vec(), counts.to_vec());
        let expected = format!("dragnet_msgs/msg/Heartbeat .. directive.{expected}");
        assert_mentions(&refusal(MessageKind::Heartbeat, &wire), &expected);
    };
    check(&[0, 4], &[1], "counts .. 1 .. 2 .. `firsts`");
    check(&[0, 1], &[2, 1], "firsts[1] .. 1 .. 2 .. ascending");
    check(&[6], &[1], "firsts[0] .. 6 .. 0 to 5");
    check(&[4], &[3], "counts[0] .. 6 .. 0 to 5");
    check(&[4], &[u32::MAX], "counts[0] .. 4294967295 .. 0 to 5");
    check(&[4], &[0], "counts[0] .. 0 .. at least 1");
}

#[test]
fn pictures_are_rejected_by_field() {
    let good = wire::Picture {
        version: wire::VERSION,
        robot: 2,
        time_ns: 3,
        cell: 4,
        camera: "front".to_owned(),
        label: "person".to_owned(),
        score: 0.5,
        quality: 12.5,
        size: 20_000,
        first: 19_998,
        data: vec![7, 8],
    };
    let codec = Codec::new(grid());
    let read = codec.decode_picture(&cdr::encode(&good)).unwrap();
    assert_eq!(wire::Picture::from(&read), good);
    assert_eq!(encode_picture(&read), cdr::encode(&good));
    let check = |change: fn(&mut wire::Picture), expected: &str| {
        let mut wire = good.clone();
        change(&mut wire);
        let refused = codec.decode_picture(&cdr::encode(&wire)).unwrap_err().to_string();
        assert_mentions(&refused, &format!("dragnet_msgs/msg/Picture .. {expected}"));
    };
    check(|it| it.robot = 0, "robot .. 0 .. from 1");
    check(|it| it.cell = 6, "cell .. 6 .. 0 to 5");
    check(|it| it.camera = "x".repeat(65), "camera .. 65 .. 64");
    check(|it| it.label = "x".repeat(65), "label .. 65 .. 64");
    check(|it| it.score = 1.5, "score .. 1.5 .. 0 to 1");
    check(|it| it.quality = f32::NAN, "quality .. NaN .. from 0");
    check(|it| it.size = 20_001, "size .. 20001 .. 1 to 20000");
    check(|it| it.size = 0, "size .. 0 .. 1 to 20000");
    check(|it| it.first = 20_001, "first .. 20001 .. 20000");
    check(|it| it.data.push(9), "data .. 3 .. 2");
}

#[test]
fn verdicts_are_rejected_by_field() {
    let good = wire::Verdicts {
        version: wire::VERSION,
        robot: 0,
        time_ns: 3,
        cells: vec![1, 4],
        numbers: vec![5, 6],
        decisions: vec![1, 2],
        log_odds: vec![-7, 1 << 61],
    };
    let read = Codec::new(grid()).decode(MessageKind::Verdicts, &cdr::encode(&good)).unwrap();
    assert!(check_sender(&read, Participant::Coordinator).is_ok());
    assert!(check_sender(&read, Participant::Robot(RobotId::FIRST)).is_err());
    let check = |change: fn(&mut wire::Verdicts), expected: &str| {
        let mut wire = good.clone();
        change(&mut wire);
        let expected = format!("dragnet_msgs/msg/Verdicts .. {expected}");
        assert_mentions(&refusal(MessageKind::Verdicts, &wire), &expected);
    };
    check(|it| it.cells[1] = 6, "cells[1] .. 6 .. 0 to 5");
    check(|it| it.cells[1] = 1, "cells[1] .. 1 .. 1 .. ascending");
    check(|it| it.numbers.truncate(1), "numbers .. 1 .. 2 .. `cells`");
    check(|it| it.decisions[0] = 3, "decisions[0] .. 3 .. 2 confirmed");
    check(|it| it.log_odds[0] = 1, "log_odds[0] .. 1 .. -1 if dismissed");
    check(|it| it.log_odds[1] = 5, "log_odds[1] .. 5 .. 2^61 if confirmed");
    check(|it| it.version = 9, "version .. 9 .. 4");
}

#[test]
fn orders_to_single_robots_are_rejected_by_field() {
    let good = wire::Orders {
        version: wire::VERSION,
        robot: 0,
        time_ns: 3,
        robots: vec![1, 2],
        numbers: vec![5, 6],
        orders: vec![1, 3],
        cells: vec![4, 0],
    };
    let read = Codec::new(grid()).decode(MessageKind::Orders, &cdr::encode(&good)).unwrap();
    assert!(check_sender(&read, Participant::Coordinator).is_ok());
    assert!(check_sender(&read, Participant::Robot(RobotId::FIRST)).is_err());
    let check = |change: fn(&mut wire::Orders), expected: &str| {
        let mut wire = good.clone();
        change(&mut wire);
        let expected = format!("dragnet_msgs/msg/Orders .. {expected}");
        assert_mentions(&refusal(MessageKind::Orders, &wire), &expected);
    };
    check(|it| it.cells[0] = 6, "cells[0] .. 6 .. 0 to 5");
    check(|it| it.robots[1] = 1, "robots[1] .. 1 .. 1 .. ascending");
    check(|it| it.robots[0] = 0, "robots[0] .. 0 .. from 1");
    check(|it| it.numbers.truncate(1), "numbers .. 1 .. 2 .. `robots`");
    check(|it| it.orders[0] = 4, "orders[0] .. 4 .. 3 pause");
    check(|it| it.version = 9, "version .. 9 .. 4");
}

#[test]
fn zones_are_rejected_by_field() {
    let good = wire::Zones {
        version: wire::VERSION,
        robot: 0,
        time_ns: 3,
        firsts: vec![1, 4],
        counts: vec![2, 1],
        numbers: vec![5, 6],
        zones: vec![1, 2],
    };
    let read = Codec::new(grid()).decode(MessageKind::Zones, &cdr::encode(&good)).unwrap();
    assert!(check_sender(&read, Participant::Coordinator).is_ok());
    assert!(check_sender(&read, Participant::Robot(RobotId::FIRST)).is_err());
    let check = |change: fn(&mut wire::Zones), expected: &str| {
        let mut wire = good.clone();
        change(&mut wire);
        let expected = format!("dragnet_msgs/msg/Zones .. {expected}");
        assert_mentions(&refusal(MessageKind::Zones, &wire), &expected);
    };
    check(|it| it.firsts[1] = 2, "firsts[1] .. 2 .. 3 .. ascending");
    check(|it| it.counts[1] = 3, "counts[1] .. 6 .. 0 to 5");
    check(|it| it.counts[1] = 0, "counts[1] .. 0 .. at least 1");
    check(|it| it.numbers.truncate(1), "numbers .. 1 .. 2 .. `firsts`");
    check(|it| it.zones[1] = 3, "zones[1] .. 3 .. 2 no-go");
    check(|it| it.version = 9, "version .. 9 .. 4");
}

#[test]
fn marks_are_rejected_by_field() {
    let (version, number) = (wire::VERSION, 7);
    let [firsts, counts] = [vec![1, 4], vec![2, 1]];
    let (note, strength) = ("team 2".to_owned(), 800);
    let search = wire::Mark {
        version,
        id: 5,
        number,
        kind: 1,
        strength,
        firsts,
        counts,
        note,
        ..wire::Mark::default()
    };
    let [firsts, counts] = [vec![3], vec![1]];
    let clue = wire::Mark { id: 6, kind: 0, strength: 20_000, radius: 150, firsts, counts, ..search.clone() };
    let good = wire::Marks { version, robot: 0, time_ns: 3, marks: vec![search, clue] };
    let codec = Codec::new(grid());
    let read = codec.decode(MessageKind::Marks, &cdr::encode(&good)).unwrap();
    assert!(check_sender(&read, Participant::Coordinator).is_ok());
    assert!(check_sender(&read, Participant::Robot(RobotId::FIRST)).is_err());
    let check = |change: fn(&mut wire::Marks), expected: &str| {
        let mut wire = good.clone();
        change(&mut wire);
        let expected = format!("dragnet_msgs/msg/Marks .. {expected}");
        assert_mentions(&refusal(MessageKind::Marks, &wire), &expected);
    };
    check(|it| it.marks[1].id = 5, "marks[1] .. 5 .. 5 .. ascending");
    check(|it| it.marks = vec![it.marks[0].clone(); 2001], "marks .. 2001 .. 2000");
    check(|it| it.marks[0].kind = 2, "marks[0].kind .. 2 .. 1 searched");
    check(|it| it.marks[0].strength = 1000, "marks[0].strength .. 1 to 999");
    check(|it| it.marks[0].strength = 0, "marks[0].strength .. 0 .. 1 to 999");
    check(|it| it.marks[1].strength = 1000, "marks[1].strength .. 1000 .. 1001 to 1000000");
    check(|it| it.marks[1].radius = 10_001, "marks[1].radius .. 10001 .. 0 to 10000");
    check(|it| it.marks[1].counts[0] = 2, "marks[1].counts .. 2 .. 1 cell of a clue");
    check(|it| (it.marks[0].firsts.clear(), it.marks[0].counts.clear()).0, "marks[0].counts .. 0");
    check(|it| it.marks[0].firsts[1] = 2, "marks[0].firsts[1] .. 2 .. 3 .. ascending");
    check(|it| it.marks[0].note = "é".repeat(121), "marks[0].note .. 242 .. 240");
    check(|it| it.version = 9, "version .. 9 .. 4");
    check(|it| it.marks[0].version = 9, "marks[0].version .. 9 .. 4");
    // Few bytes, and many cells.
    let whole = |it: &mut wire::Marks| {
        let all = wire::Mark { firsts: vec![0], counts: vec![6], ..it.marks[0].clone() };
        it.marks = (0..33).map(|id| wire::Mark { id, ..all.clone() }).collect();
    };
    check(whole, "marks[32].counts[0] .. 6 .. 0");
}

#[test]
fn the_number_0_is_the_operators_and_no_robots() {
    let mark = wire::Observation { robot: 0, ..wire::Observation::from(&observation(7, 0)) };
    let read = Codec::new(grid()).decode(MessageKind::Observation, &cdr::encode(&mark)).unwrap();
    let Message::Observation(read) = read else { panic!("{read:?}") };
    assert_eq!(read.origin.source, Source::Operator);
    assert_eq!(wire::Observation::from(&*read), mark);
    let refused = "robot .. 0 .. from 1";
    let plan = wire::Intent { robot: 0, ..wire::Intent::from(&intent(7)) };
    assert_mentions(&refusal(MessageKind::Intent, &plan), &format!("dragnet_msgs/msg/Intent .. {refused}"));
    let beat = wire::Heartbeat { robot: 0, intent: plan, ..wire::Heartbeat::from(&heartbeat()) };
    assert_mentions(
        &refusal(MessageKind::Heartbeat, &beat),
        &format!("dragnet_msgs/msg/Heartbeat .. {refused}"),
    );
    let request = wire::SyncRequest { version: wire::VERSION, ..wire::SyncRequest::default() };
    assert_mentions(
        &refusal(MessageKind::SyncRequest, &request),
        &format!("dragnet_msgs/msg/SyncRequest .. from_{refused}"),
    );
}

#[test]
fn a_log_reply_is_of_one_robot_in_order_and_short() {
    let check = |observations: &[(u16, u64)], expected: &str| {
        let observations =
            observations.iter().map(|&(robot, sequence)| Arc::new(observation(robot, sequence)));
        let reply = SyncReply { observations: observations.collect() };
        assert_mentions(
            &refusal(MessageKind::SyncReply, &wire::SyncReply::from(&reply)),
            &format!("dragnet_msgs/msg/SyncReply .. {expected}"),
        );
    };
    check(&[(1, 0), (2, 1)], "observations[1].robot .. 2 .. 1");
    check(&[(1, 5), (1, 5)], "observations[1].sequence .. 5 .. 5 .. ascending");
    check(&[(1, 0); 65], "observations .. 65 .. 64");
}

#[test]
fn a_full_sync_reply_of_the_widest_sensor_is_decoded() {
    let reading = Reading { cell: cell(0), value: 0.5, variance: 1.0 };
    let full = |sequence| Observation {
        readings: vec![reading; check::MAX_READINGS],
        positions: (0..6)
            .map(|number| ObjectPosition::new(cell(number), [1.5, 2.5], [1.0, 0.5, 2.0]).unwrap())
            .collect(),
        ..observation(1, sequence)
    };
    let observations = (0..64).map(|sequence| Arc::new(full(sequence))).collect();
    let bytes = encode(&Message::SyncReply(SyncReply { observations }));
    assert!(Codec::new(grid()).decode(MessageKind::SyncReply, &bytes).is_ok(), "{}", bytes.len());
}

#[test]
fn a_message_must_match_its_key() {
    let (seven, eight) =
        (Participant::Robot(RobotId::new(7).unwrap()), Participant::Robot(RobotId::new(8).unwrap()));
    let message = Message::Intent(intent(7));
    assert!(check_sender(&message, seven).is_ok());
    assert_eq!(
        check_sender(&message, eight).unwrap_err().to_string(),
        "Intent of robot 7 under a key of robot 8"
    );
    assert!(check_sender(&Message::Heartbeat(heartbeat()), Participant::Coordinator).is_err());
    assert!(check_sender(&Message::SyncReply(SyncReply { observations: vec![] }), eight).is_ok());
}

#[test]
fn a_step_of_an_unknown_kind_is_rejected() {
    let codec = Codec::new(grid());
    let step = wire::Step { version: wire::VERSION, kind: 7, ..wire::Step::default() };
    let error = codec.decode_step(&cdr::encode(&step)).unwrap_err().to_string();
    assert!(error.contains("kind: 7; allowed are 0 start, 1 sensed"), "{error}");

    let reply = wire::StepReply {
        version: wire::STEP_REPLY_VERSION,
        messages: vec![5],
        ..wire::StepReply::default()
    };
    let error = codec.decode_step_reply(&cdr::encode(&reply)).unwrap_err().to_string();
    assert!(error.contains("kinds: 0 entries; allowed are 1"), "{error}");
}

#[test]
fn a_decision_of_more_seconds_than_any_clock_counts_is_rejected() {
    for seconds in [-1.0, 1.1e9, 1e300, f64::INFINITY, f64::NAN] {
        let reply = wire::StepReply {
            version: wire::STEP_REPLY_VERSION,
            decision_seconds: seconds,
            ..wire::StepReply::default()
        };
        let error = Codec::new(grid()).decode_step_reply(&cdr::encode(&reply)).unwrap_err().to_string();
        assert!(error.contains("decision_seconds: ") && error.contains("0 to 1000000000 seconds"), "{error}");
    }
}
