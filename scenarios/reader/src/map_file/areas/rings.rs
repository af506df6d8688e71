//! Validation of rings and lines: closed, on the earth, and without crossings.

use std::path::Path;

use geo::{Coord, LineString, MultiPolygon, Polygon, Validation};

use super::feature::Position;
use crate::map_file::{GeoPoint, MapFileError};

/// Valid polygons; messages number them within the feature.
pub(super) fn polygons(
    file: &Path,
    place: &str,
    polygons: &[Vec<Vec<Position>>],
) -> Result<MultiPolygon<f64>, MapFileError> {
    let numbered = (1..).zip(polygons);
    numbered.map(|(number, rings)| polygon(file, &format!("{place}, polygon {number}"), rings)).collect()
}

fn polygon(file: &Path, place: &str, rings: &[Vec<Position>]) -> Result<Polygon<f64>, MapFileError> {
    let numbered = (1..).zip(rings);
    let mut read = numbered.map(|(number, ring)| closed(file, &format!("{place}, ring {number}"), ring));
    let Some(exterior) = read.next().transpose()? else {
        return Err(MapFileError::value(file, place, "without a ring", "an outer ring, and holes in it"));
    };
    let polygon = Polygon::new(exterior, read.collect::<Result<_, _>>()?);
    polygon.check_validation().map_err(|error| {
        let allowed = "rings that neither cross themselves nor each other, with holes inside";
        MapFileError::value(file, place, format!("not valid: {error}"), allowed)
    })?;
    Ok(polygon)
}

fn closed(file: &Path, place: &str, ring: &[Position]) -> Result<LineString<f64>, MapFileError> {
    let ring = corners(file, place, ring)?;
    if ring.len() >= 4 && ring.first() == ring.last() {
        return Ok(LineString(ring));
    }
    let open = if ring.first() == ring.last() { "" } else { ", and it is not closed" };
    let found = format!("{} positions{open}", ring.len());
    Err(MapFileError::value(file, place, found, "at least 4, the last one equal to the first"))
}

/// A line of at least two corners.
pub(super) fn line(file: &Path, place: &str, line: &[Position]) -> Result<LineString<f64>, MapFileError> {
    let corners = corners(file, place, line)?;
    if corners.len() >= 2 {
        return Ok(LineString(corners));
    }
    Err(MapFileError::value(file, place, format!("a line of {} positions", corners.len()), "at least 2"))
}

fn corners(file: &Path, place: &str, positions: &[Position]) -> Result<Vec<Coord<f64>>, MapFileError> {
    let numbered = (1..).zip(positions);
    numbered
        .map(|(number, position)| corner(file, &format!("{place}, position {number}"), position))
        .collect()
}

pub(super) fn corner(file: &Path, place: &str, position: &Position) -> Result<Coord<f64>, MapFileError> {
    if let &[x, y, ..] = position.as_slice()
        && GeoPoint::checked(x, y).is_some()
    {
        return Ok(Coord { x, y });
    }
    let allowed = "[longitude, latitude] in degrees, -180 to 180 and -85 to 85";
    Err(MapFileError::value(file, place, format!("{position:?}"), allowed))
}
