//! Two independent ROS 2 readers read recordings as they were written.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use dragnet_coordinator::inspect::inspect;
use dragnet_coordinator::mission::Record;
use dragnet_coordinator::recover::recover;
use dragnet_search::cell::Cell;
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::episode::{Episode, ORIGIN, header};
use crate::interpreter::interpreter;

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// The results of each reader.
fn read(recording: &Path) -> [(&'static str, Value); 2] {
    let script = Path::new(WORKSPACE).join("tests/python/read_recording.py");
    let output = Command::new(interpreter(Path::new(WORKSPACE))).arg(script).arg(recording).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut seen: Value = serde_json::from_slice(&output.stdout).unwrap();
    ["mcap", "rosbags"].map(|reader| (reader, seen[reader].take()))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

/// The center of a cell in the frame of the map's file: from its corner along its rows, and to their left.
fn placed(cell: Cell) -> (f64, f64) {
    let (along, up) = header().terrain.center_meters(cell);
    let (sine, cosine) = ORIGIN.yaw_radians.sin_cos();
    (ORIGIN.x_meters + (cosine * along - sine * up), ORIGIN.y_meters + (sine * along + cosine * up))
}

/// Sum of the values of a robot's readings, and its recorded positions, `[x, y, Unix seconds]`.
fn expected(episode: &Episode, of: u16) -> (f64, Vec<[f64; 3]>) {
    let start = header().start_unix_ns as f64 / 1e9;
    let (mut sum, mut places) = (0.0, Vec::new());
    for (_, record) in &episode.records {
        match record {
            Record::Observation(observation) if observation.origin.source.number() == of => {
                sum += observation.readings.iter().map(|reading| f64::from(reading.value)).sum::<f64>();
            }
            Record::Pose { robot, cell, time } if robot.number() == of => {
                let (x, y) = placed(*cell);
                places.push([x, y, start + time.as_seconds()]);
            }
            _ => {}
        }
    }
    (sum, places)
}

#[test]
fn ros_readers_read_recordings() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let episode = Episode::play();
    episode.record(&path);
    let counts: BTreeMap<String, u64> = inspect(&path)
        .unwrap()
        .topics
        .into_iter()
        .map(|(topic, content)| (topic, content.messages))
        .collect();
    for (reader, seen) in read(&path) {
        assert_eq!(seen["counts"], json!(counts), "{reader}");
        for robot in [1, 2] {
            check_robot(&seen, &episode, robot);
        }
        check_maps(&seen, &episode);
        check_mission(&seen, &episode);
    }
}

fn check_robot(seen: &Value, episode: &Episode, robot: u16) {
    let (sum, places) = expected(episode, robot);
    let read = seen["observation_sums"][format!("/robots/{robot}/observation")].as_f64().unwrap();
    assert!((read - sum).abs() < 1e-9 && sum.abs() > 0.1, "{read} {sum}");

    let poses = seen["poses"][format!("/robots/{robot}/pose")].as_array().unwrap();
    assert_eq!(poses.len(), places.len());
    for (read, expected) in poses.iter().map(numbers).zip(&places) {
        assert!(read.iter().zip(expected).all(|(read, expected)| (read - expected).abs() < 1e-5), "{read:?}");
    }
    let half = ORIGIN.yaw_radians / 2.0;
    let turns = seen["turns"].as_array().unwrap();
    assert!(!turns.is_empty() && turns.iter().all(|turn| *turn == json!([half.sin(), half.cos()])));
    let frames: Vec<[f64; 2]> = places.iter().map(|&[x, y, _]| [x, y]).collect();
    assert_eq!(seen["frames"][format!("robot_{robot}")], json!(frames));

    let plans = episode.records.iter().filter_map(|(_, record)| match record {
        Record::Plan { robot: whose, path } if whose.number() == robot => Some(path),
        _ => None,
    });
    let plans: Vec<Vec<(f64, f64)>> =
        plans.map(|path| path.iter().map(|&(cell, _)| placed(cell)).collect()).collect();
    assert_eq!(seen["paths"][format!("/robots/{robot}/path")], json!(plans));
    assert!(plans.iter().any(|plan| plan.len() > 2) && plans.iter().any(Vec::is_empty));
}

fn check_maps(seen: &Value, episode: &Episode) {
    let (terrain, belief) = (header().terrain, episode.mission.belief());
    let ground = [[0, 0, 0, 0, 0, 0], [0, 0, 0, 0, -1, 0], [0, 0, 100, 0, 100, 0], [0, 0, 0, 0, 0, 0]];
    assert_eq!(seen["map"]["data"], json!(ground.concat()));
    assert_eq!((&seen["map"]["width"], &seen["map"]["height"]), (&json!(6), &json!(4)));
    let half = ORIGIN.yaw_radians / 2.0;
    for origin in [&seen["map"]["origin"], &seen["belief_origin"], &seen["probability"]["origin"]] {
        assert_eq!(*origin, json!([ORIGIN.x_meters, ORIGIN.y_meters, half.sin(), half.cos()]));
    }
    let probability = |cell| belief.probability(cell);
    let percent: Vec<f64> = terrain
        .grid()
        .cells()
        .map(|cell| if terrain.is_searched(cell) { (100.0 * probability(cell)).round() } else { -1.0 })
        .collect();
    assert_eq!(numbers(&seen["belief"]), percent);
    assert!(percent.contains(&100.0) && percent.contains(&0.0));

    let bytes: Vec<u8> = serde_json::from_value(seen["probability"]["bytes"].clone()).unwrap();
    let (floats, rest) = bytes.as_chunks::<4>();
    assert_eq!((floats.len(), rest.len()), (terrain.grid().cell_count(), 0));
    for (cell, &float) in terrain.grid().cells().zip(floats) {
        assert!((f64::from(f32::from_le_bytes(float)) - probability(cell)).abs() < 1e-6);
    }
}

fn check_mission(seen: &Value, episode: &Episode) {
    let declared: Vec<u32> = episode.mission.declared().map(|object| object.cell.number()).collect();
    assert_eq!(seen["status"]["declared"], json!(declared));
    assert_eq!(seen["status"]["alive"], json!([1, 2]));
    assert_eq!(seen["status"]["observations"], json!(episode.mission.replica().log().len()));
    let digest = episode.mission.belief().digest().0;
    let halves = [digest >> 64, digest & u128::from(u64::MAX)].map(|half| half.to_string());
    assert_eq!(seen["digest"], json!(halves));
    assert_eq!(seen["objects"].as_array().unwrap().len(), 2);
    let log_times: Vec<u64> = serde_json::from_value(seen["log_times"].clone()).unwrap();
    let start = u64::try_from(header().start_unix_ns).unwrap();
    assert_eq!(log_times.iter().min(), Some(&start));
    assert_eq!(log_times.iter().max(), Some(&(start + 20_000_000_000)));
}

#[test]
fn ros_readers_see_the_scenario_and_how_to_replay_each_topic() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    Episode::play().record(&path);
    let [(_, mcap), (_, rosbags)] = read(&path);
    assert_eq!(mcap["profile"], "ros2");
    assert_eq!(mcap["attachments"]["scenario.toml"], header().scenario);
    let beginning = ["/map", "/belief", "/belief/probability"];
    assert_eq!(mcap["attachments"]["beginning.mcap.zst"], json!(beginning));
    assert_eq!(mcap["metadata"], json!({"run": header().run, "summary": {"found": "1"}}));
    assert_eq!(rosbags["durabilities"]["/map"], json!(["TRANSIENT_LOCAL"]));
    assert_eq!(rosbags["durabilities"]["/robots/1/pose"], json!(["VOLATILE"]));
}

#[test]
fn ros_readers_read_recovered_recordings() {
    let folder = tempdir().unwrap();
    let (path, cut_off, mended) =
        (folder.path().join("run.mcap"), folder.path().join("cut.mcap"), folder.path().join("mended.mcap"));
    Episode::play().record(&path);
    let bytes = fs::read(&path).unwrap();
    fs::write(&cut_off, &bytes[..bytes.len() / 2]).unwrap();
    let recovered = recover(&cut_off, &mended).unwrap();
    assert!(recovered.messages > 20, "{recovered}");
    for (reader, seen) in read(&mended) {
        let counts: BTreeMap<String, u64> = serde_json::from_value(seen["counts"].clone()).unwrap();
        assert_eq!(counts.values().sum::<u64>(), recovered.messages, "{reader}");
    }
}
