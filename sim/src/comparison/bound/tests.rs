use std::path::Path;

use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::variance;
use rand::RngExt;

use super::walks::Prices;
use super::*;

fn scenario(map: &str, rest: &str) -> Scenario {
    let text = format!("name = 'a'\nmap = {{ {map} }}\nmission.budget_meters = 9000.0\n{rest}\n");
    Scenario::from_text(Path::new("a.toml"), text).unwrap()
}

fn open(rows: u32, columns: u32, rest: &str) -> Scenario {
    scenario(
        &format!("shape = 'all_traversable', rows = {rows}, columns = {columns}, cell_meters = 30.0"),
        rest,
    )
}

fn any_prices(targets: usize, landmarks: &[Vec<u16>], glance: i32, random: &mut Stream) -> Prices {
    let mut prices = Prices { entry: Vec::new(), once: vec![0; targets], glance };
    prices.entry = (0..targets).map(|_| random.random_range(0..=UNIT)).collect();
    for &target in landmarks.iter().flatten() {
        let target = usize::from(target);
        prices.once[target] = random.random_range(0..=UNIT - prices.entry[target]);
    }
    prices
}

/// Every walk of a length, with the targets that it has seen.
fn walk_all(board: &Board, walk: &mut Vec<usize>, length: usize, visit: &mut impl FnMut(&[usize], usize)) {
    visit(walk, length);
    for step in &board.steps[walk[walk.len() - 1]] {
        if let Some(left) = length.checked_sub(usize::from(step.length)) {
            walk.push(usize::from(step.to));
            walk_all(board, walk, left, visit);
            walk.pop();
        }
    }
}

/// The heart of the bound: whatever the prices, no walk sees more than they allow.
#[test]
fn no_walk_leaves_less_unseen_than_any_prices_prove() {
    let mut tight = 0;
    for seed in 0..24 {
        let mut random = stream(seed, Purpose::Map, 0);
        let connectivity = if seed % 3 == 0 { 8 } else { 4 };
        let (rows, columns) = (random.random_range(2..5), random.random_range(2..7));
        let map = format!(
            "shape = 'all_traversable', rows = {rows}, columns = {columns}, connectivity = {connectivity}, cell_meters = 30.0"
        );
        let scenario = scenario(&map, "sensor.radius = 1\nobjects.count = 2\n");
        let board = Board::new(&scenario, false).unwrap();
        let landmarks = vec![vec![0, 1], vec![u16::try_from(board.targets.len() - 1).unwrap()]];
        let prices = any_prices(board.targets.len(), &landmarks, UNIT, &mut random);
        let walks = Walks::new(&board, landmarks);
        let longest = 6 * usize::from(board.units_per_cell);
        let most = walks.most_credit(&prices, longest, |_| false);
        assert_eq!(most.from.len(), longest + 1);
        let total: i32 = prices.entry.iter().chain(&prices.once).sum();
        for start in 0..board.positions.len() {
            walk_all(&board, &mut vec![start], longest, &mut |walk, left| {
                let is_seen = |target: u16| walk.iter().any(|&at| board.seen[at].contains(&target));
                let unseen = (0..).take(board.targets.len()).filter(|&target| !is_seen(target)).count();
                let proven = total - most.from[longest - left][start];
                assert!(proven <= UNIT * i32::try_from(unseen).unwrap(), "{seed} {walk:?}");
                tight += usize::from(unseen > 0 && proven > UNIT * i32::try_from(unseen).unwrap() / 2);
            });
        }
    }
    assert!(tight > 100, "{tight}");
}

/// What a cell pays by itself: a first look in full, or a glance its share, and as much again for a second look.
#[test]
fn every_cell_that_is_looked_at_has_paid_for_it() {
    let glance = 700;
    let scenario = open(4, 5, "sensor.radius = 2\nobjects.density = 0.1\n");
    let board = Board::new(&scenario, true).unwrap();
    let prices =
        Prices { entry: vec![UNIT; board.targets.len()], once: vec![0; board.targets.len()], glance };
    let walks = Walks::new(&board, Vec::new());
    let most = walks.most_credit(&prices, 5, |_| false);
    let mut met = [0; 3];
    for start in 0..board.positions.len() {
        walk_all(&board, &mut vec![start], 5, &mut |walk, left| {
            let mut owed = 0;
            for target in (0..).take(board.targets.len()) {
                let looks: Vec<usize> =
                    (0..walk.len()).filter(|&place| board.seen[walk[place]].contains(&target)).collect();
                let is_glance = looks
                    .first()
                    .is_some_and(|&first| first > 0 && board.is_glance(target, walk[first - 1], walk[first]));
                owed += match (looks.len(), is_glance) {
                    (0, _) => 0,
                    (_, false) => UNIT,
                    (1, true) => glance,
                    (_, true) => 2 * glance,
                };
                met[if looks.is_empty() { 0 } else { 1 + usize::from(is_glance) }] += 1;
            }
            assert!(owed <= most.from[5 - left][start], "{walk:?}");
        });
    }
    assert!(met.iter().all(|&met| met > 1000), "{met:?}");
}

/// `W_c <= q^(e + g)` after a glance, by numerical integration over its readings, for all shares of the price.
#[test]
fn a_glance_earns_no_less_than_it_proves() {
    for (density, needed, expected) in [(0.01, 7.5, 0.850), (0.2, 4.3, 0.814)] {
        let precision = 1.0 / f64::from(variance(0.005, 5));
        let k = glance_share(density, precision, needed);
        assert!((k - expected).abs() < 0.01, "{k}");
        let q = 1.0 - density;
        for e in [0.01, 0.1, 0.5, 0.9, 1.0_f64] {
            let step = 0.002;
            let mut mean = 0.0;
            for place in -20_000..20_000 {
                let nats = f64::from(place) * step;
                let normal = |mean: f64| {
                    (-(nats - mean).powi(2) / 2.0 / precision).exp()
                        / (2.0 * std::f64::consts::PI * precision).sqrt()
                };
                let (object, empty) = (density * normal(precision / 2.0), q * normal(-precision / 2.0));
                let psi = if nats >= needed { 1.0 } else { empty / (object + empty) };
                mean += step * (object + empty) * psi.max(q.powf(k * e));
            }
            assert!(q.powf(k * e) * mean <= q.powf(e) * (1.0 + 1e-6), "{density} {e}");
            // With a smaller share it would not hold.
            if e > 0.99 {
                assert!(q.powf(0.9 * k) * mean > q, "{density}");
            }
        }
    }
}

/// Along a corridor, from its end, a step shows one more cell whatever one does.
#[test]
fn the_bound_is_exact_where_nothing_can_be_chosen() {
    let rest = "sensor.radius = 1\nsensor.noise = 'clipped'\nrobots.start = [0, 0]\n";
    let density = open(1, 20, &format!("{rest}objects.density = 0.1"));
    let expected: f64 = (0..18).map(|unseen| 1.0 - 0.9_f64.powi(18 - unseen)).sum();
    let bound = least_cells_to_full_recall(&density).unwrap();
    assert!((bound - expected).abs() < 1e-9, "{bound} {expected}");
    let count = open(1, 20, &format!("{rest}objects.count = 1"));
    let expected: f64 = (1..=18).map(|unseen| f64::from(unseen) / 20.0).sum();
    let bound = least_cells_to_full_recall(&count).unwrap();
    assert!((bound - expected).abs() < 1e-9, "{bound} {expected}");
}

#[test]
fn the_budget_restricts_the_bound_as_it_does_the_mean() {
    let rest = "sensor.radius = 1\nsensor.noise = 'clipped'\nrobots.start = [0, 0]\nobjects.density = 0.1";
    let bound =
        |cells| least_cells_to_full_recall(&open(1, 20, rest).with_budget_cells(cells).unwrap()).unwrap();
    let expected: f64 = (0..5).map(|unseen| 1.0 - 0.9_f64.powi(18 - unseen)).sum();
    assert!((bound(5) - expected).abs() < 1e-9);
    assert!(bound(5) < bound(9) && bound(9) < bound(18));
}

#[test]
fn no_policy_is_better_than_the_bound() {
    for (objects, robots) in [("density = 0.05", 1), ("density = 0.05", 2), ("count = 3", 1)] {
        let rest = format!("sensor.radius = 2\nobjects.{objects}\nrobots.count = {robots}");
        let scenario = open(9, 9, &rest);
        let bound = least_cells_to_full_recall(&scenario).unwrap();
        for policy in ["path", "tour"] {
            let scenario =
                scenario.with_policy(policy.parse::<dragnet_learn::policy::PolicyName>().unwrap()).unwrap();
            let setting = super::super::Setting::new(&scenario, policy.to_owned());
            let trials = (0..20).map(|seed| super::super::run(&setting, &scenario, seed).unwrap());
            let row = super::super::Row::new(&setting, trials.collect());
            let mean = row.cells_to_full_recall.restricted_mean;
            assert!(bound > 0.2 * mean, "{policy} {objects}: {bound} {mean}");
            assert!(bound < mean, "{policy} {objects}: {bound} {mean}");
        }
    }
}

#[test]
fn there_is_no_bound_where_a_policy_could_know_all() {
    let known = open(5, 5, "sensor.radius = 1\nobjects.cells = [[1, 1]]");
    assert_eq!(least_cells_to_full_recall(&known), Err(NoBound::KnownObjects));
    let large = open(65, 65, "sensor.radius = 1\nobjects.count = 2");
    assert_eq!(least_cells_to_full_recall(&large), Err(NoBound::TooLarge));
}
