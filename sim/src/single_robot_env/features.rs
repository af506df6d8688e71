//! What a learner observes: features of every cell, each a number from 0 to 1 in 32 bits, written once in full and then
//! where something changed.
//!
//! They are [`Feature`]s of a [`View`], the part of a search that a robot knows, in the order and frame of a [`Layout`].

use std::f32::consts::LN_2;

use dragnet_search::belief::{Belief, entropy_nats};
use dragnet_search::cell::{Cell, Grid};

use super::Field;

/// A feature of a cell, `0..=1` unless it says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Probability of an object; 0 where nothing is searched.
    Probability,
    /// Entropy of that, bits.
    Entropy,
    /// How precisely the cell was read: `s / (s + r)`, where `s` is the precision of its readings and `r` that of one reading
    /// from the sensor's radius. 0 before the first reading, 1/2 after one from there.
    Observed,
    /// 1 where a robot can be, else 0.
    Traversable,
    /// 1 where an object can be, else 0.
    Searched,
    /// Length `d` of the shortest path from the robot, as `d / (d + h)`, where `h` is half of the sum of the map's rows and
    /// columns; 1 out of reach.
    Distance,
    /// 1 in the robot's cell, else 0.
    Robot,
    /// Share of the budget that is left, the same in every cell.
    Budget,
    /// 1 where a teammate was last known to be, else 0.
    Teammates,
    /// Row, as a share of the longer side of the map; in [`Frame::Robot`] from the robot's, `-1..=1`.
    Row,
    /// Column, likewise.
    Column,
}

impl Feature {
    /// Those of cells.
    const OF_CELLS: [Self; 6] =
        [Self::Probability, Self::Entropy, Self::Observed, Self::Traversable, Self::Searched, Self::Distance];

    /// Its name in observations.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Probability => "probability",
            Self::Entropy => "entropy",
            Self::Observed => "observed",
            Self::Traversable => "traversable",
            Self::Searched => "searched",
            Self::Distance => "distance",
            Self::Robot => "robot",
            Self::Budget => "budget",
            Self::Teammates => "teammates",
            Self::Row => "row",
            Self::Column => "column",
        }
    }

    /// The value beyond the edge of the map; the budget is the same everywhere.
    const fn beyond(self, budget: f32) -> f32 {
        match self {
            Self::Distance => 1.0,
            Self::Budget => budget,
            _ => 0.0,
        }
    }
}

/// The order of numbers in an observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Shape `[features, rows, columns]`, as convolutions read it.
    Planes,
    /// The same, without [`Feature::Robot`] and [`Feature::Budget`], which are named apart from cells.
    Named,
    /// Shape `[cells, features]`, as graph networks read it; with [`Feature::Row`] and [`Feature::Column`].
    Nodes,
}

/// Where the origin of an observation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// In the map's south-western corner.
    Map,
    /// In the robot's cell: nothing says where on the map it is but what it sees of the map. Planes have `2 rows - 1` rows and
    /// `2 columns - 1` columns, the robot's in the middle.
    Robot,
}

/// Whether an observation has teammates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Company {
    /// A robot without a team.
    Alone,
    /// A robot of a team.
    Team,
}

/// Order, frame and features of an observation.
#[derive(Clone, Debug)]
pub struct Layout {
    order: Order,
    frame: Frame,
    features: Vec<Feature>,
    grid: Grid,
}

/// What a robot knows of a search.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Its belief.
    pub belief: &'a Belief,
    /// Its cell.
    pub robot: Cell,
    /// Share of its budget that is left, `0..=1`.
    pub budget: f32,
    /// Where it last knew its teammates to be.
    pub teammates: &'a [Cell],
}

impl Layout {
    /// A layout for a map.
    #[must_use]
    pub fn new(order: Order, frame: Frame, company: Company, grid: Grid) -> Self {
        let mut features = Feature::OF_CELLS.to_vec();
        if order != Order::Named {
            features.extend([Feature::Robot, Feature::Budget]);
        }
        if company == Company::Team {
            features.push(Feature::Teammates);
        }
        if order == Order::Nodes {
            features.extend([Feature::Row, Feature::Column]);
        }
        Self { order, frame, features, grid }
    }

    /// The layout of what a whole team knows: features of cells that are the same for all of its robots, as planes.
    #[must_use]
    pub fn of_team(grid: Grid) -> Self {
        let features = Feature::OF_CELLS.into_iter().filter(|&feature| feature != Feature::Distance);
        Self { order: Order::Named, frame: Frame::Map, features: features.collect(), grid }
    }

    /// The features, in their order.
    #[must_use]
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// Count of all numbers in the map's frame, in which they are drawn.
    #[must_use]
    pub fn drawn_len(&self) -> usize {
        self.features.len() * self.grid.cell_count()
    }

    /// Rows and columns of an observation.
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        let (rows, columns) = (self.grid.rows() as usize, self.grid.columns() as usize);
        if self.is_centered() { (2 * rows - 1, 2 * columns - 1) } else { (rows, columns) }
    }

    /// Count of all numbers of an observation.
    #[must_use]
    pub fn len(&self) -> usize {
        let (rows, columns) = self.shape();
        self.features.len() * rows * columns
    }

    /// Whether observations have no numbers: never, since maps have cells.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.features.is_empty()
    }

    /// Whether what is drawn in the map's frame is to be [centered](Self::center) on the robot.
    #[must_use]
    pub fn is_centered(&self) -> bool {
        self.order != Order::Nodes && self.frame == Frame::Robot
    }

    /// Writes all features in the map's frame: [`Self::drawn_len`] numbers.
    pub fn draw(&self, field: &Field, view: &View<'_>, numbers: &mut [f32]) {
        let terrain = field.scenario().terrain();
        let cells: Vec<Cell> = self.grid.cells().collect();
        let flag = |is: bool| if is { 1.0 } else { 0.0 };
        self.fill(Feature::Traversable, numbers, |index| flag(terrain.is_traversable(cells[index])));
        self.fill(Feature::Searched, numbers, |index| flag(terrain.is_searched(cells[index])));
        if self.frame == Frame::Map {
            self.draw_coordinates(view.robot, numbers);
        }
        if self.order != Order::Named {
            self.fill(Feature::Robot, numbers, |_| 0.0);
        }
        self.redraw(field, view, view.robot, &cells, numbers);
    }

    /// Writes what changes from step to step; of the belief only these cells. `before` is the robot's cell when it was
    /// written last.
    pub fn redraw(&self, field: &Field, view: &View<'_>, before: Cell, cells: &[Cell], numbers: &mut [f32]) {
        self.draw_belief(field, view.belief, cells, numbers);
        if self.features.contains(&Feature::Distance) {
            let shares = field.distance_shares(view.robot);
            if self.order == Order::Nodes {
                self.fill(Feature::Distance, numbers, |index| shares[index]);
            } else {
                numbers[self.start(Feature::Distance)..][..shares.len()].copy_from_slice(&shares);
            }
        }
        if self.order != Order::Named {
            numbers[self.place(Feature::Robot, before)] = 0.0;
            numbers[self.place(Feature::Robot, view.robot)] = 1.0;
            self.fill(Feature::Budget, numbers, |_| view.budget);
        }
        if self.features.contains(&Feature::Teammates) {
            self.fill(Feature::Teammates, numbers, |_| 0.0);
            for &teammate in view.teammates {
                numbers[self.place(Feature::Teammates, teammate)] = 1.0;
            }
        }
        if self.frame == Frame::Robot {
            self.draw_coordinates(view.robot, numbers);
        }
    }

    fn draw_belief(&self, field: &Field, belief: &Belief, cells: &[Cell], numbers: &mut [f32]) {
        let least = field.least_precision();
        let places = [Feature::Probability, Feature::Entropy, Feature::Observed].map(|it| self.start(it));
        let stride = self.stride();
        for &cell in cells {
            let (probability, entropy) = probability_and_entropy(belief.log_odds_nats(cell));
            let precision = belief.evidence().of(cell).precision as f64;
            #[expect(clippy::cast_possible_truncation, reason = "shares for networks")]
            let observed = (precision / (precision + least)) as f32;
            let at = cell.index() * stride;
            numbers[places[0] + at] = probability;
            numbers[places[1] + at] = entropy;
            numbers[places[2] + at] = observed;
        }
    }

    fn draw_coordinates(&self, robot: Cell, numbers: &mut [f32]) {
        if self.order != Order::Nodes {
            return;
        }
        let columns = self.grid.columns() as usize;
        let side = self.grid.rows().max(self.grid.columns()) as f32;
        let (row, column) = match self.frame {
            Frame::Map => (0, 0),
            Frame::Robot => (robot.index() / columns, robot.index() % columns),
        };
        let share = |at: usize, from: usize| (at as f32 - from as f32) / side;
        self.fill(Feature::Row, numbers, |index| share(index / columns, row));
        self.fill(Feature::Column, numbers, |index| share(index % columns, column));
    }

    /// Moves planes from the map's frame to the robot's.
    pub fn center(&self, view: &View<'_>, drawn: &[f32], numbers: &mut [f32]) {
        let (rows, columns) = (self.grid.rows() as usize, self.grid.columns() as usize);
        let (wide_rows, wide_columns) = self.shape();
        let robot = self.grid.position(view.robot);
        let (south, west) = (rows - 1 - robot.row as usize, columns - 1 - robot.column as usize);
        let planes = numbers.chunks_exact_mut(wide_rows * wide_columns);
        let of_map = drawn.chunks_exact(rows * columns);
        for ((feature, plane), drawn) in self.features.iter().zip(planes).zip(of_map) {
            plane.fill(feature.beyond(view.budget));
            for (row, drawn) in drawn.chunks_exact(columns).enumerate() {
                plane[(south + row) * wide_columns + west..][..columns].copy_from_slice(drawn);
            }
        }
    }

    fn fill(&self, feature: Feature, numbers: &mut [f32], value: impl Fn(usize) -> f32) {
        let (start, count) = (self.start(feature), self.grid.cell_count());
        match self.order {
            Order::Planes | Order::Named => {
                for (index, number) in numbers[start..][..count].iter_mut().enumerate() {
                    *number = value(index);
                }
            }
            Order::Nodes => {
                for (index, number) in numbers[start..].iter_mut().step_by(self.stride()).enumerate() {
                    *number = value(index);
                }
            }
        }
    }

    fn place(&self, feature: Feature, cell: Cell) -> usize {
        self.start(feature) + cell.index() * self.stride()
    }

    /// Place of a feature of the first cell.
    fn start(&self, feature: Feature) -> usize {
        let channel = self.features.iter().position(|&it| it == feature).unwrap_or(0);
        match self.order {
            Order::Planes | Order::Named => channel * self.grid.cell_count(),
            Order::Nodes => channel,
        }
    }

    /// From a feature of a cell to that of the next one.
    fn stride(&self) -> usize {
        match self.order {
            Order::Planes | Order::Named => 1,
            Order::Nodes => self.features.len(),
        }
    }
}

/// Beyond these log-odds a cell is shown as certain.
const CERTAIN_NATS: f64 = 40.0;

/// Probability, and entropy in bits, of log-odds (nats), to 1e-6, with one exponential for both.
#[expect(clippy::cast_possible_truncation, reason = "shares for networks")]
fn probability_and_entropy(log_odds_nats: f64) -> (f32, f32) {
    let magnitude = log_odds_nats.abs();
    // Certain to 1e-17, as most cells are soon: without exponential.
    if magnitude > CERTAIN_NATS {
        return (if log_odds_nats > 0.0 { 1.0 } else { 0.0 }, 0.0);
    }
    let magnitude = magnitude as f32;
    let odds = (-magnitude).exp();
    let (less, more) = (odds / (1.0 + odds), 1.0 / (1.0 + odds));
    let bits = (odds.ln_1p() + magnitude * less) / LN_2;
    debug_assert!((f64::from(bits) - entropy_nats(log_odds_nats) / f64::from(LN_2)).abs() < 1e-6);
    (if log_odds_nats > 0.0 { more } else { less }, bits.min(1.0))
}

#[cfg(test)]
mod tests;
