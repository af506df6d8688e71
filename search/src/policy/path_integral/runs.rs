//! Straight runs of a tree of shortest paths: candidates whose last observation needs no traversal to be scored.
//!
//! A robot that has driven straight on for two radii leaves the same precision behind wherever it does so, provided that
//! no earlier part of its path came as near: each cell of the footprint has been observed from the cells behind, as
//! often as its place in the footprint says. [`super::stencil`] scores these observations, many at once. A cell from which walls
//! hide something ends a run.

use crate::cell::{Cell, Grid, Offset, Position};
use crate::route::{Connectivity, ShortestPathTree};
use crate::situation::Situation;

/// Sensors that see farther take more memory than this saves time: `(radius + 1)^2 (2 radius + 1)` numbers a column.
const WIDEST_RADIUS: u8 = 8;

/// The moves of which a straight run repeats one: south, west, east, north.
pub(super) const MOVES: &[Offset] = Connectivity::Four.offsets();

/// What is to be done with each cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// It is no candidate.
    None,
    /// The traversal scores it: it is not on a straight run, or something beyond it is not.
    Walked,
    /// On a straight run of this one of [`MOVES`], with all that is beyond it.
    Straight(u8),
}

/// How a path has come to a cell.
#[derive(Clone, Copy, Default)]
struct Trail {
    position: (u32, u32),
    /// Index of the last move in [`MOVES`]; none in the root.
    step: Option<u8>,
    /// Cells of the path right behind, in a line, at most two radii.
    run: u8,
    /// Index of its segment.
    segment: u32,
}

/// A part of a path that moves never away from where it began: its cells are as far from each other, in Manhattan
/// distance, as the path between them is long.
struct Segment {
    start: (u32, u32),
    /// A rectangle around the path before: its least and greatest position.
    before: Option<[(u32, u32); 2]>,
}

impl Segment {
    /// Whether all of the path before is farther away than this.
    fn is_behind(&self, at: (u32, u32), distance: u32) -> bool {
        self.before.is_none_or(|[least, greatest]| {
            let outside = |at: u32, least: u32, greatest: u32| {
                least.saturating_sub(at).max(at.saturating_sub(greatest))
            };
            outside(at.0, least.0, greatest.0) + outside(at.1, least.1, greatest.1) > distance
        })
    }

    /// The segment that begins in a cell of this one.
    fn bend(&self, at: (u32, u32)) -> Self {
        let mut around = self.before.unwrap_or([self.start; 2]);
        for (row, column) in [self.start, at] {
            around[0] = (around[0].0.min(row), around[0].1.min(column));
            around[1] = (around[1].0.max(row), around[1].1.max(column));
        }
        Self { start: at, before: Some(around) }
    }
}

/// What is to be done with each cell, shape `[cells]`.
pub(super) fn kinds(situation: &Situation<'_>, routes: &ShortestPathTree) -> Vec<Kind> {
    let grid = situation.terrain.grid();
    let reach = match u8::try_from(situation.sensor.radius()) {
        Ok(radius @ ..=WIDEST_RADIUS) if situation.connectivity == Connectivity::Four => 2 * radius,
        _ => return walked(routes, grid.cell_count()),
    };
    let mut kinds = vec![Kind::None; grid.cell_count()];
    let mut trails = vec![Trail::default(); grid.cell_count()];
    let Position { row, column } = grid.position(routes.root());
    trails[routes.root().index()].position = (row, column);
    let mut segments = vec![Segment { start: (row, column), before: None }];
    for &cell in routes.candidates() {
        let parent = trails[routes.parent(cell).index()];
        let mut trail = follow(parent, step(grid, routes.parent(cell), cell), reach, &mut segments);
        let is_limited = situation.terrain.line_of_sight().shadows(cell).is_some();
        if is_limited {
            trail.run = 0;
        }
        let is_clear = !is_limited
            && trail.run == reach
            && segments[trail.segment as usize].is_behind(trail.position, reach.into());
        kinds[cell.index()] = match trail.step {
            Some(step) if is_clear => Kind::Straight(step),
            _ => Kind::Walked,
        };
        trails[cell.index()] = trail;
    }
    for &cell in routes.candidates().iter().rev() {
        let parent = routes.parent(cell);
        if kinds[cell.index()] == Kind::Walked && parent != routes.root() {
            kinds[parent.index()] = Kind::Walked;
        }
    }
    kinds
}

/// All candidates are walked.
pub(super) fn walked(routes: &ShortestPathTree, cell_count: usize) -> Vec<Kind> {
    let mut kinds = vec![Kind::None; cell_count];
    for cell in routes.candidates() {
        kinds[cell.index()] = Kind::Walked;
    }
    kinds
}

/// Index in [`MOVES`] of the move between neighbors.
fn step(grid: Grid, from: Cell, to: Cell) -> u8 {
    let (from, to) = (from.number(), to.number());
    match to.wrapping_sub(from) {
        ahead if ahead == grid.columns() => 3,
        1 => 2,
        u32::MAX if grid.columns() > 1 => 1,
        _ => 0,
    }
}

/// The trail one move on; it may begin a segment.
fn follow(parent: Trail, step: u8, longest: u8, segments: &mut Vec<Segment>) -> Trail {
    let Offset { north, east } = MOVES[usize::from(step)];
    let (row, column) = parent.position;
    let position = (row.wrapping_add_signed(north), column.wrapping_add_signed(east));
    let start = segments[parent.segment as usize].start;
    let distance = |(row, column): (u32, u32)| row.abs_diff(start.0) + column.abs_diff(start.1);
    let mut segment = parent.segment;
    if distance(position) < distance(parent.position) {
        let bend = segments[segment as usize].bend(parent.position);
        segment = u32::try_from(segments.len()).unwrap_or(u32::MAX);
        segments.push(bend);
    }
    let run = match parent.step {
        // The robot's own cell is no part of the path.
        None => 0,
        Some(last) if last == step => (parent.run + 1).min(longest),
        Some(_) => 1,
    };
    Trail { position, step: Some(step), run, segment }
}
