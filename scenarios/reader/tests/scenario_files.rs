//! The scenarios of the repository: all can be run, the schema is the one of the code, and the README explains every
//! key.

use std::fs;
use std::path::{Path, PathBuf};

use dragnet_scenario::{Scenario, schema_json};
use serde_json::Value;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn scenario_files() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = ["", "paper"]
        .iter()
        .flat_map(|sub| fs::read_dir(folder().join(sub)).expect("the folder of scenarios"))
        .map(|entry| entry.expect("its entries").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_scenario_loads_without_a_warning() {
    let files = scenario_files();
    assert!(files.len() >= 13, "{files:?}");
    for file in files {
        let scenario = Scenario::load(&file).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scenario.warnings(), [], "{}", file.display());
        let cells = scenario.terrain().traversable_cells().count();
        println!("{}: {} robots, {cells} open cells", scenario.name(), scenario.robots().len());
    }
}

#[test]
fn every_scenario_is_named_after_its_file_and_begins_with_its_schema() {
    for file in scenario_files() {
        let text = fs::read_to_string(&file).unwrap();
        let schema = text.lines().next().unwrap().strip_prefix("#:schema ").unwrap();
        assert!(file.with_file_name(schema).is_file(), "{}: {schema}", file.display());
        let stem = file.file_stem().unwrap().to_str().unwrap().to_owned();
        let name = Scenario::load(&file).unwrap().name().to_owned();
        assert_eq!(name.trim_start_matches("paper_"), stem);
    }
}

#[test]
fn the_papers_setup_is_reproduced() {
    for side in [30, 60] {
        for shape in ["ice_cream_cone", "all_traversable", "open_asterisk", "figure_four"] {
            let suffix = if side == 60 { "_60" } else { "" };
            let scenario = Scenario::load(&folder().join(format!("paper/{shape}{suffix}.toml"))).unwrap();
            let grid = scenario.terrain().grid();
            assert_eq!((grid.rows(), grid.columns(), scenario.robots().len()), (side, side, 1));
        }
    }
}

/// To update the schema: `BLESS=1 cargo test -p dragnet-scenario --test scenario_files`.
#[test]
fn the_committed_schema_is_the_one_of_the_code() {
    let file = folder().join("scenario.schema.json");
    if std::env::var_os("BLESS").is_some() {
        fs::write(&file, schema_json()).unwrap();
    }
    assert_eq!(fs::read_to_string(file).unwrap(), schema_json(), "see the comment of this test");
}

#[test]
fn the_readme_explains_every_key() {
    let readme = fs::read_to_string(folder().join("README.md")).unwrap();
    let mut keys = Vec::new();
    collect_keys(&serde_json::from_str(&schema_json()).unwrap(), &mut keys);
    assert!(keys.len() > 40, "{keys:?}");
    for key in keys {
        assert!(readme.contains(&format!("`{key}`")), "scenarios/README.md does not explain `{key}`");
    }
}

fn collect_keys(schema: &Value, keys: &mut Vec<String>) {
    match schema {
        Value::Object(members) => {
            if let Some(Value::Object(properties)) = members.get("properties") {
                keys.extend(properties.keys().cloned());
            }
            members.values().for_each(|value| collect_keys(value, keys));
        }
        Value::Array(values) => values.iter().for_each(|value| collect_keys(value, keys)),
        _ => {}
    }
}
