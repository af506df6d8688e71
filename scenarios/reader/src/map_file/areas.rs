//! Areas and places drawn on the earth: search areas, no-go areas, and likely positions. Read from `GeoJSON`, KML, KMZ,
//! GPX, and plans of `QGroundControl`, WGS84 degrees; `docs/maps.md` explains the convention.
//!
//! A file of any of these formats becomes features, and each of these an [`Area`], or is ignored. Areas are checked once,
//! here: rings are closed, cross nothing, and lie on the earth; small faults are mended.

mod by_distance;
mod closed;
mod description;
mod feature;
mod geojson;
mod gpx;
mod kind;
mod kml;
mod kmz;
mod plan;
mod prior;
mod quartiles;
mod rings;
mod unique;

use std::path::Path;

use geo::{MultiLineString, MultiPolygon};

use super::georeference::GeoPoint;
use super::{Format, MapFileError};

pub use prior::{Claims, Region, RegionPrior, Rest, Weights};
pub use quartiles::Quartiles;

pub(super) use prior::rings;

/// The most corners of all areas together: validation compares each edge of a ring with each other.
const MAX_CORNERS: usize = 20_000;
/// The most rings, holes included: validation compares each hole with each other.
const MAX_RINGS: usize = 1_000;
/// The most features of one file, including ignored ones.
const MAX_FEATURES: usize = 10_000;

/// The contents of a file of areas.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Areas {
    /// In the order of the file.
    pub areas: Vec<Area>,
    /// Ignored features, by name or position in the file, and ignored shapes of areas, such as `1 point of A`; what an
    /// export has added to its areas counts together.
    pub left_out: Vec<String>,
    /// Number of features that an export has added to the areas of its mission.
    pub(crate) results: usize,
    /// Polygons with a fault that changed less than a thousandth of their area, and are read without it: place and fault.
    pub mended: Vec<String>,
}

/// An area or a place on the earth.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Its name or, without one, its position in the file.
    pub name: String,
    /// Its purpose.
    pub purpose: Purpose,
}

/// The purpose of an area. Coordinates are `(longitude, latitude)` in degrees of WGS84; polygons are valid.
#[derive(Clone, Debug, PartialEq)]
pub enum Purpose {
    /// Objects are searched inside.
    Search(MultiPolygon<f64>),
    /// Robots enter no cell that it touches; such cells of the search area are still searched, from outside.
    NoGo(MultiPolygon<f64>, MultiLineString<f64>),
    /// The object is inside with this probability, uniformly distributed.
    Prior {
        /// The region.
        region: MultiPolygon<f64>,
        /// Probability of area, a share from 0 to 1.
        poa: f64,
    },
    /// The object is around a place with this probability.
    LastKnownPosition {
        /// The place.
        point: GeoPoint,
        /// How its distance is distributed.
        spread: Spread,
        /// Probability of area, a share from 0 to 1.
        poa: f64,
    },
    /// The object is near lines, such as trails, roads or drainage, with this probability.
    LinearFeature {
        /// The lines.
        lines: MultiLineString<f64>,
        /// How its distance from the nearest of them is distributed, the track offset.
        quartiles: Quartiles,
        /// Probability of area, a share from 0 to 1.
        poa: f64,
    },
    /// Robots start here.
    Start(GeoPoint),
}

/// The distribution of the object around a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// Normal, with this standard deviation to the east and to the north, meters.
    Normal(f64),
    /// By quartiles of its distance, in all directions alike.
    Quartiles(Quartiles),
}

impl Areas {
    /// The longest text that is read, bytes.
    pub const MAX_BYTES: u64 = 1 << 24;

    /// Whether a file contains areas, by its extension.
    #[must_use]
    pub fn is_file(file: &Path) -> bool {
        Format::of(file) == Some(Format::Areas)
    }

    /// Whether one of them is searched.
    #[must_use]
    pub fn has_search_area(&self) -> bool {
        self.areas.iter().any(|area| matches!(area.purpose, Purpose::Search(_)))
    }

    /// Only the areas with a probability; the others count as ignored.
    pub(crate) fn likely_ones(self) -> Self {
        let (areas, others): (Vec<Area>, Vec<Area>) =
            self.areas.into_iter().partition(|area| area.purpose.poa().is_some());
        let left_out = self.left_out.into_iter().chain(others.into_iter().map(|area| area.name)).collect();
        Self { areas, left_out, ..self }
    }

    /// Reads a file.
    pub(crate) fn load(file: &Path) -> Result<Self, MapFileError> {
        Self::from_bytes(file, super::read_bytes_at_most(file, Self::MAX_BYTES)?)
    }

    /// Areas of the content of a file, which need not be on this computer's disk. Its name's extension determines the
    /// format, and messages name it.
    ///
    /// # Errors
    /// If the extension is not that of areas, the content is longer than [`Areas::MAX_BYTES`] or is not text, or as
    /// [`Areas::from_geojson`] and [`Areas::from_kml`].
    pub fn from_bytes(file: &Path, bytes: Vec<u8>) -> Result<Self, MapFileError> {
        Self::valid_from_bytes(file, bytes).and_then(whole)
    }

    /// The valid areas of a file like [`Areas::from_bytes`], and what is wrong with each of the others: for a person who
    /// sees what is missing, and draws it anew.
    ///
    /// # Errors
    /// As [`Areas::from_bytes`], but for invalid areas.
    pub fn valid_from_bytes(
        file: &Path,
        mut bytes: Vec<u8>,
    ) -> Result<(Self, Vec<MapFileError>), MapFileError> {
        if !Self::is_file(file) {
            let allowed = ".geojson, .json, .kml, .kmz, .gpx or .plan areas";
            return Err(MapFileError::Extension { file: file.to_owned(), allowed });
        }
        if bytes.len() as u64 > Self::MAX_BYTES {
            let (found, allowed) = (format!("{} bytes", bytes.len()), format!("at most {}", Self::MAX_BYTES));
            return Err(MapFileError::value(file, "the size", found, allowed));
        }
        let is = |name: &str| file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(name));
        if is("kmz") {
            bytes = kmz::kml(file, &bytes)?;
        }
        if is("kml") || is("kmz") {
            return Self::of(file, kml::features(file, &kml::decoded(file, bytes)?)?);
        }
        if is("gpx") {
            return Self::of(file, gpx::features(file, &kml::decoded(file, bytes)?)?);
        }
        let text = dragnet_files::text_of(bytes).map_err(|source| MapFileError::syntax(file, source))?;
        if is("plan") {
            return Self::of(file, plan::features(file, &text)?);
        }
        Self::of(file, geojson::features(file, &text)?)
    }

    /// Areas of a `GeoJSON` text (RFC 7946); messages name the file.
    ///
    /// # Errors
    /// If the text is not `GeoJSON`, or a feature is invalid for its kind.
    pub fn from_geojson(file: &Path, text: &str) -> Result<Self, MapFileError> {
        Self::of(file, geojson::features(file, text)?).and_then(whole)
    }

    /// Areas of a KML text (OGC 2.2 and 2.3); messages name the file.
    ///
    /// # Errors
    /// If the text is not KML, or a placemark is invalid for its kind.
    pub fn from_kml(file: &Path, text: &str) -> Result<Self, MapFileError> {
        Self::of(file, kml::features(file, text)?).and_then(whole)
    }

    fn of(file: &Path, features: Vec<feature::Feature>) -> Result<(Self, Vec<MapFileError>), MapFileError> {
        check_number(file, "features", features.len(), MAX_FEATURES)?;
        let shapes = || features.iter().map(|feature| &feature.shapes);
        check_number(file, "corners", shapes().map(feature::Shapes::corner_count).sum(), MAX_CORNERS)?;
        check_number(file, "rings", shapes().map(feature::Shapes::ring_count).sum(), MAX_RINGS)?;
        let (mut read, mut invalid) = (Self::default(), Vec::new());
        for feature in features {
            match kind::area(file, &feature, &mut read.mended) {
                Err(error) => invalid.push(error),
                Ok(Some(area)) => {
                    let beside = feature.shapes.beside(&area.purpose);
                    read.left_out.extend(beside.map(|shapes| format!("{shapes} of {}", area.name)));
                    read.areas.push(area);
                }
                Ok(None) if kind::is_result(&feature) => read.results += 1,
                Ok(None) => read.left_out.push(feature.name.unwrap_or(feature.place)),
            }
        }
        match read.results {
            0 => {}
            1 => read.left_out.push("1 result of an earlier search".to_owned()),
            results => read.left_out.push(format!("{results} results of an earlier search")),
        }
        Ok((read, invalid))
    }

    /// The areas as a `GeoJSON` text; [`Areas::from_geojson`] returns equal areas. Ignored features are left out.
    #[must_use]
    pub fn to_geojson(&self) -> String {
        geojson::text(&self.areas)
    }
}

impl Area {
    /// The area as a `GeoJSON` feature; reading it returns an equal area.
    #[must_use]
    pub fn feature(&self) -> ::geojson::Feature {
        geojson::feature_of(self)
    }
}

impl Purpose {
    /// The kind of search areas, as files name it.
    pub const SEARCH: &str = kind::SEARCH;
    /// All kinds, as files name them.
    pub const KINDS: [&str; 6] = [
        kind::SEARCH,
        kind::NO_GO,
        kind::PRIOR,
        kind::LAST_KNOWN_POSITION,
        kind::LINEAR_FEATURE,
        kind::START,
    ];

    /// The probability of area, if it has one.
    #[must_use]
    pub const fn poa(&self) -> Option<f64> {
        match self {
            Self::Prior { poa, .. }
            | Self::LastKnownPosition { poa, .. }
            | Self::LinearFeature { poa, .. } => Some(*poa),
            Self::Search(_) | Self::NoGo(..) | Self::Start(_) => None,
        }
    }

    /// Its kind as files name it.
    #[must_use]
    pub const fn word(&self) -> &'static str {
        match self {
            Self::Search(_) => kind::SEARCH,
            Self::NoGo(..) => kind::NO_GO,
            Self::Prior { .. } => kind::PRIOR,
            Self::LastKnownPosition { .. } => kind::LAST_KNOWN_POSITION,
            Self::LinearFeature { .. } => kind::LINEAR_FEATURE,
            Self::Start(_) => kind::START,
        }
    }

    /// Its polygons; empty for a place and for lines.
    #[must_use]
    pub fn polygons(&self) -> &[geo::Polygon<f64>] {
        match self {
            Self::Search(polygons) | Self::NoGo(polygons, _) => &polygons.0,
            Self::Prior { region, .. } => &region.0,
            Self::LastKnownPosition { .. } | Self::LinearFeature { .. } | Self::Start(_) => &[],
        }
    }

    /// Its lines; empty for all but no-go areas and linear features.
    #[must_use]
    pub fn lines(&self) -> &[geo::LineString<f64>] {
        match self {
            Self::NoGo(_, lines) | Self::LinearFeature { lines, .. } => &lines.0,
            Self::Search(_) | Self::Prior { .. } | Self::LastKnownPosition { .. } | Self::Start(_) => &[],
        }
    }

    /// The properties by which a file says how likely distances are, with their keys.
    #[must_use]
    pub fn distances(&self) -> Option<(&'static str, String)> {
        match self {
            Self::LastKnownPosition { spread: Spread::Normal(meters), .. } => {
                Some((feature::Facts::SPREAD, meters.to_string()))
            }
            Self::LastKnownPosition { spread: Spread::Quartiles(quartiles), .. }
            | Self::LinearFeature { quartiles, .. } => {
                Some((feature::Facts::QUARTILES, quartiles.to_string()))
            }
            Self::Search(_) | Self::NoGo(..) | Self::Prior { .. } | Self::Start(_) => None,
        }
    }
}

/// All areas, if they are valid.
fn whole((areas, invalid): (Areas, Vec<MapFileError>)) -> Result<Areas, MapFileError> {
    invalid.into_iter().next().map_or(Ok(areas), Err)
}

fn check_number(file: &Path, what: &str, number: usize, most: usize) -> Result<(), MapFileError> {
    if number <= most {
        return Ok(());
    }
    let allowed = format!("at most {most}: merge or simplify what is drawn");
    Err(MapFileError::value(file, format!("number of {what}"), number, allowed))
}

#[cfg(test)]
mod tests;
