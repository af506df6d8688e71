//! Maps as drawings: objects, beliefs and tracks.

use std::fmt::Write;

use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::measures::Truth;
use dragnet_search::terrain::Terrain;

use super::markup::{Markup, escape};

/// Edge of a cell in the drawing.
const CELL: u32 = 10;
/// Number of steps in which probabilities are drawn.
const LEVELS: u32 = 16;

const BLOCKED: &str = "#d4d4d4";
const OPEN: &str = "#ffffff";
const OBJECT: &str = "#0072b2";
const WAYPOINT: &str = "#c1121f";

/// The color map viridis (Smith and van der Walt 2015), from 0 to 1 in equal steps: of even lightness, and
/// distinguishable with color blindness and in print.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

/// The track of a robot.
#[derive(Clone, Copy)]
pub(super) struct Way<'a> {
    /// Cells that it was in, in order.
    pub(super) track: &'a [Cell],
    /// In order.
    pub(super) waypoints: &'a [Cell],
}

/// The map, its objects, and where the robot starts.
pub(super) fn truth(terrain: &Terrain, truth: &Truth, start: Cell, caption: &str) -> Markup {
    let grid = terrain.grid();
    let is_open = |cell: &Cell| terrain.is_traversable(*cell);
    let mut drawing = squares(grid, grid.cells().filter(is_open), OPEN);
    drawing += &squares(grid, truth.objects().iter().copied(), OBJECT);
    drawing += &start_mark(grid, start);
    panel(grid, &drawing, caption)
}

/// The belief of each searched cell, and the track that it comes from.
pub(super) fn belief(terrain: &Terrain, belief: &Belief, way: Way<'_>, caption: &str) -> Markup {
    let grid = terrain.grid();
    let mut drawing = String::new();
    for level in 0..=LEVELS {
        let is_here = |cell: &Cell| self::level(belief.probability(*cell)) == level;
        drawing += &squares(grid, terrain.searched_cells().filter(is_here), &color(level));
    }
    drawing += &path(grid, way.track);
    if let Some(&start) = way.track.first() {
        drawing += &start_mark(grid, start);
    }
    for (number, &waypoint) in (1..).zip(way.waypoints) {
        drawing += &waypoint_mark(grid, waypoint, number);
    }
    panel(grid, &drawing, caption)
}

/// The legend of the belief's colors.
pub(super) fn legend() -> Markup {
    let mut drawing = String::new();
    for level in 0..=LEVELS {
        let (x, color) = (20 + level * 14, color(level));
        let _ = write!(drawing, "<rect x=\"{x}\" y=\"2\" width=\"14\" height=\"14\" fill=\"{color}\"/>");
    }
    for (x, label) in [(27, "0"), (139, "0.5"), (251, "1")] {
        let _ = write!(drawing, "<text x=\"{x}\" y=\"32\" text-anchor=\"middle\">{label}</text>");
    }
    Markup::raw(format!(
        "<svg class=\"legend\" viewBox=\"0 0 280 38\" width=\"280\" height=\"38\" font-size=\"13\" role=\"img\" \
         aria-label=\"Colors of the probability of an object, from 0, dark violet, to 1, yellow\">{drawing}</svg>\n"
    ))
}

fn panel(grid: Grid, drawing: &str, caption: &str) -> Markup {
    let (width, height) = (grid.columns() * CELL, grid.rows() * CELL);
    let caption = escape(caption);
    Markup::raw(format!(
        "<figure class=\"panel\"><svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{caption}\">\
         <rect width=\"{width}\" height=\"{height}\" fill=\"{BLOCKED}\"/>{drawing}</svg>\
         <figcaption>{caption}</figcaption></figure>\n"
    ))
}

/// North-western corner of a cell.
fn corner(grid: Grid, cell: Cell) -> (u32, u32) {
    let Position { row, column } = grid.position(cell);
    (column * CELL, (grid.rows() - 1 - row) * CELL)
}

fn center(grid: Grid, cell: Cell) -> (u32, u32) {
    let (x, y) = corner(grid, cell);
    (x + CELL / 2, y + CELL / 2)
}

/// Cells of one color, as one path.
fn squares(grid: Grid, cells: impl Iterator<Item = Cell>, color: &str) -> String {
    let mut outline = String::new();
    for cell in cells {
        let (x, y) = corner(grid, cell);
        let _ = write!(outline, "M{x} {y}h{CELL}v{CELL}h-{CELL}z");
    }
    if outline.is_empty() {
        return outline;
    }
    // A thin edge of the same color, so that no seam shows between cells.
    format!("<path d=\"{outline}\" fill=\"{color}\" stroke=\"{color}\" stroke-width=\"0.4\"/>")
}

/// A line that is visible on dark and on light.
fn path(grid: Grid, track: &[Cell]) -> String {
    let points: Vec<String> = track
        .iter()
        .map(|&cell| {
            let (x, y) = center(grid, cell);
            format!("{x},{y}")
        })
        .collect();
    let line = |color: &str, width: u32| {
        format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" stroke-linejoin=\"round\" \
             stroke-linecap=\"round\"/>",
            points.join(" ")
        )
    };
    line("#000000", 5) + &line("#ffffff", 2)
}

fn start_mark(grid: Grid, cell: Cell) -> String {
    let (x, y) = center(grid, cell);
    format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"6\" fill=\"#ffffff\" stroke=\"#000000\" stroke-width=\"2\"/>")
}

fn waypoint_mark(grid: Grid, cell: Cell, number: usize) -> String {
    let (x, y) = corner(grid, cell);
    // Somewhat larger than its cell, around the same center.
    let (left, top) = (f64::from(x) - 2.0, f64::from(y) - 2.0);
    let (middle, base) = (f64::from(x) + 5.0, f64::from(y) + 9.0);
    format!(
        "<rect x=\"{left}\" y=\"{top}\" width=\"14\" height=\"14\" rx=\"2\" fill=\"{WAYPOINT}\" stroke=\"#ffffff\"/>\
         <text x=\"{middle}\" y=\"{base}\" font-size=\"11\" font-weight=\"bold\" text-anchor=\"middle\" \
         fill=\"#ffffff\">{number}</text>"
    )
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to LEVELS")]
fn level(probability: f64) -> u32 {
    (probability.clamp(0.0, 1.0) * f64::from(LEVELS)).round() as u32
}

/// The color of a level, `0..=LEVELS`.
fn color(level: u32) -> String {
    let place = f64::from(level.min(LEVELS)) / f64::from(LEVELS) * 8.0;
    let below = (0..8_u8).rev().find(|&stop| f64::from(stop) <= place).unwrap_or(0);
    let share = place - f64::from(below);
    let (from, to) = (VIRIDIS[usize::from(below)], VIRIDIS[usize::from(below) + 1]);
    let channel = |index: usize| (from[index] + share * (to[index] - from[index])).round();
    format!("rgb({},{},{})", channel(0), channel(1), channel(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_goes_from_violet_through_green_to_yellow() {
        assert_eq!(color(level(0.0)), "rgb(68,1,84)");
        assert_eq!(color(level(0.5)), "rgb(33,145,140)");
        assert_eq!(color(level(0.53)), "rgb(33,145,140)");
        assert_eq!(color(level(1.0)), "rgb(253,231,37)");
        assert_eq!(color(1), "rgb(70,23,104)");
    }

    #[test]
    fn north_is_up() {
        let terrain = Terrain::from_ascii("#.\n..\n..", 1.0).unwrap();
        let grid = terrain.grid();
        let north_east = grid.cell(Position { row: 2, column: 1 }).unwrap();
        assert_eq!(corner(grid, north_east), (10, 0));
        let drawing = truth(&terrain, &Truth::new(&terrain, vec![north_east]), north_east, "truth");
        assert!(drawing.as_str().contains("d=\"M10 0h10v10h-10z\" fill=\"#0072b2\""), "{}", drawing.as_str());
    }
}
