//! How thoroughly the cells were searched so far, by robots and others: their probability of detection.

use dragnet_coordinator::fold::MissionFold;
use dragnet_search::cell::Cell;

/// The probability of detection of each cell, and of the whole search.
///
/// It is updated cell by cell: to compute it for all cells takes milliseconds on large maps, and there are ten frames a
/// second for each viewer.
#[derive(Clone, Debug)]
pub(crate) struct Searched {
    detection_threshold: f64,
    /// Shape `[cells]`, 0 to 1.
    pod: Vec<f64>,
    /// Sum of the prior probabilities.
    mass: f64,
    /// Sum of prior probability times probability of detection.
    detected: f64,
}

impl Searched {
    /// Before the first observation.
    pub(crate) fn new(fold: &MissionFold, detection_threshold: f64) -> Self {
        let grid = fold.terrain().grid();
        let mut searched =
            Self { detection_threshold, pod: vec![0.0; grid.cell_count()], mass: 0.0, detected: 0.0 };
        searched.add(fold, fold.terrain().searched_cells());
        searched
    }

    /// Counts cells that are searched from now on. Readings of them count with the next [`Searched::update`].
    pub(crate) fn add(&mut self, fold: &MissionFold, cells: impl IntoIterator<Item = Cell>) {
        let prior = |cell| fold.belief().prior_probability(cell);
        self.mass += cells.into_iter().map(prior).sum::<f64>();
    }

    /// Takes up the evidence of these cells.
    pub(crate) fn update(&mut self, fold: &MissionFold, cells: &[Cell]) {
        let belief = fold.belief();
        for &cell in cells {
            let pod = fold.probability_of_detection(cell, self.detection_threshold);
            let before = std::mem::replace(&mut self.pod[cell.index()], pod);
            self.detected += belief.prior_probability(cell) * (pod - before);
        }
    }

    /// The probability of detection of a cell.
    pub(crate) fn pod(&self, cell: Cell) -> f64 {
        self.pod[cell.index()]
    }

    /// The probability of detection of each cell, shape `[cells]`.
    pub(crate) fn pods(&self) -> &[f64] {
        &self.pod
    }

    /// The probability of detection of the whole search: the mean over its cells, weighted by their prior.
    pub(crate) fn total(&self) -> f64 {
        if self.mass > 0.0 { (self.detected / self.mass).clamp(0.0, 1.0) } else { 0.0 }
    }
}
