//! Searches for one subject: what is stated is what happens, as often as it is stated.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by a panic; Clippy knows only functions marked as tests"
)]

use std::path::Path;

use dragnet_scenario::Scenario;
use dragnet_search::cell::Cell;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::simulation::End;

const SEARCHES: u64 = 400;

/// A search of eight by eight cells by one robot. Its budget ends many searches before all is searched, so that the
/// probabilities of different searches differ.
fn search(rest_of_world: f64, budget_meters: f64, noise_variance: f64) -> Scenario {
    let text = format!(
        "name = 'one'\nmap = {{ shape = 'all_traversable', rows = 8, columns = 8, cell_meters = 10.0 }}\n\
         sensor = {{ radius = 1, noise_variance = {noise_variance:?} }}\nprior.rest_of_world = {rest_of_world:?}\n\
         objects.count = 1\nrobots.policy = 'greedy'\nmission.budget_meters = {budget_meters:?}\n"
    );
    Scenario::from_text(Path::new("one.toml"), text).unwrap()
}

fn run(scenario: &Scenario) -> Vec<Episode> {
    (0..SEARCHES).map(|seed| episode::run(scenario, seed, End::Resting).unwrap()).collect()
}

/// A probability that was stated, and whether what it is about happened, for each search.
struct Stated {
    probabilities: Vec<f64>,
    happened: Vec<bool>,
}

impl Stated {
    fn of(searches: &[Episode], of: impl Fn(&Episode) -> (f64, bool)) -> Self {
        let (probabilities, happened) = searches.iter().map(of).unzip();
        Self { probabilities, happened }
    }

    /// The number of times, what was expected, and the standard deviation of their difference.
    fn compared(&self) -> (f64, f64, f64) {
        let count = self.happened.iter().filter(|&&it| it).count() as f64;
        let variance: f64 = self.probabilities.iter().map(|p| p * (1.0 - p)).sum();
        (count, self.probabilities.iter().sum(), variance.sqrt())
    }

    fn assert_calibrated(&self, what: &str) {
        let (count, expected, deviation) = self.compared();
        assert!((count - expected).abs() <= 3.0 * deviation, "{what}: {count}, {expected} ± {deviation}");
        assert!(deviation > 1.0, "{what} was never in doubt: {deviation}");
    }
}

#[test]
fn the_subject_is_found_outside_or_left_as_often_as_stated() {
    let scenario = search(0.3, 350.0, 0.3);
    let searches = run(&scenario);
    let threshold = scenario.mission().detection_threshold;
    let is_found = |search: &Episode, cell: Cell| search.belief.is_found(cell, threshold);
    let place = |search: &Episode| search.truth.objects().first().copied();
    let standing = |search: &Episode| search.subject.unwrap();
    let found = Stated::of(&searches, |search| {
        (standing(search).found, place(search).is_some_and(|cell| is_found(search, cell)))
    });
    let left = Stated::of(&searches, |search| {
        (standing(search).remaining, place(search).is_some_and(|cell| !is_found(search, cell)))
    });
    let outside = Stated::of(&searches, |search| (standing(search).rest_of_world, place(search).is_none()));
    found.assert_calibrated("found");
    left.assert_calibrated("left");
    outside.assert_calibrated("outside");
    // The searches differ: some are almost sure of either.
    let is_among = |low: f64, high: f64| outside.probabilities.iter().any(|p| (low..high).contains(p));
    assert!(is_among(0.0, 0.05) && is_among(0.4, 1.0));
    // Independent cells know nothing of the rest of the world: they state something else.
    let independent = Stated::of(&searches, |search| {
        let remaining = search.belief.expected_remaining(scenario.terrain(), &search.reach, threshold);
        (remaining.min(1.0), place(search).is_some_and(|cell| !is_found(search, cell)))
    });
    let (count, expected, deviation) = independent.compared();
    assert!((count - expected).abs() > 3.0 * deviation, "{count}, {expected} ± {deviation}");
}

#[test]
fn a_search_for_somebody_who_is_not_there_ends_by_its_stopping_rule() {
    let scenario = search(0.3, 100_000.0, 0.2);
    let searches = run(&scenario);
    let limit = scenario.mission().stop_when_expected_remaining.unwrap();
    let absent: Vec<&Episode> = searches.iter().filter(|search| search.truth.objects().is_empty()).collect();
    let expected = 0.3 * SEARCHES as f64;
    assert!((absent.len() as f64 - expected).abs() < 4.0 * (0.7 * expected).sqrt(), "{}", absent.len());
    for search in &searches {
        assert!(search.expected_remaining <= limit, "{}", search.expected_remaining);
        assert!(search.path_cells[0] < 1_000.0, "it was not its budget that ended it");
    }
    let sure = absent.iter().filter(|search| search.subject.unwrap().rest_of_world > 0.9).count();
    assert!(sure as f64 > 0.9 * absent.len() as f64, "{sure} of {}", absent.len());
}
