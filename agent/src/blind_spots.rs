//! Cells that a vehicle does not see although the sensor's model says that it does: behind walls that hide them, or in
//! parts that its cameras never face.
//!
//! An observation of such a cell contains no reading of it, or one that says next to nothing, however often it is made,
//! and a robot that expects more would come back until its budget is spent. A robot that has expected readings of a
//! cell often enough and got none counts on none: it plans, and ends its search, as if the cell were empty. The team's
//! belief remains as it is, and with it the number of objects that are still expected.

use std::borrow::Cow;
use std::collections::BTreeMap;

use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;

/// Observations without a reading after which a cell is a blind spot, more than the cells from which it can be observed.
const MORE_OBSERVATIONS: u32 = 8;
/// Variance of a reading that says next to nothing: a tenth of a nat,
const FAINT_VARIANCE: f32 = 5.0;
/// and is larger than that of the sensor's model by more than this factor.
const LESS_PRECISE: f32 = 2.0;
/// Evidence of an empty cell that nobody goes to look at, nats.
const EMPTY_NATS: f64 = 40.0;

/// The cells without readings.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlindSpots {
    /// Number of observations that should have read a cell since the last one that did.
    missed: BTreeMap<Cell, u32>,
}

impl BlindSpots {
    /// Adds an own observation. One of a simulated sensor reads all of its cells.
    pub(crate) fn add(&mut self, terrain: &Terrain, sensor: &Sensor, from: Cell, readings: &[Reading]) {
        // Most observations are in the order of the footprint.
        let mut next = 0;
        for (cell, place) in terrain.in_sight(sensor, from) {
            let reading = match readings.get(next) {
                Some(reading) if reading.cell == cell => {
                    next += 1;
                    Some(reading)
                }
                _ => readings.iter().find(|reading| reading.cell == cell),
            };
            let is_clear = |reading: &Reading| {
                reading.is_undecided()
                    || reading.variance <= FAINT_VARIANCE.max(LESS_PRECISE * place.variance)
            };
            if reading.is_some_and(is_clear) {
                self.missed.remove(&cell);
            } else if terrain.is_searched(cell) {
                let missed = self.missed.entry(cell).or_insert(0);
                *missed = missed.saturating_add(1);
            }
        }
    }

    /// The belief in which all blind spots are empty.
    pub(crate) fn removed_from<'a>(&self, mut belief: Cow<'a, Belief>, sensor: &Sensor) -> Cow<'a, Belief> {
        let most =
            u32::try_from(sensor.footprint().len()).unwrap_or(u32::MAX).saturating_add(MORE_OBSERVATIONS);
        for (&cell, _) in self.missed.iter().filter(|&(_, &missed)| missed > most) {
            clear(&mut belief, cell);
        }
        belief
    }
}

/// Makes a cell empty, so that nobody goes to look at it.
pub(crate) fn clear(belief: &mut Cow<'_, Belief>, cell: Cell) {
    belief.to_mut().add(&Reading::with_nats(cell, 0.0, EMPTY_NATS));
}

#[cfg(test)]
mod tests {
    use super::*;
    use dragnet_search::sensor::Noise;

    #[test]
    fn a_cell_without_readings_is_a_blind_spot_until_it_is_read() {
        let terrain = Terrain::from_ascii("...\n...\n...", 10.0).unwrap();
        let sensor = Sensor::new(1, 0.005, Noise::Gaussian).unwrap();
        let belief = Belief::uniform(&terrain, 0.1).unwrap();
        let middle = terrain.grid().cell_numbered(4).unwrap();
        let reading = |cell| Reading { cell, value: 0.0, variance: 1.0 };
        let seen: Vec<Cell> =
            [1, 3, 4, 5].map(|number| terrain.grid().cell_numbered(number).unwrap()).to_vec();
        let hidden = terrain.grid().cell_numbered(7).unwrap();
        let readings: Vec<Reading> = seen.iter().copied().map(reading).collect();
        let mut blind_spots = BlindSpots::default();
        let mut probability = |readings: &[Reading]| {
            blind_spots.add(&terrain, &sensor, middle, readings);
            let belief = blind_spots.removed_from(Cow::Borrowed(&belief), &sensor);
            format!("{:.2}", belief.probability(hidden))
        };
        // There are five cells to observe it from.
        for _ in 0..13 {
            assert_eq!(probability(&readings), "0.10");
        }
        assert_eq!(probability(&readings), "0.00");
        assert_eq!(probability(&[Reading::undecided(hidden)]), "0.10");
        assert_eq!(probability(&readings), "0.10");
    }
}
