//! Simulated annealing of a tour (Kirkpatrick, Gelatt and Vecchi, 1983).

use rand::RngExt;

use super::ground::Ground;
use super::planner::{Leg, Planner, Progress, WalkedTour};
use crate::seed::Stream;

/// The temperature at the end, cells.
const COLD: f64 = 0.03;
/// Evaluations between two coolings.
const COOLING: u32 = 16;

/// Improves a tour by this many evaluations from this temperature (cells) on; returns the best and its cost. A tour
/// that is too long counts as none.
pub(super) fn anneal(
    planner: &Planner<'_>,
    mut tour: Vec<Leg>,
    evaluations: u32,
    mut temperature: f64,
    random: &mut Stream,
) -> (Vec<Leg>, f64) {
    if planner.cost(&tour).is_infinite() {
        tour.clear();
    }
    let mut walked = WalkedTour::new(planner, &tour);
    let mut cost = walked.cost(planner, &tour);
    let mut best = (tour.clone(), cost);
    let mut trial: Vec<Leg> = Vec::new();
    let fall = libm::pow(COLD / temperature, f64::from(COOLING) / f64::from(evaluations.max(COOLING)));
    for evaluation in 1..=evaluations {
        if evaluation.is_multiple_of(COOLING) {
            temperature *= fall;
        }
        trial.clone_from(&tour);
        let change = Change {
            ground: planner.ground,
            root: planner.root.at,
            end: walked.end(),
            has_teammates: planner.has_teammates(),
        };
        let Some(first) = change.apply(&mut trial, random) else { continue };
        let most = tour.len().min(trial.len()) - first;
        let ends = trial.iter().rev().zip(tour.iter().rev()).take(most);
        let common = ends.take_while(|(a, b)| a == b).count();
        if trial.len() == tour.len() && first + common == tour.len() {
            continue;
        }
        let limit = cost - temperature * libm::log(random.random::<f64>().max(f64::MIN_POSITIVE));
        if walked.cost_of_changed(planner, (&tour, &trial), (first, common), limit) > limit {
            continue;
        }
        std::mem::swap(&mut tour, &mut trial);
        walked.walk(planner, &tour, first);
        cost = walked.cost(planner, &tour);
        if cost < best.1 - 1e-9 {
            best = (tour.clone(), cost);
        }
    }
    best
}

/// A random change of a tour.
struct Change<'a> {
    ground: &'a Ground,
    root: u16,
    /// The search at the end of the tour, and of teammates' tours.
    end: &'a Progress,
    has_teammates: bool,
}

impl Change<'_> {
    /// Changes the tour; returns the first leg that may differ.
    fn apply(&self, tour: &mut Vec<Leg>, random: &mut Stream) -> Option<usize> {
        let legs = tour.len();
        match if legs == 0 { 0 } else { below(100, random) } {
            kind @ 0..25 => Some(self.insert(tour, kind < 15, random)),
            kind @ 25..40 => {
                let first = below(legs, random);
                let count = if kind < 33 { 1 } else { 1 + below(3, random) };
                tour.drain(first..(first + count).min(legs));
                Some(first)
            }
            kind @ 40..70 => {
                let first = below(legs, random);
                let count = if kind < 58 { 1 } else { 1 + below(4, random) };
                self.shift(&mut tour[first..(first + count).min(legs)], random).then_some(first)
            }
            70..75 => {
                let first = below(legs, random);
                tour[first].bend ^= 1;
                Some(first)
            }
            75..85 => {
                let (a, b) = (below(legs, random), below(legs, random));
                tour[a.min(b)..=a.max(b)].reverse();
                (a != b).then_some(a.min(b))
            }
            kind @ 85..95 => Some(self.transfer(tour, kind < 90, random)),
            _ => {
                let first = below(legs, random);
                let to = self.near(tour[first].to, 5, random);
                tour[first] = Leg { to, bend: bend(random) };
                Some(first)
            }
        }
    }

    fn insert(&self, tour: &mut Vec<Leg>, is_cheapest: bool, random: &mut Stream) -> usize {
        let to = self.promising(random);
        let first = if is_cheapest { self.cheapest(tour, to) } else { below(tour.len() + 1, random) };
        tour.insert(first, Leg { to, bend: bend(random) });
        first
    }

    /// Shifts waypoints alike, often along one axis only.
    fn shift(&self, legs: &mut [Leg], random: &mut Stream) -> bool {
        let (mut north, mut east) = (self.around(2, random), self.around(2, random));
        match below(3, random) {
            0 => north = 0,
            1 => east = 0,
            _ => {}
        }
        let mut is_changed = false;
        for leg in legs {
            let (row, column) = self.ground.place(leg.to);
            if let Some(to) = self.ground.waypoint_at(row + north, column + east) {
                is_changed |= to != leg.to;
                leg.to = to;
            }
        }
        is_changed
    }

    /// Moves a piece, perhaps reversed.
    fn transfer(&self, tour: &mut Vec<Leg>, is_cheapest: bool, random: &mut Stream) -> usize {
        let from = below(tour.len(), random);
        let count = (1 + below(4, random)).min(tour.len() - from);
        let mut piece: Vec<Leg> = tour.drain(from..from + count).collect();
        if below(2, random) == 0 {
            piece.reverse();
        }
        let to = if is_cheapest { self.cheapest(tour, piece[0].to) } else { below(tour.len() + 1, random) };
        tour.splice(to..to, piece);
        from.min(to)
    }

    /// A waypoint, more likely where the tour leaves much.
    fn promising(&self, random: &mut Stream) -> u16 {
        let hidden = |number: u16| self.end.hidden[self.ground.framed(number)];
        // A part of the map is left only here and there: most draws would miss it.
        if self.has_teammates && below(2, random) == 0 {
            let mut share = random.random::<f64>() * self.end.left;
            let left = (0..self.ground.count()).find(|&number| {
                share -= f64::from(hidden(number));
                share < 0.0
            });
            if let Some(number) = left {
                return self.near(number, 3, random);
            }
        }
        let any = |random: &mut Stream| random.random_range(0..self.ground.count());
        let mut best = any(random);
        for _ in 0..below(12, random) {
            let other = any(random);
            if hidden(other) > hidden(best) {
                best = other;
            }
        }
        self.near(best, 4, random)
    }

    fn near(&self, number: u16, reach: i32, random: &mut Stream) -> u16 {
        let (row, column) = self.ground.place(number);
        let (row, column) = (row + self.around(reach, random), column + self.around(reach, random));
        self.ground.waypoint_at(row, column).unwrap_or_else(|| self.ground.waypoint(number))
    }

    /// From `-reach` to `reach`, in spacings of waypoints.
    fn around(&self, reach: i32, random: &mut Stream) -> i32 {
        random.random_range(-reach..=reach) * self.ground.spacing()
    }

    /// The leg before which a waypoint is the smallest detour.
    fn cheapest(&self, tour: &[Leg], to: u16) -> usize {
        let length = |from: u16, to: u16| i32::from(self.ground.length(from, to));
        let starts = std::iter::once(self.root).chain(tour.iter().map(|leg| leg.to));
        let detours = starts.enumerate().map(|(place, from)| {
            let after = tour.get(place).map_or(0, |leg| length(to, leg.to) - length(from, leg.to));
            (length(from, to) + after, place)
        });
        detours.min().map_or(0, |(_, place)| place)
    }
}

fn below(bound: usize, random: &mut Stream) -> usize {
    random.random_range(0..bound)
}

fn bend(random: &mut Stream) -> u8 {
    random.random_range(0..2)
}
