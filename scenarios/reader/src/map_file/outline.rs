//! The map of areas drawn on the earth: `GeoJSON` and KML, WGS84.
//!
//! All search areas of the file together are searched, the ground that several share once; holes are left out. The grid starts at the south-western corner
//! of their bounding box, in the frame of [`Georeference`]; a cell is open where at least half of its area lies inside,
//! else blocked. No robot enters a cell that a no-go area touches; if it would be open, it is still searched, from
//! outside.

use std::collections::BTreeSet;
use std::path::Path;

use dragnet_search::cell::{Grid, GridSizeError};
use dragnet_search::terrain::{Ground, Terrain};
use geo::{MapCoords, MultiPolygon, Polygon};

use super::areas::{Areas, Purpose, rings};
use super::georeference::{GeoPoint, Georeference};
use super::raster::whole_cells;
use super::scanline::covered_shares;
use super::union::{overlapping_pairs, union};
use super::{MapFile, MapFileError, MapOrigin};

/// Half a cell, less rounding.
const OPEN_SHARE: f64 = 0.5 - 1e-9;

/// Converts areas to cells of an edge in meters; messages name the file.
pub(super) fn map(file: &Path, areas: Areas, cell_meters: f64) -> Result<MapFile, MapFileError> {
    let searched = Searched::of(&areas);
    let frame = searched.frame(file)?;
    let invalid = |source| MapFileError::Terrain { file: file.to_owned(), source };
    let grid = searched.grid(&frame, cell_meters).map_err(|error| invalid(error.into()))?;
    let is_entered = entered(file, &areas, &frame, grid, cell_meters)?;
    let shared = overlapping_pairs(&searched.grounds());
    let region = searched.region(&shared);
    let overlaps = searched.areas_of(&shared);
    let ground = covered_shares(grid, &rings(&in_cells(&region, &frame, cell_meters)))
        .into_iter()
        .zip(is_entered)
        .map(|(share, is_entered)| match (share >= OPEN_SHARE, is_entered) {
            (true, true) => Ground::OPEN,
            (true, false) => Ground::OUT_OF_REACH,
            (false, _) => Ground::BLOCKED,
        })
        .collect();
    let terrain = Terrain::new(grid, cell_meters, ground).map_err(invalid)?;
    Ok(MapFile { terrain, georeference: Some(frame), origin: MapOrigin::default(), areas, overlaps })
}

/// The grids of areas, by the cells' edge, meters; `None` for edges that they cannot have.
pub(super) fn grids(areas: &Areas) -> Option<impl Fn(f64) -> Option<Grid>> {
    let searched = Searched::of(areas);
    let frame = searched.frame(Path::new("")).ok()?;
    Some(move |cell_meters| searched.grid(&frame, cell_meters).ok())
}

/// The polygons of search areas, each with its place: the name of its area, and its number in it.
struct Searched<'a> {
    polygons: Vec<((&'a str, usize), &'a Polygon<f64>)>,
    /// Whether the file is an export, with results of a search.
    is_export: bool,
}

impl<'a> Searched<'a> {
    fn of(areas: &'a Areas) -> Self {
        let searched = areas.areas.iter().filter_map(|area| match &area.purpose {
            Purpose::Search(region) => Some((&area.name, region)),
            _ => None,
        });
        let polygons = searched.flat_map(|(name, region)| {
            region.iter().enumerate().map(move |(index, polygon)| ((name.as_str(), index), polygon))
        });
        Self { polygons: polygons.collect(), is_export: areas.results > 0 }
    }

    /// The polygons alone.
    fn grounds(&self) -> Vec<&'a Polygon<f64>> {
        self.polygons.iter().map(|&(_, polygon)| polygon).collect()
    }

    /// The searched ground, for an even-odd rule: what several polygons share lies in one of them.
    fn region(&self, shared: &[(usize, usize)]) -> MultiPolygon<f64> {
        let grounds = self.grounds();
        if shared.is_empty() { grounds.into_iter().cloned().collect() } else { union(&grounds) }
    }

    /// The names of the areas of pairs of polygons, each pair once; of one area both are the same.
    fn areas_of(&self, pairs: &[(usize, usize)]) -> Vec<[String; 2]> {
        let name = |polygon: usize| self.polygons[polygon].0.0.to_owned();
        let mut told = BTreeSet::new();
        pairs.iter().map(|&(a, b)| [name(a), name(b)]).filter(|pair| told.insert(pair.clone())).collect()
    }

    fn corners(&self) -> impl Iterator<Item = GeoPoint> + '_ {
        self.polygons.iter().flat_map(|(_, polygon)| polygon.exterior()).map(|&corner| GeoPoint::from(corner))
    }

    /// The frame whose corner is that of the bounding box, scaled for the middle of it.
    fn frame(&self, file: &Path) -> Result<Georeference, MapFileError> {
        let latitudes = || self.corners().map(|corner| corner.latitude_degrees);
        let south = latitudes().fold(f64::INFINITY, f64::min);
        let north = latitudes().fold(f64::NEG_INFINITY, f64::max);
        let west = self.corners().map(|corner| corner.longitude_degrees).fold(f64::INFINITY, f64::min);
        if self.polygons.is_empty() {
            let (found, allowed) = if self.is_export {
                let found = "without a search area: it is the export of a search, with its tracks and finds";
                (found, "the GeoJSON or the KML of a recording whose map has drawn areas")
            } else {
                ("without a search area", "at least one polygon of kind search, or without a kind and a poa")
            };
            return Err(MapFileError::value(file, "the map", found, allowed));
        }
        let south_west = GeoPoint { longitude_degrees: west, latitude_degrees: south };
        let frame = Georeference::new(south_west, f64::midpoint(south, north));
        for &((name, index), polygon) in &self.polygons {
            for &corner in polygon.exterior() {
                frame.check_near(corner.into()).map_err(|far| {
                    let place = format!("search area {name:?}, polygon {}", index + 1);
                    let found = format!("{far} at [{}, {}]", corner.x, corner.y);
                    MapFileError::value(file, place, found, Georeference::NEAR)
                })?;
            }
        }
        Ok(frame)
    }

    /// The smallest grid in which all polygons fit.
    fn grid(&self, frame: &Georeference, cell_meters: f64) -> Result<Grid, GridSizeError> {
        let meters = self.corners().map(|corner| frame.meters(corner));
        let (east, north) = meters.fold((0.0_f64, 0.0_f64), |most, at| (most.0.max(at.0), most.1.max(at.1)));
        Grid::new(whole_cells(north / cell_meters), whole_cells(east / cell_meters))
    }
}

/// Whether robots may enter each cell, shape `[cells]`.
fn entered(
    file: &Path,
    areas: &Areas,
    frame: &Georeference,
    grid: Grid,
    cell_meters: f64,
) -> Result<Vec<bool>, MapFileError> {
    let mut is_touched = vec![false; grid.cell_count()];
    for area in &areas.areas {
        if matches!(area.purpose, Purpose::NoGo(..) | Purpose::Start(_)) {
            area.check_near(file, frame)?;
        }
        area.each_closed(frame, grid, cell_meters, |cell| is_touched[cell.index()] = true);
    }
    Ok(is_touched.into_iter().map(|is_touched| !is_touched).collect())
}

fn in_cells(region: &MultiPolygon<f64>, frame: &Georeference, cell_meters: f64) -> MultiPolygon<f64> {
    region.map_coords(|corner| frame.cells(corner, cell_meters))
}

#[cfg(test)]
mod tests;
