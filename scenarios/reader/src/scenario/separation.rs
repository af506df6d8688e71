//! How far apart robots keep, and that they find room to start.

use dragnet_search::cell::Cell;
use dragnet_search::route::{Connectivity, ShortestPathTree};
use dragnet_search::separation::Separation;
use dragnet_search::terrain::Terrain;

use super::check::{self, Invalid};
use super::robots::{Robot, Start};

const KEY: &str = "robots.separation_meters";
const MAX_METERS: f64 = 1e6;

/// The separation of a team, whose robots it moves apart where several start in one place.
pub(super) fn separation(
    meters: f64,
    robots: &mut [Robot],
    terrain: &Terrain,
) -> Result<Separation, Invalid> {
    check::at_least_zero(KEY, meters, MAX_METERS)?;
    let separation = Separation::of_meters(meters, terrain.cell_meters());
    if !separation.is_kept() {
        return Ok(separation);
    }
    let above = terrain.from_above();
    for flies in [false, true] {
        let ground = if flies { &above } else { terrain };
        let mut layer: Vec<&mut Robot> =
            robots.iter_mut().filter(|robot| robot.class.flies == flies).collect();
        let (count, mut taken) = (layer.len(), Vec::new());
        let no_room = || {
            let kind = if flies { " that fly" } else { "" };
            let found = format!("{meters:?} meters for {count} robots{kind}");
            Invalid::new(KEY, found, "a distance at which all find room where they start")
        };
        for robot in &mut layer {
            if let Start::Cell(cell) = &mut robot.start {
                *cell = apart(separation, ground, *cell, &taken).ok_or_else(no_room)?;
                taken.push(*cell);
            }
        }
        // Wherever the others are drawn, each keeps the next from this many cells at most.
        let side = u64::from(separation.cells()).saturating_mul(2).saturating_sub(1);
        let needed = (count as u64).saturating_sub(1).saturating_mul(side.saturating_mul(side));
        let areas = ground.connected_areas();
        let is_narrow = |area: usize| areas.get(area).is_none_or(|cells| cells.len() as u64 <= needed);
        let is_too_narrow = |robot: &&mut Robot| match robot.start {
            Start::Cell(_) => false,
            Start::Together { area } if !flies => is_narrow(area),
            // What flies is in reach of everything.
            Start::Together { .. } | Start::Scattered => is_narrow(0),
        };
        if layer.iter().any(is_too_narrow) {
            return Err(no_room());
        }
    }
    Ok(separation)
}

/// The cell nearest to this one that is apart from all that are taken; of equally near ones the smallest.
fn apart(separation: Separation, ground: &Terrain, cell: Cell, taken: &[Cell]) -> Option<Cell> {
    let routes = ShortestPathTree::from(ground, Connectivity::Four, cell);
    separation.first_apart(ground.grid(), &routes, taken)
}

/// The cells in which robots start that are drawn in these, apart from those before them and from those whose cells are given.
pub(super) fn placed(
    separation: Separation,
    robots: &[Robot],
    terrain: &Terrain,
    drawn: Vec<Cell>,
) -> Vec<Cell> {
    if !separation.is_kept() {
        return drawn;
    }
    let above = terrain.from_above();
    let mut placed = drawn;
    for flies in [false, true] {
        let ground = if flies { &above } else { terrain };
        let layer = || (0..).zip(robots).filter(|(_, robot)| robot.class.flies == flies);
        let mut taken: Vec<Cell> = layer()
            .filter_map(|(_, robot)| if let Start::Cell(cell) = robot.start { Some(cell) } else { None })
            .collect();
        for (place, _) in layer().filter(|(_, robot)| !matches!(robot.start, Start::Cell(_))) {
            let place: &mut Cell = &mut placed[place];
            // There is one: the scenario was checked for it.
            *place = apart(separation, ground, *place, &taken).unwrap_or(*place);
            taken.push(*place);
        }
    }
    placed
}
