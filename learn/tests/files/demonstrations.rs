//! Files of demonstrations, and folders of them.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use dragnet_files::FileError;
use dragnet_learn::demonstration::{Demonstration, Folder, Source, Trajectory, file_name, read, write};
use dragnet_search::cell::{Cell, Position};
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::route::Connectivity;
use dragnet_search::sensor::{Noise, Sensor};
use dragnet_search::terrain::Terrain;
use safetensors::Dtype;
use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::mentions::assert_mentions;
use crate::parts::{Parts, changed};

/// Three decisions on a small map with ground of all kinds; in the second, a teammate has a plan.
fn trajectory(expert: &str, seed: u64) -> Trajectory {
    let terrain = Terrain::from_ascii(".....\n.#~,.\n.....\n", 12.5).unwrap();
    let sensor = Sensor::new(3, 0.1 + 0.2, Noise::Gaussian).unwrap();
    let at = |row, column| terrain.grid().cell(Position { row, column }).unwrap();
    let count = terrain.grid().cell_count();
    let mut planned_precision = PlannedPrecision::nothing(&terrain);
    planned_precision.add_path(&terrain, &sensor, &[at(0, 4), at(1, 4)]);
    let decision = |number: u16, robot: Cell, chosen: Cell, planned_precision: &PlannedPrecision| {
        let field =
            |scale: f32| (0..count).map(|cell| scale * (cell as f32 + f32::from(number)).sin()).collect();
        let mut scores: Vec<f32> = field(0.3);
        scores[robot.index()] = f32::NEG_INFINITY;
        let mut log_odds_nats: Vec<f32> = field(9.0);
        log_odds_nats[at(1, 1).index()] = f32::NEG_INFINITY;
        Demonstration { log_odds_nats, planned_precision: planned_precision.clone(), robot, chosen, scores }
    };
    let nothing = PlannedPrecision::nothing(&terrain);
    let decisions = vec![
        decision(0, at(0, 0), at(2, 0), &nothing),
        decision(1, at(2, 0), at(2, 4), &planned_precision),
        decision(2, at(2, 4), at(1, 3), &nothing),
    ];
    Trajectory {
        source: Source {
            expert: expert.to_owned(),
            path_length_weight: 0.1 + 0.2,
            max_decisions: 40,
            explore: 0.05,
            program: "0.1.0 (\"somewhere\")".to_owned(),
            follow: Some("5b0e".to_owned()),
            scored_within_cells: Some(5.0),
        },
        scenario: "süd_west".to_owned(),
        scenario_digest: "0123456789abcdef".to_owned(),
        seed,
        terrain: Arc::new(terrain),
        connectivity: Connectivity::Eight,
        sensor: Arc::new(sensor),
        decisions,
    }
}

/// A folder, and the bytes of one file in it.
fn written(trajectory: &Trajectory) -> (TempDir, PathBuf, Vec<u8>) {
    let folder = tempdir().unwrap();
    let path = folder.path().join(file_name(&trajectory.scenario, trajectory.seed));
    write(&path, trajectory).unwrap();
    let bytes = fs::read(&path).unwrap();
    (folder, path, bytes)
}

/// The file is rejected, with these words and its name.
fn refuse(path: &Path, file: &[u8], expected: &str) {
    fs::write(path, file).unwrap();
    let error = read(path).unwrap_err();
    assert!(matches!(error, FileError::Content { .. }));
    let error = error.to_string();
    assert_mentions(&error, &format!("{} .. {expected}", path.display()));
}

#[test]
fn a_trajectory_comes_back_from_its_file_byte_for_byte() {
    let planned_precision = trajectory("path", 7);
    let mut alone = planned_precision.clone();
    alone.decisions.remove(1);
    let mut idle = planned_precision.clone();
    idle.decisions.clear();
    for given in [planned_precision, alone, idle] {
        let (folder, path, bytes) = written(&given);
        let found = read(&path).unwrap();
        assert_eq!(
            (&found.source, &found.scenario, found.seed),
            (&given.source, &given.scenario, given.seed)
        );
        assert_eq!(
            (&found.terrain, found.connectivity, &found.sensor),
            (&given.terrain, given.connectivity, &given.sensor)
        );
        assert_eq!(found.decisions, given.decisions);
        let again = folder.path().join("again");
        write(&again, &found).unwrap();
        assert!(fs::read(again).unwrap() == bytes);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left beside them");
    }
}

#[test]
fn what_walls_hide_comes_back_from_a_file() {
    let open = trajectory("path", 7);
    let terrain = Terrain::clone(&open.terrain).with_opaque_walls(3);
    assert_ne!(terrain, *open.terrain);
    let behind_walls = Trajectory { terrain: Arc::new(terrain), ..open };
    let (_folder, path, file) = written(&behind_walls);
    assert_eq!(read(&path).unwrap().terrain, behind_walls.terrain);
    for radius in [0, 1 << 20] {
        let file = changed(&file, |parts| parts.header["line_of_sight_radius"] = json!(radius));
        refuse(&path, &file, &format!("line_of_sight_radius {radius}: the map is too large"));
    }
}

#[test]
fn plans_are_written_only_if_there_are_any() {
    let mut trajectory = trajectory("path", 7);
    let has_promises = |trajectory: &Trajectory| {
        Parts::of(&written(trajectory).2).tensors.iter().any(|part| part.name == "planned_precision")
    };
    assert!(has_promises(&trajectory));
    trajectory.decisions.remove(1);
    assert!(!has_promises(&trajectory));
}

#[test]
fn a_truncated_file_is_rejected_wherever_it_ends() {
    let (_folder, path, file) = written(&trajectory("path", 7));
    assert!(file.len() > 1000);
    for end in (0..file.len()).step_by(64).chain([file.len() - 1]) {
        refuse(&path, &file[..end], "truncated");
    }
}

#[test]
fn a_contradictory_header_is_rejected() {
    let (_folder, path, file) = written(&trajectory("path", 7));
    let check = |key: &str, value: Value, expected: &str| {
        refuse(&path, &changed(&file, |parts| parts.header[key] = value), expected);
    };
    check("format", json!("dragnet-demonstrations-9"), "\"dragnet-demonstrations-9\"");
    check("decisions", json!(4), "log_odds_nats is F32 [3, 15]; expected F32 [4, 15]");
    check("decisions", json!(usize::MAX), "log_odds_nats is F32 [3, 15]; expected F32 [");
    check("rows", json!(4), "ground is U8 [3, 5]; expected U8 [4, 5]");
    check("rows", json!(0), "a map of 0 rows");
    check("columns", json!(u32::MAX), "a map of 3 rows and 4294967295 columns");
    check("cell_meters", json!(0.0), "cell edge 0 m");
    check("connectivity", json!(6), "connectivity 6: allowed are 4 and 8");
    check("radius", json!(0), "sensor radius 0 cells");
    check("noise_variance", json!(-1.0), "sensor variance noise_variance = -1");
    check("expert", json!(null), "\"dragnet\" .. null");
    let weights = |parts: &mut Parts| parts.header = json!({"format": "dragnet-weights-2"});
    refuse(&path, &changed(&file, weights), "\"dragnet-weights-2\"");
}

#[test]
fn invalid_decisions_are_rejected() {
    let (_folder, path, file) = written(&trajectory("path", 7));
    let check =
        |change: &dyn Fn(&mut Parts), expected: &str| refuse(&path, &changed(&file, change), expected);
    let put = |parts: &mut Parts, name: &str, bytes: &[u8]| {
        parts.get(name).bytes[..bytes.len()].copy_from_slice(bytes);
    };
    check(&|parts| put(parts, "scores", &f32::NAN.to_le_bytes()), "scores holds NaN at place 0");
    check(&|parts| put(parts, "robot", &15_u32.to_le_bytes()), "robot .. 15 .. traversable");
    check(&|parts| put(parts, "chosen", &6_u32.to_le_bytes()), "chosen .. 6 .. traversable");
    check(&|parts| put(parts, "planned_precision", &(-1_i64).to_le_bytes()), "planned_precision is below 0");
    check(&|parts| parts.tensors.retain(|part| part.name != "chosen"), "chosen is missing");
    check(&|parts| parts.get("robot").dtype = Dtype::I32, "robot is I32 [3]; expected U32 [3]");
}

#[test]
fn a_folder_gives_its_trajectories_by_name_and_ignores_other_files() {
    let folder = tempdir().unwrap();
    for seed in [12, 3, 7] {
        write(&folder.path().join(file_name("süd_west", seed)), &trajectory("path", seed)).unwrap();
    }
    // The remains of a program that was killed while writing, and a user's file.
    fs::write(folder.path().join(file_name("süd_west", 1)).with_extension("part"), [0; 100]).unwrap();
    fs::write(folder.path().join("notes.txt"), "by hand").unwrap();
    let folder = Folder::open(folder.path()).unwrap();
    assert_eq!(folder.len(), 3);
    let seeds: Vec<u64> = folder.trajectories().map(|trajectory| trajectory.unwrap().seed).collect();
    assert_eq!(seeds, [12, 3, 7], "12 stands before 3 in names");
}

#[test]
fn a_folder_without_demonstrations_is_rejected() {
    let folder = tempdir().unwrap();
    let check = |path: &Path, expected: &str| {
        let error = Folder::open(path).unwrap_err().to_string();
        assert_mentions(&error, &format!("{} .. {expected}", path.display()));
    };
    check(folder.path(), "no demonstrations .. .demo.safetensors");
    fs::write(folder.path().join("a.demo.part"), [0; 100]).unwrap();
    check(folder.path(), "no demonstrations here");
    check(&folder.path().join("missing"), "No such file");
    check(&folder.path().join("a.demo.part"), "Not a directory");
}

#[test]
fn a_folder_of_two_experts_is_rejected_where_the_second_begins() {
    let check = |other: &Trajectory, expected: Option<&str>| {
        let folder = tempdir().unwrap();
        write(&folder.path().join(file_name("a", 1)), &trajectory("path", 1)).unwrap();
        write(&folder.path().join(file_name("b", 1)), other).unwrap();
        let found: Vec<_> = Folder::open(folder.path()).unwrap().trajectories().collect();
        assert!(found.len() == 2 && found[0].is_ok());
        let error = found[1].as_ref().err().map(ToString::to_string);
        assert_eq!(error.is_some(), expected.is_some(), "{error:?}");
        let parts = expected.map(|expected| format!("b-1.demo.safetensors .. {expected}"));
        assert_mentions(&error.unwrap_or_default(), &parts.unwrap_or_default());
    };
    check(&trajectory("greedy", 1), Some("greedy .. 0.30000000000000004 .. path .. 0.30000000000000004"));
    let mut other = trajectory("path", 1);
    other.source.path_length_weight = 0.3;
    check(&other, Some("path .. 0.3 .. path .. 0.30000000000000004"));
    // Another version of the program may have recorded it, and for longer.
    let mut other = trajectory("path", 2);
    (other.source.program, other.source.max_decisions) = ("0.2.0".to_owned(), 80);
    check(&other, None);
}

#[test]
fn a_file_that_cannot_be_written_leaves_nothing() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("missing").join(file_name("a", 1));
    let error = write(&path, &trajectory("path", 1)).unwrap_err().to_string();
    assert!(
        error.starts_with(&path.display().to_string()) && error.contains("cannot write: No such file"),
        "{error}"
    );
    // A folder has the file's name.
    let path = folder.path().join(file_name("b", 1));
    fs::create_dir(&path).unwrap();
    let error = write(&path, &trajectory("path", 1)).unwrap_err().to_string();
    assert!(error.contains("cannot write: "), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
