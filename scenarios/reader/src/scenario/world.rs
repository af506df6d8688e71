//! The map and the sensor of a scenario.

use std::path::Path;
use std::sync::Arc;

use dragnet_search::cell::Grid;
use dragnet_search::evidence::{MAX_VARIANCE, MIN_VARIANCE};
use dragnet_search::generated::Generated;
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::route::Connectivity;
use dragnet_search::sensor::{Noise, Sensor};
use dragnet_search::shape::Shape;
use dragnet_search::terrain::Terrain;

use super::check::{self, Invalid};
use super::class::Classes;
use super::error::Fault;
use super::file::{GeoPointTable, MapTable, SensorTable};
use crate::map_file::{Areas, Format, GeoPoint, Georeference, MapFile};

/// One row of as many cells as a grid can have.
const MAX_SIDE: u32 = 1 << 24;
/// The shortest edge of a cell, meters.
const MIN_CELL_METERS: f64 = 0.001;

/// The map of areas that are in memory; the table names their file.
pub(super) fn map_of_areas(table: &MapTable, areas: Areas) -> Result<MapFile, Fault> {
    let cell_meters = edge(table)?;
    let (None, None, None, Some(file)) = (&table.shape, &table.origin, &table.keepout, &table.file) else {
        let allowed = "a file of areas, without shape, origin and keepout";
        return Err(Invalid::new("map", "another one", allowed).into());
    };
    check_no_size(table)?;
    let map = MapFile::of_areas(Path::new(file), areas, cell_meters)
        .map_err(|source| Fault::MapFile { key: "map.file", source })?;
    check_something_is_open(&map.terrain)?;
    Ok(map)
}

fn edge(table: &MapTable) -> Result<f64, Invalid> {
    check::within("map.cell_meters", table.cell_meters, MIN_CELL_METERS, 1e6)
}

pub(super) fn map(table: &MapTable, folder: &Path) -> Result<MapFile, Fault> {
    let cell_meters = edge(table)?;
    let map = match (&table.shape, &table.file) {
        (Some(shape), None) => MapFile::unplaced(shape_terrain(shape, table, cell_meters)?),
        (None, Some(file)) => map_file(table, &folder.join(file), cell_meters)?,
        (Some(_), Some(_)) => {
            return Err(Invalid::new("map", "shape and file", "exactly one of shape and file").into());
        }
        (None, None) => {
            return Err(Invalid::new("map", "without shape or file", "exactly one of them").into());
        }
    };
    let map = match &table.keepout {
        Some(mask) => without(map, table, &folder.join(mask))?,
        None => map,
    };
    check_something_is_open(&map.terrain)?;
    Ok(match &table.origin {
        Some(origin) => MapFile { georeference: Some(georeference(origin, &map)?), ..map },
        None => map,
    })
}

fn georeference(table: &GeoPointTable, map: &MapFile) -> Result<Georeference, Invalid> {
    let key = "map.origin";
    if map.georeference.is_some() {
        let allowed = "no such key beside a map whose file has a position";
        return Err(Invalid::new(key, "given", allowed));
    }
    if map.origin.yaw_radians.abs() > 0.0 {
        let found = format!("that of a map turned by {} rad", map.origin.yaw_radians);
        return Err(Invalid::new(key, found, "the origin of a map whose rows run to the east"));
    }
    let (longitude, latitude) = (table.longitude_degrees, table.latitude_degrees);
    let south_west = GeoPoint::checked(longitude, latitude).ok_or_else(|| {
        let found =
            format!("longitude {} and latitude {}", check::written(longitude), check::written(latitude));
        Invalid::new(key, found, GeoPoint::ALLOWED)
    })?;
    Ok(Georeference::of_map(south_west, &map.terrain))
}

fn shape_terrain(name: &str, table: &MapTable, cell_meters: f64) -> Result<Terrain, Invalid> {
    let shape = Shape::ALL.into_iter().find(|shape| shape.as_str() == name);
    let generated = Generated::ALL.into_iter().find(|kind| kind.as_str() == name);
    let terrain = match (shape, generated) {
        (Some(_), _) if table.seed.is_some() => {
            let kinds = Generated::ALL.map(Generated::as_str).join(", ");
            return Err(Invalid::new(
                "map.seed",
                format!("a seed for {name}"),
                format!("a seed for {kinds} only"),
            ));
        }
        (Some(shape), _) => shape.terrain(grid(table)?, cell_meters),
        (None, Some(kind)) => {
            let seed = check::integer("map.seed", table.seed.unwrap_or(0), 0, u32::MAX)?;
            kind.terrain(grid(table)?, cell_meters, seed.into())
        }
        (None, None) => {
            let allowed = super::file::shape_names().join(", ");
            return Err(Invalid::new("map.shape", format!("{name:?}"), allowed));
        }
    };
    terrain.map_err(|error| Invalid::new("map.cell_meters", error, "a length above 0"))
}

fn grid(table: &MapTable) -> Result<Grid, Invalid> {
    let size = |key: &str, value: Option<i64>| match value {
        Some(value) => check::integer(key, value, 1, MAX_SIDE),
        None => Err(Invalid::new(key, "missing", "a number of cells where map.shape is given")),
    };
    let (rows, columns) = (size("map.rows", table.rows)?, size("map.columns", table.columns)?);
    Grid::new(rows, columns).map_err(|_| {
        let allowed = format!("1 to {} cells", Grid::MAX_CELLS);
        Invalid::new("map", format!("{rows} x {columns} cells"), allowed)
    })
}

fn map_file(table: &MapTable, file: &Path, cell_meters: f64) -> Result<MapFile, Fault> {
    check_no_size(table)?;
    MapFile::load(file, cell_meters).map_err(|source| Fault::MapFile { key: "map.file", source })
}

/// The map without what a keep-out mask closes.
fn without(map: MapFile, table: &MapTable, mask: &Path) -> Result<MapFile, Fault> {
    let key = "map.keepout";
    if table.file.as_deref().and_then(|file| Format::of(Path::new(file))) != Some(Format::Ros) {
        return Err(Invalid::new(key, "given", "no such key but beside a ROS map (.yaml) as map.file").into());
    }
    map.without(mask).map_err(|source| Fault::MapFile { key, source })
}

/// A file has its own size.
fn check_no_size(table: &MapTable) -> Result<(), Invalid> {
    for (key, value) in [("map.rows", table.rows), ("map.columns", table.columns), ("map.seed", table.seed)] {
        if let Some(value) = value {
            return Err(Invalid::new(key, value, "no such key beside map.file"));
        }
    }
    Ok(())
}

fn check_something_is_open(terrain: &Terrain) -> Result<(), Invalid> {
    let what = match (terrain.traversable_cells().next(), terrain.searched_cells().next()) {
        (None, _) => "traversable",
        (_, None) => "searched",
        _ => return Ok(()),
    };
    let allowed = format!("at least one {what} cell (smaller cells keep narrow ground open)");
    Err(Invalid::new("map", format!("without a {what} cell"), allowed))
}

pub(super) fn connectivity(number: i64) -> Result<Connectivity, Invalid> {
    match number {
        4 => Ok(Connectivity::Four),
        8 => Ok(Connectivity::Eight),
        _ => Err(Invalid::new("map.connectivity", number, "4 or 8")),
    }
}

/// The map with what walls hide from robots on the ground, if sensors do not see through them.
pub(super) fn with_line_of_sight(
    map: Arc<MapFile>,
    table: &SensorTable,
    classes: &Classes,
) -> Result<Arc<MapFile>, Invalid> {
    if !table.line_of_sight {
        return Ok(map);
    }
    let on_the_ground = classes.all().filter(|class| !class.flies);
    let radius = on_the_ground.map(|class| class.sensor.radius()).max().unwrap_or(1);
    let grid = map.terrain.grid();
    if LineOfSight::is_too_large(grid, radius) {
        let found = format!("true on a map of {} cells with a radius of {radius}", grid.cell_count());
        let allowed = format!(
            "no more than {} pairs of cells within the radius (larger cells, or a shorter radius)",
            LineOfSight::MAX_PAIRS
        );
        return Err(Invalid::new("sensor.line_of_sight", found, allowed));
    }
    let terrain = map.terrain.clone().with_opaque_walls(radius);
    Ok(Arc::new(MapFile { terrain, ..MapFile::clone(&map) }))
}

/// The sensor of a table at a key.
pub(super) fn sensor(key: &str, table: &SensorTable, grid: Grid) -> Result<Sensor, Invalid> {
    let noise = match table.noise.as_str() {
        "gaussian" => Noise::Gaussian,
        "clipped" => Noise::Clipped,
        other => {
            let allowed = "\"gaussian\" or \"clipped\"";
            return Err(Invalid::new(format!("{key}.noise"), format!("{other:?}"), allowed));
        }
    };
    let larger_side = grid.rows().max(grid.columns());
    let widest = Sensor::MAX_RADIUS.min(larger_side);
    let radius = check::integer(format!("{key}.radius"), table.radius, 1, widest).map_err(|invalid| {
        let allowed = format!("{} (the map's larger side is {larger_side})", invalid.allowed);
        Invalid { allowed, ..invalid }
    })?;
    Sensor::new(radius, table.noise_variance, noise).map_err(|_| {
        let least = 5.0 * f64::from(MIN_VARIANCE);
        let most = f64::from(MAX_VARIANCE) / f64::from(radius * radius);
        let allowed = format!("from {least:.6} to {most:.3} at this radius");
        Invalid::new(format!("{key}.noise_variance"), check::written(table.noise_variance), allowed)
    })
}
