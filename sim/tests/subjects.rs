//! Searches for subjects of known number: what is stated is what happens, as often as it is stated.
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

/// A search for one subject in eight by eight cells by one robot. Its budget ends many searches before all is searched, so that the
/// probabilities of different searches differ.
fn search(rest_of_world: f64, budget_meters: f64, noise_variance: f64) -> Scenario {
    search_for(1, rest_of_world, budget_meters, noise_variance)
}

fn search_for(number: u32, rest_of_world: f64, budget_meters: f64, noise_variance: f64) -> Scenario {
    let text = format!(
        "name = 'one'\nmap = {{ shape = 'all_traversable', rows = 8, columns = 8, cell_meters = 10.0 }}\n\
         sensor = {{ radius = 1, noise_variance = {noise_variance:?} }}\nprior.rest_of_world = {rest_of_world:?}\n\
         objects.count = {number}\nrobots.policy = 'greedy'\nmission.budget_meters = {budget_meters:?}\n"
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

/// A number that was stated in the mean, and what it was, for each search.
fn assert_stated(searches: &[Episode], what: &str, of: impl Fn(&Episode) -> (f64, usize)) {
    let errors: Vec<f64> = searches.iter().map(of).map(|(stated, counted)| counted as f64 - stated).collect();
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let variance = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let error = (variance / count).sqrt();
    assert!(mean.abs() <= 3.0 * error, "{what}: {mean} ± {error} more than stated");
    assert!(error > 0.001, "{what} was never in doubt: {error}");
}

#[test]
fn of_four_subjects_as_many_are_found_outside_or_left_as_stated() {
    let scenario = search_for(4, 0.2, 350.0, 0.3);
    let searches = run(&scenario);
    let threshold = scenario.mission().detection_threshold;
    let found = |search: &Episode| {
        let objects = search.truth.objects();
        objects.iter().filter(|&&cell| search.belief.is_found(cell, threshold)).count()
    };
    let standing = |search: &Episode| search.subject.unwrap();
    assert_stated(&searches, "found", |search| (standing(search).found, found(search)));
    assert_stated(&searches, "left", |search| {
        (standing(search).remaining, search.truth.objects().len() - found(search))
    });
    assert_stated(&searches, "outside", |search| {
        (standing(search).rest_of_world, 4 - search.truth.objects().len())
    });
}

#[test]
fn a_search_for_three_who_are_all_here_ends_with_the_third_find_and_not_before() {
    let scenario = search_for(3, 0.0, 100_000.0, 0.05);
    let independent = scenario.source().text.replace("prior.rest_of_world = 0.0\n", "");
    let independent = Scenario::from_text(Path::new("three.toml"), independent).unwrap();
    let threshold = scenario.mission().detection_threshold;
    // Searches that ended with less than three, and cells.
    let [known, guessed] = [&scenario, &independent].map(|scenario| {
        run(scenario).iter().fold((0, 0.0), |(early, cells), search| {
            let is_found = |cell: &&Cell| search.belief.is_found(**cell, threshold);
            let found = search.truth.objects().iter().filter(is_found).count();
            (early + usize::from(found < 3), cells + search.path_cells[0])
        })
    });
    assert!(known.0 * 4 <= guessed.0, "{known:?} {guessed:?}");
    assert!(known.1 < guessed.1, "{known:?} {guessed:?}");
}
