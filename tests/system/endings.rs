//! However a process ends, and whatever its disk does, its recording can be read.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use dragnet_coordinator::Ending;
use dragnet_coordinator::inspect::{Inspection, inspect};
use dragnet_coordinator::mission::Record;
use dragnet_coordinator::playback::Playback;
use dragnet_coordinator::record::ENDED;
use dragnet_proto::message::Activity;
use dragnet_search::observation::Source;

use crate::durability::{SmallDisk, endless};
use crate::field::{DRAGNET, Field, Process};
use crate::operator::Operator;

/// Waits for a condition, with a time limit.
fn comes_true(what: &str, mut is_so: impl FnMut() -> bool) {
    let came = (0..600).any(|_| {
        let is_so = is_so();
        if !is_so {
            std::thread::sleep(Duration::from_millis(100));
        }
        is_so
    });
    assert!(came, "in vain: {what}");
}

/// The part that is written.
fn read(recording: &Path) -> Option<Inspection> {
    inspect(recording).ok()
}

fn observations(recording: &Path) -> u64 {
    read(recording).map_or(0, |read| read.observations)
}

fn assert_finished(recording: &Path) {
    assert_eq!(inspect(recording).unwrap().ending, Ending::Complete, "{}", recording.display());
}

/// The program with default signal handling.
fn program() -> Command {
    let mut command = Command::new("env");
    command.args(["--default-signal=INT,TERM,HUP", DRAGNET]);
    command
}

#[test]
fn a_coordinator_that_is_ended_by_any_signal_has_finished_its_recording() {
    let field = Field::new(&endless(1), 1, 7);
    for signal in ["INT", "TERM", "HUP"] {
        let recording = field.path(&format!("{signal}.mcap"));
        let settings = field.coordinator_settings(&recording);
        let coordinator = Process::start(program().args(["coordinator", "--config"]).arg(settings));
        comes_true("handlers", || handles(&coordinator, signal));
        comes_true("a recording", || read(&recording).is_some());
        assert!(coordinator.signal(signal).success(), "{signal}");
        assert_finished(&recording);
    }
}

#[test]
fn a_robot_ends_by_any_signal_and_outlives_its_terminal_if_it_is_asked_to() {
    let field = Field::new(&endless(1), 1, 8);
    let settings = field.robot_settings(1, None);
    for signal in ["INT", "HUP"] {
        let robot = Process::start(program().args(["agent", "--config"]).arg(&settings));
        comes_true("handlers", || handles(&robot, signal));
        assert!(robot.signal(signal).success(), "{signal}");
    }
    let mut nohup = Command::new("nohup");
    let robot = Process::start(nohup.args([DRAGNET, "agent", "--config"]).arg(settings));
    comes_true("handlers", || handles(&robot, "TERM"));
    assert!(!handles(&robot, "HUP"));
    let sent = Command::new("kill").args(["-s", "HUP", &robot.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert!(robot.signal("TERM").success());
}

/// Whether a process handles a signal, by its status file on Linux.
fn handles(process: &Process, signal: &str) -> bool {
    let number = match signal {
        "HUP" => 1,
        "INT" => 2,
        _ => 15,
    };
    let status = std::fs::read_to_string(format!("/proc/{}/status", process.id())).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or("0");
    u64::from_str_radix(caught.trim(), 16).unwrap() >> (number - 1) & 1 == 1
}

#[test]
fn a_simulator_that_is_asked_to_stop_ends_by_itself() {
    let field = Field::new(&endless(1), 1, 12);
    // At first it waits for its robot.
    for is_running in [false, true] {
        let world = field.world();
        let robot = is_running.then(|| field.robot(1));
        comes_true("handlers", || handles(&world, "TERM"));
        assert_eq!(world.signal("TERM").code(), Some(1));
        drop(robot);
    }
}

#[test]
fn a_run_that_is_stopped_has_finished_its_recording() {
    let field = Field::new(&endless(2), 2, 9);
    let start = |name: &str, arguments: &[&str]| {
        let recording = field.path(name);
        let mut command = program();
        command.arg("run").arg(field.path("field.toml")).args(arguments).arg("--record").arg(&recording);
        let run = Process::start(&mut command);
        comes_true("observations", || observations(&recording) > 3);
        (run, recording)
    };
    for (signal, arguments) in [
        ("INT", ["--real-time-factor", "20"]),
        ("TERM", ["--real-time-factor", "20"]),
        ("HUP", ["--live", "--json"]),
    ] {
        let (run, recording) = start(&format!("{signal}.mcap"), &arguments);
        assert_eq!(run.signal(signal).code(), Some(1), "{signal}");
        assert_finished(&recording);
    }
    let (run, recording) = start("deaf.mcap", &["--real-time-factor", "20"]);
    assert_eq!(run.deafen().code(), Some(1));
    assert_finished(&recording);
}

#[test]
fn a_coordinator_that_is_killed_and_started_again_goes_on_in_a_new_recording() {
    let field = Field::new(&endless(1), 1, 10);
    let (world, robot) = (field.world(), field.robot(1));
    let [first, second, third] = ["field.mcap", "field-2.mcap", "field-3.mcap"].map(|name| field.path(name));
    let coordinator = field.coordinator();
    comes_true("observations", || observations(&first) > 3);
    coordinator.kill();
    let before = std::fs::read(&first).unwrap();
    for recording in [&second, &third] {
        let coordinator = field.coordinator();
        // It receives again what it had received.
        comes_true("all observations", || observations(recording) > observations(&first));
        coordinator.terminate();
        assert_finished(recording);
    }
    assert_eq!(std::fs::read(&first).unwrap(), before, "what was written stays");
    robot.terminate();
    drop(world);
}

/// A coordinator with a page, after some observations.
fn begun(field: &Field, operator: &Operator, recording: &Path) -> Process {
    let settings = operator.settings(field, recording);
    let coordinator = Process::start(Command::new(DRAGNET).args(["coordinator", "--config"]).arg(settings));
    comes_true("observations", || observations(recording) > 20);
    coordinator
}

#[test]
fn a_mission_that_the_operator_ends_is_over_once_all_robots_are_back_and_the_robots_go_on() {
    let field = Field::new(&endless(2), 2, 13);
    let (operator, recording) = (Operator::new(), field.path("field.mcap"));
    let (_world, robots) = (field.world(), [field.robot(1), field.robot(2)]);
    let coordinator = begun(&field, &operator, &recording);
    let answer = operator.order(r#"{"command": "end"}"#);
    assert!(answer.contains("The mission ends once all robots are back at their bases."), "{answer}");
    assert!(coordinator.ended().success());
    let read = inspect(&recording).unwrap();
    assert_eq!((read.ending, read.summary[ENDED].as_str()), (Ending::Complete, "by the operator"));
    assert_gapless(&recording);
    // Each rests in its base, where it has started.
    let (mut started, mut rested) = (BTreeMap::new(), BTreeMap::new());
    for (_, record) in Playback::read(&recording).unwrap().records {
        match record {
            Record::Observation(seen) => {
                started.entry(seen.origin.source).or_insert((Activity::Recalled, seen.from));
            }
            Record::Heartbeat(beat) => {
                rested.insert(Source::Robot(beat.robot), (beat.activity, beat.cell));
            }
            _ => {}
        }
    }
    assert_eq!(rested, started);
    robots.into_iter().for_each(Process::terminate);
}

#[test]
fn a_mission_that_waits_for_a_robot_that_is_gone_is_ended_without_it() {
    let field = Field::new(&endless(2), 2, 14);
    let (operator, recording) = (Operator::new(), field.path("field.mcap"));
    let (world, gone, robot) = (field.world(), field.robot(1), field.robot(2));
    let coordinator = begun(&field, &operator, &recording);
    gone.kill();
    world.kill();
    operator.order(r#"{"command": "end"}"#);
    let answer = operator.order(r#"{"command": "end", "now": true}"#);
    assert!(answer.contains("The mission ends now"), "{answer}");
    assert!(coordinator.ended().success());
    let read = inspect(&recording).unwrap();
    assert_eq!(read.ending, Ending::Complete);
    assert!(read.summary[ENDED].starts_with("by the operator, without robot"), "{:?}", read.summary);
    robot.terminate();
}

#[test]
fn a_coordinator_on_a_full_disk_reports_it_and_records_all_once_there_is_space() {
    let field = Field::new(&endless(2), 2, 11);
    let settings = |disk: &Path| field.coordinator_settings(&disk.join("field.mcap"));
    let Some(mut cramped) = SmallDisk::start(&field, "coordinator", settings) else {
        crate::skip("a disk of its own needs a mount namespace, which this system does not give");
        return;
    };
    let (world, first, second) = (field.world(), field.robot(1), field.robot(2));
    let log = || std::fs::read_to_string(field.path("log")).unwrap();
    let growing = cramped.seen(&field.path("disk/field.mcap"));
    comes_true("observations", || observations(&growing) > 10);
    cramped.order("fill");
    comes_true("a full disk is told of", || log().contains("what is to be recorded waits in memory"));
    cramped.order("free");
    comes_true("a mended disk is told of", || log().contains("written again, nothing is missing"));
    let before = observations(&growing);
    comes_true("more observations", || observations(&growing) > before + 10);
    world.kill();
    first.terminate();
    second.terminate();
    cramped.order("stop");
    let recording = field.path("disk.copy/field.mcap");
    assert_finished(&recording);
    assert_gapless(&recording);
}

/// Every observation of each start of each robot, from the first on, is there.
fn assert_gapless(recording: &Path) {
    let playback = Playback::read(recording).unwrap();
    let names: BTreeSet<_> = playback
        .records
        .iter()
        .filter_map(|(_, record)| match record {
            Record::Observation(it) => Some((it.origin, it.sequence)),
            _ => None,
        })
        .collect();
    assert!(names.len() > 20, "{}", names.len());
    for &(origin, sequence) in names.iter().filter(|(_, sequence)| *sequence > 0) {
        assert!(names.contains(&(origin, sequence - 1)), "{origin:?} {sequence}");
    }
}

#[test]
fn a_process_may_open_as_many_files_as_the_system_lets_it() {
    let field = Field::new(&endless(1), 1, 12);
    let settings = field.robot_settings(1, None);
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -Sn 100; exec \"$0\" agent --config \"$1\"", DRAGNET]).arg(settings);
    let robot = Process::start(&mut command);
    comes_true("more files", || {
        let limits = std::fs::read_to_string(format!("/proc/{}/limits", robot.id())).unwrap();
        let files = limits.lines().find_map(|line| line.strip_prefix("Max open files")).unwrap();
        let numbers: Vec<&str> = files.split_whitespace().collect();
        numbers[0] == numbers[1]
    });
}
