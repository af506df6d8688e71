//! Searches for one subject, and operational periods: what the first believed is the prior of the second.

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
    let [pos, remaining, outside] = ["pos", "remaining", "rest_of_world"].map(|key| number(&report, key));
    assert!((pos + remaining + outside - 1.0).abs() < 1e-9, "{report}");
    assert!(outside > 0.21 && remaining < 0.79 && pos.abs() < 1e-12, "searched in vain: {report}");
    assert!((report["expected_remaining"].as_f64().unwrap() - remaining).abs() < 1e-9, "all is in reach");
    let stated = format!(
        "found with probability {pos:.4} (POS), else in the area with {remaining:.4}, outside of it with {outside:.4}"
    );
    let replayed = place.succeed(&["replay", "first.mcap"]);
    assert!(replayed.contains(&stated), "{stated} is not in {replayed}");
    let inspected = place.succeed(&["inspect", "first.mcap"]);
    let recorded = inspected.lines().find_map(|line| line.strip_prefix("summary       rest_of_world = "));
    assert!((recorded.unwrap().parse::<f64>().unwrap() - outside).abs() < 1e-9, "{outside} {inspected}");
    let exported = place.succeed(&["export", "first.mcap", "--to", "first.geojson"]);
    let line = format!("else in the area with {:.1} %", 100.0 * remaining);
    assert!(exported.contains(&line) && exported.contains("now"), "{line} is not in {exported}");
    let map: Value = serde_json::from_str(&fs::read_to_string(place.path("first.geojson")).unwrap()).unwrap();
    assert!((map["subject"]["rest_of_world"].as_f64().unwrap() - outside).abs() < 1e-6, "{}", map["subject"]);
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
    let rest = |scenario: &Scenario| scenario.one_subject().unwrap().rest_of_world();
    for (rows, cell_meters) in [(12, 30.0), (24, 15.0), (6, 60.0), (9, 40.0)] {
        let scenario = second(rows, cell_meters);
        assert!((inside(&scenario) - remaining).abs() < 1e-4, "{rows}: {}", inside(&scenario));
        assert!((rest(&scenario) - outside).abs() < 1e-4, "{rows}: {}", rest(&scenario));
    }
    // What was searched in the first period is unlikely in the second, which searches elsewhere.
    let again = place.json(&["run", "second.toml", "--seed", "0", "--record", "second.mcap", "--json"]);
    assert!(number(&again, "rest_of_world") > outside || number(&again, "pos") > 0.5, "{again}");
    let (alike, fresh) = (second(12, 30.0), Scenario::load(&place.path("first.toml")).unwrap());
    let corner = |scenario: &Scenario| scenario.prior().probabilities()[0];
    assert!(corner(&alike) < corner(&fresh) / 20.0, "the robot started there");
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
