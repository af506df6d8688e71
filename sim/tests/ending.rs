//! The end of searches: robots do not drive without gain, rest when nothing is left, and expect the right number of
//! remaining objects.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use dragnet_agent::agent::Agent;
use dragnet_learn::policy::build;
use dragnet_proto::message::Activity;
use dragnet_scenario::Scenario;
use dragnet_search::policy::{Decision, LEAST_NATS, Policy};
use dragnet_search::seed::Stream;
use dragnet_search::situation::Situation;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::participants::LocalParticipants;
use dragnet_sim::simulation::{End, Membership, Rules, StepContext};

/// A policy whose decisions are checked: it never sends a robot without gain.
struct Watched {
    policy: Box<dyn Policy + Send>,
    rests: Arc<AtomicU32>,
}

impl Policy for Watched {
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        let decision = self.policy.decide(situation, random);
        let best = decision.scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if decision.is_rest() {
            assert!(best <= LEAST_NATS, "it rests where {best} nats are to be had");
            self.rests.fetch_add(1, Ordering::Relaxed);
        } else {
            let score = decision.scores[decision.chosen.index()];
            assert!(score > LEAST_NATS && score >= best, "{score} nats, and {best} were to be had");
        }
        decision
    }
}

/// An episode until all robots rest.
struct Watching {
    episode: Episode,
    /// Number of decisions to rest.
    rests: u32,
    /// How often a robot began to wait for its teammates.
    waits: u32,
}

fn watch(scenario: &Scenario, seed: u64) -> Watching {
    let rests = Arc::new(AtomicU32::new(0));
    let mut robots = episode::team(scenario, seed, |config| {
        let policy = build(config.robot.policy.name, config.robot.policy.parameters, None);
        Agent::with_policy(config, Box::new(Watched { policy, rests: Arc::clone(&rests) }))
    });
    let mut waits = 0;
    let mut count = |_, scene| {
        if let StepContext::Departs { activity: Some(Activity::Waiting), .. } = scene {
            waits += 1;
        }
    };
    let rules = Rules { end: End::Resting, coordinator: Membership::Absent };
    let mut participants = LocalParticipants::new(&mut robots, None);
    let episode = episode::run_with(scenario, seed, rules, &mut participants, &mut count).unwrap();
    assert!(episode.outcome.beliefs_equal);
    Watching { episode, rests: rests.load(Ordering::Relaxed), waits }
}

/// Checks that a search ends soon after its last find: half as long again as the search took until then at most, and
/// the time of this many sweeps in lanes as wide as the sensor's diameter. Two of them bring all cells to where no more
/// than 0.05 objects are expected in 3,600 cells of 1 %, whenever the last was found: a cell needs about 7 nats of
/// evidence, and an observation at the sensor radius gives 4 (a precision of 8).
fn check_tail(scenario: &Scenario, episode: &Episode, sweeps: f64, what: &str) {
    let (terrain, mission) = (scenario.terrain(), scenario.mission());
    let ended = episode.outcome.ended.as_seconds();
    let last_find = episode.outcome.last_find.map_or(0.0, dragnet_scenario::time::MissionTime::as_seconds);
    let lane = f64::from(2 * scenario.sensor().radius() + 1);
    let sweep_meters = terrain.traversable_cells().count() as f64 / lane * terrain.cell_meters();
    let robots = scenario.robots().len() as f64;
    let swept = sweeps * sweep_meters / mission.speed_meters_per_second / robots;
    let missed = episode.score.false_negatives;
    println!(
        "{what}: last find {last_find:.0} s, end {ended:.0} s, {sweeps} sweeps {swept:.0} s, missed {missed}"
    );
    assert!(ended <= 1.5 * last_find + swept, "{what}: last find at {last_find} s, end at {ended} s");
    let expected = episode.expected_remaining;
    assert!(
        expected <= mission.stop_when_expected_remaining.unwrap(),
        "{what}: {expected} objects are expected"
    );
}

fn team(robots: u32) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/team.toml");
    Scenario::load(&path).unwrap().with_robots(robots).unwrap()
}

#[test]
fn a_team_of_any_size_goes_nowhere_for_nothing_and_ends_soon_after_its_last_find() {
    for (robots, seeds) in [(8, 0..2), (12, 0..2), (50, 0..1)] {
        let scenario = team(robots);
        let (mut rests, mut waits) = (0, 0);
        for seed in seeds {
            let watching = watch(&scenario, seed);
            check_tail(&scenario, &watching.episode, 0.0, &format!("{robots} robots, seed {seed}"));
            rests += watching.rests;
            waits += watching.waits;
        }
        assert!(rests > 0, "{robots} robots: it never came to nothing");
        println!("{robots} robots: {rests} rests, {waits} waits");
    }
}

/// A lake in the middle of 26 x 26 cells, so wide that its inner 6 x 6 are out of reach.
fn lake(robots: u32) -> Scenario {
    let folder = tempfile::tempdir().unwrap();
    let shore = ".".repeat(26) + "\n";
    let across = ".".repeat(6) + &"~".repeat(14) + &".".repeat(6) + "\n";
    std::fs::write(folder.path().join("lake.txt"), shore.repeat(6) + &across.repeat(14) + &shore.repeat(6))
        .unwrap();
    let text = format!(
        "name = 'lake'\nmap.file = 'lake.txt'\nsensor.radius = 4\nobjects.count = 8\nrobots.count = {robots}\n\
         mission.budget_seconds = 20000.0\n"
    );
    Scenario::from_text(&folder.path().join("a.toml"), text).unwrap()
}

#[test]
fn cells_out_of_reach_do_not_prolong_the_search() {
    let mut out_of_reach = 0;
    for robots in [1, 3] {
        for seed in 0..6 {
            let scenario = lake(robots);
            let Watching { episode, .. } = watch(&scenario, seed);
            check_tail(&scenario, &episode, 2.0, &format!("lake, {robots} robots, seed {seed}"));
            let hidden: Vec<_> = episode.reach.out_of_reach(scenario.terrain()).collect();
            assert!((20..60).contains(&hidden.len()), "{}", hidden.len());
            let lost = episode.truth.objects().iter().filter(|cell| hidden.contains(cell)).count();
            let in_reach = episode.truth.objects().len() - lost;
            let counted = episode.score.true_positives + episode.score.false_negatives;
            assert_eq!(
                usize::try_from(counted).unwrap(),
                in_reach,
                "an object that nobody can see is none that is missed"
            );
            out_of_reach += lost;
        }
    }
    assert!(out_of_reach > 0, "no object was ever out of reach");
}

#[test]
fn with_no_threshold_a_search_ends_when_everything_is_known() {
    let text = "name = 'a'\nmap = { shape = 'ice_cream_cone', rows = 12, columns = 12 }\nsensor.radius = 3\n\
                objects.count = 3\nrobots.count = 3\nmission = { budget_seconds = 1e6, stop_when_expected_remaining = 0.0 }\n";
    let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
    for policy in dragnet_learn::policy::PolicyName::all() {
        let scenario = scenario.with_policy(policy).unwrap();
        let episode = episode::run(&scenario, 1, End::Resting).unwrap();
        let ended = episode.outcome.ended.as_seconds();
        assert!(ended < 1e5, "{policy}: {ended} s");
        assert!(episode.expected_remaining < 1e-3, "{policy}: {}", episode.expected_remaining);
    }
}

/// Robots that stop when 0.5 objects are expected leave that number, in the mean over many searches.
#[test]
fn as_much_is_expected_to_remain_as_really_does() {
    let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 12, columns = 12 }\nsensor.radius = 3\n\
                objects.density = 0.05\nmission = { budget_meters = 1e6, stop_when_expected_remaining = 0.5 }\n";
    let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
    let (mut expected, mut remaining, mut square) = (0.0, 0.0, 0.0);
    let episodes = 400;
    for seed in 0..episodes {
        let episode = episode::run(&scenario, seed, End::Resting).unwrap();
        let left = f64::from(episode.score.false_negatives);
        expected += episode.expected_remaining;
        remaining += left;
        square += (left - episode.expected_remaining).powi(2);
    }
    let error = f64::sqrt(square);
    println!("{expected:.1} objects expected after {episodes} searches, {remaining} remained, +- {error:.1}");
    assert!(expected > 90.0, "{expected}");
    assert!((expected - remaining).abs() < 4.0 * error, "{expected:.1} expected, {remaining} remained");
}
