//! What is wrong with a plan, where, and what comes of its areas.

use std::path::Path;

use dragnet_scenario::map_file::areas::{Claims, Region, Rest};
use dragnet_scenario::map_file::{Areas, GeoPoint, MapFileError, Purpose};
use dragnet_scenario::{Drawn, Invalid, Scenario, ScenarioError, Start, Warning};
use dragnet_search::cell::Position;
use geojson::{Feature, FeatureCollection, GeoJson};
use serde::Serialize;

use crate::MissionPlan;
pub use unseen::Bounds;

mod unseen;

/// The name of the areas in messages, where they have no file.
pub(crate) const DRAWN: &str = "drawn.geojson";

/// What a plan is.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Review {
    /// What must be changed before the plan can be saved, forecast or run; if empty it is a scenario.
    pub problems: Vec<Problem>,
    /// Likely mistakes, and areas without effect.
    pub warnings: Vec<String>,
    /// The cells, of a plan that is a scenario.
    pub size: Option<Size>,
    /// The suggested edge of the cells, meters, if the areas make a map.
    pub suggested_cell_meters: Option<f64>,
    /// What comes of each area.
    pub effects: Vec<Effect>,
    /// `[latitude, longitude]` of the cell in which each robot starts, degrees; `None` for one that is drawn at random.
    pub starts: Vec<Option<[f64; 2]>>,
    /// Searched ground that no robot sees, in rectangles: the largest ones, if they are many.
    pub unseen: Vec<Bounds>,
}

/// Something that must be changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// Where.
    pub at: Place,
    /// What is wrong, and what is allowed.
    pub message: String,
}

/// A place in a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// A feature, by its place in [`MissionPlan::features`].
    Feature(usize),
    /// A setting, by its key in scenarios.
    Key(String),
    /// The areas together.
    Map,
}

/// The cells of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// From south to north.
    pub rows: u32,
    /// From west to east.
    pub columns: u32,
    /// Number of searched cells.
    pub searched: usize,
    /// Number of cells that robots can enter.
    pub traversable: usize,
    /// Searched ground, square meters.
    pub searched_square_meters: f64,
}

/// What comes of an area.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// Its name, or none for the probability outside of all regions.
    pub name: Option<String>,
    /// Its kind, as files name it.
    pub kind: &'static str,
    /// Cells that are searched, closed, or hold the probability.
    pub cells: usize,
    /// Probability of area, 0 to 1, if it has one.
    pub poa: Option<f64>,
}

impl MissionPlan {
    /// What is wrong with the plan, and what comes of its areas.
    #[must_use]
    pub fn review(&self) -> Review {
        let areas = match self.areas() {
            Ok(areas) => areas,
            Err(problems) => return Review { problems, ..Review::default() },
        };
        let suggested_cell_meters = Scenario::cells_of_areas(&areas).map(|(cell_meters, _)| cell_meters);
        if !areas.has_search_area() {
            let message = "no search area yet: draw one, or open a file that has one".to_owned();
            return Review { problems: vec![Problem { at: Place::Map, message }], ..Review::default() };
        }
        match self.scenario_of(areas) {
            Ok(scenario) => Review { suggested_cell_meters, ..Review::of(&scenario) },
            Err(problem) => Review { problems: vec![problem], suggested_cell_meters, ..Review::default() },
        }
    }

    /// The scenario of the plan.
    ///
    /// # Errors
    /// What must be changed first.
    pub fn scenario(&self) -> Result<Scenario, Vec<Problem>> {
        self.scenario_of(self.areas()?).map_err(|problem| vec![problem])
    }

    fn scenario_of(&self, areas: Areas) -> Result<Scenario, Problem> {
        let files = self.files();
        let path = Path::new(&files.scenario_name);
        Scenario::from_text_and_areas(path, files.scenario_text, areas)
            .map_err(|error| Problem::of_scenario(&error))
    }
}

impl Review {
    fn of(scenario: &Scenario) -> Self {
        let drawn = scenario.drawn();
        let terrain = scenario.terrain();
        let searched = terrain.searched_cells().count();
        let frame = scenario.georeference();
        let start = |robot: &dragnet_scenario::Robot| match (robot.start, frame) {
            (Start::Cell(cell), Some(frame)) => {
                let GeoPoint { latitude_degrees, longitude_degrees } =
                    frame.point(terrain.center_meters(cell));
                Some([latitude_degrees, longitude_degrees])
            }
            _ => None,
        };
        // A map in a browser has no cells to point at.
        let place = |at: Position| {
            let cell = terrain.grid().cell(at);
            let point = cell.zip(frame).map(|(cell, frame)| frame.point(terrain.center_meters(cell)));
            point.map_or_else(String::new, |GeoPoint { latitude_degrees, longitude_degrees }| {
                format!("at {latitude_degrees:.5}, {longitude_degrees:.5}")
            })
        };
        let warnings = scenario.warnings_with(&drawn);
        let unseen = warnings.iter().find_map(|warning| match warning {
            Warning::Unseen { cells, .. } => Some(unseen::bounds(cells, terrain, frame?)),
            _ => None,
        });
        Self {
            problems: Vec::new(),
            warnings: warnings.iter().map(|warning| warning.written(place)).collect(),
            size: Some(Size {
                rows: terrain.grid().rows(),
                columns: terrain.grid().columns(),
                searched,
                traversable: terrain.traversable_cells().count(),
                searched_square_meters: searched as f64 * terrain.cell_meters().powi(2),
            }),
            suggested_cell_meters: None,
            effects: effects(drawn, scenario.claims()),
            starts: scenario.robots().iter().map(start).collect(),
            unseen: unseen.unwrap_or_default(),
        }
    }
}

fn effects(drawn: Vec<Drawn>, claims: Option<&Claims>) -> Vec<Effect> {
    let of_ground = drawn.into_iter().map(|Drawn { name, kind, cells, .. }| Effect {
        name: Some(name),
        kind,
        cells,
        poa: None,
    });
    let of_regions = claims.into_iter().flat_map(|Claims { regions, rest }| {
        let region = |Region { name, poa, cells, .. }: &Region| Effect {
            name: Some(name.clone()),
            kind: "prior",
            cells: *cells,
            poa: Some(*poa),
        };
        let &Rest { poa, cells } = rest;
        let rest = Effect { name: None, kind: "prior", cells, poa: Some(poa) };
        regions.iter().map(region).chain(std::iter::once(rest)).collect::<Vec<_>>()
    });
    of_ground.chain(of_regions).collect()
}

impl Problem {
    pub(crate) fn of_map(error: &MapFileError) -> Self {
        Self { at: Place::Map, message: plain(error) }
    }

    /// At the setting that is wrong, where that is known.
    fn of_scenario(error: &ScenarioError) -> Self {
        match error {
            ScenarioError::Value { invalid: Invalid { key, found, allowed }, .. } if key == "map" => {
                Self { at: Place::Map, message: format!("the map is {found}; allowed is {allowed}") }
            }
            // Keys mean nothing to who sees fields.
            ScenarioError::Value { invalid: Invalid { key, .. }, .. } if key == "mission" => Self {
                at: Place::Key(key.clone()),
                message:
                    "a mission ends: allowed is a time budget, a distance that each robot can drive, or both"
                        .to_owned(),
            },
            ScenarioError::Value { invalid: Invalid { key, found, allowed }, .. } => Self {
                at: Place::Key(key.clone()),
                message: format!("{found} is not possible; allowed is {allowed}"),
            },
            ScenarioError::MapFile { source, .. } | ScenarioError::Map(source) => Self::of_map(source),
            other => Self { at: Place::Map, message: other.to_string() },
        }
    }
}

/// A message without the name of a file that does not exist.
fn plain(error: &MapFileError) -> String {
    match error {
        MapFileError::Value { place, found, allowed, .. } => {
            format!("{place} is {found}; allowed is {allowed}")
        }
        MapFileError::Syntax { message, .. } => message.clone(),
        MapFileError::Terrain { source, .. } => source.to_string(),
        other => other.to_string(),
    }
}

/// The area of a feature, or what is wrong with it.
pub(crate) fn area(feature: &Feature) -> Result<Areas, String> {
    /// As the reader names the only feature of a file.
    const ONLY: &str = "feature 1";
    let of_one = FeatureCollection { bbox: None, features: vec![feature.clone()], foreign_members: None };
    let text = GeoJson::FeatureCollection(of_one).to_string();
    let areas = Areas::from_geojson(Path::new(DRAWN), &text).map_err(|error| {
        let message = plain(&error);
        message
            .strip_prefix(ONLY)
            .map_or(message.clone(), |rest| rest.trim_start_matches([' ', ',']).to_owned())
    })?;
    match areas.left_out.first() {
        Some(name) => Err(format!(
            "{name} has no meaning for a search; allowed are the kinds {}",
            Purpose::KINDS.join(", ")
        )),
        None => Ok(areas),
    }
}

#[cfg(test)]
mod tests;
