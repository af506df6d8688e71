//! Lower bounds of path costs over a plain grid.

/// Costs are whole numbers: this many units for the length of a cell's edge over free ground.
pub const UNITS_PER_CELL: u32 = 1_000;

/// Kinds of steps: all others are their mirror images. Neighboring directions span a unit area each, so that every cell
/// between them is reached by a whole number of both.
const KINDS: [(i32, i32); 5] = [(1, 0), (3, 1), (2, 1), (3, 2), (1, 1)];

/// A step to a cell, and its kind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) east: i32,
    pub(super) north: i32,
    pub(super) kind: usize,
}

/// Maximum reach of steps along an axis, in cells.
pub(super) const STEP_REACH: usize = 3;

/// The 32 steps, counterclockwise.
pub(super) fn steps() -> Vec<Step> {
    let mut steps = Vec::with_capacity(32);
    for (kind, &(long, short)) in KINDS.iter().enumerate() {
        for (a, b) in [(long, short), (short, long)] {
            for (east, north) in [(a, b), (-a, b), (a, -b), (-a, -b)] {
                if !steps.iter().any(|step: &Step| (step.east, step.north) == (east, north)) {
                    steps.push(Step { east, north, kind });
                }
            }
        }
    }
    let angle = |step: &Step| f64::from(step.north).atan2(f64::from(step.east));
    steps.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    steps
}

/// Euclidean length of a kind of steps, in cells.
pub(super) fn length_cells(kind: usize) -> f64 {
    f64::from(KINDS[kind].0).hypot(f64::from(KINDS[kind].1))
}

/// Cost of each kind of steps over free ground, in units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Metric {
    pub(super) weights: [u32; KINDS.len()],
}

impl Metric {
    /// Euclidean lengths, scaled and rounded down.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 4 cells")]
    pub(super) fn scaled(scale: f64) -> Self {
        let weight = |kind| (f64::from(UNITS_PER_CELL) * length_cells(kind) * scale).floor() as u32;
        Self { weights: std::array::from_fn(weight) }
    }

    /// The cheapest path over free ground: by the two directions between which the goal lies.
    #[inline]
    pub(super) fn cost(&self, east: i32, north: i32) -> u64 {
        let (east, north) = (u64::from(east.unsigned_abs()), u64::from(north.unsigned_abs()));
        let (a, b) = (east.max(north), east.min(north));
        let [axis, three_one, two_one, three_two, diagonal] = self.weights.map(u64::from);
        if a >= 3 * b {
            (a - 3 * b) * axis + b * three_one
        } else if a >= 2 * b {
            (a - 2 * b) * three_one + (3 * b - a) * two_one
        } else if 2 * a >= 3 * b {
            (2 * a - 3 * b) * two_one + (2 * b - a) * three_two
        } else {
            (a - b) * three_two + (3 * b - 2 * a) * diagonal
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bellman and Ford over all 32 steps.
    #[test]
    fn the_cost_over_free_ground_is_that_of_the_cheapest_path() {
        let metric = Metric::scaled(0.98);
        let side = 41_usize;
        let middle = i32::try_from(side / 2).unwrap();
        let at = |east: i32, north: i32| {
            let (x, y) = (usize::try_from(east + middle).ok()?, usize::try_from(north + middle).ok()?);
            (x < side && y < side).then_some(y * side + x)
        };
        assert_eq!(steps().len(), 32);
        let mut cost = vec![u64::MAX / 2; side * side];
        cost[at(0, 0).unwrap()] = 0;
        loop {
            let before = cost.clone();
            for north in -middle..=middle {
                for east in -middle..=middle {
                    let here = cost[at(east, north).unwrap()];
                    for step in steps() {
                        if let Some(to) = at(east + step.east, north + step.north) {
                            cost[to] = cost[to].min(here + u64::from(metric.weights[step.kind]));
                        }
                    }
                }
            }
            if cost == before {
                break;
            }
        }
        for north in -15_i32..=15 {
            for east in -15_i32..=15 {
                assert_eq!(metric.cost(east, north), cost[at(east, north).unwrap()], "{east} {north}");
            }
        }
    }
}
