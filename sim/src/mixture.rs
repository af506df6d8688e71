//! A mixture of varied scenarios to train general policies on.

use std::path::Path;

use dragnet_scenario::{Scenario, ScenarioError};
use dragnet_search::generated::Generated;
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::sensor::Sensor;
use rand::RngExt;

/// Sides of a map, cells.
const SIDES: std::ops::RangeInclusive<u32> = 16..=40;
/// Densities of objects are drawn between these, evenly in their logarithm.
const DENSITIES: (f64, f64) = (0.01, 0.3);
/// One of this many searches has a team.
const TEAM_EVERY: u32 = 4;
/// One of this many has a robot that moves to eight neighbors.
const DIAGONAL_EVERY: u32 = 5;
/// One of this many has a sensor of another radius than the default.
const OTHER_RADIUS_EVERY: u32 = 3;

/// The scenario of a seed: a generated map of random size, density and sensor, with one robot or a few. The maps of the
/// paper are not among them.
///
/// # Errors
/// Never, since all generated scenarios are valid.
pub fn scenario(seed: u32) -> Result<Scenario, ScenarioError> {
    let mut random = stream(seed.into(), Purpose::Map, 1);
    let shape = Generated::ALL[random.random_range(0..Generated::ALL.len())].as_str();
    let (rows, columns) = (random.random_range(SIDES), random.random_range(SIDES));
    let density = DENSITIES.0 * (DENSITIES.1 / DENSITIES.0).powf(random.random::<f64>());
    let is_one_in = |count: u32, draw: u32| draw.is_multiple_of(count);
    let robots = if is_one_in(TEAM_EVERY, random.random()) { random.random_range(2..=4) } else { 1 };
    let connectivity = if is_one_in(DIAGONAL_EVERY, random.random()) { 8 } else { 4 };
    let drawn_radius = random.random_range(3..=7);
    let radius =
        if is_one_in(OTHER_RADIUS_EVERY, random.random()) { drawn_radius } else { Sensor::DEFAULT_RADIUS };
    let text = format!(
        "name = 'mixture'\n\
         map = {{ shape = '{shape}', rows = {rows}, columns = {columns}, seed = {seed}, connectivity = {connectivity} }}\n\
         sensor.radius = {radius}\n\
         objects.density = {density}\n\
         robots = {{ count = {robots}, policy = 'path', start = 'scattered' }}\n\
         mission.budget_meters = {}\n",
        30 * rows * columns
    );
    Scenario::from_text(Path::new(&format!("mixture-{seed}.toml")), text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_seed_is_a_search_and_they_differ() {
        let (mut teams, mut sizes) = (0, std::collections::BTreeSet::new());
        for seed in 0..200 {
            let scenario = scenario(seed).unwrap();
            teams += u32::from(scenario.robots().len() > 1);
            sizes.insert(scenario.terrain().grid().cell_count());
        }
        assert!((20..80).contains(&teams), "{teams}");
        assert!(sizes.len() > 100, "{}", sizes.len());
    }
}
