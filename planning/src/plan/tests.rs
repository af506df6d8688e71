use std::fs;

use super::*;

/// A kilometer square with a pond, a likely region, a last known position and two starts.
const AREAS: &str = r#"{"type":"FeatureCollection","features":[
    {"type":"Feature","properties":{"kind":"search","name":"Moor"},
     "geometry":{"type":"Polygon","coordinates":[[[0,0],[0.01,0],[0.01,0.01],[0,0.01],[0,0]]]}},
    {"type":"Feature","properties":{"kind":"no_go","name":"Pond"},
     "geometry":{"type":"Polygon","coordinates":[[[0.004,0.004],[0.006,0.004],[0.006,0.006],[0.004,0.004]]]}},
    {"type":"Feature","properties":{"kind":"prior","name":"Hut","poa":0.5},
     "geometry":{"type":"Polygon","coordinates":[[[0.001,0.001],[0.003,0.001],[0.003,0.003],[0.001,0.001]]]}},
    {"type":"Feature","properties":{"kind":"last_known_position","name":"Bench","poa":0.2,"spread_meters":80},
     "geometry":{"type":"Point","coordinates":[0.008,0.008]}},
    {"type":"Feature","properties":{"kind":"start","name":"Post"},
     "geometry":{"type":"Point","coordinates":[0.0005,0.0005]}},
    {"type":"Feature","properties":{"kind":"start","name":"Gate"},
     "geometry":{"type":"Point","coordinates":[0.0095,0.0005]}}]}"#;

pub(crate) fn areas() -> Areas {
    Areas::from_geojson(Path::new("moor.geojson"), AREAS).unwrap()
}

pub(crate) fn plan() -> MissionPlan {
    MissionPlan::of_areas("moor", &areas()).unwrap()
}

/// The scenario that `dragnet run` reads once the files of a plan are written.
fn on_disk(plan: &MissionPlan) -> Scenario {
    let (folder, files) = (tempfile::tempdir().unwrap(), plan.files());
    fs::write(folder.path().join(&files.areas_name), &files.areas_text).unwrap();
    let path = folder.path().join(&files.scenario_name);
    fs::write(&path, &files.scenario_text).unwrap();
    Scenario::load(&path).unwrap()
}

#[test]
fn a_plan_is_the_scenario_that_its_files_are() {
    let mut plan = plan();
    plan.scenario.robots.count = 2;
    plan.scenario.mission.budget_seconds = Some(3_600.0);
    let (here, there) = (plan.scenario().unwrap(), on_disk(&plan));
    assert_eq!(here.file(), there.file());
    assert_eq!(here.map(), there.map());
    assert_eq!(here.prior(), there.prior());
    assert_eq!(here.robots(), there.robots());
    assert_eq!(here.warnings(), there.warnings());
    // And back: nothing is lost on the way.
    let again = MissionPlan::of_scenario(&there).unwrap();
    assert_eq!(again.areas().unwrap(), plan.areas().unwrap());
    assert_eq!(again.scenario().unwrap().file(), here.file());
    let json = serde_json::to_value(&plan).unwrap();
    assert_eq!(MissionPlan::from_json(json).unwrap(), plan);
    // The edge that was suggested is followed further.
    assert!(again.is_cell_suggested);
    plan.scenario.map.cell_meters = 25.0;
    assert!(!MissionPlan::of_scenario(&on_disk(&plan)).unwrap().is_cell_suggested);
}

#[test]
fn areas_alone_are_planned_as_they_would_run() {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("moor.geojson");
    fs::write(&map, AREAS).unwrap();
    let (run, planned) = (Scenario::load(&map).unwrap(), plan().scenario().unwrap());
    assert_eq!(run.terrain(), planned.terrain());
    assert_eq!(run.mission().budget.time(), planned.mission().budget.time());
    assert_eq!(run.robots(), planned.robots());
    assert_eq!(MissionPlan::of_scenario(&run).unwrap().scenario().unwrap().terrain(), run.terrain());
}

#[test]
fn cells_follow_the_areas_until_an_edge_is_given() {
    let mut plan = plan();
    let edge = |plan: &MissionPlan| plan.clone().settled().scenario.map.cell_meters.to_string();
    assert_eq!(edge(&plan), "20");
    for feature in &mut plan.features {
        let text = feature.to_string().replace("0.01,", "0.001,").replace("0.01]", "0.001]");
        *feature = text.parse().unwrap();
    }
    plan.features.truncate(1);
    assert_eq!(edge(&plan), "2");
    plan.is_cell_suggested = false;
    assert_eq!(edge(&plan), "20");
}

#[test]
fn starts_of_a_scenario_become_places_and_what_is_not_shown_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("moor.geojson"), AREAS).unwrap();
    let text = "name = 'a'\nmap = { file = 'moor.geojson', cell_meters = 50.0 }\nobjects.count = 1\n\
                mission.budget_seconds = 60.0\nnetwork.loss = 0.1\n[robots]\ncount = 2\nstart = [3, 4]\n\
                robot = [{ number = 2, policy = 'greedy', start = [1, 1] }]\n";
    let path = folder.path().join("a.toml");
    fs::write(&path, text).unwrap();
    let scenario = Scenario::load(&path).unwrap();
    let plan = MissionPlan::of_scenario(&scenario).unwrap();
    let planned = plan.scenario().unwrap();
    assert_eq!(planned.robots(), scenario.robots());
    assert_eq!(planned.file().network, scenario.file().network);
    assert!(!plan.is_cell_suggested);
    // A page cannot change what it does not show.
    let mut sent = plan.clone();
    sent.scenario.network.loss = 0.5;
    sent.scenario.recording.file = Some("/etc/passwd".to_owned());
    sent.scenario.map.file = Some("/etc/passwd".to_owned());
    sent.scenario.mission.speed_meters_per_second = 5.0;
    let changed = plan.changed(sent);
    let mut expected = plan.clone();
    expected.scenario.mission.speed_meters_per_second = 5.0;
    assert_eq!(changed, expected);
}

#[test]
fn only_maps_on_the_earth_can_be_planned() {
    let shipped = |name: &str| Scenario::load(Path::new(name)).unwrap();
    let refused = MissionPlan::of_scenario(&shipped("warehouse")).unwrap_err().to_string();
    assert!(refused.contains("warehouse.toml") && refused.contains("not drawn on the earth"), "{refused}");
    let plan = MissionPlan::of_scenario(&shipped("missing_person")).unwrap();
    assert_eq!(plan.scenario().unwrap().prior(), shipped("missing_person").prior());
}

#[test]
fn a_plan_in_another_format_names_the_key() {
    let json = serde_json::to_string(&plan()).unwrap();
    let refused = |from: &str, to: &str| {
        MissionPlan::from_json(json.replace(from, to).parse().unwrap()).unwrap_err().to_string()
    };
    let error = refused(r#""count":1,"policy""#, r#""count":"two","policy""#);
    assert!(error.contains("scenario.robots.count") && error.contains("a whole number"), "{error}");
    assert!(refused(r#""is_cell_suggested""#, r#""is_suggested""#).contains("is_suggested"));
    assert!(refused(r#""MultiPolygon""#, r#""Circle""#).contains("features"));
}
