//! Scenarios that come with the program.

use std::fs;

use crate::Place;

#[test]
fn a_scenario_runs_in_an_empty_folder() {
    let place = Place::new();
    let listed = place.succeed(&["scenarios"]);
    assert!(listed.lines().any(|line| line.starts_with("warehouse") && line.contains("hall")), "{listed}");
    let checked = place.succeed(&["check", "jersey", "paper/figure_four"]);
    assert_eq!(checked.lines().filter(|line| line.contains(": ok: ")).count(), 2, "{checked}");
    let run = place.json(&["run", "ice_cream_cone", "--json"]);
    assert_eq!((&run["scenario"], &run["recall"]), (&"ice_cream_cone".into(), &1.0.into()));
    assert!(place.path("ice_cream_cone-0.mcap").exists());
}

#[test]
fn a_copy_is_the_same_scenario_and_overwrites_nothing() {
    let place = Place::new();
    let copied = place.succeed(&["scenarios", "--write", "warehouse", "--into", "mine"]);
    assert!(copied.contains("mine/warehouse.toml") && copied.contains("mine/maps/warehouse.pgm"), "{copied}");
    // What is there already is left alone; what is the same may be there.
    place.succeed(&["scenarios", "--write", "warehouse", "--into", "mine"]);
    let digest = |scenario: &str| place.json(&["run", scenario, "--json"])["belief_digest"].clone();
    assert_eq!(digest("mine/warehouse.toml"), digest("warehouse"));
    fs::write(place.path("mine/warehouse.toml"), "name = 'changed'").unwrap();
    place.refuse(
        &["scenarios", "--write", "warehouse", "--into", "mine"],
        &["mine/warehouse.toml", "exists already"],
    );
    place.refuse(&["scenarios", "--write", "warehoose"], &["--write warehoose", "ice_cream_cone, team"]);
    place.refuse(&["run", "teem.toml"], &["teem.toml", "ice_cream_cone, team"]);
}

#[test]
fn a_map_alone_is_searched_and_becomes_a_scenario() {
    let place = Place::new();
    let kml = include_str!("../../scenarios/maps/missing_person.kml");
    place.write("west wood.kml", kml);
    let run = place.json(&["run", "west wood.kml", "--robots", "2", "--json"]);
    assert_eq!(
        (&run["scenario"], &run["robots"], &run["policy"]),
        (&"west_wood".into(), &2.into(), &"tour".into())
    );
    let declared = run["declared"].as_array().unwrap();
    let found = declared.iter().filter(|cell| cell["is_object"] == true).count();
    assert_eq!(
        (&run["found"], run["false_positives"].as_u64()),
        (&found.into(), Some((declared.len() - found) as u64))
    );
    for cell in declared {
        let within = |key: &str, range: std::ops::Range<f64>| range.contains(&cell[key].as_f64().unwrap());
        assert!(within("latitude_degrees", 49.235..49.246), "{cell}");
        assert!(within("longitude_degrees", -2.241..-2.223), "{cell}");
    }
    let output = place.command(&["run", "west wood.kml", "--json"]).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    for assumed in
        ["assumed: west wood.kml", "20 m", "1 object", "1 robot", "tour", "--write 'west wood.kml'"]
    {
        assert!(told.contains(assumed), "{assumed}: {told}");
    }
    assert!(place.succeed(&["scenarios", "--write", "west wood.kml"]).contains("west wood.toml"));
    place.succeed(&["scenarios", "--write", "west wood.kml", "--into", "elsewhere"]);
    for scenario in ["west wood.toml", "elsewhere/west wood.toml"] {
        let digest = |scenario: &str| place.json(&["run", scenario, "--json"])["belief_digest"].clone();
        assert_eq!(digest(scenario), digest("west wood.kml"), "{scenario}");
    }
    place.refuse(&["scenarios", "--write", "west wood.toml"], &["west wood.toml", "maps"]);
    place.refuse(&["run", "east.kml"], &["east.kml"]);
    place.write("empty.kml", "<kml/>");
    place.refuse(&["run", "empty.kml"], &["empty.kml"]);
}
