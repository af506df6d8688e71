//! Arrays with a learner's observation of a search: written once in full, then only where something changed.

use dragnet_search::belief::{Belief, probability};
use dragnet_search::cell::Cell;
use dragnet_search::evidence::UNITS;

use super::{Field, SingleRobotEnv};

/// A learner's arrays, each of shape `[cells]` by index except for the last two.
pub struct ObservationBuffers<'a> {
    /// `ln(p / (1 - p))`; `-inf` where nothing is searched.
    pub log_odds_nats: &'a mut [f64],
    /// `p`, `0..=1`.
    pub probability: &'a mut [f32],
    /// `sum 1/v` of the readings of the cell, exact to 1/65,536.
    pub precision: &'a mut [f64],
    /// `sum y/v` of the readings of the cell, exact to 1/65,536.
    pub weighted_sum: &'a mut [f64],
    /// Length of the shortest path from the robot, cells; infinite out of reach.
    pub distance_cells: &'a mut [f32],
    /// Row and column of the robot, shape `[2]`.
    pub position: &'a mut [i32],
    /// 1 if an action is available, else 0: shape `[cells]` if actions are waypoints, `[steps]` if they are steps.
    pub action_mask: &'a mut [i8],
}

/// The meaning of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// A cell to go to, by index.
    Waypoint,
    /// A step to a neighbor, by its index in the offsets of the moves.
    Step,
}

impl SingleRobotEnv {
    /// Writes all arrays in full.
    pub fn draw(&mut self, buffers: &mut ObservationBuffers<'_>, control: Control) {
        self.seen.clear();
        buffers.draw_belief(self.world.merged(), self.field.scenario().terrain().grid().cells());
        buffers.draw_robot(&self.field, self.cell(), control);
    }

    /// Writes what changed since the last call.
    pub fn redraw(&mut self, buffers: &mut ObservationBuffers<'_>, control: Control) {
        buffers.draw_belief(self.world.merged(), self.seen.iter().copied());
        self.seen.clear();
        buffers.draw_robot(&self.field, self.cell(), control);
    }
}

impl ObservationBuffers<'_> {
    /// Writes the belief of these cells.
    pub fn draw_belief(&mut self, belief: &Belief, cells: impl Iterator<Item = Cell>) {
        for cell in cells {
            let (index, evidence) = (cell.index(), belief.evidence().of(cell));
            let log_odds_nats = belief.log_odds_nats(cell);
            self.log_odds_nats[index] = log_odds_nats;
            self.probability[index] = short_probability(log_odds_nats);
            self.precision[index] = evidence.precision as f64 / UNITS;
            self.weighted_sum[index] = evidence.weighted_sum as f64 / UNITS;
        }
    }

    /// Writes a robot's position and its available actions.
    #[expect(clippy::cast_possible_wrap, reason = "a map has at most 2^24 rows or columns")]
    pub fn draw_robot(&mut self, field: &Field, cell: Cell, control: Control) {
        let position = field.scenario().terrain().grid().position(cell);
        self.position.copy_from_slice(&[position.row as i32, position.column as i32]);
        field.draw_distances(cell, self.distance_cells);
        match control {
            Control::Step => {
                for (step, is_open) in self.action_mask.iter_mut().enumerate() {
                    *is_open = i8::from(field.neighbor(cell, step).is_some());
                }
            }
            Control::Waypoint => {
                for (is_open, length) in self.action_mask.iter_mut().zip(&*self.distance_cells) {
                    *is_open = i8::from(length.is_finite() && *length > 0.0);
                }
            }
        }
    }
}

/// Probability of log-odds (nats), in 32 bits. Values that are certain in 32 bits need no exponential, and most cells
/// are.
#[expect(clippy::cast_possible_truncation, reason = "a probability for networks")]
fn short_probability(log_odds_nats: f64) -> f32 {
    if log_odds_nats > 18.0 {
        1.0
    } else if log_odds_nats < -104.0 {
        0.0
    } else {
        probability(log_odds_nats) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::float_cmp, clippy::cast_possible_truncation, reason = "to the bit")]
    fn a_short_probability_is_the_rounded_one() {
        for step in -12_000..=12_000 {
            let log_odds = f64::from(step) / 100.0;
            assert_eq!(short_probability(log_odds), probability(log_odds) as f32, "{log_odds}");
        }
        assert_eq!(short_probability(f64::NEG_INFINITY), 0.0);
    }
}
