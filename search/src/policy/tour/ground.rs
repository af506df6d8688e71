//! The part of a map that a tour is planned on: its cells, the sensor's footprint on them, and shortest paths between
//! them.

use std::cell::OnceCell;

use super::hidden;
use super::planner::PlannedObservation;
use crate::cell::{Cell, Offset};
use crate::line_of_sight::LineOfSight;
use crate::route::{Connectivity, ShortestPathTree};
use crate::sensor::Sensor;
use crate::situation::Situation;
use crate::terrain::Terrain;

/// No cell.
pub(super) const NOWHERE: u16 = u16::MAX;
/// The most cells that a tour is planned on: of larger maps, those nearest to the robot.
const MAX_CELLS: usize = 4096;
/// The most entries of all legs together, 4 bytes each; waypoints are thinned out to stay below it.
const MAX_LEG_ENTRIES: usize = 1 << 23;

/// Lengths are counted in fifths of a cell, and a diagonal counts seven of them, so that sums are exact.
const STRAIGHT: u16 = 5;
const DIAGONAL: u16 = 7;
pub(super) const PER_CELL: u32 = STRAIGHT as u32;
pub(super) const LENGTH_UNIT: f64 = 1.0 / STRAIGHT as f64;
const FAR: u16 = u16::MAX;
/// The longest path is shorter than this, so lengths never overflow.
const _: () = assert!(MAX_CELLS * (DIAGONAL as usize) + 64 < FAR as usize);

/// Straight moves first, north and south before east and west, then diagonals.
const MOVES: [Offset; 8] = [
    Offset { north: -1, east: 0 },
    Offset { north: 1, east: 0 },
    Offset { north: 0, east: -1 },
    Offset { north: 0, east: 1 },
    Offset { north: -1, east: -1 },
    Offset { north: -1, east: 1 },
    Offset { north: 1, east: -1 },
    Offset { north: 1, east: 1 },
];
/// Of several shortest paths, one takes the first possible move in this order: along columns, or along rows and
/// diagonals.
const PREFERENCES: [[u8; 8]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 2, 3, 0, 1]];

/// A move from one cell to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// The number of the cell entered.
    pub to: u16,
    /// Length, fifths of a cell.
    pub length: u16,
}

/// The observations of one row of the footprint.
struct FootprintRow {
    /// From the robot's place in the frame to the first cell of the row.
    offset: isize,
    /// Precision at each cell, in steps of the table of hidden mass.
    precision: Vec<u8>,
}

/// Paths from all cells to one.
struct Paths {
    /// Length, fifths of a cell.
    length: Vec<u16>,
    /// The move from each cell, by preference.
    moves: [Vec<u8>; 2],
}

/// The cells that a tour may enter. Cells have numbers, in order of their index; arrays over what the sensor sees have
/// the shape of a frame that leaves room for the footprint on all sides.
pub(super) struct Ground {
    terrain: Terrain,
    connectivity: Connectivity,
    /// Whether it is all that the robot can reach.
    is_whole: bool,
    /// Where the nearest cells were taken from.
    center: Cell,
    /// By number.
    cells: Vec<Cell>,
    /// Row and column in the frame, by number.
    places: Vec<(i32, i32)>,
    frame: Frame,
    /// By place in the frame.
    numbers: Vec<u16>,
    neighbors: Vec<[u16; 8]>,
    /// The nearest waypoint, by number.
    waypoint: Vec<u16>,
    spacing: i32,
    /// By footprint, with the whole one first: where walls hide something from a cell it has its own.
    footprints: Vec<Vec<FootprintRow>>,
    /// By number.
    footprint: Vec<u16>,
    seen: Seen,
    /// Whether a place of the frame can be seen from one of the cells.
    is_visible: Vec<bool>,
    paths: Vec<OnceCell<Paths>>,
    radius: u32,
    base: Option<Cell>,
    /// Length of the way to the base, fifths of a cell, by number; empty without a base.
    way_home: Vec<u32>,
}

/// What a sensor sees from a cell: offsets, and precision in steps of the table.
pub(super) struct Seen {
    cells: Vec<(Offset, u8)>,
    radius: u32,
    line_of_sight: LineOfSight,
}

impl Seen {
    /// By this sensor, but for what walls hide.
    pub(super) fn by(sensor: &Sensor, line_of_sight: &LineOfSight) -> Self {
        let cells = sensor.footprint().iter().map(|it| (it.offset, hidden::steps(it.precision)));
        Self { cells: cells.collect(), radius: sensor.radius(), line_of_sight: line_of_sight.clone() }
    }
}

/// A rectangle of the map with a margin of the sensor's radius.
#[derive(Clone, Copy)]
struct Frame {
    south: i32,
    west: i32,
    rows: i32,
    columns: i32,
}

impl Frame {
    fn around(terrain: &Terrain, cells: &[Cell], radius: u32) -> Self {
        let positions = || cells.iter().map(|&cell| terrain.grid().position(cell));
        let ends = |values: &mut dyn Iterator<Item = u32>| {
            values.fold((u32::MAX, 0), |(low, high), value| (low.min(value), high.max(value)))
        };
        let (south, north) = ends(&mut positions().map(|it| it.row));
        let (west, east) = ends(&mut positions().map(|it| it.column));
        let margin = radius.cast_signed();
        let side = |low: u32, high: u32| (high - low).cast_signed() + 1 + 2 * margin;
        let low = |value: u32| value.cast_signed() - margin;
        Self { south: low(south), west: low(west), rows: side(south, north), columns: side(west, east) }
    }

    const fn len(self) -> usize {
        self.rows.unsigned_abs() as usize * self.columns.unsigned_abs() as usize
    }

    fn place(self, terrain: &Terrain, cell: Cell) -> Option<(i32, i32)> {
        Some(self.relative(terrain, cell)).filter(|&(row, column)| self.holds(row, column))
    }

    fn relative(self, terrain: &Terrain, cell: Cell) -> (i32, i32) {
        let position = terrain.grid().position(cell);
        (position.row.cast_signed() - self.south, position.column.cast_signed() - self.west)
    }

    fn holds(self, row: i32, column: i32) -> bool {
        (0..self.rows).contains(&row) && (0..self.columns).contains(&column)
    }

    const fn index(self, row: i32, column: i32) -> usize {
        row.unsigned_abs() as usize * self.columns.unsigned_abs() as usize + column.unsigned_abs() as usize
    }
}

impl Ground {
    /// The cells nearest to the robot.
    pub(super) fn new(situation: &Situation<'_>) -> Self {
        let (terrain, radius) = (situation.terrain, situation.sensor.radius());
        let routes = ShortestPathTree::from(terrain, situation.connectivity, situation.robot);
        let reached = routes.reached();
        let mut cells = reached[..reached.len().min(MAX_CELLS)].to_vec();
        cells.sort_unstable();
        let frame = Frame::around(terrain, &cells, radius);
        let places: Vec<(i32, i32)> = cells.iter().filter_map(|&cell| frame.place(terrain, cell)).collect();
        let mut numbers = vec![NOWHERE; frame.len()];
        for (number, &(row, column)) in (0..).zip(&places) {
            numbers[frame.index(row, column)] = number;
        }
        let mut ground = Self {
            terrain: terrain.clone(),
            connectivity: situation.connectivity,
            is_whole: cells.len() == reached.len(),
            center: situation.robot,
            neighbors: Vec::new(),
            waypoint: Vec::new(),
            spacing: 1,
            footprints: vec![footprint(situation.sensor, frame, |_| true)],
            footprint: vec![0; cells.len()],
            seen: Seen::by(situation.sensor, terrain.line_of_sight()),
            is_visible: vec![false; frame.len()],
            paths: (0..cells.len()).map(|_| OnceCell::new()).collect(),
            base: situation.ways_home.map(ShortestPathTree::root),
            way_home: way_home(situation, &cells),
            cells,
            places,
            frame,
            numbers,
            radius,
        };
        ground.neighbors = ground.cells.iter().map(|&cell| ground.neighbors_of(cell)).collect();
        ground.thin_out();
        ground.limit_footprints(situation.sensor);
        ground.is_visible = ground.visible();
        ground
    }

    /// Leaves out of the footprint of each cell what walls hide from it.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "at most one for each of `MAX_CELLS`, and the whole one"
    )]
    fn limit_footprints(&mut self, sensor: &Sensor) {
        self.footprints.truncate(1);
        for (&cell, own) in self.cells.iter().zip(&mut self.footprint) {
            *own = 0;
            let Some(shadows) = self.terrain.line_of_sight().shadows(cell) else { continue };
            *own = self.footprints.len() as u16;
            self.footprints.push(footprint(sensor, self.frame, |offset| !shadows.hide(offset)));
        }
    }

    /// The ground of a situation, and whether it is new: the one that is kept, if it serves, or else a new one, which is
    /// kept.
    pub(super) fn kept_for<'g>(kept: &'g mut Option<Self>, situation: &Situation<'_>) -> (&'g Self, bool) {
        let known = kept.take().filter(|ground| ground.serves(situation));
        let is_new = known.is_none();
        let ground = kept.insert(known.unwrap_or_else(|| Self::new(situation)));
        ground.look_anew(situation);
        (ground, is_new)
    }

    /// Whether it still serves in this situation.
    fn serves(&self, situation: &Situation<'_>) -> bool {
        let is_near = || situation.terrain.grid().manhattan(self.center, situation.robot) <= 4 * self.radius;
        self.radius == situation.sensor.radius()
            && self.connectivity == situation.connectivity
            && self.base == situation.ways_home.map(ShortestPathTree::root)
            && self.number(situation.robot).is_some()
            && (self.is_whole || is_near())
            && self.terrain.is_equal_ground(situation.terrain)
    }

    /// Takes note of what else is hidden now; paths stay the same.
    fn look_anew(&mut self, situation: &Situation<'_>) {
        if self.terrain.line_of_sight() != situation.terrain.line_of_sight() {
            self.terrain = situation.terrain.clone();
            self.seen = Seen::by(situation.sensor, situation.terrain.line_of_sight());
            self.limit_footprints(situation.sensor);
            self.is_visible = self.visible();
        }
    }

    fn neighbors_of(&self, cell: Cell) -> [u16; 8] {
        let is_allowed = |offset: &Offset| self.connectivity.offsets().contains(offset);
        MOVES.map(|offset| {
            let to = Some(offset).filter(is_allowed);
            to.and_then(|offset| Connectivity::step(&self.terrain, cell, offset))
                .and_then(|cell| self.number(cell))
                .unwrap_or(NOWHERE)
        })
    }

    fn visible(&self) -> Vec<bool> {
        let mut is_visible = vec![false; self.frame_len()];
        for (start, row) in (0..self.count()).flat_map(|from| self.observation(from)) {
            for (is_visible, &precision) in is_visible[start..].iter_mut().zip(row) {
                *is_visible |= precision > 0;
            }
        }
        is_visible
    }

    /// Chooses waypoints that are some cells apart, so that paths to all of them fit in memory.
    fn thin_out(&mut self) {
        let count = self.cells.len();
        while count * (count / (self.spacing * self.spacing).unsigned_abs() as usize) > MAX_LEG_ENTRIES {
            self.spacing += 1;
        }
        let reach = self.spacing - 1;
        let mut is_waypoint = vec![false; count];
        for number in 0..self.count() {
            let is_near = self.around(number, reach).any(|near| is_waypoint[near as usize]);
            is_waypoint[number as usize] = !is_near;
        }
        self.waypoint = (0..self.count())
            .map(|number| {
                let distance = |near: &u16| {
                    let ((a, b), (c, d)) = (self.places[number as usize], self.places[*near as usize]);
                    ((a - c).abs() + (b - d).abs(), *near)
                };
                self.around(number, reach).filter(|&near| is_waypoint[near as usize]).min_by_key(distance)
            })
            .map(|waypoint| waypoint.unwrap_or(0))
            .collect();
    }

    fn around(&self, number: u16, reach: i32) -> impl Iterator<Item = u16> + '_ {
        let (row, column) = self.places[number as usize];
        (-reach..=reach)
            .flat_map(move |north| (-reach..=reach).map(move |east| self.at(row + north, column + east)))
            .filter(|&near| near != NOWHERE)
    }

    /// Number of cells.
    #[expect(clippy::cast_possible_truncation, reason = "at most `MAX_CELLS`")]
    pub(super) fn count(&self) -> u16 {
        self.cells.len() as u16
    }

    /// Number of places in the frame.
    pub(super) const fn frame_len(&self) -> usize {
        self.frame.len()
    }

    /// Cells between waypoints.
    pub(super) const fn spacing(&self) -> i32 {
        self.spacing
    }

    /// An observation from a cell, by rows of the footprint: the first place of the frame, and the precision at it and
    /// at those that follow.
    #[inline]
    pub(super) fn observation(&self, from: u16) -> impl Iterator<Item = (usize, &[u8])> {
        let rows = &self.footprints[usize::from(self.footprint[usize::from(from)])];
        let from = self.framed(from);
        rows.iter().map(move |row| (from.wrapping_add_signed(row.offset), row.precision.as_slice()))
    }

    /// What a robot observes that is in these cells at these times, fifths of a cell, and sees this. All observations of a cell while the robot passes by count together, at the time of the best of them. Its
    /// pace is how many cells it passes in five fifths.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    pub(super) fn planned(
        &self,
        seen: &Seen,
        pace: f64,
        steps: impl Iterator<Item = (Cell, u32)>,
    ) -> Vec<PlannedObservation> {
        let passing = f64::from(2 * u32::from(DIAGONAL) * (seen.radius + 1)) / pace;
        let passing = passing.min(f64::from(u32::MAX)) as u32;
        // By place: what is planned for it last, and the precision of the best observation.
        let mut last: Vec<Option<(PlannedObservation, u8)>> = vec![None; self.frame_len()];
        let mut planned = Vec::new();
        for (cell, time) in steps {
            let (row, column) = self.frame.relative(&self.terrain, cell);
            let shadows = seen.line_of_sight.shadows(cell);
            for &(offset, precision) in &seen.cells {
                let (row, column) = (row + offset.north, column + offset.east);
                let is_hidden = shadows.is_some_and(|shadows| shadows.hide(offset));
                if precision == 0 || is_hidden || !self.frame.holds(row, column) {
                    continue;
                }
                let at = self.frame.index(row, column);
                match &mut last[at] {
                    Some((before, best)) if time <= before.time.saturating_add(passing) => {
                        before.precision = before.precision.saturating_add(precision);
                        if precision > *best {
                            (before.time, *best) = (time, precision);
                        }
                    }
                    slot => {
                        planned.extend(slot.map(|(before, _)| before));
                        *slot = Some((PlannedObservation { time, place: at, precision }, precision));
                    }
                }
            }
        }
        planned.extend(last.into_iter().flatten().map(|(observation, _)| observation));
        planned
    }

    /// What the robot itself sees.
    pub(super) const fn seen(&self) -> &Seen {
        &self.seen
    }

    /// Length of a move, fifths of a cell; of one from an unknown cell, that of a straight one.
    pub(super) fn move_length(offset: Option<Offset>) -> u32 {
        let is_diagonal = offset.is_some_and(|offset| offset.north != 0 && offset.east != 0);
        u32::from(if is_diagonal { DIAGONAL } else { STRAIGHT })
    }

    /// The sensor's radius, cells.
    pub(super) const fn radius(&self) -> u32 {
        self.radius
    }

    /// The cell of a number.
    pub(super) fn cell(&self, number: u16) -> Cell {
        self.cells[number as usize]
    }

    /// The number of a cell.
    pub(super) fn number(&self, cell: Cell) -> Option<u16> {
        let (row, column) = self.frame.place(&self.terrain, cell)?;
        Some(self.numbers[self.frame.index(row, column)]).filter(|&number| number != NOWHERE)
    }

    /// The number at a row and column of the frame, or [`NOWHERE`].
    pub(super) fn at(&self, row: i32, column: i32) -> u16 {
        if self.frame.holds(row, column) { self.numbers[self.frame.index(row, column)] } else { NOWHERE }
    }

    /// Row and column of a number in the frame.
    pub(super) fn place(&self, number: u16) -> (i32, i32) {
        self.places[number as usize]
    }

    /// The waypoint next to the cell at a row and column, if there is such a cell.
    pub(super) fn waypoint_at(&self, row: i32, column: i32) -> Option<u16> {
        Some(self.at(row, column)).filter(|&number| number != NOWHERE).map(|number| self.waypoint(number))
    }

    /// The waypoint nearest to a cell.
    pub(super) fn waypoint(&self, number: u16) -> u16 {
        self.waypoint[number as usize]
    }

    /// Place in the frame of a number.
    #[inline]
    pub(super) fn framed(&self, number: u16) -> usize {
        let (row, column) = self.places[number as usize];
        self.frame.index(row, column)
    }

    /// Place in the frame of any cell of the map, if it can be seen from the ground.
    pub(super) fn framed_visible(&self, cell: Cell) -> Option<usize> {
        let (row, column) = self.frame.place(&self.terrain, cell)?;
        Some(self.frame.index(row, column)).filter(|&place| self.is_visible[place])
    }

    /// Length of the path between two cells, fifths of a cell. `to` must be a waypoint, or paths to it take memory.
    pub(super) fn length(&self, from: u16, to: u16) -> u16 {
        self.paths(to).length[from as usize]
    }

    /// Length of the way from a cell to the base, fifths of a cell; 0 for a robot without one.
    #[inline]
    pub(super) fn way_home(&self, from: u16) -> u32 {
        self.way_home.get(from as usize).copied().unwrap_or(0)
    }

    /// The next step on the path to another cell.
    #[inline]
    pub(super) fn step(&self, bend: u8, from: u16, to: u16) -> Step {
        let taken = self.paths(to).moves[usize::from(bend)][from as usize];
        Step { to: self.neighbors[from as usize][usize::from(taken)], length: move_length(taken) }
    }

    #[inline]
    fn paths(&self, to: u16) -> &Paths {
        self.paths[to as usize].get_or_init(|| self.paths_to(to))
    }

    /// Dijkstra (1959) from the end, with the buckets of Dial (1969), and of each cell the first move that lies on a
    /// shortest path.
    fn paths_to(&self, to: u16) -> Paths {
        let mut length = vec![FAR; self.cells.len()];
        length[to as usize] = 0;
        let mut buckets: [Vec<u16>; DIAGONAL as usize + 1] = Default::default();
        buckets[0].push(to);
        let (mut so_far, mut empty) = (0_u16, 0);
        while empty < buckets.len() {
            let bucket = std::mem::take(&mut buckets[usize::from(so_far) % (usize::from(DIAGONAL) + 1)]);
            empty = if bucket.is_empty() { empty + 1 } else { 0 };
            for at in bucket {
                if length[at as usize] < so_far {
                    continue;
                }
                for (taken, &near) in (0..).zip(&self.neighbors[at as usize]) {
                    let longer = so_far + move_length(taken);
                    if near != NOWHERE && longer < length[near as usize] {
                        length[near as usize] = longer;
                        buckets[usize::from(longer) % (usize::from(DIAGONAL) + 1)].push(near);
                    }
                }
            }
            so_far += 1;
        }
        let moves = PREFERENCES.map(|preference| {
            let is_shortest = |from: usize, taken: u8| {
                let near = self.neighbors[from][usize::from(taken)];
                near != NOWHERE && length[near as usize].checked_add(move_length(taken)) == Some(length[from])
            };
            let first = |from| preference.into_iter().find(|&taken| is_shortest(from, taken)).unwrap_or(0);
            (0..self.cells.len()).map(first).collect()
        });
        Paths { length, moves }
    }
}

const fn move_length(taken: u8) -> u16 {
    if taken < 4 { STRAIGHT } else { DIAGONAL }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 0; casts saturate")]
fn way_home(situation: &Situation<'_>, cells: &[Cell]) -> Vec<u32> {
    let fifths = |length_cells: f32| (length_cells * PER_CELL as f32).ceil() as u32;
    situation
        .ways_home
        .map_or_else(Vec::new, |ways_home| cells.iter().map(|&cell| fifths(ways_home.length(cell))).collect())
}

/// The footprint of a sensor, with nothing where a cell is not seen.
fn footprint(sensor: &Sensor, frame: Frame, is_seen: impl Fn(Offset) -> bool) -> Vec<FootprintRow> {
    let rows = sensor.footprint().chunk_by(|a, b| a.offset.north == b.offset.north);
    rows.map(|row| {
        let first = row[0].offset;
        FootprintRow {
            offset: first.north as isize * frame.columns as isize + first.east as isize,
            precision: row
                .iter()
                .map(|it| if is_seen(it.offset) { hidden::steps(it.precision) } else { 0 })
                .collect(),
        }
    })
    .collect()
}
