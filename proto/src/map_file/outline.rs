//! Search areas as polygons on the earth: `GeoJSON` (RFC 7946), WGS84 longitude and latitude in degrees.
//!
//! All polygons of the file together are the search area: a `Polygon` or `MultiPolygon`, bare, in a
//! `Feature`, or in the features of a `FeatureCollection`. Holes are left out. The grid starts at the
//! south-western corner of the area's bounding box, in the frame of [`Georeference`]; a cell is open where at
//! least half of its area lies inside, else blocked.

use std::path::Path;

use dragnet_search::cell::Grid;
use dragnet_search::terrain::{Ground, Terrain};
use geo::coordinate_position::CoordPos;
use geo::dimensions::Dimensions;
use geo::{BoundingRect, Coord, Intersects, LineString, Polygon, Relate, Validation};
use geojson::{GeoJson, Geometry, GeometryValue, Position};

use super::georeference::{GeoPoint, Georeference};
use super::raster::whole_cells;
use super::scanline::covered_shares;
use super::{MapFile, MapFileError, MapOrigin};

/// The most corners of all rings together: validation compares each edge of a ring with each other.
const MAX_CORNERS: usize = 20_000;
/// The most rings, holes included: validation compares each hole with each other.
const MAX_RINGS: usize = 1_000;
/// Half a cell, less rounding.
const OPEN_SHARE: f64 = 0.5 - 1e-9;

/// Reads polygons into cells of an edge in metres.
pub(super) fn read(file: &Path, text: &str, cell_meters: f64) -> Result<MapFile, MapFileError> {
    let json: GeoJson = text.parse().map_err(|error| MapFileError::syntax(file, error))?;
    let area = Area { file, polygons: polygons(file, json)? };
    area.check()?;
    let (south_west, north_east) = area.bounds();
    let middle_degrees = f64::midpoint(south_west.latitude_degrees, north_east.latitude_degrees);
    let frame = Georeference::new(south_west, middle_degrees);
    let (east_meters, north_meters) = frame.meters(north_east);
    let invalid = |source| MapFileError::Terrain { file: file.to_owned(), source };
    let grid = Grid::new(whole_cells(north_meters / cell_meters), whole_cells(east_meters / cell_meters))
        .map_err(|error| invalid(error.into()))?;
    let ground = covered_shares(grid, &area.rings(&frame, cell_meters))
        .into_iter()
        .map(|share| if share >= OPEN_SHARE { Ground::OPEN } else { Ground::BLOCKED })
        .collect();
    let terrain = Terrain::new(grid, cell_meters, ground).map_err(invalid)?;
    Ok(MapFile { terrain, georeference: Some(frame), origin: MapOrigin::default() })
}

/// The polygons of one file, in degrees.
struct Area<'a> {
    file: &'a Path,
    polygons: Vec<Polygon<f64>>,
}

impl Area<'_> {
    fn check(&self) -> Result<(), MapFileError> {
        let corners = self.all_rings().map(|ring| ring.0.len()).sum();
        self.check_number("corners", corners, MAX_CORNERS)?;
        self.check_number("rings", self.all_rings().count(), MAX_RINGS)?;
        for (number, polygon) in (1..).zip(&self.polygons) {
            polygon.check_validation().map_err(|error| {
                let allowed = "rings that neither cross themselves nor each other, with holes inside";
                self.invalid(&format!("polygon {number}"), &format!("not valid: {error}"), allowed)
            })?;
        }
        match self.overlapping_pair() {
            Some((a, b)) => {
                let allowed = "polygons that share no ground";
                Err(self.invalid(&format!("polygon {a}"), &format!("on polygon {b} in part"), allowed))
            }
            None => Ok(()),
        }
    }

    fn check_number(&self, what: &str, number: usize, most: usize) -> Result<(), MapFileError> {
        if (1..=most).contains(&number) {
            return Ok(());
        }
        let allowed = format!("1 to {most}: merge or simplify the outlines");
        Err(self.invalid(&format!("number of {what}"), &number.to_string(), &allowed))
    }

    /// Two polygons, numbered from 1, that share more than a border.
    fn overlapping_pair(&self) -> Option<(usize, usize)> {
        let boxes: Vec<_> = self.polygons.iter().map(BoundingRect::bounding_rect).collect();
        let overlap = |a: usize, b: usize| {
            let is_near = boxes[a].zip(boxes[b]).is_some_and(|(a, b)| a.intersects(&b));
            let shared =
                || self.polygons[a].relate(&self.polygons[b]).get(CoordPos::Inside, CoordPos::Inside);
            is_near && shared() == Dimensions::TwoDimensional
        };
        let count = self.polygons.len();
        (0..count)
            .flat_map(|a| (a + 1..count).map(move |b| (a, b)))
            .find(|&(a, b)| overlap(a, b))
            .map(|(a, b)| (b + 1, a + 1))
    }

    fn invalid(&self, place: &str, found: &str, allowed: &str) -> MapFileError {
        MapFileError::value(self.file, place, found, allowed)
    }

    fn all_rings(&self) -> impl Iterator<Item = &LineString<f64>> {
        self.polygons
            .iter()
            .flat_map(|polygon| std::iter::once(polygon.exterior()).chain(polygon.interiors()))
    }

    /// South-western and north-eastern corner of the bounding box.
    fn bounds(&self) -> (GeoPoint, GeoPoint) {
        let mut low = Coord { x: f64::INFINITY, y: f64::INFINITY };
        let mut high = Coord { x: f64::NEG_INFINITY, y: f64::NEG_INFINITY };
        for &corner in self.all_rings().flatten() {
            low = Coord { x: low.x.min(corner.x), y: low.y.min(corner.y) };
            high = Coord { x: high.x.max(corner.x), y: high.y.max(corner.y) };
        }
        (geo_point(low), geo_point(high))
    }

    /// The rings in cells east and north of the frame's corner.
    fn rings(&self, frame: &Georeference, cell_meters: f64) -> Vec<Vec<(f64, f64)>> {
        let cells = |corner: &Coord<f64>| {
            let (east_meters, north_meters) = frame.meters(geo_point(*corner));
            (east_meters / cell_meters, north_meters / cell_meters)
        };
        self.all_rings().map(|ring| ring.0.iter().map(cells).collect()).collect()
    }
}

const fn geo_point(corner: Coord<f64>) -> GeoPoint {
    GeoPoint { longitude_degrees: corner.x, latitude_degrees: corner.y }
}

fn polygons(file: &Path, json: GeoJson) -> Result<Vec<Polygon<f64>>, MapFileError> {
    let geometries: Vec<Option<Geometry>> = match json {
        GeoJson::Geometry(geometry) => vec![Some(geometry)],
        GeoJson::Feature(feature) => vec![feature.geometry],
        GeoJson::FeatureCollection(collection) => {
            collection.features.into_iter().map(|feature| feature.geometry).collect()
        }
    };
    let mut found = Vec::new();
    for (index, geometry) in geometries.into_iter().enumerate() {
        let value = geometry.map(|geometry| geometry.value);
        let members = match value {
            Some(GeometryValue::Polygon { coordinates }) => vec![coordinates],
            Some(GeometryValue::MultiPolygon { coordinates }) => coordinates,
            other => {
                let found = other.as_ref().map_or("null", GeometryValue::type_name);
                let place = format!("geometry {}", index + 1);
                return Err(MapFileError::value(file, place, found, "Polygon or MultiPolygon"));
            }
        };
        for rings in members {
            found.push(polygon(file, found.len() + 1, &rings)?);
        }
    }
    Ok(found)
}

fn polygon(file: &Path, number: usize, rings: &[Vec<Position>]) -> Result<Polygon<f64>, MapFileError> {
    let mut read = rings
        .iter()
        .enumerate()
        .map(|(index, ring)| read_ring(file, &format!("polygon {number}, ring {}", index + 1), ring));
    let exterior = read.next().transpose()?.unwrap_or_else(|| LineString(Vec::new()));
    Ok(Polygon::new(exterior, read.collect::<Result<_, _>>()?))
}

fn read_ring(file: &Path, place: &str, ring: &[Position]) -> Result<LineString<f64>, MapFileError> {
    let is_closed =
        ring.len() >= 4 && ring.first().map(Position::as_slice) == ring.last().map(Position::as_slice);
    if !is_closed {
        let found = format!("{} positions", ring.len());
        return Err(MapFileError::value(file, place, found, "at least 4, the last one equal to the first"));
    }
    ring.iter()
        .enumerate()
        .map(|(index, position)| {
            corner(position).ok_or_else(|| {
                let place = format!("{place}, position {}", index + 1);
                let found = format!("{:?}", position.as_slice());
                let allowed = "[longitude, latitude] in degrees, -180 to 180 and -85 to 85";
                MapFileError::value(file, place, found, allowed)
            })
        })
        .collect()
}

/// Nearer to a pole than 85 degrees the frame's east would be no direction.
fn corner(position: &Position) -> Option<Coord<f64>> {
    let &[x, y, ..] = position.as_slice() else { return None };
    let is_on_earth = (-180.0..=180.0).contains(&x) && (-85.0..=85.0).contains(&y);
    is_on_earth.then_some(Coord { x, y })
}

#[cfg(test)]
mod tests;
