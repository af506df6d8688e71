//! Measures of a search.

use crate::belief::Belief;
use crate::cell::Cell;
use crate::reach::Reach;
use crate::terrain::Terrain;

/// The truth: which cells hold an object, shape `[cells]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Truth {
    is_object: Vec<bool>,
    objects: Vec<Cell>,
}

impl Truth {
    /// Objects in these cells of a map.
    #[must_use]
    pub fn new(terrain: &Terrain, mut objects: Vec<Cell>) -> Self {
        objects.sort_unstable();
        objects.dedup();
        let mut is_object = vec![false; terrain.grid().cell_count()];
        for object in &objects {
            is_object[object.index()] = true;
        }
        Self { is_object, objects }
    }

    /// Whether a cell holds an object.
    #[must_use]
    #[inline]
    pub fn is_object(&self, cell: Cell) -> bool {
        self.is_object[cell.index()]
    }

    /// Cells that hold an object, by index.
    #[must_use]
    pub fn objects(&self) -> &[Cell] {
        &self.objects
    }
}

/// A confusion count of the cells that a belief calls found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Objects found.
    pub true_positives: u32,
    /// Empty cells called found.
    pub false_positives: u32,
    /// Objects not found.
    pub false_negatives: u32,
}

impl Score {
    /// Scores every searched cell that a robot can observe: an object out of reach does not count as missed.
    #[must_use]
    pub fn of(terrain: &Terrain, reach: &Reach, belief: &Belief, truth: &Truth, tau: f64) -> Self {
        let mut score = Self::default();
        for cell in terrain.searched_cells().filter(|&cell| reach.covers(cell)) {
            score.count(belief.is_found(cell, tau), truth.is_object(cell));
        }
        score
    }

    fn count(&mut self, is_found: bool, is_object: bool) {
        match (is_found, is_object) {
            (true, true) => self.true_positives += 1,
            (true, false) => self.false_positives += 1,
            (false, true) => self.false_negatives += 1,
            (false, false) => {}
        }
    }

    /// Updates the counts when one cell, object or empty, becomes found or stops being found.
    pub fn change(&mut self, is_found: bool, is_object: bool) {
        match (is_found, is_object) {
            (true, true) => {
                self.true_positives += 1;
                self.false_negatives -= 1;
            }
            (false, true) => {
                self.true_positives -= 1;
                self.false_negatives += 1;
            }
            (true, false) => self.false_positives += 1,
            (false, false) => self.false_positives -= 1,
        }
    }

    /// Number of objects in reach. Without one the shares below say nothing about a search.
    #[must_use]
    pub const fn object_count(self) -> u32 {
        self.true_positives + self.false_negatives
    }

    /// Share of the objects that are found; 1 if there is none.
    #[must_use]
    pub fn recall(self) -> f64 {
        share(self.true_positives, self.true_positives + self.false_negatives)
    }

    /// Share of the cells called found that hold an object; 1 if none is called found.
    #[must_use]
    pub fn precision(self) -> f64 {
        share(self.true_positives, self.true_positives + self.false_positives)
    }

    /// Harmonic mean of precision and recall; 1 if there is nothing to find and nothing is called found.
    #[must_use]
    pub fn f1(self) -> f64 {
        let positives = 2 * self.true_positives;
        share(positives, positives + self.false_positives + self.false_negatives)
    }
}

fn share(part: u32, whole: u32) -> f64 {
    if whole == 0 { 1.0 } else { f64::from(part) / f64::from(whole) }
}

/// A measure against path length, or against time: a step function that holds each value until the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// `(path length in cells, or seconds; value from there on)`, ascending.
    points: Vec<(f64, f64)>,
}

impl Curve {
    /// From this path length (cells) on, the measure has this value. Lengths must not decrease.
    pub fn push(&mut self, path_cells: f64, value: f64) {
        debug_assert!(self.points.last().is_none_or(|&(last, _)| path_cells >= last));
        match self.points.last_mut() {
            Some(last) if last.0 >= path_cells => last.1 = value,
            _ => self.points.push((path_cells, value)),
        }
    }

    /// Value at a path length (cells); 0 before the first.
    #[must_use]
    pub fn at(&self, path_cells: f64) -> f64 {
        let after = self.points.partition_point(|&(length, _)| length <= path_cells);
        if after == 0 { 0.0 } else { self.points[after - 1].1 }
    }

    /// Mean value from length 0 to a length (cells) above 0: the area under the curve over that length, `0..=1` for a
    /// measure in `0..=1`. Where a search ended earlier its last value is held.
    #[must_use]
    pub fn mean_until(&self, path_cells: f64) -> f64 {
        let ends = self.points.iter().skip(1).map(|&(length, _)| length).chain([f64::INFINITY]);
        let area: f64 = self
            .points
            .iter()
            .zip(ends)
            .map(|(&(start, value), end)| value * (end.min(path_cells) - start.min(path_cells)))
            .sum();
        area / path_cells
    }

    /// Path length (cells) from which on the measure first had at least this value; `None` if it never did.
    #[must_use]
    pub fn first_at_least(&self, value: f64) -> Option<f64> {
        self.points.iter().find(|point| point.1 >= value).map(|&(length, _)| length)
    }

    /// The points, `(path length in cells, value)`.
    #[must_use]
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_follow_their_definitions() {
        let score = Score { true_positives: 6, false_positives: 2, false_negatives: 4 };
        assert!((score.recall() - 0.6).abs() < 1e-12);
        assert!((score.precision() - 0.75).abs() < 1e-12);
        let f1 = 2.0 * 0.6 * 0.75 / (0.6 + 0.75);
        assert!((score.f1() - f1).abs() < 1e-12);
        assert!((Score::default().f1() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_change_counts_as_a_recount_does() {
        let mut score = Score { true_positives: 1, false_positives: 1, false_negatives: 2 };
        score.change(true, true);
        score.change(false, false);
        assert_eq!(score, Score { true_positives: 2, false_positives: 0, false_negatives: 1 });
        score.change(false, true);
        score.change(true, false);
        assert_eq!(score, Score { true_positives: 1, false_positives: 1, false_negatives: 2 });
    }

    #[test]
    fn a_curve_holds_each_value_until_the_next() {
        let mut curve = Curve::default();
        for (length, value) in [(0.0, 0.0), (2.0, 0.5), (6.0, 1.0), (6.0, 0.75)] {
            curve.push(length, value);
        }
        assert!((curve.at(5.9) - 0.5).abs() < 1e-12);
        assert!((curve.at(6.0) - 0.75).abs() < 1e-12);
        assert!((curve.mean_until(8.0) - (4.0 * 0.5 + 2.0 * 0.75) / 8.0).abs() < 1e-12);
        assert!((curve.mean_until(4.0) - 0.25).abs() < 1e-12);
        let first = [0.0, 0.5, 0.6, 0.75, 0.8].map(|value| curve.first_at_least(value));
        assert_eq!(first, [Some(0.0), Some(2.0), Some(6.0), Some(6.0), None]);
    }
}
