//! The paper's four maps, drawn as geometric shapes at any size.
//!
//! The paper prints them as pictures only (its Figures 2 and 4), so these are shapes of the same kind, not the same
//! cells. All lengths are shares of the map's smaller edge.

use crate::cell::{Grid, Position};
use crate::terrain::{Ground, Terrain, TerrainError};

/// A map of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// The field site: a cone that stands on its tip, with a round scoop on top.
    IceCreamCone,
    /// Four bars that cross in the middle: horizontal, vertical and both diagonals.
    OpenAsterisk,
    /// The digit 4: a stem, a crossbar and a slanted stroke that enclose a blocked triangle.
    FigureFour,
    /// Every cell.
    AllTraversable,
}

/// A point of the unit square, `x` east and `y` north.
#[derive(Clone, Copy)]
struct Point {
    x: f64,
    y: f64,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 4] =
        [Self::IceCreamCone, Self::OpenAsterisk, Self::FigureFour, Self::AllTraversable];

    /// The name used in scenarios.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::IceCreamCone => "ice_cream_cone",
            Self::OpenAsterisk => "open_asterisk",
            Self::FigureFour => "figure_four",
            Self::AllTraversable => "all_traversable",
        }
    }

    /// Draws the shape on a grid with cells of edge `cell_meters`, meters: cells whose center is inside are open, the
    /// others blocked.
    ///
    /// # Errors
    /// If the edge is not a positive length.
    pub fn terrain(self, grid: Grid, cell_meters: f64) -> Result<Terrain, TerrainError> {
        let ground = grid
            .cells()
            .map(|cell| {
                let Position { row, column } = grid.position(cell);
                let center = Point {
                    x: (f64::from(column) + 0.5) / f64::from(grid.columns()),
                    y: (f64::from(row) + 0.5) / f64::from(grid.rows()),
                };
                if self.contains(center) { Ground::OPEN } else { Ground::BLOCKED }
            })
            .collect();
        Terrain::new(grid, cell_meters, ground)
    }

    fn contains(self, point: Point) -> bool {
        match self {
            Self::IceCreamCone => ice_cream_cone(point),
            Self::OpenAsterisk => open_asterisk(point),
            Self::FigureFour => figure_four(point),
            Self::AllTraversable => true,
        }
    }
}

fn ice_cream_cone(Point { x, y }: Point) -> bool {
    let scoop = (x - 0.5).hypot(y - 0.68) <= 0.3;
    let cone = y <= 0.68 && (x - 0.5).abs() <= 0.3 * (y + 0.02) / 0.70;
    scoop || cone
}

fn open_asterisk(Point { x, y }: Point) -> bool {
    let (east, north) = (x - 0.5, y - 0.5);
    let half_width = 0.075;
    let diagonal = std::f64::consts::FRAC_1_SQRT_2;
    let is_on_bar = |across: f64, along: f64| across.abs() <= half_width && along.abs() <= 0.48;
    is_on_bar(north, east)
        || is_on_bar(east, north)
        || is_on_bar((east - north) * diagonal, (east + north) * diagonal)
        || is_on_bar((east + north) * diagonal, (east - north) * diagonal)
}

fn figure_four(point: Point) -> bool {
    let half_width = 0.07;
    let strokes = [
        (Point { x: 0.68, y: 0.05 }, Point { x: 0.68, y: 0.93 }),
        (Point { x: 0.12, y: 0.35 }, Point { x: 0.9, y: 0.35 }),
        (Point { x: 0.12, y: 0.35 }, Point { x: 0.68, y: 0.93 }),
    ];
    strokes.iter().any(|&(from, to)| distance_to_segment(point, from, to) <= half_width)
}

fn distance_to_segment(point: Point, from: Point, to: Point) -> f64 {
    let (along_x, along_y) = (to.x - from.x, to.y - from.y);
    let along = (point.x - from.x) * along_x + (point.y - from.y) * along_y;
    let share = (along / (along_x * along_x + along_y * along_y)).clamp(0.0, 1.0);
    (point.x - from.x - share * along_x).hypot(point.y - from.y - share * along_y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draw(shape: Shape, side: u32) -> Terrain {
        shape.terrain(Grid::new(side, side).unwrap(), 30.0).unwrap()
    }

    #[test]
    fn each_shape_is_one_area_of_much_the_same_share_at_any_size() {
        for shape in Shape::ALL {
            let share = |side: u32| {
                let terrain = draw(shape, side);
                let open = terrain.traversable_cells().count();
                assert_eq!(terrain.largest_area().len(), open, "{shape:?} at {side}");
                f64::from(u32::try_from(open).unwrap()) / f64::from(side * side)
            };
            let (small, large) = (share(30), share(120));
            assert!((small - large).abs() < 0.04, "{shape:?}: {small} and {large}");
            assert!(large > 0.3, "{shape:?}: {large}");
        }
    }

    #[test]
    fn the_cone_narrows_to_the_south() {
        let terrain = draw(Shape::IceCreamCone, 30);
        let width = |row: u32| {
            (0..30)
                .filter(|&column| {
                    terrain.is_traversable(terrain.grid().cell(Position { row, column }).unwrap())
                })
                .count()
        };
        assert!(width(2) < width(8) && width(8) < width(14) && width(14) < width(20));
    }

    #[test]
    fn the_four_encloses_a_blocked_triangle() {
        let terrain = draw(Shape::FigureFour, 30);
        let inside = terrain.grid().cell(Position { row: 14, column: 15 }).unwrap();
        assert!(!terrain.is_traversable(inside));
    }
}
