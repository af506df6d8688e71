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
