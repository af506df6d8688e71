//! What a decision is expected to find along its path.

use super::Decision;
use crate::belief::probability;
use crate::cell::Cell;
use crate::evidence::UNITS;
use crate::situation::Situation;
use crate::utility::{found, log_odds_nats as log_odds_of};

impl Decision {
    /// Expected number of objects that count as found before the first cell of the path and after each of its cells, shape
    /// `[path.len() + 1]`, if the robot drives it to the end: `sum_c p_c F_c`.
    ///
    /// `p_c` is the probability of an object in cell `c`. `F_c` is the probability that readings of the total precision `k`
    /// from the path bring the log-odds of an object's cell from `L` to the detection threshold `theta`, `Phi((L + k/2 -
    /// theta) / sqrt k)`. It counts neither what teammates observe meanwhile nor that the robot may decide again with
    /// new readings, nor empty cells that are called found.
    #[must_use]
    pub fn expected_found(&self, situation: &Situation<'_>) -> Vec<f64> {
        let Situation { terrain, sensor, belief, .. } = situation;
        let theta = log_odds_of(situation.detection_threshold);
        let of_cell = |cell: Cell, precision: i64| {
            let log_odds_nats = belief.log_odds_nats(cell);
            probability(log_odds_nats) * found(log_odds_nats, precision as f64 / UNITS, theta)
        };
        let mut precision = vec![0_i64; terrain.grid().cell_count()];
        let mut each: Vec<f64> = vec![0.0; precision.len()];
        for cell in terrain.searched_cells() {
            each[cell.index()] = of_cell(cell, 0);
        }
        let mut sum: f64 = each.iter().sum();
        let mut sums = vec![sum];
        for &from in &self.path {
            for (cell, observation) in terrain.in_sight(sensor, from) {
                if !terrain.is_searched(cell) {
                    continue;
                }
                precision[cell.index()] += observation.precision;
                let more = of_cell(cell, precision[cell.index()]);
                sum += more - each[cell.index()];
                each[cell.index()] = more;
            }
            sums.push(sum);
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use crate::belief::Belief;
    use crate::cell::{Cell, Grid};
    use crate::evidence::Reading;
    use crate::intent::PlannedPrecision;
    use crate::policy::{Decision, Parameters, PolicyName, build};
    use crate::seed::{Purpose, Stream, stream};
    use crate::sensor::{Noise, Sensor};
    use crate::situation::Situation;
    use crate::terrain::{Ground, Terrain};

    fn open(side: u32) -> Terrain {
        let grid = Grid::new(side, side).unwrap();
        Terrain::new(grid, 1.0, vec![Ground::OPEN; grid.cell_count()]).unwrap()
    }

    fn origin(terrain: &Terrain) -> Cell {
        terrain.grid().cells().next().unwrap()
    }

    /// Objects found after each cell of the path, in one drawn world.
    fn drive(situation: &Situation<'_>, path: &[Cell], random: &mut Stream) -> Vec<f64> {
        let mut belief = situation.belief.clone();
        let terrain = situation.terrain;
        let is_object: Vec<bool> = terrain
            .grid()
            .cells()
            .map(|cell| terrain.is_searched(cell) && random.random::<f64>() < belief.probability(cell))
            .collect();
        let found = |belief: &Belief| {
            let is_found = |cell: &Cell| {
                is_object[cell.index()] && belief.is_found(*cell, situation.detection_threshold)
            };
            terrain.searched_cells().filter(is_found).count() as f64
        };
        let mut counts = vec![found(&belief)];
        for &from in path {
            for observation in situation.sensor.footprint() {
                let Some(cell) = terrain.grid().step(from, observation.offset) else { continue };
                let value = situation.sensor.draw(is_object[cell.index()], observation, random);
                belief.add(&Reading { cell, value, variance: observation.variance });
            }
            counts.push(found(&belief));
        }
        counts
    }

    #[test]
    fn as_many_objects_are_found_along_a_path_as_are_expected() {
        let terrain = open(8);
        let sensor = Sensor::new(3, 0.2, Noise::Gaussian).unwrap();
        let belief = Belief::uniform(&terrain, 0.05).unwrap();
        let planned = PlannedPrecision::nothing(&terrain);
        let situation = Situation::alone(&terrain, &sensor, &belief, &planned, origin(&terrain));
        let mut random = stream(1, Purpose::Decision, 1);
        let decision = build(PolicyName::Tour, Parameters::default()).choose(&situation, &mut random);
        let expected = decision.expected_found(&situation);
        assert_eq!(expected.len(), decision.path.len() + 1);
        let worlds: Vec<Vec<f64>> =
            (0..2_000).map(|_| drive(&situation, &decision.path, &mut random)).collect();
        for (place, expected) in expected.iter().enumerate() {
            let values = || worlds.iter().map(|world| world[place]);
            let mean = values().sum::<f64>() / 2_000.0;
            let variance = values().map(|value| (value - mean).powi(2)).sum::<f64>() / 2_000.0;
            assert!(
                (mean - expected).abs() <= 4.0 * (variance / 2_000.0).sqrt() + 1e-3,
                "{place}: {mean}, {expected}"
            );
        }
        assert!(expected.last().unwrap() > &2.5, "{expected:?}");
    }

    #[test]
    fn a_decision_to_rest_expects_what_is_found_already() {
        let terrain = open(3);
        let sensor = Sensor::new(1, 0.2, Noise::Gaussian).unwrap();
        let belief = Belief::uniform(&terrain, 0.97).unwrap();
        let planned = PlannedPrecision::nothing(&terrain);
        let situation = Situation::alone(&terrain, &sensor, &belief, &planned, origin(&terrain));
        let rest = Decision { chosen: situation.robot, path: Vec::new(), scores: Vec::new() };
        let expected = rest.expected_found(&situation);
        assert!(expected.len() == 1 && (expected[0] - 9.0 * 0.97).abs() < 1e-9, "{expected:?}");
    }
}
