//! Searches for subjects of known number, and operational periods: what the first believed is the prior of the second.

use std::fs;

use dragnet_scenario::Scenario;
use serde_json::Value;

use super::Place;

/// A search for one subject that ends before all is searched.
const FIRST: &str = "\
name = 'first'
[map]
shape = 'all_traversable'
rows = 12
columns = 12
cell_meters = 30.0
origin = { latitude_degrees = 49.2, longitude_degrees = -2.2 }
[sensor]
radius = 2
[prior]
rest_of_world = 0.2
[objects]
count = 1
[robots]
start = [0, 0]
[mission]
budget_meters = 600.0
";

fn number(report: &Value, key: &str) -> f64 {
    report["subject"][key].as_f64().unwrap_or_else(|| panic!("no {key} in {report}"))
}

/// The report of the first search, with a seed whose search finds nobody.
fn first(place: &Place) -> Value {
    place.write("first.toml", FIRST);
    let report = place.json(&["run", "first.toml", "--seed", "0", "--record", "first.mcap", "--json"]);
    assert_eq!(report["declared"], Value::Array(Vec::new()), "{report}");
    report
}

#[test]
fn all_commands_state_the_same_of_one_subject() {
    let place = Place::new();
    let report = first(&place);
    let [found, remaining, unreachable, outside] =
        ["found", "remaining", "out_of_reach", "rest_of_world"].map(|key| number(&report, key));
    assert!((found + remaining + outside - 1.0).abs() < 1e-9, "{report}");
    assert!(
        outside > 0.21 && remaining < 0.79 && found.abs() + unreachable.abs() < 1e-12,
        "searched in vain: {report}"
    );
    assert!((report["expected_remaining"].as_f64().unwrap() - remaining).abs() < 1e-9, "all is in reach");
    let stated = format!(
        "in a declared cell with {found:.4}, elsewhere in the area with {remaining:.4}, outside of the area with {outside:.4}"
    );
    let replayed = place.succeed(&["replay", "first.mcap"]);
    assert!(replayed.contains(&stated), "{stated} is not in {replayed}");
    let inspected = place.succeed(&["inspect", "first.mcap"]);
    let recorded = inspected.lines().find_map(|line| line.strip_prefix("summary       rest_of_world = "));
    assert!((recorded.unwrap().parse::<f64>().unwrap() - outside).abs() < 1e-9, "{outside} {inspected}");
    let exported = place.succeed(&["export", "first.mcap", "--to", "first.geojson"]);
    assert!(exported.contains(&stated) && exported.contains("posterior"), "{stated} is not in {exported}");
    let header = exported.lines().find(|line| line.starts_with("area")).unwrap();
    assert!(header.contains("POS") && header.contains("posterior"), "{header}");
    assert!(exported.contains("POS is of the effort, POA x POD") && !stated.contains("POS"), "{exported}");
    let map: Value = serde_json::from_str(&fs::read_to_string(place.path("first.geojson")).unwrap()).unwrap();
    assert!((map["subject"]["rest_of_world"].as_f64().unwrap() - outside).abs() < 1e-6, "{}", map["subject"]);
}

#[test]
fn all_commands_state_the_same_of_several_subjects() {
    let place = Place::new();
    place.write("three.toml", &FIRST.replace("count = 1", "count = 3"));
    let report = place.json(&["run", "three.toml", "--seed", "0", "--record", "three.mcap", "--json"]);
    let [found, remaining, outside] = ["found", "remaining", "rest_of_world"].map(|key| number(&report, key));
    assert!((found + remaining + outside - 3.0).abs() < 1e-9, "{report}");
    let stated = format!(
        "of 3, {found:.4} expected in declared cells, {remaining:.4} elsewhere in the area, outside of the area {outside:.4}"
    );
    let told = place.succeed(&["run", "three.toml", "--seed", "0"]);
    assert!(told.contains(&format!("subjects      {stated}")), "{stated} is not in {told}");
    for command in [&["replay", "three.mcap"][..], &["export", "three.mcap", "--to", "three.geojson"]] {
        let told = place.succeed(command);
        assert!(told.contains(&stated), "{stated} is not in {told}");
    }
    let map: Value = serde_json::from_str(&fs::read_to_string(place.path("three.geojson")).unwrap()).unwrap();
    assert_eq!(map["subject"]["number"], 3, "{}", map["subject"]);
    let areas = map["features"].as_array().unwrap();
    let shares = areas.iter().filter_map(|it| it["properties"]["probability_now"].as_f64());
    assert!(shares.into_iter().all(|share| (0.0..=1.0).contains(&share)));

    // Who has been found in the first period is one of the three in the second, whichever file it continues.
    let text = place.succeed(&["export", "three.mcap", "--to", "three.belief.json"]);
    assert!(text.contains("objects expected in 144 searched cells"), "{text}");
    let again = ["run", "three.toml", "--seed", "0", "--json", "--prior-from"];
    let [of_recording, of_file] = ["three.mcap", "three.belief.json"]
        .map(|file| place.json(&again.iter().copied().chain([file]).collect::<Vec<_>>()));
    assert_eq!(of_recording["subject"], of_file["subject"]);
    let sum = ["found", "remaining", "rest_of_world"].map(|key| number(&of_file, key)).iter().sum::<f64>();
    assert!((sum - 3.0).abs() < 1e-9 && number(&of_file, "found") > found - 0.01, "{of_file}");
    place.write("two.toml", &FIRST.replace("count = 1", "count = 2"));
    let said = [
        "the number of its subjects is 3",
        "2, as the scenario seeks; objects.count counts those too that are found",
    ];
    place.refuse(&["check", "two.toml", "--prior-from", "three.mcap"], &said);
    place.write("next.toml", &FIRST.replace("rest_of_world = 0.2", "").replace("count = 1", "count = 3"));
    place.succeed(&["check", "next.toml", "--prior-from", "three.mcap"]);
}

#[test]
fn the_second_period_begins_with_what_the_first_believed_also_in_other_cells() {
    let place = Place::new();
    let report = first(&place);
    let (remaining, outside) = (number(&report, "remaining"), number(&report, "rest_of_world"));
    let text = place.succeed(&["export", "first.mcap", "--to", "first.belief.json"]);
    let stated = format!(
        "the subject is in 144 searched cells with {remaining:.4}, outside of them with {outside:.4}"
    );
    assert!(text.contains(&stated), "{stated} is not in {text}");
    let second = |rows: u32, cell_meters: f64| {
        let text = FIRST
            .replace("first", "second")
            .replace("rest_of_world = 0.2", "rest_of_world = 0.2\nfile = 'first.belief.json'")
            .replace("rows = 12", &format!("rows = {rows}"))
            .replace("columns = 12", &format!("columns = {rows}"))
            .replace("30.0", &format!("{cell_meters:?}"));
        place.write("second.toml", &text);
        Scenario::load(&place.path("second.toml")).unwrap()
    };
    let inside = |scenario: &Scenario| scenario.prior().probabilities().iter().sum::<f64>();
    let rest = |scenario: &Scenario| scenario.subjects().unwrap().rest_of_world();
    for (rows, cell_meters) in [(12, 30.0), (24, 15.0), (6, 60.0), (9, 40.0)] {
        let scenario = second(rows, cell_meters);
        assert!((inside(&scenario) - remaining).abs() < 1e-4, "{rows}: {}", inside(&scenario));
        assert!((rest(&scenario) - outside).abs() < 1e-4, "{rows}: {}", rest(&scenario));
    }
    // What was searched in the first period is unlikely in the second, which searches elsewhere.
    let again = place.json(&["run", "second.toml", "--seed", "0", "--record", "second.mcap", "--json"]);
    assert!(number(&again, "rest_of_world") > outside || number(&again, "found") > 0.5, "{again}");
    let (alike, fresh) = (second(12, 30.0), Scenario::load(&place.path("first.toml")).unwrap());
    let corner = |scenario: &Scenario| scenario.prior().probabilities()[0];
    assert!(corner(&alike) < corner(&fresh) / 20.0, "the robot started there");
}

/// Two pieces of ground that no way connects; the subject is in the second, which is out of reach.
const APART: &str = "\
name = 'apart'
map = { file = 'apart.txt', cell_meters = 30.0 }
sensor.radius = 1
objects.cells = [[0, 11]]
prior.rest_of_world = 0.1
robots.start = [0, 0]
mission.budget_meters = 3000.0
";

#[test]
fn the_end_of_a_search_says_what_is_out_of_reach() {
    let place = Place::new();
    place.write("apart.txt", "....######....\n....######....\n");
    place.write("apart.toml", APART);
    let report = place.json(&["run", "apart.toml", "--record", "apart.mcap", "--json"]);
    let [remaining, unreachable] = ["remaining", "out_of_reach"].map(|key| number(&report, key));
    assert!(remaining > 0.7 && unreachable > 0.7 && unreachable <= remaining, "{report}");
    let text = place.succeed(&["run", "apart.toml", "--record", "again.mcap"]);
    let stated = format!(
        "elsewhere in the area with {remaining:.4}, of which {unreachable:.4} out of every robot's reach"
    );
    assert!(text.contains(&stated), "{stated} is not in {text}");
    let left = text.lines().find(|line| line.starts_with("left ")).unwrap();
    let expected = format!(
        "in reach is complete at 0.05, that of the area is NOT: {unreachable:.2} in 8 cells out of reach"
    );
    assert!(left.contains(&expected), "{left}");
    assert!(place.succeed(&["replay", "apart.mcap"]).contains(&stated));
    let exported = place.succeed(&["export", "apart.mcap", "--to", "a.kml", "--origin", "49.2,-2.2"]);
    assert!(exported.contains(&stated), "{stated} is not in {exported}");
    assert!(fs::read_to_string(place.path("a.kml")).unwrap().contains("of which 0."));
}

#[test]
fn a_find_of_the_one_subject_is_probable_until_somebody_has_looked() {
    let place = Place::new();
    let found = FIRST
        .replace("count = 1", "cells = [[2, 9]]")
        .replace("radius = 2", "radius = 2\nnoise_variance = 0.05");
    place.write("found.toml", &found);
    let text = place.succeed(&["run", "found.toml", "--record", "found.mcap"]);
    let report = place.json(&["run", "found.toml", "--record", "again.mcap", "--json"]);
    let probability = report["declared"][0]["probability"].as_f64().unwrap();
    assert!((0.95..0.99).contains(&probability), "{report}");
    let percent = (1000.0 * probability).floor() / 10.0;
    let words = format!(
        "probable find ({percent:.1} %) at [2, 9] at latitude 49.200674, longitude -2.196089, not confirmed by hand: look before \
         you stand down\n"
    );
    // When it is declared, and in the end.
    assert!(text.contains(&format!("robot 1  {words}")), "{words} is not in {text}");
    assert!(text.contains(&format!("declared      {words}")), "{words} is not in {text}");
    assert!(
        !text.contains("finds an object") && text.contains("found 1 of 1 object, as the simulation knows"),
        "{text}"
    );
    for shown in [
        place.succeed(&["replay", "found.mcap"]),
        place.succeed(&["export", "found.mcap", "--to", "found.gpx"]),
    ] {
        assert!(shown.contains(&words) && !shown.contains("object found"), "{words} is not in {shown}");
    }
}

#[test]
fn a_belief_that_cannot_be_handed_over_is_rejected() {
    let place = Place::new();
    first(&place);
    place.refuse(
        &["export", "first.mcap", "--to", "first.json", "--format", "belief"],
        &["--to first.json", ".belief.json"],
    );
    place.succeed(&["export", "first.mcap", "--to", "first.belief.json"]);
    place.refuse(
        &["export", "first.mcap", "--to", "first.belief.json"],
        &["first.belief.json", "exists already"],
    );
    place.refuse(&["export", "first.toml", "--to", "a.belief.json"], &["first.toml", "not a recording"]);
    let next = FIRST.replace("rest_of_world", "file = 'first.belief.json'\nrest_of_world");
    place.write("unplaced.toml", &next.replace("origin = {", "# origin = {"));
    place.refuse(&["check", "unplaced.toml"], &["first.belief.json", "map.origin"]);
    place.write("elsewhere.toml", &next.replace("49.2", "49.3"));
    place.refuse(&["check", "elsewhere.toml"], &["first.belief.json", "its map is elsewhere"]);
    let bytes = fs::read(place.path("first.mcap")).unwrap();
    fs::write(place.path("cut.mcap"), &bytes[..bytes.len() * 3 / 4]).unwrap();
    let cut = place.dragnet(&["export", "cut.mcap", "--to", "cut.belief.json"]);
    let warning = String::from_utf8_lossy(&cut.stderr);
    assert!(cut.status.success() && warning.contains("cut off"), "{warning}");
    place.write("next.toml", &next.replace("first.belief", "cut.belief"));
    assert!(place.succeed(&["check", "next.toml"]).contains("next.toml: ok"));
}

/// A second period: the first area, and as much ground again to the east, in cells of this edge.
fn second(cell_meters: f64) -> String {
    let rows = (360.0 / cell_meters).round();
    FIRST
        .replace("first", "second")
        .replace("rows = 12", &format!("rows = {rows}"))
        .replace("columns = 12", &format!("columns = {}", 2.0 * rows))
        .replace("30.0", &format!("{cell_meters:?}"))
}

#[test]
fn a_search_continues_from_a_recording_also_over_another_area_in_other_cells() {
    let place = Place::new();
    let report = first(&place);
    place.succeed(&["export", "first.mcap", "--to", "first.belief.json"]);
    for cell_meters in [30.0, 15.0, 60.0, 40.0] {
        place.write("second.toml", &second(cell_meters));
        // By the flag as by the key of the scenario, whose files robots read.
        let named = second(cell_meters).replace("[prior]", "[prior]\nfile = 'first.belief.json'");
        place.write("named.toml", &named);
        let scenario = Scenario::load(&place.path("named.toml")).unwrap();
        let (inside, outside) = (
            scenario.prior().probabilities().iter().sum::<f64>(),
            scenario.subjects().unwrap().rest_of_world(),
        );
        assert!((inside + outside - 1.0).abs() < 1e-6, "{cell_meters}: {inside} {outside}");
        // What is left of the first area is kept to the cell; the new half has its share of the rest.
        let columns = scenario.terrain().grid().columns();
        let west: f64 = scenario
            .terrain()
            .searched_cells()
            .filter(|&cell| scenario.terrain().grid().position(cell).column < columns / 2)
            .map(|cell| scenario.prior().probability(cell))
            .sum();
        assert!((west - number(&report, "remaining")).abs() < 2e-3, "{cell_meters}: {west}");
        let stated = format!(
            "continues first (first.mcap), which covers 50.0 % of the searched cells: the subject is in the area with \
             {inside:.4}, outside of it with {outside:.4}"
        );
        let checked = place.succeed(&["check", "second.toml", "--prior-from", "first.mcap"]);
        assert!(checked.contains(&stated), "{stated} is not in {checked}");
    }
    let forecast = place.dragnet(&[
        "forecast",
        "second.toml",
        "--prior-from",
        "first.mcap",
        "--seeds",
        "2",
        "--robots",
        "1",
    ]);
    assert!(forecast.status.success() && super::stderr(&forecast).contains("prior: continues first"));
}

#[test]
fn a_continued_search_is_the_same_in_memory_and_in_processes_and_is_continued_itself() {
    let place = Place::new();
    first(&place);
    place.write("second.toml", &second(20.0));
    let run = |record: &str, more: &[&str]| {
        let shared = ["run", "second.toml", "--prior-from", "first.mcap", "--record", record];
        let output = place.dragnet(&[&shared[..], more].concat());
        assert!(output.status.success(), "{}", super::stderr(&output));
        super::stderr(&output)
    };
    assert!(run("memory.mcap", &[]).contains("prior: continues first (first.mcap)"));
    run("processes.mcap", &["--processes"]);
    let [memory, processes] =
        ["memory.mcap", "processes.mcap"].map(|file| fs::read(place.path(file)).unwrap());
    assert_eq!(memory, processes);
    assert!(place.succeed(&["inspect", "memory.mcap"]).contains("continues = first"));
    // A third period over the first's area: what the second has searched of it counts.
    let third = place.succeed(&["check", "first.toml", "--prior-from", "memory.mcap"]);
    assert!(third.contains("continues second (memory.mcap), which covers 100.0 %"), "{third}");
}

#[test]
fn an_earlier_search_that_does_not_fit_is_refused_with_the_reason() {
    let place = Place::new();
    first(&place);
    let refuse = |scenario: &str, file: &str, expected: &[&str]| {
        place.write("second.toml", scenario);
        for command in ["run", "forecast"] {
            place.refuse(&[command, "second.toml", "--prior-from", file], expected);
        }
    };
    let origin = "origin = { latitude_degrees = 49.2, longitude_degrees = -2.2 }\n";
    refuse(
        &FIRST.replace("49.2", "49.3"),
        "first.mcap",
        &["first.mcap: its map is elsewhere", "at least one"],
    );
    refuse(&FIRST.replace("49.2", "59.2"), "first.mcap", &["first.mcap: its map is", "km away"]);
    refuse(&FIRST.replace(origin, ""), "first.mcap", &["first.mcap", "map.origin"]);
    let several = FIRST.replace("rest_of_world = 0.2", "").replace("count = 1", "count = 2");
    refuse(&several, "first.mcap", &["what it sought is one subject", "2 objects", "prior.rest_of_world"]);
    place.write("several.toml", &several.replace("first", "several"));
    place.succeed(&["run", "several.toml", "--record", "several.mcap"]);
    refuse(FIRST, "several.mcap", &["what it sought is objects in cells", "one subject", "prior.file"]);
    refuse(FIRST, "second.toml", &["second.toml", "not a recording"]);
    refuse(FIRST, "none.mcap", &["none.mcap", "No such file"]);
    let bytes = fs::read(place.path("first.mcap")).unwrap();
    fs::write(place.path("start.mcap"), &bytes[..40]).unwrap();
    refuse(FIRST, "start.mcap", &["start.mcap", "not a recording"]);
    fs::write(place.path("cut.mcap"), &bytes[..bytes.len() * 3 / 4]).unwrap();
    let cut = place.dragnet(&["run", "second.toml", "--prior-from", "cut.mcap"]);
    assert!(cut.status.success() && super::stderr(&cut).contains("cut off"), "{}", super::stderr(&cut));
    let settings = "robot = 1\n[common]\nmission = 'first'\nscenario = 'first.toml'\n";
    place.write("robot.toml", &format!("{settings}prior_from = 'first.mcap'\n"));
    assert!(place.succeed(&["check", "robot.toml"]).contains("ok"));
    place.refuse(&["check", "robot.toml", "--prior-from", "first.mcap"], &["common.prior_from"]);
    place.write("robot.toml", &format!("{settings}prior_from = 'none.mcap'\n"));
    place.refuse(&["check", "robot.toml"], &["common.prior_from: "]);
}
