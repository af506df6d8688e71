//! A map's position on the earth: conversion between WGS84 degrees and meters east and north.

use std::fmt;

use dragnet_search::terrain::Terrain;
use geo::{Coord, Distance, Geodesic, Point};

/// Semi-major axis of WGS84, meters.
const SEMI_MAJOR_METERS: f64 = 6_378_137.0;
/// Flattening of WGS84.
const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// Maximum distance from its corner at which a frame is used, meters.
const NEAR_METERS: f64 = 100_000.0;

/// A point of WGS84.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeoPoint {
    /// `-180..=180`, east positive.
    pub longitude_degrees: f64,
    /// `-90..=90`, north positive.
    pub latitude_degrees: f64,
}

/// To six places, a tenth of a meter.
impl fmt::Display for GeoPoint {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { latitude_degrees, longitude_degrees } = self;
        write!(formatter, "latitude {latitude_degrees:.6}, longitude {longitude_degrees:.6}")
    }
}

impl GeoPoint {
    /// The allowed values of [`GeoPoint::checked`].
    pub const ALLOWED: &str = "longitude -180 to 180 and latitude -85 to 85 degrees";

    /// A point where a map can lie; `None` if it is not on the earth, or nearer to a pole than 85 degrees, where east
    /// is not a useful direction.
    #[must_use]
    pub fn checked(longitude_degrees: f64, latitude_degrees: f64) -> Option<Self> {
        let is_place =
            (-180.0..=180.0).contains(&longitude_degrees) && (-85.0..=85.0).contains(&latitude_degrees);
        is_place.then_some(Self { longitude_degrees, latitude_degrees })
    }
}

impl From<Coord<f64>> for GeoPoint {
    fn from(corner: Coord<f64>) -> Self {
        Self { longitude_degrees: corner.x, latitude_degrees: corner.y }
    }
}

/// A local frame, meters east and north of the map's south-western corner.
///
/// With the radii of curvature of the ellipsoid at a reference latitude `p`, that of the map's middle,
///
/// ```text
/// M = a (1 - e2) / (1 - e2 sin2 p)^(3/2)     along the meridian
/// N = a / (1 - e2 sin2 p)^(1/2)              across it
/// east = (longitude - longitude0) N cos p,   north = (latitude - latitude0) M
/// ```
///
/// Both conversions are linear and inverse to each other. The error against distances on the ellipsoid comes from the
/// meridians' convergence: a length to the east is off by the share `n tan(p) / a`, `n` the meters north of the middle.
/// In a map of 10 km at 45 degrees that is at most 0.08 %, or 4 m from the middle of an edge to the corner; for 1 km, 4
/// cm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Georeference {
    south_west: GeoPoint,
    reference_latitude_degrees: f64,
    east_meters_per_degree: f64,
    north_meters_per_degree: f64,
    /// From the east to the map's rows, counterclockwise, radians.
    yaw_radians: f64,
}

impl Georeference {
    /// The frame of a map with this south-western corner, scaled for a reference latitude, that of its
    /// middle.
    #[must_use]
    pub fn new(south_west: GeoPoint, reference_latitude_degrees: f64) -> Self {
        let (sine, cosine) = reference_latitude_degrees.to_radians().sin_cos();
        let eccentricity2 = FLATTENING * (2.0 - FLATTENING);
        let bend = 1.0 - eccentricity2 * sine * sine;
        let across_meters = SEMI_MAJOR_METERS / bend.sqrt();
        let along_meters = across_meters * (1.0 - eccentricity2) / bend;
        Self {
            south_west,
            reference_latitude_degrees,
            east_meters_per_degree: (across_meters * cosine).to_radians(),
            north_meters_per_degree: along_meters.to_radians(),
            yaw_radians: 0.0,
        }
    }

    /// The frame for a map whose rows are rotated from east by this angle, radians counterclockwise: meters are then
    /// measured along its rows and up its columns.
    #[must_use]
    pub const fn turned(self, yaw_radians: f64) -> Self {
        Self { yaw_radians, ..self }
    }

    /// The frame of a map of this size with this south-western corner.
    #[must_use]
    pub fn of_map(south_west: GeoPoint, terrain: &Terrain) -> Self {
        let rough = Self::new(south_west, south_west.latitude_degrees);
        let middle_meters = f64::from(terrain.grid().rows()) * terrain.cell_meters() / 2.0;
        Self::new(south_west, rough.point((0.0, middle_meters)).latitude_degrees)
    }

    /// The latitude at which lengths to the east and to the north are those on the ellipsoid, degrees.
    #[must_use]
    pub const fn reference_latitude_degrees(&self) -> f64 {
        self.reference_latitude_degrees
    }

    /// From the east to the map's rows, counterclockwise, radians.
    #[must_use]
    pub const fn yaw_radians(&self) -> f64 {
        self.yaw_radians
    }

    /// The map's south-western corner.
    #[must_use]
    pub const fn south_west(&self) -> GeoPoint {
        self.south_west
    }

    /// Meters `(east, north)` of the south-western corner.
    #[must_use]
    pub fn meters(&self, point: GeoPoint) -> (f64, f64) {
        let east =
            (point.longitude_degrees - self.south_west.longitude_degrees) * self.east_meters_per_degree;
        let north =
            (point.latitude_degrees - self.south_west.latitude_degrees) * self.north_meters_per_degree;
        turn((east, north), -self.yaw_radians)
    }

    /// A corner `(longitude, latitude)` in cells of an edge in meters, `(east, north)` of the south-western corner.
    pub(super) fn cells(&self, corner: Coord<f64>, cell_meters: f64) -> Coord<f64> {
        let (east, north) = self.meters(GeoPoint::from(corner));
        Coord { x: east / cell_meters, y: north / cell_meters }
    }

    /// The allowed points.
    pub(crate) const NEAR: &str = "at most 100 km from the map's south-western corner";

    /// A point's distance in words, if it is too far for this frame.
    pub(crate) fn check_near(&self, point: GeoPoint) -> Result<(), String> {
        let (east, north) = self.meters(point);
        if east.hypot(north) <= NEAR_METERS {
            return Ok(());
        }
        // The frame's own lengths are wrong far from its corner, and go around the earth the long way.
        let of = |place: GeoPoint| Point::new(place.longitude_degrees, place.latitude_degrees);
        let kilometers = Geodesic.distance(of(self.south_west), of(point)) / 1000.0;
        let is_across = (point.longitude_degrees - self.south_west.longitude_degrees).abs() > 180.0;
        let across = if is_across { " across the 180th meridian, which no map may cross," } else { "" };
        Err(format!("{kilometers:.0} km away{across}"))
    }

    /// The point at meters east and north of the south-western corner.
    #[must_use]
    pub fn point(&self, meters: (f64, f64)) -> GeoPoint {
        let (east_meters, north_meters) = turn(meters, self.yaw_radians);
        GeoPoint {
            longitude_degrees: self.south_west.longitude_degrees + east_meters / self.east_meters_per_degree,
            latitude_degrees: self.south_west.latitude_degrees + north_meters / self.north_meters_per_degree,
        }
    }
}

fn turn((x, y): (f64, f64), radians: f64) -> (f64, f64) {
    let (sine, cosine) = radians.sin_cos();
    (cosine * x - sine * y, sine * x + cosine * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(longitude_degrees: f64, latitude_degrees: f64) -> GeoPoint {
        GeoPoint { longitude_degrees, latitude_degrees }
    }

    /// Published lengths of a degree on WGS84 at latitudes 0, 45 and 60.
    #[test]
    fn a_degree_has_its_length_on_the_ellipsoid() {
        for (latitude, east_meters, north_meters) in
            [(0.0, 111_319.5, 110_574.3), (45.0, 78_846.8, 111_131.8), (60.0, 55_800.0, 111_412.2)]
        {
            let frame = Georeference::new(at(10.0, latitude), latitude);
            let (east, north) = frame.meters(at(11.0, latitude + 1.0));
            assert!((east - east_meters).abs() < 1.0, "{latitude}: {east}");
            assert!((north - north_meters).abs() < 1.0, "{latitude}: {north}");
        }
    }

    /// The error in the frame's documentation, at the corners of a map of 10 km.
    #[test]
    fn a_map_of_10_km_keeps_distances_to_a_fraction_of_a_cell() {
        for (latitude, max_meters) in [(0.0, 0.1), (45.0, 4.1), (-45.0, 4.1), (60.0, 7.0), (70.0, 11.0)] {
            let frame = Georeference::of_map(at(10.0, latitude), &square(10_000.0));
            let middle = (5_000.0, 5_000.0);
            let mut worst_meters: f64 = 0.0;
            for step in 0..=20 {
                let along = 500.0 * f64::from(step);
                for to in [(along, 0.0), (along, 10_000.0), (0.0, along), (10_000.0, along)] {
                    let flat = (to.0 - middle.0).hypot(to.1 - middle.1);
                    let [a, b] = [middle, to].map(|meters| frame.point(meters));
                    let ends = [a, b].map(|it| geo::Point::new(it.longitude_degrees, it.latitude_degrees));
                    worst_meters = worst_meters.max((Geodesic.distance(ends[0], ends[1]) - flat).abs());
                }
            }
            assert!(worst_meters < max_meters, "{latitude}: {worst_meters} m");
            assert!(latitude.abs() < 1.0 || worst_meters > max_meters / 4.0, "{latitude}: {worst_meters} m");
        }
    }

    fn square(edge_meters: f64) -> Terrain {
        Terrain::from_ascii(".", edge_meters).unwrap()
    }

    #[test]
    fn a_distant_point_has_no_position_in_the_frame() {
        let frame = Georeference::new(at(-2.25, 49.16), 49.2);
        assert_eq!(frame.check_near(at(-1.0, 49.16)), Ok(()));
        assert_eq!(frame.check_near(at(-2.25, 51.16)), Err("222 km away".to_owned()));
        assert!(frame.check_near(at(f64::NAN, 0.0)).is_err());
        let (fiji, meridian) = (Georeference::new(at(-179.9, -17.0), -17.0), "across the 180th meridian");
        let across = fiji.check_near(at(179.8, -17.0)).unwrap_err();
        assert!(across.starts_with("32 km away") && across.contains(meridian), "{across}");
        // Nothing is farther than half the way around the earth.
        let half = Georeference::new(at(0.0, 0.0), 0.0).check_near(at(180.0, 0.0)).unwrap_err();
        assert_eq!(half, "20004 km away");
    }

    #[test]
    fn there_and_back_is_the_same_point() {
        let frame = Georeference::new(at(-2.25, 49.16), 49.2);
        let point = at(-2.013, 49.27);
        let back = frame.point(frame.meters(point));
        assert!((back.longitude_degrees - point.longitude_degrees).abs() < 1e-12);
        assert!((back.latitude_degrees - point.latitude_degrees).abs() < 1e-12);
        assert_eq!(frame.meters(frame.south_west()), (0.0, 0.0));
    }

    #[test]
    fn the_rows_of_a_map_that_is_turned_run_where_they_do() {
        let frame = Georeference::new(at(-2.25, 49.16), 49.2);
        let turned = frame.turned(std::f64::consts::FRAC_PI_2);
        let (along, north) = (turned.point((100.0, 20.0)), frame.point((-20.0, 100.0)));
        assert!((along.longitude_degrees - north.longitude_degrees).abs() < 1e-12);
        assert!((along.latitude_degrees - north.latitude_degrees).abs() < 1e-12);
        let (x, y) = turned.meters(along);
        assert!((x - 100.0).hypot(y - 20.0) < 1e-6, "{x} {y}");
    }
}
