//! NATS and GUTS against their full matrix form: nothing diagonal is assumed, nothing is updated in place.

use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Reading, UNITS};
use dragnet_search::policy::PolicyName;
use dragnet_search::seed::{Purpose, stream};
use nalgebra::{DMatrix, DVector};
use rand_distr::{Distribution, StandardNormal};

use super::{Case, check};

struct Gaussian {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
    gamma: DVector<f64>,
}

/// Readings of the searched cells as `y = X theta + N(0, S)`.
struct Data {
    x: DMatrix<f64>,
    s_inverse: DMatrix<f64>,
    y: DVector<f64>,
}

impl Data {
    /// One row a reading: the summed evidence of each cell that has any is one reading of the same likelihood.
    fn of(case: &Case, cells: &[Cell]) -> Self {
        let mut rows = Vec::new();
        for (column, &cell) in cells.iter().enumerate() {
            let sums = case.belief.evidence().of(cell);
            if sums.precision > 0 {
                let precision = sums.precision as f64 / UNITS;
                rows.push((column, sums.weighted_sum as f64 / UNITS / precision, precision));
            }
        }
        Self::from_rows(&rows, cells.len())
    }

    fn from_rows(rows: &[(usize, f64, f64)], columns: usize) -> Self {
        let mut x = DMatrix::zeros(rows.len(), columns);
        for (row, &(column, _, _)) in rows.iter().enumerate() {
            x[(row, column)] = 1.0;
        }
        let s_inverse =
            DMatrix::from_diagonal(&DVector::from_iterator(rows.len(), rows.iter().map(|row| row.2)));
        let y = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.1));
        Self { x, s_inverse, y }
    }

    /// `(X^T S^-1 X + G^-1)^-1` and the mean that goes with it.
    fn posterior(&self, gamma: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let g_inverse = DMatrix::from_diagonal(&gamma.map(|gamma| 1.0 / gamma));
        let information = self.x.transpose() * &self.s_inverse * &self.x + g_inverse;
        let covariance = information.try_inverse().unwrap();
        (&covariance * self.x.transpose() * &self.s_inverse * &self.y, covariance)
    }

    fn and(&self, rows: &[(usize, f64, f64)]) -> Self {
        let columns = self.x.ncols();
        let mut all: Vec<(usize, f64, f64)> = (0..self.x.nrows())
            .map(|row| {
                let column = (0..columns).find(|&column| self.x[(row, column)] > 0.0).unwrap();
                (column, self.y[row], self.s_inverse[(row, row)])
            })
            .collect();
        all.extend(rows);
        Self::from_rows(&all, columns)
    }
}

fn em(data: &Data, iterations: usize) -> Gaussian {
    let count = data.x.ncols();
    let mut gamma = DVector::from_element(count, 1e8);
    let (mut mean, mut covariance) = data.posterior(&gamma);
    for _ in 0..iterations {
        (mean, covariance) = data.posterior(&gamma);
        gamma = DVector::from_fn(count, |i, _| (2.0 + mean[i] * mean[i] + covariance[(i, i)]) / 1.2);
    }
    Gaussian { mean, covariance, gamma }
}

fn support(z: &DVector<f64>) -> Vec<bool> {
    z.iter().map(|value| value.round() > z.max() / 2.0).collect()
}

/// Reward of every candidate by the released algorithm, matrices and all.
fn reference(case: &Case, name: PolicyName, seed: u64) -> Vec<(Cell, f64)> {
    let cells: Vec<Cell> = case.terrain.searched_cells().collect();
    let data = Data::of(case, &cells);
    let is_nats = name == PolicyName::Nats;
    let belief = em(&data, if is_nats { 30 } else { 1 });
    let mut random = stream(seed, Purpose::Decision, 1);
    let mut sample = DVector::from_fn(cells.len(), |i, _| {
        let normal: f64 = StandardNormal.sample(&mut random);
        (belief.mean[i] + belief.covariance[(i, i)].sqrt() * normal).max(0.0)
    });
    if is_nats {
        let half = sample.max() / 2.0;
        sample = sample.map(|value| f64::from(u8::from(value > half)));
    }
    let routes = case.routes();
    let grid = case.terrain.grid();
    let mut terms = Vec::new();
    for &candidate in routes.candidates() {
        let mut rows = Vec::new();
        for (column, &cell) in cells.iter().enumerate() {
            let offset = grid.offset(candidate, cell);
            let distance = offset.manhattan();
            if distance <= case.sensor.radius() && !case.terrain.line_of_sight().hides(candidate, offset) {
                rows.push((column, sample[column], 1.0 / f64::from(case.sensor.variance(distance))));
            }
        }
        let (mean, _) = data.and(&rows).posterior(&belief.gamma);
        let error = &mean - &sample;
        let norm = if is_nats { error.abs().sum() } else { error.norm() };
        let differs = f64::from(u8::from(support(&mean) != support(&sample)));
        let offset = grid.offset(case.robot, candidate);
        let distance = f64::from(offset.north * offset.north + offset.east * offset.east).sqrt();
        terms.push((candidate, norm + 0.01 * differs, distance));
    }
    reward(&terms, is_nats)
}

fn reward(terms: &[(Cell, f64, f64)], is_nats: bool) -> Vec<(Cell, f64)> {
    let count = terms.len() as f64;
    let loss_mean = terms.iter().map(|term| term.1).sum::<f64>() / count;
    let distance_mean = terms.iter().map(|term| term.2).sum::<f64>() / count;
    let least = terms.iter().map(|term| term.1).fold(f64::INFINITY, f64::min);
    let most = terms.iter().map(|term| term.1).fold(f64::NEG_INFINITY, f64::max);
    terms
        .iter()
        .map(|&(cell, loss, distance)| {
            if is_nats {
                (cell, -loss / loss_mean - 0.1 * distance / distance_mean)
            } else {
                (cell, if most > least { -(loss - least) / (most - least) } else { 0.0 })
            }
        })
        .collect()
}

fn check_all(name: PolicyName) {
    for seed in 0..60 {
        let case = Case::new(seed);
        let expected = reference(&case, name, seed);
        let of = |to| expected.iter().find(|(cell, _)| *cell == to).unwrap().1;
        check(&case, &case.decide(name, seed), of, 1e-9);
    }
}

#[test]
fn nats_agrees_with_its_matrix_form() {
    check_all(PolicyName::Nats);
}

#[test]
fn guts_agrees_with_its_matrix_form() {
    check_all(PolicyName::Guts);
}

#[test]
fn before_any_reading_nats_goes_blind_yet_on_the_map() {
    let mut case = Case::new(2);
    case.belief = dragnet_search::belief::Belief::uniform(&case.terrain, 0.2).unwrap();
    let first = case.decide(PolicyName::Nats, 1);
    assert!(case.routes().candidates().contains(&first.chosen));
    let cell = case.terrain.searched_cells().next().unwrap();
    case.belief.add(&Reading { cell, value: 0.0, variance: 0.1 });
    assert!(case.routes().candidates().contains(&case.decide(PolicyName::Nats, 1).chosen));
}
