//! A mission's position on the earth, as stored in its recording.

use std::collections::BTreeMap;
use std::path::Path;

use super::areas::{Area, Areas};
use super::georeference::{GeoPoint, Georeference};

/// A mission's position on the earth.
#[derive(Clone, Debug, PartialEq)]
pub struct Earth {
    /// The frame of its map.
    pub frame: Georeference,
    /// The areas drawn on the map.
    pub areas: Vec<Area>,
    /// Total number of expected objects, to which probabilities of area refer.
    pub expected_objects: f64,
}

const LATITUDE: &str = "south_west_latitude_degrees";
const LONGITUDE: &str = "south_west_longitude_degrees";
const REFERENCE: &str = "reference_latitude_degrees";
const OBJECTS: &str = "expected_objects";

impl Earth {
    /// All fields except the areas, as text by name.
    #[must_use]
    pub fn facts(&self) -> BTreeMap<String, String> {
        let corner = self.frame.south_west();
        let facts = [
            (LATITUDE, corner.latitude_degrees),
            (LONGITUDE, corner.longitude_degrees),
            (REFERENCE, self.frame.reference_latitude_degrees()),
            (OBJECTS, self.expected_objects),
        ];
        facts.into_iter().map(|(name, number)| (name.to_owned(), number.to_string())).collect()
    }

    /// The areas as a `GeoJSON` text.
    #[must_use]
    pub fn areas_geojson(&self) -> String {
        Areas { areas: self.areas.clone(), ..Areas::default() }.to_geojson()
    }

    /// Reads the texts of [`Earth::facts`] and [`Earth::areas_geojson`].
    ///
    /// # Errors
    /// If a fact is missing or invalid, or the text holds no areas.
    pub fn read(facts: &BTreeMap<String, String>, areas_geojson: &str) -> Result<Self, String> {
        let frame = Self::read_frame(facts)?;
        let areas = Areas::from_geojson(Path::new("areas.geojson"), areas_geojson);
        Ok(Self {
            frame,
            areas: areas.map_err(|error| error.to_string())?.areas,
            expected_objects: number(facts, OBJECTS)?,
        })
    }

    /// Reads the map's frame of the texts of [`Earth::facts`] alone.
    ///
    /// # Errors
    /// If one of its facts is missing or invalid.
    pub fn read_frame(facts: &BTreeMap<String, String>) -> Result<Georeference, String> {
        let (latitude, longitude) = (number(facts, LATITUDE)?, number(facts, LONGITUDE)?);
        let reference = number(facts, REFERENCE)?;
        let corner = GeoPoint::checked(longitude, latitude)
            .filter(|_| GeoPoint::checked(longitude, reference).is_some())
            .ok_or_else(|| format!("a map at {latitude}, {longitude}; allowed is {}", GeoPoint::ALLOWED))?;
        Ok(Georeference::new(corner, reference))
    }
}

fn number(facts: &BTreeMap<String, String>, name: &str) -> Result<f64, String> {
    let text = facts.get(name).map_or("missing", String::as_str);
    text.parse().map_err(|_| format!("{name} is {text:?}; allowed is a number"))
}
