//! `dragnet soak`: whole teams under faults.

use super::Place;

#[test]
fn teams_survive_and_every_fault_has_bitten() {
    let place = Place::new();
    let total = place.json(&["soak", "--seeds", "500", "--json"]);
    assert_eq!(total["episodes"], 500);
    assert!(total["steps_checked"].as_u64() > Some(100_000), "{total}");
    let faults = total["faults"].as_object().unwrap();
    let network = faults["network"].as_object().unwrap();
    let counts = faults.iter().filter(|(kind, _)| *kind != "network").chain(network);
    for (kind, count) in counts {
        assert!(count.as_u64() >= Some(50), "{kind}: {total}");
    }
}

#[test]
fn the_same_seeds_are_the_same_episodes() {
    let place = Place::new();
    let run = |threads| place.succeed(&["soak", "--seeds", "7..17", "--json", "--threads", threads]);
    assert_eq!(run("1"), run("2"));
}
