//! Which cells the walls of the mission's map and of the vehicle's own hide from which, for its plans.
//!
//! Evidence follows from where the cameras were. A plan only knows the cells that the vehicle will be in, so it takes it to be
//! in the middle of each. A cell is hidden from there if all of its parts are. One that is seen in part, as it is when a wall
//! leads through it, is worth observing until these parts were: then it counts as hidden from there, and the vehicle has to go
//! to where it sees the rest. Once the cell may hold an object it is worth observing from anywhere again.

use std::collections::BTreeMap;

use dragnet_lattice::costmap::CostMap;
use dragnet_search::cell::{Cell, Grid, Offset};
use dragnet_search::line_of_sight::{LineOfSight, Walls, is_clear};
use dragnet_search::terrain::Terrain;
use nalgebra::Vector2;

use super::account::{ALL_PARTS, Accounts, NO_PART, Parts, pair, parts};

/// What is hidden by the walls that the vehicle knows of.
#[derive(Clone, Debug)]
pub(crate) struct Sight {
    radius: u32,
    /// The vehicle's own map.
    walls: Option<CostMap>,
    /// By the walls alone.
    behind_walls: LineOfSight,
    /// Of an observed cell and the one that it is observed from, the parts that are seen, where these are some and not all.
    in_part: BTreeMap<(Cell, Cell), Parts>,
    /// The parts of such cells that were observed.
    observed: BTreeMap<Cell, Parts>,
    /// By these walls, and what needs no other observation from there.
    hidden: LineOfSight,
}

/// A rectangle, meters: its south-western and its north-eastern corner.
#[derive(Clone, Copy)]
struct Area(Vector2<f64>, Vector2<f64>);

impl Area {
    fn around(points: impl IntoIterator<Item = Vector2<f64>>) -> Option<Self> {
        points.into_iter().map(|point| Self(point, point)).reduce(Self::with)
    }

    /// Around all cells within a radius from a cell, cells.
    fn in_sight(terrain: &Terrain, from: Cell, radius: u32) -> Self {
        let (east, north) = terrain.center_meters(from);
        let reach = Vector2::repeat((f64::from(radius) + 0.5) * terrain.cell_meters());
        let middle = Vector2::new(east, north);
        Self(middle - reach, middle + reach)
    }

    fn with(self, other: Self) -> Self {
        Self(self.0.inf(&other.0), self.1.sup(&other.1))
    }

    fn meets(self, other: Self) -> bool {
        self.0 <= other.1 && other.0 <= self.1
    }
}

impl Sight {
    /// By the mission's map alone, as far as a sensor of this radius sees, cells. On maps too large for it plans see through
    /// walls.
    pub(crate) fn new(terrain: &Terrain, radius: u32) -> Self {
        let line_of_sight = if LineOfSight::is_too_large(terrain.grid(), radius) {
            LineOfSight::everywhere()
        } else {
            LineOfSight::behind_walls(terrain, radius)
        };
        Self {
            radius,
            walls: None,
            behind_walls: line_of_sight.clone(),
            in_part: BTreeMap::new(),
            observed: BTreeMap::new(),
            hidden: line_of_sight,
        }
    }

    /// What is hidden, or needs no other observation from there.
    pub(crate) const fn line_of_sight(&self) -> &LineOfSight {
        &self.hidden
    }

    /// The vehicle's own map, if it has one.
    pub(crate) const fn walls(&self) -> Option<&CostMap> {
        self.walls.as_ref()
    }

    /// Takes a new map of the vehicle. Only from cells near squares that have become occupied or free it is looked anew.
    pub(crate) fn set_walls(&mut self, terrain: &Terrain, map: CostMap) {
        let changed = changed(self.walls.as_ref(), &map);
        if let Some(changed) = changed.filter(|_| !LineOfSight::is_too_large(terrain.grid(), self.radius)) {
            let grid = terrain.grid();
            let occupied = Walls::of(map.grid(), |square| map.is_lethal(square));
            let is_near = |from| Area::in_sight(terrain, from, self.radius).meets(changed);
            let mut in_part = std::mem::take(&mut self.in_part);
            in_part.retain(|&(_, from), _| !is_near(from));
            self.behind_walls = self.behind_walls.renewed(grid, self.radius, is_near, |from, offset| {
                let Some(cell) = grid.step(from, offset) else { return false };
                let lines = Lines::new(terrain, from, offset);
                if !is_clear(grid, from, offset, |cell| terrain.is_wall(cell)) {
                    return true;
                }
                let seen = if is_any_in(&occupied, &map, lines.area) { lines.seen(&map) } else { ALL_PARTS };
                if seen != NO_PART && seen != ALL_PARTS {
                    in_part.insert((cell, from), seen);
                }
                seen == NO_PART
            });
            self.in_part = in_part;
            self.hide_observed(grid);
        }
        self.walls = Some(map);
    }

    /// Takes note of the parts of cells that were observed so far.
    pub(crate) fn note(&mut self, grid: Grid, accounts: &Accounts) {
        let mut observed = BTreeMap::new();
        for &(cell, _) in self.in_part.keys() {
            observed.entry(cell).or_insert_with(|| accounts.observed_parts(cell));
        }
        if observed != self.observed {
            self.observed = observed;
            self.hide_observed(grid);
        }
    }

    fn hide_observed(&mut self, grid: Grid) {
        let is_known = |cell: Cell, seen: Parts| {
            self.observed.get(&cell).is_some_and(|observed| seen & !observed == NO_PART)
        };
        let known = self.in_part.iter().filter(|&(&(cell, _), &seen)| is_known(cell, seen));
        let known = known.map(|(&(cell, from), _)| (from, cell)).collect();
        let hidden = self.behind_walls.with_hidden(grid, self.radius, &known);
        // What is equal stays the same, which is sooner compared.
        if hidden != self.hidden {
            self.hidden = hidden;
        }
    }
}

/// The lines from the middle of a cell to the parts of another.
struct Lines {
    from: Vector2<f64>,
    middle: Vector2<f64>,
    cell_meters: f64,
    area: Area,
}

impl Lines {
    fn new(terrain: &Terrain, from: Cell, offset: Offset) -> Self {
        let (east, north) = terrain.center_meters(from);
        let (from, cell_meters) = (Vector2::new(east, north), terrain.cell_meters());
        let middle = from + cell_meters * Vector2::new(f64::from(offset.east), f64::from(offset.north));
        let corner = Vector2::repeat(cell_meters / 2.0);
        let area = Area(from, from).with(Area(middle - corner, middle + corner));
        Self { from, middle, cell_meters, area }
    }

    /// The parts that no square of the map hides.
    fn seen(&self, map: &CostMap) -> Parts {
        let parts = parts(self.middle, self.cell_meters).enumerate();
        let seen = parts.filter(|(_, part)| !map.hides(pair(self.from), pair(*part)));
        seen.fold(NO_PART, |seen, (index, _)| seen | 1 << index)
    }
}

/// A rectangle around the squares that are occupied on one of two maps and not on the other.
fn changed(before: Option<&CostMap>, map: &CostMap) -> Option<Area> {
    let center = |map: &CostMap, square| {
        let (x, y) = map.center_meters(square);
        Vector2::new(x, y)
    };
    let is_occupied =
        |map: &CostMap, at: Vector2<f64>| map.cell_at(at.x, at.y).is_some_and(|square| map.is_lethal(square));
    let is_like =
        |before: &&CostMap| before.resolution_meters().to_bits() == map.resolution_meters().to_bits();
    let occupied = |map: &CostMap| {
        let squares = map.grid().cells().filter(|&square| map.is_lethal(square));
        squares.map(|square| center(map, square)).collect::<Vec<_>>()
    };
    let own = occupied(map);
    let differing: Vec<Vector2<f64>> = match before.filter(is_like) {
        Some(before) => {
            let new = own.into_iter().filter(|&at| !is_occupied(before, at));
            let gone = occupied(before).into_iter().filter(|&at| !is_occupied(map, at));
            new.chain(gone).collect()
        }
        None => own.into_iter().chain(before.map(occupied).unwrap_or_default()).collect(),
    };
    let half = Vector2::repeat(map.resolution_meters() / 2.0);
    let Area(south_west, north_east) = Area::around(differing)?;
    Some(Area(south_west - half, north_east + half))
}

/// Whether a square of the map is occupied that lies in a rectangle, at least in part.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "held within the map")]
fn is_any_in(walls: &Walls, map: &CostMap, Area(south_west, north_east): Area) -> bool {
    let span = |ends: [f64; 2], origin_meters: f64, most: u32| {
        let [low, high] = ends.map(|meters| (meters - origin_meters) / map.resolution_meters());
        let low = low.floor().clamp(0.0, f64::from(most)) as usize;
        low..(high.ceil().clamp(0.0, f64::from(most)) as usize).max(low)
    };
    let (west_meters, south_meters) = map.origin_meters();
    let rows = span([south_west.y, north_east.y], south_meters, map.grid().rows());
    walls.is_any_in(rows, span([south_west.x, north_east.x], west_meters, map.grid().columns()))
}

#[cfg(test)]
mod tests {
    use dragnet_lattice::costmap::LETHAL;
    use dragnet_search::cell::Position;
    use proptest::prelude::*;

    use super::*;

    const RADIUS: u32 = 6;

    /// A map in squares of half a meter; these are occupied.
    fn map(side: u32, is_occupied: impl Fn(Position) -> bool) -> CostMap {
        let grid = Grid::new(side, side).unwrap();
        let cost = |square| if is_occupied(grid.position(square)) { LETHAL } else { 0 };
        CostMap::new(grid, 0.5, (0.0, 0.0), grid.cells().map(cost).collect()).unwrap()
    }

    /// What is seen from the middle of the western edge, as a drawing.
    fn seen(terrain: &Terrain, line_of_sight: &LineOfSight) -> String {
        let grid = terrain.grid();
        let from = grid.cell(Position { row: grid.rows() / 2, column: 0 }).unwrap();
        let mark = |row, column| {
            let to = grid.cell(Position { row, column }).unwrap();
            if line_of_sight.hides(from, grid.offset(from, to)) { 'x' } else { 'o' }
        };
        let line = |row| (0..grid.columns()).map(|column| mark(row, column)).collect::<String>();
        (0..grid.rows()).rev().map(line).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn a_wall_thinner_than_a_cell_hides_the_cells_behind_it_but_for_its_gaps() {
        // Cells of 2 m. The wall fills the western quarter of the third column, but for 1 m of the middle row.
        let terrain = Terrain::from_ascii(".....\n.....\n.....\n.....\n.....", 2.0).unwrap();
        let mut sight = Sight::new(&terrain, RADIUS);
        assert!(sight.line_of_sight().is_everywhere() && sight.walls().is_none());
        let wall = map(20, |Position { row, column }| column == 8 && !(9..11).contains(&row));
        sight.set_walls(&terrain, wall);
        assert_eq!(seen(&terrain, sight.line_of_sight()), "oooxx\noooxx\nooooo\noooxx\noooxx");
        let before = sight.line_of_sight().clone();
        sight.set_walls(&terrain, map(20, |Position { column, .. }| column == 8));
        assert_eq!(seen(&terrain, sight.line_of_sight()), "oooxx\noooxx\noooxx\noooxx\noooxx");
        assert_ne!(*sight.line_of_sight(), before);
        sight.set_walls(&terrain, map(20, |_| false));
        assert!(sight.line_of_sight().is_everywhere(), "the wall is gone");
    }

    #[test]
    fn walls_of_the_missions_map_hide_too() {
        let terrain = Terrain::from_ascii("...#.\n...#.\n...#.", 2.0).unwrap();
        let mut sight = Sight::new(&terrain, RADIUS);
        let expected = "oooox\noooox\noooox";
        assert_eq!(seen(&terrain, sight.line_of_sight()), expected);
        sight.set_walls(&terrain, map(10, |Position { row, column }| row == 0 && column == 0));
        assert_eq!(seen(&terrain, sight.line_of_sight()), expected);
    }

    proptest! {
        #[test]
        fn after_changes_of_the_map_it_is_as_if_computed_anew(
            maps in prop::collection::vec(prop::collection::btree_set(0_u32..400, 0..25), 1..4),
        ) {
            let terrain = Terrain::from_ascii("....\n.#..\n....\n....", 2.0).unwrap();
            let mut changing = Sight::new(&terrain, RADIUS);
            for occupied in maps {
                let map = map(20, |Position { row, column }| occupied.contains(&(20 * row + column)));
                let mut anew = Sight::new(&terrain, RADIUS);
                changing.set_walls(&terrain, map.clone());
                anew.set_walls(&terrain, map);
                prop_assert_eq!(changing.line_of_sight(), anew.line_of_sight());
            }
        }
    }
}
