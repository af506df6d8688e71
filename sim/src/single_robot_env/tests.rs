use std::path::Path;

use dragnet_learn::policy;
use dragnet_scenario::Scenario;
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::situation::Situation;

use super::*;
use crate::episode;

fn scenario(rest: &str) -> Scenario {
    let text = format!("name = 'a'\nsensor.radius = 3\nobjects.count = 4\n{rest}");
    Scenario::from_text(Path::new("a.toml"), text).unwrap()
}

fn at_hand(scenario: &Scenario, end: End, seed: u64) -> SingleRobotEnv {
    SingleRobotEnv::new(Arc::new(Field::new(scenario.clone())), Terms { end, reward: Reward::Entropy }, seed)
}

/// Searches with the policy of the scenario's robot.
fn search(scenario: &Scenario, end: End, seed: u64) -> SingleRobotEnv {
    let mut env = at_hand(scenario, end, seed);
    let robot = &scenario.robots()[0];
    let mut policy = policy::build(robot.policy.name, robot.policy.parameters, None);
    let mut random = stream(seed, Purpose::Decision, robot.id.number());
    let planned_precision = PlannedPrecision::nothing(scenario.terrain());
    while env.ended().is_none() {
        let situation = Situation {
            connectivity: scenario.connectivity(),
            ..Situation::alone(
                scenario.terrain(),
                scenario.sensor(),
                env.belief(),
                &planned_precision,
                env.cell(),
            )
        };
        let decision = policy.decide(&situation, &mut random);
        if decision.is_rest() {
            env.wait();
        } else {
            env.go(decision.chosen);
        }
    }
    env
}

fn check(rest: &str, end: End, expected: Ended) {
    let scenario = scenario(rest);
    let mut met = 0;
    for seed in 0..12 {
        let env = search(&scenario, end, seed);
        let episode = episode::run(&scenario, seed, end).unwrap();
        assert_eq!(env.belief().digest(), episode.outcome.digest, "{rest}, seed {seed}");
        assert_eq!(env.score(), episode.score);
        assert_eq!(vec![env.path_cells()], episode.path_cells, "{rest}, seed {seed}");
        assert_eq!(env.track().len() as u64, episode.outcome.observations);
        met += u32::from(env.ended() == Some(expected));
    }
    assert!(met > 0, "{rest}: never {expected:?}");
}

const MAP: &str = "map = { shape = 'ice_cream_cone', rows = 14, columns = 14, cell_meters = 30.0 }\n";

#[test]
fn a_search_by_hand_is_the_episode_of_the_simulation() {
    for (policy, meters, expected) in [
        ("'path'", 9000.0, Ended::Found),
        ("'random'", 900.0, Ended::Spent),
        ("'coverage'", 9000.0, Ended::Found),
        ("{ name = 'greedy', replan_after_cells = 2 }", 9000.0, Ended::Found),
    ] {
        let rest = format!("{MAP}robots.policy = {policy}\nmission.budget_meters = {meters:?}\n");
        check(&rest, End::AllFound, expected);
    }
    let cleared =
        format!("{MAP}mission.budget_meters = 60000.0\nmission.stop_when_expected_remaining = 0.5\n");
    check(&cleared, End::Resting, Ended::Cleared);
}

#[test]
fn time_ends_a_search_where_it_ends_the_episode_beats_and_arrivals_at_once_too() {
    for connectivity in [4, 8] {
        for (speed, heartbeat, seconds) in
            [(2.0, 10.0, 600.0), (3.0, 10.0, 600.0), (6.0, 5.0, 300.0), (2.0, 5.0, 301.0), (3.7, 7.0, 99.0)]
        {
            let map = MAP.replace("30.0 }", &format!("30.0, connectivity = {connectivity} }}"));
            let mission = format!(
                "[mission]\nstop_when_expected_remaining = 0.0\nspeed_meters_per_second = {speed:?}\nheartbeat_seconds = {heartbeat:?}\nbudget_seconds = {seconds:?}\n"
            );
            check(&format!("{map}{mission}"), End::Resting, Ended::Spent);
        }
    }
}

#[test]
fn rewards_add_up_to_their_definition() {
    let scenario = scenario(&format!("{MAP}mission.budget_meters = 3000.0\n"));
    let field = Arc::new(Field::new(scenario.clone()));
    for reward in [Reward::Entropy, Reward::Found, Reward::F1] {
        let mut env = SingleRobotEnv::new(Arc::clone(&field), Terms { end: End::AllFound, reward }, 3);
        let measure = |env: &SingleRobotEnv| match reward {
            Reward::Entropy => -env.belief().entropy_nats(scenario.terrain()),
            Reward::Found => f64::from(env.score().true_positives),
            Reward::F1 => env.score().f1(),
        };
        let (start, mut sum) = (measure(&env), 0.0);
        let mut way = 0_usize;
        while env.ended().is_none() {
            let open = (0..4).map(|step| (step + way) % 4).find_map(|step| field.neighbor(env.cell(), step));
            sum += env.step(open.unwrap());
            way += 1;
        }
        assert!((measure(&env) - start - sum).abs() < 1e-9, "{reward:?}");
        assert!(sum.abs() > 0.0, "{reward:?}");
        assert!(env.step(env.cell()).abs() < f64::MIN_POSITIVE);
    }
}

#[test]
fn a_copy_has_the_same_future_and_changes_nothing_of_the_original() {
    let scenario = scenario(&format!("{MAP}mission.budget_meters = 3000.0\n"));
    let mut env = at_hand(&scenario, End::AllFound, 5);
    let walk = |env: &mut SingleRobotEnv, steps: usize| {
        let rewards: Vec<f64> = (0..steps)
            .map(|turn| {
                let open = (0..4).find_map(|step| env.field().neighbor(env.cell(), (step + turn) % 4));
                env.step(open.unwrap())
            })
            .collect();
        (rewards, env.belief().digest(), env.now())
    };
    walk(&mut env, 7);
    let before = env.belief().digest();
    let mut copy = env.clone();
    let imagined = walk(&mut copy, 12);
    assert_eq!(env.belief().digest(), before);
    assert_ne!(imagined.1, before);
    assert_eq!(walk(&mut env, 12), imagined);
}
