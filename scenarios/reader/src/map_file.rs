//! Map files: drawn, surveyed or recorded maps, as the [`Terrain`] that is searched.
//!
//! | extension | format | read by |
//! |---|---|---|
//! | `.txt` | drawing, see [`Terrain::from_ascii`] | this file |
//! | `.yaml` | ROS 2 map with its image, and a keep-out mask | `ros`, `keepout` |
//! | `.map` | `MovingAI` benchmark | `movingai` |
//! | `.geojson`, `.json`, `.kml`, `.kmz`, `.gpx`, `.plan` | areas drawn on the earth | [`areas`], `outline` |
//!
//! Reading a file returns a map, or a [`MapFileError`] that states the allowed values.

pub mod areas;
mod belief_file;
mod earth;
mod error;
mod georeference;
mod keepout;
mod movingai;
mod outline;
mod picture;
mod probabilities;
mod raster;
mod ros;
mod scanline;
mod union;

use std::fmt;
use std::path::Path;

use crate::shipped::read_at_most;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::terrain::Terrain;
use serde::Serialize;

pub use areas::{Area, Areas, Purpose, Quartiles, Spread};
pub use belief_file::BeliefFile;
pub use earth::Earth;
pub use error::MapFileError;
pub use georeference::{GeoPoint, Georeference};
pub use probabilities::load_probabilities;

/// A map file that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct MapFile {
    /// The map. Row 0, column 0 is its south-western cell.
    pub terrain: Terrain,
    /// Its position on the earth, if the file has one.
    pub georeference: Option<Georeference>,
    /// Its pose in the frame of its file.
    pub origin: MapOrigin,
    /// The areas in its file, besides the ground; empty for formats without areas.
    pub areas: Areas,
    /// Pairs of search areas that share ground, by name, which is searched once.
    pub overlaps: Vec<[String; 2]>,
}

/// Pose of the map's south-western corner in the frame of its file: for a ROS map in the frame `map`. Zero for all
/// others.
///
/// Used for all positions in that frame: in recordings, in exports, and on a robot's own network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MapOrigin {
    /// Meters along the frame's x axis.
    pub x_meters: f64,
    /// Meters along the frame's y axis.
    pub y_meters: f64,
    /// From the frame's x axis to the map's eastern one, counterclockwise, radians.
    pub yaw_radians: f64,
}

impl MapOrigin {
    /// The position of a point of the map in the frame, meters. The point is given by its distance from the corner
    /// along the map's rows and up its columns, meters.
    #[must_use]
    pub fn point(&self, (along_meters, up_meters): (f64, f64)) -> (f64, f64) {
        let (sine, cosine) = self.yaw_radians.sin_cos();
        (
            self.x_meters + (cosine * along_meters - sine * up_meters),
            self.y_meters + (sine * along_meters + cosine * up_meters),
        )
    }

    /// The center of a cell in the frame, meters.
    #[must_use]
    pub fn center(&self, terrain: &Terrain, cell: Cell) -> (f64, f64) {
        self.point(terrain.center_meters(cell))
    }
}

impl fmt::Display for MapOrigin {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { x_meters, y_meters, yaw_radians } = self;
        write!(formatter, "({x_meters}, {y_meters}) m, turned by {yaw_radians} rad")
    }
}

impl MapFile {
    /// The largest file that is read.
    pub const MAX_BYTES: u64 = 1 << 28;

    /// A map without a position on the earth, at the origin of its file's frame.
    #[must_use]
    pub fn unplaced(terrain: Terrain) -> Self {
        Self {
            terrain,
            georeference: None,
            origin: MapOrigin::default(),
            areas: Areas::default(),
            overlaps: Vec::new(),
        }
    }

    /// The same map without the cells that a keep-out mask of Nav2 closes: a file like that of a ROS map, which this is to be.
    ///
    /// # Errors
    /// If the mask, or its image, cannot be read or is invalid; if it is turned against the map, or none of its keep-out
    /// pixels lies on the map.
    pub fn without(self, mask: &Path) -> Result<Self, MapFileError> {
        keepout::close(self, mask)
    }

    /// The map of areas, in cells of edge `cell_meters`, meters; messages name the file.
    ///
    /// # Errors
    /// If no search area is among them, or there would be no cell, or too many.
    pub fn of_areas(file: &Path, areas: Areas, cell_meters: f64) -> Result<Self, MapFileError> {
        outline::map(file, areas, cell_meters)
    }

    /// Reads a map file into cells of edge `cell_meters`, meters. The file's extension determines the format.
    ///
    /// # Errors
    /// If the file, or an image that it names, cannot be read or is invalid; if the edge is not a positive length or is
    /// shorter than the map's pixels; if there would be no cell, or too many.
    pub fn load(file: &Path, cell_meters: f64) -> Result<Self, MapFileError> {
        if !(cell_meters.is_finite() && cell_meters > 0.0) {
            return Err(MapFileError::value(
                file,
                "cell edge",
                cell_meters,
                "a finite length in meters above 0",
            ));
        }
        match Format::of(file) {
            Some(Format::Drawing) => Terrain::from_ascii(&read_text(file)?, cell_meters)
                .map(Self::unplaced)
                .map_err(|source| MapFileError::Terrain { file: file.to_owned(), source }),
            Some(Format::Ros) => ros::load(file, cell_meters),
            Some(Format::MovingAi) => {
                movingai::read(file, &read_text(file)?, cell_meters).map(Self::unplaced)
            }
            Some(Format::Areas) => Self::of_areas(file, Areas::load(file)?, cell_meters),
            None => Err(MapFileError::Extension {
                file: file.to_owned(),
                allowed: ".txt drawing, .yaml ROS map, .map MovingAI, .geojson, .kml, .kmz, .gpx or .plan areas",
            }),
        }
    }
}

/// The grids of a ROS map, by the cells' edge, meters; `None` for edges that it cannot have.
pub(crate) fn grids_of_ros_map(file: &Path) -> Result<impl Fn(f64) -> Option<Grid>, MapFileError> {
    let extent = ros::extent(file)?;
    Ok(move |cell_meters| extent.grid(file, cell_meters).ok())
}

/// The same of areas; `None` without a search area, or if they are too far apart.
pub(crate) fn grids_of_areas(areas: &Areas) -> Option<impl Fn(f64) -> Option<Grid>> {
    outline::grids(areas)
}

/// The format of a map file, by its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// A character for each cell, `.txt`.
    Drawing,
    /// ROS `map_server`, `.yaml`.
    Ros,
    /// `MovingAI`, a character for each cell, `.map`.
    MovingAi,
    /// Areas on the earth, `.geojson`, `.kml`, `.kmz`, `.gpx` and `.plan`.
    Areas,
}

impl Format {
    /// The format of a file; `None` if it has no extension of a map.
    pub(crate) fn of(file: &Path) -> Option<Self> {
        match file.extension()?.to_string_lossy().to_lowercase().as_str() {
            "txt" => Some(Self::Drawing),
            "yaml" | "yml" => Some(Self::Ros),
            "map" => Some(Self::MovingAi),
            "geojson" | "json" | "kml" | "kmz" | "gpx" | "plan" => Some(Self::Areas),
            _ => None,
        }
    }
}

fn read_text(file: &Path) -> Result<String, MapFileError> {
    read_text_at_most(file, MapFile::MAX_BYTES)
}

fn read_text_at_most(file: &Path, bytes: u64) -> Result<String, MapFileError> {
    dragnet_files::text_of(read_bytes_at_most(file, bytes)?)
        .map_err(|source| MapFileError::syntax(file, source))
}

fn read_bytes(file: &Path) -> Result<Vec<u8>, MapFileError> {
    read_bytes_at_most(file, MapFile::MAX_BYTES)
}

fn read_bytes_at_most(file: &Path, bytes: u64) -> Result<Vec<u8>, MapFileError> {
    read_at_most(file, bytes).map_err(|source| MapFileError::Read { file: file.to_owned(), source })
}

#[cfg(test)]
mod tests;
