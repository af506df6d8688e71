//! Robots, coordinator and world as separate processes.

use std::path::PathBuf;

use dragnet_runtime::team::{self, Options};

use crate::field::{DRAGNET, Field, Process};
use crate::{committed, eventually};

#[test]
fn a_run_of_processes_is_the_run_in_one_process() {
    let cone = committed("ice_cream_cone.toml");
    let run = |processes| {
        let options = Options { processes, version: "test".to_owned(), ..Options::default() };
        team::run(&cone, 2, &options, &mut |_, _| ()).unwrap().episode
    };
    let (one, many) = (run(None), run(Some(PathBuf::from(DRAGNET))));
    assert_eq!(one.outcome.digest, many.outcome.digest);
    assert_eq!(one.path_cells, many.path_cells);
    assert!(many.outcome.beliefs_equal);
}

#[test]
fn a_process_that_cannot_start_fails_the_run_by_name() {
    let options = Options { processes: Some("/no/such/program".into()), ..Options::default() };
    let error = team::run(&committed("ice_cream_cone.toml"), 2, &options, &mut |_, _| ()).unwrap_err();
    assert!(
        error.to_string().contains("robot 1") && error.to_string().contains("/no/such/program"),
        "{error}"
    );
}

#[test]
fn a_process_that_dies_fails_the_run_by_name() {
    let options = Options { processes: Some("/bin/false".into()), ..Options::default() };
    let error = team::run(&committed("ice_cream_cone.toml"), 2, &options, &mut |_, _| ()).unwrap_err();
    assert!(error.to_string().contains("ended before the mission"), "{error}");
}

const SEARCH: &str = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 15\ncolumns = 15\n\
                      [objects]\ncount = 4\n[robots]\ncount = 2\npolicy = \"path\"\n\
                      [mission]\nbudget_seconds = 3600.0\nstop_when_expected_remaining = 0.001\n";

fn check_outcome(json: &str) -> serde_json::Value {
    let outcome: serde_json::Value = serde_json::from_str(json).unwrap();
    assert_eq!(outcome["beliefs_equal"], true, "{outcome}");
    assert_eq!(outcome["recall"], 1.0, "{outcome}");
    outcome
}

#[test]
fn a_mission_started_by_hand_in_any_order_is_searched_and_recorded() {
    let field = Field::new(SEARCH, 2, 3);
    let second = field.robot(2);
    let (coordinator, world) = (field.coordinator(), field.world());
    let first = field.robot(1);
    let outcome = check_outcome(&world.output());
    first.terminate();
    second.terminate();
    coordinator.terminate();
    let recording = dragnet_coordinator::inspect::inspect(&field.path("field.mcap")).unwrap();
    assert_eq!(recording.ending, dragnet_coordinator::Ending::Complete);
    assert_eq!(Some(recording.observations as u64), outcome["observations_sent"].as_u64());
}

#[test]
fn robots_search_on_when_the_coordinator_is_killed() {
    let field = Field::new(SEARCH, 2, 3);
    let coordinator = field.coordinator();
    let robots = [field.robot(1), field.robot(2)];
    let world = field.world();
    // The search takes 4 s; once a part of it is on disk the coordinator is killed.
    let recording = field.path("field.mcap");
    let observations =
        || dragnet_coordinator::inspect::inspect(&recording).map_or(0, |inspection| inspection.observations);
    eventually("an observation is recorded", || observations() > 0);
    drop(coordinator);
    check_outcome(&world.output());
    robots.into_iter().for_each(Process::terminate);
    dragnet_coordinator::recover::recover(&recording, &field.path("mended.mcap")).unwrap();
    let mended = dragnet_coordinator::inspect::inspect(&field.path("mended.mcap")).unwrap();
    assert_eq!(mended.ending, dragnet_coordinator::Ending::Complete);
    assert!(mended.observations > 0);
}
