//! Thompson sampling of NATS and GUTS: the baselines.
//!
//! NATS: Ghods, Durkin and Schneider, "Decentralized multi-agent active search for sparse signals", ICRA 2021. GUTS:
//! Bakshi et al., ICRA 2023. Both as their authors released them, on this crate's sensor, map and moves:
//!
//! - the belief is Gaussian, `theta_i ~ N(0, gamma_i)`, `gamma_i ~ InvGamma(a, b)`, fitted by EM from `gamma = 1e8`:
//!   `V = 1 / (precision + 1/gamma)`, `mu = V weighted_sum`, `gamma <- (2b + mu^2 + V) / (1 + 2a)`;
//! - a robot draws one sample `s` of it, assumes that an observation from each candidate would return `s`, and goes
//!   where the estimate after it, `mu+`, would come closest to `s`. Only the final waypoint counts, and no plan is
//!   shared.
//!
//! Since a reading is of one cell, every matrix is diagonal and a decision takes one footprint per candidate.
//! Departures: our sensor is omnidirectional (theirs has headings), so a candidate is a cell; candidates are the cells
//! in reach but the robot's own; cells outside the search area are left out of belief and loss, which is GUTS's prior
//! of 0 there (of its prior of 0.05 inside, its released estimate makes no use); and cells whose path yields no
//! information are skipped, while the released code visits them repeatedly. That makes both better baselines.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

use super::worth::without_plans;
use super::{Decision, Policy};
use crate::cell::Cell;
use crate::evidence::{CellEvidence, UNITS};
use crate::intent::PlannedPrecision;
use crate::line_of_sight::Views;
use crate::route::ShortestPathTree;
use crate::seed::Stream;
use crate::situation::Situation;
use crate::utility_gain::{Frame, Limited};

/// Where NATS and GUTS differ.
pub(super) struct Thompson {
    em_iterations: u32,
    is_sample_binary: bool,
    norm: Norm,
    /// The last fit at each cell, shape `[cells]`: it depends on the sums alone, and few change between decisions.
    fits: Vec<(CellEvidence, Fit)>,
}

/// How far an estimate is from the sample.
#[derive(Clone, Copy)]
enum Norm {
    /// `|d|_1`, and a reward of `-loss / mean(loss) - 0.1 distance / mean(distance)`.
    Absolute,
    /// `|d|_2`, and a reward of minus the loss scaled to `0..=1`; distance has no weight.
    Euclidean,
}

/// Shape and scale of the inverse Gamma prior of each variance.
const A: f64 = 0.1;
const B: f64 = 1.0;
/// Initial `gamma` of EM.
const FIRST_GAMMA: f64 = 1e8;
/// Prior variance and scale of the Laplace sample of a first move, before any reading.
const BLIND_GAMMA: f64 = 1e3;
const BLIND_SCALE: f64 = 0.1;
/// What an estimate loses if it points to other cells than the sample.
const SUPPORT_LOSS: f64 = 0.01;
const DISTANCE_WEIGHT: f64 = 0.1;

impl Thompson {
    pub(super) const NATS: Self =
        Self { em_iterations: 30, is_sample_binary: true, norm: Norm::Absolute, fits: Vec::new() };
    pub(super) const GUTS: Self =
        Self { em_iterations: 1, is_sample_binary: false, norm: Norm::Euclidean, fits: Vec::new() };
}

impl Policy for Thompson {
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        let routes = situation.routes();
        let posterior = self.posterior(situation, random);
        let losses = CandidateLoss::new(situation, &posterior, self.norm);
        let loss: Vec<f64> = routes.candidates().iter().map(|&cell| losses.of(cell)).collect();
        let mut scores = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
        for (&cell, reward) in routes.candidates().iter().zip(self.rewards(situation, &routes, &loss)) {
            scores[cell.index()] = reward;
        }
        let nothing = PlannedPrecision::nothing(situation.terrain);
        Decision::best_of_informative(&without_plans(situation, &nothing), &routes, scores)
    }
}

/// Belief and sample of one cell.
#[derive(Clone, Copy)]
struct Sampled {
    precision: f64,
    weighted_sum: f64,
    /// `1 / gamma`.
    prior_precision: f64,
    /// Estimate without a further observation.
    mean: f64,
    sample: f64,
    /// Whether the sample points to this cell.
    is_support: bool,
}

impl Thompson {
    /// Belief and one sample, of searched cells only, shape `[cells]`.
    fn posterior(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Vec<Option<Sampled>> {
        let evidence = situation.belief.evidence();
        let is_blind = evidence.cells().iter().all(|cell| cell.precision == 0);
        let unseen = self.fit(0.0, 0.0);
        self.fits.resize(situation.terrain.grid().cell_count(), (CellEvidence::default(), unseen));
        let mut cells: Vec<Option<Sampled>> = vec![None; situation.terrain.grid().cell_count()];
        for cell in situation.terrain.searched_cells() {
            let sums = evidence.of(cell);
            let (precision, weighted_sum) = (sums.precision as f64 / UNITS, sums.weighted_sum as f64 / UNITS);
            let (fit, draw) = if is_blind {
                (Fit { gamma: BLIND_GAMMA, ..unseen }, laplace(random) * BLIND_SCALE)
            } else {
                if self.fits[cell.index()].0 != sums {
                    self.fits[cell.index()] = (sums, self.fit(precision, weighted_sum));
                }
                let (_, fit) = self.fits[cell.index()];
                let normal: f64 = StandardNormal.sample(random);
                (fit, fit.mean + fit.variance.sqrt() * normal)
            };
            let prior_precision = 1.0 / fit.gamma;
            cells[cell.index()] = Some(Sampled {
                precision,
                weighted_sum,
                prior_precision,
                mean: weighted_sum / (precision + prior_precision),
                sample: draw.max(0.0),
                is_support: false,
            });
        }
        self.finish_sample(&mut cells, is_blind);
        cells
    }

    fn finish_sample(&self, cells: &mut [Option<Sampled>], is_blind: bool) {
        let highest = |cells: &[Option<Sampled>]| {
            cells.iter().flatten().map(|cell| cell.sample).fold(f64::NEG_INFINITY, f64::max)
        };
        if self.is_sample_binary && !is_blind {
            let half = highest(cells) / 2.0;
            for cell in cells.iter_mut().flatten() {
                cell.sample = f64::from(u8::from(cell.sample > half));
            }
        }
        let half = highest(cells) / 2.0;
        for cell in cells.iter_mut().flatten() {
            cell.is_support = cell.sample.round() > half;
        }
    }

    fn fit(&self, precision: f64, weighted_sum: f64) -> Fit {
        let mut fit = Fit { gamma: FIRST_GAMMA, mean: 0.0, variance: 0.0 };
        for _ in 0..self.em_iterations {
            fit.variance = 1.0 / (precision + 1.0 / fit.gamma);
            fit.mean = fit.variance * weighted_sum;
            fit.gamma = (2.0 * B + fit.mean * fit.mean + fit.variance) / (1.0 + 2.0 * A);
        }
        fit
    }

    /// The reward of each candidate, in order of [`ShortestPathTree::candidates`].
    fn rewards(&self, situation: &Situation<'_>, routes: &ShortestPathTree, loss: &[f64]) -> Vec<f64> {
        match self.norm {
            Norm::Absolute => {
                let grid = situation.terrain.grid();
                let distance: Vec<f64> = routes
                    .candidates()
                    .iter()
                    .map(|&cell| grid.offset(routes.root(), cell).euclidean())
                    .collect();
                let (loss_mean, distance_mean) = (mean(loss), mean(&distance));
                loss.iter()
                    .zip(&distance)
                    .map(|(loss, distance)| {
                        -ratio(*loss, loss_mean) - DISTANCE_WEIGHT * ratio(*distance, distance_mean)
                    })
                    .collect()
            }
            Norm::Euclidean => {
                let least = loss.iter().copied().fold(f64::INFINITY, f64::min);
                let most = loss.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                loss.iter().map(|loss| -ratio(loss - least, most - least)).collect()
            }
        }
    }
}

/// Posterior of one cell, and the prior variance that EM gave it.
#[derive(Clone, Copy)]
struct Fit {
    gamma: f64,
    mean: f64,
    variance: f64,
}

fn laplace(random: &mut Stream) -> f64 {
    let uniform: f64 = random.random::<f64>() - 0.5;
    -uniform.signum() * (1.0 - 2.0 * uniform.abs()).ln()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// `part / whole`, and 0 where there is nothing to compare.
fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// The loss of each candidate, by what one footprint changes.
struct CandidateLoss<'a> {
    situation: &'a Situation<'a>,
    cells: &'a [Option<Sampled>],
    norm: Norm,
    observed: Observed,
    /// Searched cells by falling estimate.
    by_mean: Vec<Cell>,
    /// Cells of the sample's support by rising rounded estimate, the others by falling: the first ones contradict the
    /// sample first.
    support: Vec<Cell>,
    others: Vec<Cell>,
}

impl<'a> CandidateLoss<'a> {
    fn new(situation: &'a Situation<'a>, cells: &'a [Option<Sampled>], norm: Norm) -> Self {
        let estimate = |cell: Cell| cells[cell.index()].map_or(0.0, |cell| cell.mean);
        let is_support = |cell: Cell| cells[cell.index()].is_some_and(|cell| cell.is_support);
        let mut by_mean: Vec<Cell> = situation.terrain.searched_cells().collect();
        by_mean.sort_by(|&a, &b| estimate(b).total_cmp(&estimate(a)));
        let (mut support, others): (Vec<Cell>, Vec<Cell>) =
            by_mean.iter().partition(|&&cell| is_support(cell));
        support.reverse();
        let observed = Observed::new(situation, cells, norm);
        Self { situation, cells, norm, observed, by_mean, support, others }
    }

    /// `|mu+ - s|`, and [`SUPPORT_LOSS`] if `mu+` points to other cells than `s`: those whose rounded value is above
    /// half of the highest value.
    fn of(&self, candidate: Cell) -> f64 {
        let place = candidate.index();
        let unseen_mean = |cells| self.first_unseen(candidate, cells).map(|cell| cell.mean);
        let highest =
            self.observed.highest[place].max(unseen_mean(&self.by_mean).unwrap_or(f64::NEG_INFINITY));
        let half = highest / 2.0;
        let is_same = self.observed.least_support[place] > half
            && self.observed.highest_other[place] <= half
            && unseen_mean(&self.support).is_none_or(|mean| mean.round() > half)
            && unseen_mean(&self.others).is_none_or(|mean| mean.round() <= half);
        self.norm.whole(self.observed.distance[place]) + if is_same { 0.0 } else { SUPPORT_LOSS }
    }

    /// The first of these cells that an observation from the candidate does not cover.
    fn first_unseen(&self, candidate: Cell, cells: &[Cell]) -> Option<Sampled> {
        let Situation { terrain, sensor, .. } = self.situation;
        let unseen = cells.iter().find(|&&cell| !terrain.is_in_sight(sensor, candidate, cell))?;
        self.cells[unseen.index()]
    }
}

/// Estimates after an observation from each cell that returned the sample: shape `[cells]` each.
struct Observed {
    /// Of all estimates from the sample, absolute or squared.
    distance: Vec<f64>,
    /// Of the estimates of the cells that the observation covers.
    highest: Vec<f64>,
    /// Of these, rounded, those of the sample's support.
    least_support: Vec<f64>,
    /// Rounded, those of the other cells.
    highest_other: Vec<f64>,
}

impl Observed {
    /// All cells at one distance are observed with one precision, so a cell's estimate is computed once per ring; the
    /// rest is sums and extremes, row by row.
    fn new(situation: &Situation<'_>, cells: &[Option<Sampled>], norm: Norm) -> Self {
        let grid = situation.terrain.grid();
        let columns = grid.columns() as usize;
        let frame = Frame::new(grid, situation.sensor.radius());
        let before: f64 = cells.iter().flatten().map(|cell| norm.part(cell.mean - cell.sample)).sum();
        let all = |value: f64| vec![value; grid.cell_count()];
        let mut observed = Self {
            distance: all(before),
            highest: all(f64::NEG_INFINITY),
            least_support: all(f64::INFINITY),
            highest_other: all(f64::NEG_INFINITY),
        };
        let mut ring = Ring::nothing(frame);
        let nothing = [before, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        let views = Views::of(situation);
        let mut limited = Limited::new(frame, views.as_ref(), nothing);
        for observations in situation.sensor.rings() {
            let precision = 1.0 / f64::from(observations[0].variance);
            for (cell, sampled) in grid.cells().zip(cells) {
                if let Some(sampled) = sampled {
                    ring.set(frame.index(cell), sampled, precision, norm);
                }
            }
            limited.add(&observations, |[distance, highest, support, other], seen| {
                *distance += ring.change[seen];
                *highest = greater(*highest, ring.estimate[seen]);
                *support = lesser(*support, ring.support[seen]);
                *other = greater(*other, ring.other[seen]);
            });
            for observation in observations {
                for (row, seen) in frame.rows_at(observation.offset).enumerate() {
                    let row = row * columns..(row + 1) * columns;
                    each(&mut observed.distance[row.clone()], &ring.change[seen.clone()], |a, b| a + b);
                    each(&mut observed.highest[row.clone()], &ring.estimate[seen.clone()], greater);
                    each(&mut observed.least_support[row.clone()], &ring.support[seen.clone()], lesser);
                    each(&mut observed.highest_other[row], &ring.other[seen], greater);
                }
            }
        }
        for (from, [distance, highest, support, other]) in limited.sums() {
            let place = from.index();
            observed.distance[place] = distance;
            observed.highest[place] = highest;
            observed.least_support[place] = support;
            observed.highest_other[place] = other;
        }
        observed
    }
}

/// The effect of an observation from one distance on each cell, on a framed map; nothing outside of it.
struct Ring {
    /// Of the distance to the sample.
    change: Vec<f64>,
    estimate: Vec<f64>,
    /// Rounded estimate of a cell of the sample's support.
    support: Vec<f64>,
    /// Rounded estimate of another cell.
    other: Vec<f64>,
}

impl Ring {
    fn nothing(frame: Frame) -> Self {
        let all = |value: f64| vec![value; frame.cell_count()];
        let (least, most) = (f64::NEG_INFINITY, f64::INFINITY);
        Self { change: all(0.0), estimate: all(least), support: all(most), other: all(least) }
    }

    fn set(&mut self, place: usize, cell: &Sampled, precision: f64, norm: Norm) {
        let estimate = (cell.weighted_sum + cell.sample * precision)
            / (cell.precision + precision + cell.prior_precision);
        self.change[place] = norm.part(estimate - cell.sample) - norm.part(cell.mean - cell.sample);
        self.estimate[place] = estimate;
        let rounded = if cell.is_support { &mut self.support } else { &mut self.other };
        rounded[place] = estimate.round();
    }
}

fn each(values: &mut [f64], others: &[f64], merge: impl Fn(f64, f64) -> f64) {
    for (value, &other) in values.iter_mut().zip(others) {
        *value = merge(*value, other);
    }
}

/// Of two numbers that are not NaN: one instruction, as [`f64::max`] is not.
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

impl Norm {
    fn part(self, difference: f64) -> f64 {
        match self {
            Self::Absolute => difference.abs(),
            Self::Euclidean => difference * difference,
        }
    }

    fn whole(self, parts: f64) -> f64 {
        match self {
            Self::Absolute => parts,
            // Removing and adding parts can leave a rounding error below 0.
            Self::Euclidean => parts.max(0.0).sqrt(),
        }
    }
}
