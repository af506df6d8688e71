//! How far a camera sees past the walls of a map, direction by direction.

use std::cell::RefCell;
use std::collections::BTreeMap;

use dragnet_lattice::costmap::CostMap;
use dragnet_lattice::plane::bearing_radians;
use nalgebra::Vector2;

use super::account::pair;

/// Directions in a full turn. Between two of them lie 2 cm at a range of 10 m.
const DIRECTIONS: f64 = 3600.0;

/// What the walls of a map hide from one place. A direction is looked at once, however many positions in it are asked for.
#[derive(Debug)]
pub struct Vista<'a> {
    walls: Option<&'a CostMap>,
    from_meters: Vector2<f64>,
    /// Farther positions are not hidden.
    range_meters: f64,
    /// By direction: the range from which on positions are hidden, meters.
    hidden_from: RefCell<BTreeMap<i32, f64>>,
}

impl<'a> Vista<'a> {
    /// The vista from a position, meters. Walls hide what is up to this far away from it, meters; without walls nothing is hidden.
    #[must_use]
    pub const fn new(walls: Option<&'a CostMap>, from_meters: Vector2<f64>, range_meters: f64) -> Self {
        Self { walls, from_meters, range_meters, hidden_from: RefCell::new(BTreeMap::new()) }
    }

    /// Whether a wall hides a position, meters: [`CostMap::hides`], but for a twentieth of a degree.
    #[must_use]
    pub fn hides(&self, place_meters: Vector2<f64>) -> bool {
        let Some(walls) = self.walls else { return false };
        let turn = bearing_radians(self.from_meters, place_meters) / std::f64::consts::TAU;
        #[expect(clippy::cast_possible_truncation, reason = "at most as many as there are directions")]
        let direction = (turn * DIRECTIONS).round() as i32;
        let mut hidden_from = self.hidden_from.borrow_mut();
        let range_meters = *hidden_from.entry(direction).or_insert_with(|| {
            let (sin, cos) = (f64::from(direction) / DIRECTIONS * std::f64::consts::TAU).sin_cos();
            let end = self.from_meters + Vector2::new(cos, sin) * self.range_meters;
            let part = walls.hidden_from(pair(self.from_meters), pair(end));
            part.map_or(f64::INFINITY, |part| part * self.range_meters)
        });
        (place_meters - self.from_meters).norm() > range_meters
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::seed::{Purpose, stream};
    use dragnet_search::terrain::Terrain;
    use rand::RngExt;

    use super::*;

    #[test]
    fn it_is_what_each_line_to_a_position_says_but_at_edges() {
        let terrain =
            Terrain::from_ascii("........\n..#.....\n..#..##.\n........\n....#...\n........", 1.0).unwrap();
        let map = CostMap::from_terrain(&terrain, 1).unwrap();
        let from = Vector2::new(1.3, 2.2);
        let vista = Vista::new(Some(&map), from, 20.0);
        let mut random = stream(1, Purpose::Truth, 0);
        let (mut hidden, mut differ) = (0, 0);
        for _ in 0..2000 {
            let place = Vector2::new(random.random_range(0.0..8.0), random.random_range(0.0..6.0));
            let expected = map.hides(pair(from), pair(place));
            hidden += u32::from(expected);
            differ += u32::from(vista.hides(place) != expected);
        }
        assert!(hidden > 400 && differ < 20, "{hidden} {differ}");
        assert!(vista.hidden_from.borrow().len() < 2000);
        assert!(!Vista::new(None, from, 20.0).hides(Vector2::new(7.0, 3.0)));
    }
}
