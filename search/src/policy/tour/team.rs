//! Tours of a team: what teammates will have observed, and when; and how first tours divide the map.
//!
//! A robot plans under the tours that its teammates have published. What they are to observe counts from when they
//! observe it, so a cell is worth a visit if no teammate comes by, or only much later, and the cost of a tour is what
//! the whole team's search is expected to take. Robots decide at different times, each under the last tours of the
//! others: this is coordinate descent on that cost. The tour of a teammate that is lost is not counted any more, and
//! what it would have seen is found among what is left.
//!
//! First tours divide the map, also between robots that start in one cell and have not heard each other. Lanes over the
//! whole map are cut into pieces, one for each robot, and the robot improves all pieces in turn, each under the others.
//! It takes its own. Where it knows a teammate's plan, that stands in the place of the teammate's piece.

use super::anneal;
use super::ground::{Ground, PER_CELL, Seen};
use super::lanes;
use super::planner::{Leg, PlannedObservation, Planner};
use crate::intent::TeammatePlan;
use crate::seed::Stream;
use crate::situation::Situation;

/// How often each piece is improved under the others. It gets as many evaluations in all as a decision has, in teams of
/// more than [`FEW`] robots fewer.
const ROUNDS: u32 = 4;
const FEW: u32 = 8;
/// The temperature that pieces are annealed from, cells.
const TEMPERATURE: f64 = 0.3;

/// What teammates are to observe by their plans.
pub(super) fn planned(ground: &Ground, situation: &Situation<'_>) -> Vec<PlannedObservation> {
    let plans = situation.planned_precision.plans();
    plans.iter().flat_map(|plan| of_plan(ground, situation, plan)).collect()
}

/// A robot's tour, as another robot knows or assumes it.
struct Part {
    /// Where the robot is.
    at: u16,
    tour: Vec<Leg>,
    /// What it is to observe.
    observed: Vec<PlannedObservation>,
    is_known: bool,
}

/// The robot's first tour, and what its teammates observe while it drives it.
pub(super) fn first_tour(
    planner: &Planner<'_>,
    situation: &Situation<'_>,
    evaluations: u32,
    random: &mut Stream,
) -> (Vec<Leg>, Vec<PlannedObservation>) {
    let own = usize::from(situation.place.member);
    let mut parts = parts(planner, situation);
    let team = parts.len();
    let evaluations = evaluations.saturating_mul(FEW) / (ROUNDS * u32::from(situation.place.team).max(FEW));
    for _ in 0..ROUNDS {
        // The robot's own part is the last of each round.
        for member in (1..=team).map(|index| (own + index) % team) {
            if parts[member].is_known {
                continue;
            }
            let planner = planner.beside(parts[member].at, planned_by_others(&parts, member));
            let tour = std::mem::take(&mut parts[member].tour);
            let (tour, _) = anneal::anneal(&planner, tour, evaluations, TEMPERATURE, random);
            parts[member].observed = of_tour(&planner, &tour);
            parts[member].tour = tour;
        }
    }
    let by_teammates = planned_by_others(&parts, own);
    (std::mem::take(&mut parts[own].tour), by_teammates)
}

fn planned_by_others(parts: &[Part], member: usize) -> Vec<PlannedObservation> {
    let others = parts.iter().enumerate().filter(|&(other, _)| other != member);
    others.flat_map(|(_, part)| part.observed.iter().copied()).collect()
}

/// All robots' parts: the plans that are known, and pieces of the lanes.
fn parts(planner: &Planner<'_>, situation: &Situation<'_>) -> Vec<Part> {
    let ground = planner.ground;
    let piece = |tour: Vec<Leg>| {
        let observed = of_tour(planner, &tour);
        Part { at: planner.root.at, tour, observed, is_known: false }
    };
    let mut parts: Vec<Part> =
        pieces(planner, usize::from(situation.place.team)).into_iter().map(piece).collect();
    for plan in situation.planned_precision.plans() {
        let part = plan.member.filter(|&member| member != situation.place.member);
        let Some(part) = part.and_then(|member| parts.get_mut(usize::from(member))) else { continue };
        *part = Part {
            at: part.at,
            tour: Vec::new(),
            observed: of_plan(ground, situation, plan),
            is_known: true,
        };
    }
    parts
}

/// What a plan observes. Its robot is as far on it as it would be at its usual speed: it may not have been heard since.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
fn of_plan(ground: &Ground, situation: &Situation<'_>, plan: &TeammatePlan) -> Vec<PlannedObservation> {
    let clamped = |fifths: f64| fifths.clamp(0.0, f64::from(u32::MAX)) as u32;
    let driven = clamped(plan.driven_cells * f64::from(PER_CELL));
    let grid = situation.terrain.grid();
    let (mut time, mut before) = (0_u32, plan.cell);
    let steps = plan.path.iter().map(|&cell| {
        let offset = before.replace(cell).map(|before| grid.offset(before, cell));
        time += Ground::move_length(offset);
        (cell, clamped(f64::from(time.saturating_sub(driven)) / plan.pace))
    });
    ground.planned(&Seen::by(&plan.sensor, &plan.line_of_sight), plan.pace, steps)
}

/// What a tour observes from where the planner starts.
fn of_tour(planner: &Planner<'_>, tour: &[Leg]) -> Vec<PlannedObservation> {
    let (mut at, mut time) = (planner.root.at, 0);
    let mut steps = Vec::new();
    for leg in tour {
        while at != leg.to {
            let step = planner.ground.step(leg.bend, at, leg.to);
            (at, time) = (step.to, time + u32::from(step.length));
            steps.push((planner.ground.cell(at), time));
        }
    }
    planner.ground.planned(planner.ground.seen(), 1.0, steps.into_iter())
}

/// Lanes over what is left, cut into a piece for each robot. Of several patterns the one whose pieces together cost
/// least.
fn pieces(planner: &Planner<'_>, team: usize) -> Vec<Vec<Leg>> {
    let patterns = lanes::lanes(planner).into_iter().filter_map(|tour| {
        let mut pieces = Lanes::new(planner, &tour)?.pieces(team)?;
        pieces.resize(team, Vec::new());
        let observed = pieces.iter().flat_map(|piece| of_tour(planner, piece)).collect();
        Some((planner.beside(planner.root.at, observed).cost(&[]), pieces))
    });
    let best = patterns.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(|| vec![Vec::new(); team], |(_, pieces)| pieces)
}

/// A pattern of lanes, without the way to it.
struct Lanes<'a> {
    ground: &'a Ground,
    start: u16,
    cells: Vec<u16>,
    /// Places in `cells` where legs end.
    ends: Vec<usize>,
}

impl<'a> Lanes<'a> {
    fn new(planner: &Planner<'a>, tour: &[Leg]) -> Option<Self> {
        let (cells, ends) = planner.cells(tour);
        let first = ends.first()?.saturating_sub(1);
        let ends = ends.iter().map(|end| end.saturating_sub(1 + first)).collect();
        let cells = cells.get(first..)?.to_vec();
        // A robot that stands at the only stop has no lane to drive.
        if cells.is_empty() {
            return None;
        }
        Some(Self { ground: planner.ground, start: planner.root.at, cells, ends })
    }

    /// From the start to a cell, fifths of a cell.
    fn way(&self, place: usize) -> u32 {
        u32::from(self.ground.length(self.cells[place], self.start))
    }

    /// Way to a piece and along it, fifths of a cell.
    fn length(&self, from: usize, to: usize) -> u32 {
        let along = u32::try_from(to - from).unwrap_or(u32::MAX).saturating_mul(PER_CELL);
        self.way(from).min(self.way(to - 1)).saturating_add(along)
    }

    /// The ends of pieces none of which is longer, if the robots suffice.
    fn cut(&self, longest: u32, team: usize) -> Option<Vec<usize>> {
        let mut cuts = vec![0];
        while let Some(&from) = cuts.last().filter(|&&from| from < self.cells.len()) {
            if cuts.len() > team {
                return None;
            }
            cuts.push((from + 1..=self.cells.len()).rev().find(|&to| self.length(from, to) <= longest)?);
        }
        Some(cuts)
    }

    /// Pieces of which the longest is as short as possible, each driven from its nearer end.
    fn pieces(&self, team: usize) -> Option<Vec<Vec<Leg>>> {
        let (mut low, mut high) = (0, self.length(0, self.cells.len()).saturating_mul(2));
        self.cut(high, team)?;
        while low + 1 < high {
            let middle = low.midpoint(high);
            *(if self.cut(middle, team).is_some() { &mut high } else { &mut low }) = middle;
        }
        let cuts = self.cut(high, team)?;
        Some(cuts.windows(2).map(|ends| self.piece(ends[0], ends[1])).collect())
    }

    fn piece(&self, from: usize, to: usize) -> Vec<Leg> {
        let mut stops = vec![from];
        stops.extend(self.ends.iter().copied().filter(|&end| from < end && end + 1 < to));
        stops.push(to - 1);
        if self.way(from) > self.way(to - 1) {
            stops.reverse();
        }
        let leg = |stop: usize| Leg { to: self.ground.waypoint(self.cells[stop]), bend: 0 };
        stops.into_iter().map(leg).collect()
    }
}
