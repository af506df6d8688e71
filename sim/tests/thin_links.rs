//! Teams over radios that send a message at a time.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

use std::path::Path;

use dragnet_scenario::Scenario;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::simulation::End;

const ROBOTS: usize = 5;

fn search(bytes_per_second: f64, seed: u64) -> Episode {
    let text = format!(
        "name = 'thin'\nmap = {{ shape = 'all_traversable', rows = 20, columns = 20 }}\nobjects.count = 4\n\
         robots = {{ count = {ROBOTS}, policy = 'path', start = 'random' }}\nmission.budget_meters = 30000.0\n\
         network = {{ loss = 0.3, bytes_per_second = {bytes_per_second:?} }}\n"
    );
    let scenario = Scenario::from_text(Path::new("thin.toml"), text).unwrap();
    episode::run(&scenario, seed, End::Resting).unwrap()
}

#[test]
fn beliefs_are_equal_over_radios_that_lose_messages() {
    for seed in 0..4 {
        let episode = search(125.0, seed);
        let (outcome, traffic) = (&episode.outcome, &episode.outcome.traffic);
        assert!(outcome.network.lost > 0, "{:?}", outcome.network);
        assert!(outcome.beliefs_equal, "seed {seed}");
        assert_eq!(episode.belief.digest(), outcome.digest);
        let sent = traffic.bytes() as f64;
        assert!(
            sent <= 125.0 * ROBOTS as f64 * outcome.ended.as_seconds() + 500.0 * ROBOTS as f64,
            "seed {seed}: {traffic:?}"
        );
    }
}

#[test]
fn a_radio_that_is_too_slow_keeps_to_its_rate_and_replaces_what_is_outdated() {
    let episode = search(10.0, 1);
    let traffic = &episode.outcome.traffic;
    assert!(traffic.unsent > 0, "{traffic:?}");
    // What is on the air at the end counts.
    let most = 10.0 * ROBOTS as f64 * episode.outcome.ended.as_seconds() + 500.0 * ROBOTS as f64;
    assert!(traffic.bytes() as f64 <= most, "{} bytes of {most}", traffic.bytes());
}

#[test]
fn the_same_seed_gives_the_same_search() {
    let [a, b] = [search(30.0, 2), search(30.0, 2)].map(|episode| episode.outcome);
    assert_eq!((a.digest, a.ended, a.network, &a.traffic), (b.digest, b.ended, b.network, &b.traffic));
}
