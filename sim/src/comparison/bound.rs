//! A bound: no policy finds everything in fewer cells in the mean.
//!
//! The bound is proven for every policy, adaptive and randomized ones too, and for one that knows map, density, sensor
//! and its start. It is on the expectation, over objects, starts and noise, of the statistic that tables give: the path
//! length `T` of the farthest robot until every object in reach was found, or the budget `B` if that is less or never.
//!
//! # Derivation
//!
//! **From lengths to probabilities.** `E[min(T, B)]` is the sum of `P(T > t)` over lengths `t` below `B`. A search without
//! objects ends at length 0, and counts as that here and in the tables.
//!
//! **What was not seen.** Let `N` targets be the searched cells in reach that the prior does not call found by itself. Each
//! holds an object with probability `p`, independently. What a robot reads of some cells says nothing about others, so
//! whatever made it choose its way, each target that it has not seen holds an object with probability `p`, and a cell
//! that was not seen is not found. If at most `A(t)` targets can be seen within length `t`, then `P(T <= t) <=
//! (1 - p)^(N - A(t))`. If exactly `n` of `M` searched cells hold an object, cells are exchangeable: the next cell to be
//! seen, however it is chosen, is as good as any other, and `P(T <= t) <= C(M - u, n) / C(M, n)` with `u = N - A(t)`.
//!
//! **What can be seen.** Give each target `c` two prices, `e_c + g_c <= 1`. A walk earns `e_c` whenever `c` comes into sight
//! that was not in sight from the two positions before, and `g_c` once, when any target of its *landmark* (a few
//! neighboring targets) is first in sight. Every target seen has been paid in full, so that of all targets a walk leaves
//! at least `u = sum (e_c + g_c) - V(t)` unseen, with `V(t)` the most credit that any walk of length `t` can earn. That is
//! an exact dynamic program (`walks`) for any prices (Lagrangian relaxation of "each target counts once"; Hawkins 2003
//! and Adelman and Mersereau 2008 relax coupled decisions so). `prices` looks for good ones. Robots of a team add up
//! their credit. All of it is in integers.
//!
//! **What a glance is worth.** If the robot goes straight on, the two targets exactly aside at the sensor's radius are seen
//! once, and one reading of that little precision often does not do. Where objects are independent, readings Gaussian and
//! moves straight, such a *glance* earns `k e_c` only, `k <= 1`, and so does the next look. Let `psi_c` be 1 if `c` was ever
//! above the detection threshold, and otherwise the probability that it holds no object. Given all readings, cells are
//! independent, so `P(T <= t) <= E[prod psi_c]`. Let `q = 1 - p`, `paid_c` what `c` has paid, and `W_c` the most that
//! `E[psi_c q^(paid_c)]` can be, from what has been read of `c` on, by any rule of when and from where to look at `c` alone.
//! A step of the search looks at cells whose readings are independent, so the product of all `W_c` is a supermartingale
//! under any policy, and since no walk is paid more than `V(t)`,
//!
//! ```text
//! P(T <= t) <= q^(-V(t)) prod_c W_c <= q^(sum (e_c + g_c) - V(t)).
//! ```
//!
//! The last step is to be shown for each cell: `W_c <= q^(e_c + g_c)` at the start. Not to look gives `q`. A first observation that
//! is no glance has paid in full. After a glance the cell is left, or looked at again for another `k e_c`: at most
//! `q^(k e_c + g_c) E[max(psi_c, q^(k e_c))]`. With `p'` the probability after the glance where it does not reach the
//! threshold, else 0, `E[max(psi_c, q^(k e))] = 1 - h(e)`, `h(e) = E[min(p', 1 - q^(k e))]`. It is concave in `e` with
//! `h(0) = 0`, so `h(e) >= e h(1)`, and `1 - h(e) <= q^((1 - k) e)` holds if `h(1) >= (1 - k) ln(1 / q)`. `glance_share`
//! solves that for the least `k`: 0.85 at a density of 1 % and the sensor of the paper's scenarios. A robot learns so
//! much from one observation at its sensor's rim that noise proves little more than this.
//!
//! # How tight it is
//!
//! Walks of the relaxation may be mixed: two half searches count as one whole. And a cell that was looked at twice counts as
//! cleared for certain. `docs/results.md` has the figures.

mod board;
mod landmarks;
mod prices;
mod walks;

use dragnet_scenario::{Objects, Scenario};
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::route::Connectivity;
use dragnet_search::sensor::Noise;
use dragnet_search::terrain::Terrain;

use serde::Serialize;

use super::Row;
use board::Board;
use prices::{Case, Search, Unseen};
use walks::{UNIT, Walks};

/// Why there is no bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoBound {
    /// A policy could know them.
    #[error("objects in given cells: a bound needs objects.density or objects.count")]
    KnownObjects,
    /// The derivation takes them for alike.
    #[error("objects placed by a prior that differs by cell: a bound needs objects.placement = \"uniform\"")]
    UnlikeCells,
    /// The derivation takes them for alike.
    #[error("robots that differ in class, or fly: a bound needs robots of one class on the ground")]
    UnlikeRobots,
    /// The computation would take long.
    #[error("more than {} cells: allowed for a bound are no more", Board::MAX_POSITIONS)]
    TooLarge,
}

/// How far above the bound of its scenario a policy is. Names are those of the JSON object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// Name of the scenario.
    pub scenario: String,
    /// Label of the policy.
    pub policy: String,
    /// [`least_cells_to_full_recall`] of the scenario.
    pub bound_cells: f64,
    /// Restricted mean of the path length to full recall, cells.
    pub cells: f64,
    /// `100 (cells / bound_cells - 1)`; unknown if the bound is 0.
    pub above_percent: Option<f64>,
}

impl Gap {
    /// The gap of a row to the bound of its scenario.
    #[must_use]
    pub fn of(row: &Row, bound_cells: f64) -> Self {
        let cells = row.cells_to_full_recall.restricted_mean;
        Self {
            scenario: row.scenario.clone(),
            policy: row.policy.clone(),
            bound_cells,
            cells,
            above_percent: (bound_cells > 0.0).then(|| 100.0 * (cells / bound_cells - 1.0)),
        }
    }
}

/// Where objects are.
#[derive(Clone, Copy)]
enum Law {
    /// Each target holds one with this probability.
    Independent(f64),
    /// This number of the searched cells holds one.
    Number { objects: u32, searched: u32 },
}

/// Checks that there is a bound for a scenario, before it is computed.
///
/// # Errors
/// If there is none.
pub fn check(scenario: &Scenario) -> Result<(), NoBound> {
    check_robots(scenario)?;
    Law::of(scenario)?;
    Board::new(scenario, false).map(|_| ()).ok_or(NoBound::TooLarge)
}

/// The least expected path length, in cells, until a search finds every object or its budget is spent: a lower bound for
/// every policy, of [`super::CellsToRecall::restricted_mean`].
///
/// # Errors
/// If there is none for the scenario.
pub fn least_cells_to_full_recall(scenario: &Scenario) -> Result<f64, NoBound> {
    check_robots(scenario)?;
    let law = Law::of(scenario)?;
    let glance = glance_units(scenario, law);
    let board = Board::new(scenario, glance < UNIT).ok_or(NoBound::TooLarge)?;
    let cases = Case::all(&board.starts, scenario.robots().len());
    let units = f64::from(board.units_per_cell);
    let budget = scenario.budget_cells() * units;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a length, rounded up")]
    let longest = budget.ceil() as usize;
    let search = Search { board: &board, cases: &cases, glance, is_empty: law.is_empty(), longest };
    let mut unseen = Unseen::new();
    let walks = Walks::new(&board, Vec::new());
    search.run(&walks, &mut unseen);
    let landmarks = landmarks::landmarks(scenario, &board, walks.node_count());
    if !landmarks.is_empty() {
        search.run(&Walks::new(&board, landmarks), &mut unseen);
    }
    let lengths = unseen.least.iter().zip(0_u32..).map(|(least, length)| {
        let share = (budget - f64::from(length)).clamp(0.0, 1.0);
        let not_found: f64 = least.iter().map(|&unseen| law.is_object_among(unseen, glance)).sum();
        share * not_found / (least.len() as f64)
    });
    Ok(lengths.sum::<f64>() / units)
}

/// Robots of several classes, and those that fly, would need a board of their own.
fn check_robots(scenario: &Scenario) -> Result<(), NoBound> {
    scenario.only_class().filter(|class| !class.flies).map(|_| ()).ok_or(NoBound::UnlikeRobots)
}

impl Law {
    fn of(scenario: &Scenario) -> Result<Self, NoBound> {
        if scenario.object_weights().is_some() {
            return Err(NoBound::UnlikeCells);
        }
        match scenario.objects() {
            Objects::Density(density) => Ok(Self::Independent(*density)),
            Objects::Count(objects) => {
                let searched = scenario.terrain().searched_cells().count();
                Ok(Self::Number { objects: *objects, searched: u32::try_from(searched).unwrap_or(u32::MAX) })
            }
            Objects::Cells(_) => Err(NoBound::KnownObjects),
        }
    }

    fn is_empty(self) -> f64 {
        match self {
            Self::Independent(density) => 1.0 - density,
            Self::Number { objects, searched } => 1.0 - f64::from(objects) / f64::from(searched.max(1)),
        }
    }

    /// The least probability that something is left to be found when so much is unseen, [`UNIT`]s. Where all looks are
    /// alike targets are counted, and count in whole.
    fn is_object_among(self, unseen: i32, glance: i32) -> f64 {
        let units = f64::from(unseen.max(0)) / f64::from(UNIT);
        let targets = if glance < UNIT { units } else { units.ceil() };
        match self {
            Self::Independent(density) => 1.0 - libm::pow(1.0 - density, targets),
            Self::Number { objects, searched } => {
                let (objects, searched) = (f64::from(objects), f64::from(searched));
                // C(M - u, n) / C(M, n), as a product over the unseen.
                let mut is_none = 1.0;
                let mut drawn = 0.0;
                while drawn < targets {
                    is_none *= ((searched - objects - drawn) / (searched - drawn)).max(0.0);
                    drawn += 1.0;
                }
                1.0 - is_none
            }
        }
    }
}

/// What a glance earns of a price, [`UNIT`]s, rounded up.
fn glance_units(scenario: &Scenario, law: Law) -> i32 {
    let sensor = scenario.widest_sensor();
    let Law::Independent(density) = law else { return UNIT };
    if sensor.noise() != Noise::Gaussian || scenario.connectivity() != Connectivity::Four {
        return UNIT;
    }
    let threshold = scenario.mission().detection_threshold;
    let prior = highest_log_odds(scenario.terrain(), scenario.prior(), threshold);
    let needed = libm::log(threshold / (1.0 - threshold)) - prior - ROUNDING_NATS;
    let precision = 1.0 / f64::from(sensor.variance(sensor.radius()));
    let share = glance_share(density, precision, needed);
    #[expect(clippy::cast_possible_truncation, reason = "at most one unit")]
    let units = (share * f64::from(UNIT)).ceil() as i32;
    units.min(UNIT)
}

/// More than the quantization of evidence changes the log-odds of a reading, nats.
const ROUNDING_NATS: f64 = 0.01;

/// The highest log-odds (nats) of a cell that the prior alone does not call found: it is found soonest.
fn highest_log_odds(terrain: &Terrain, prior: &Belief, threshold: f64) -> f64 {
    let is_target = |cell: &Cell| !prior.is_found(*cell, threshold);
    let log_odds = terrain.searched_cells().filter(is_target).map(|cell| prior.log_odds_nats(cell));
    log_odds.fold(f64::NEG_INFINITY, f64::max)
}

/// The least share of the price that a glance of this precision may earn: the least `k` with `h >= (1 - k) ln(1 / q)`, where
/// `h` is the mean of `min(p', 1 - q^k)` over glances that raise the log-odds by less than `needed` (nats). `h` rises
/// with `k`, so that it is found by bisection, from above.
fn glance_share(density: f64, precision: f64, needed: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        let is_enough =
            left_by_a_glance(density, precision, needed, middle) >= (1.0 - middle) * -libm::log1p(-density);
        *(if is_enough { &mut high } else { &mut low }) = middle;
    }
    high
}

/// `h` of `glance_share`. A reading adds `N(k/2, k)` to the log-odds of a cell with an object, and `N(-k/2, k)` to those of an
/// empty one.
fn left_by_a_glance(density: f64, precision: f64, needed: f64, share: f64) -> f64 {
    let limit = 1.0 - libm::pow(1.0 - density, share);
    // From these log-odds on `p'` is above the limit.
    let above = libm::log(limit / (1.0 - limit)) - libm::log(density / (1.0 - density));
    let is_below = |nats: f64, mean: f64| 0.5 * libm::erfc((mean - nats) / libm::sqrt(2.0 * precision));
    let (object, empty) = (precision / 2.0, -precision / 2.0);
    let between = |mean: f64| (is_below(needed, mean) - is_below(above, mean)).max(0.0);
    density * is_below(above.min(needed), object)
        + limit * (density * between(object) + (1.0 - density) * between(empty))
}

#[cfg(test)]
mod tests;
