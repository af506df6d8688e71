//! The plan of a mission: what a page shows and changes.

use std::path::{Path, PathBuf};

use dragnet_files::in_words;
use dragnet_scenario::file::{PolicyField, RobotTable, ScenarioFile, StartField};
use dragnet_scenario::map_file::{Area, Areas, Purpose};
use dragnet_scenario::{Scenario, Start, toml_text};
use geojson::Feature;
use serde::{Deserialize, Serialize};

use crate::review::{Place, Problem};

/// The name of a plan that has none yet.
const USUAL_NAME: &str = "search";

/// The plan of a mission: a scenario, and the areas of its map. Both may be invalid; a [`Review`](crate::Review) says
/// where.
///
/// The settings are those of a scenario file, under the same keys, so that nothing is checked twice and a scenario that
/// is planned further loses nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MissionPlan {
    /// The settings. `map.file` is set when the plan is [written](crate::written).
    pub scenario: ScenarioFile,
    /// Whether `map.cell_meters` is the edge that is suggested for the areas.
    pub is_cell_suggested: bool,
    /// Areas and places as `GeoJSON` features, by the convention of map files. The kth one of kind `start` is where
    /// robot k starts.
    pub features: Vec<Feature>,
}

/// Why something cannot be planned.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The plan is not in the format of [`MissionPlan`].
    #[error("{key}: {message}")]
    Format {
        /// The key.
        key: String,
        /// What is wrong.
        message: String,
    },
    /// A scenario whose map is not drawn on the earth.
    #[error(
        "{}: its map is not drawn on the earth; allowed are areas (.geojson, .kml) and scenarios that name such a file",
        .0.display()
    )]
    NotOnEarth(PathBuf),
    /// The assumptions for areas are no scenario, which is a mistake of this program.
    #[error("no scenario for these areas: {0}")]
    Assumptions(String),
}

impl MissionPlan {
    /// A plan for areas alone, or for none: all else is assumed as `dragnet run AREAS` does.
    ///
    /// # Errors
    /// Never, unless what is assumed is no scenario.
    pub fn of_areas(name: &str, areas: &Areas) -> Result<Self, PlanError> {
        let name = if name.is_empty() { USUAL_NAME } else { name };
        let text = Scenario::text_of_areas(areas, name, "");
        let scenario = toml_text::read(&text).map_err(|error| PlanError::Assumptions(error.to_string()))?;
        Ok(Self {
            scenario,
            is_cell_suggested: true,
            features: areas.areas.iter().map(Area::feature).collect(),
        })
    }

    /// The plan of a scenario. Starts become features, and files that it names become absolute, so that it can be
    /// written elsewhere.
    ///
    /// # Errors
    /// If its map is not drawn on the earth.
    pub fn of_scenario(scenario: &Scenario) -> Result<Self, PlanError> {
        let path = &scenario.source().path;
        let mut areas = scenario.areas().areas;
        let is_drawn = areas.iter().any(|area| matches!(area.purpose, Purpose::Search(_)));
        if !is_drawn || scenario.origin() != dragnet_scenario::map_file::MapOrigin::default() {
            return Err(PlanError::NotOnEarth(path.clone()));
        }
        let mut file = scenario.file().clone();
        if let Some(starts) = starts(scenario) {
            areas.retain(|area| !matches!(area.purpose, Purpose::Start(_)));
            areas.extend(starts);
            if !matches!(file.robots.start, Some(StartField::Word(_))) {
                file.robots.start = None;
            }
            for robot in &mut file.robots.robot {
                robot.start = None;
            }
            file.robots.robot.retain(|robot| robot.policy.is_some() || robot.class.is_some());
        }
        // Its regions are among the areas now.
        if scenario.claims().is_some() {
            file.prior.file = None;
        }
        settle_paths(&mut file, path.parent().unwrap_or(Path::new("")));
        let features = areas.iter().map(Area::feature).collect();
        let is_cell_suggested = Scenario::cells_of_areas(&scenario.areas())
            .is_some_and(|(cell_meters, _)| cell_meters.to_bits() == file.map.cell_meters.to_bits());
        Ok(Self { scenario: file, is_cell_suggested, features })
    }

    /// A plan from JSON.
    ///
    /// # Errors
    /// If it is not in the format of a plan; the message names the key.
    pub fn from_json(json: serde_json::Value) -> Result<Self, PlanError> {
        serde_path_to_error::deserialize(json).map_err(|error| PlanError::Format {
            key: error.path().to_string(),
            message: in_words(&error.inner().to_string()),
        })
    }

    /// The plan as changed by a page. What a page does not show stays as it is: above all the files that a scenario
    /// names, so that no page makes the program read or write others.
    #[must_use]
    pub fn changed(&self, sent: Self) -> Self {
        let mut kept = self.scenario.clone();
        let ScenarioFile { name, map, sensor, objects, prior, robots, mission, .. } = sent.scenario;
        kept.name = name;
        kept.map.cell_meters = map.cell_meters;
        kept.map.connectivity = map.connectivity;
        kept.sensor = sensor;
        kept.objects = objects;
        kept.prior.rest_of_world = prior.rest_of_world;
        kept.mission = mission;
        kept.robots.count = robots.count;
        kept.robots.start = robots.start;
        if matches!(robots.policy, PolicyField::Name(_)) {
            kept.robots.policy = robots.policy;
        }
        Self { scenario: kept, ..sent }
    }

    /// Adds areas.
    pub fn add(&mut self, areas: &Areas) {
        self.features.extend(areas.areas.iter().map(Area::feature));
    }

    /// The plan with the edge that is suggested for its areas, if it follows the suggestion and there is one.
    #[must_use]
    pub fn settled(mut self) -> Self {
        if self.is_cell_suggested
            && let Some((cell_meters, side)) = self.areas().ok().as_ref().and_then(Scenario::cells_of_areas)
        {
            self.scenario.map.cell_meters = cell_meters;
            self.scenario.sensor.radius = self.scenario.sensor.radius.min(side.into());
        }
        self
    }

    /// The areas.
    ///
    /// # Errors
    /// The problems of the features.
    pub fn areas(&self) -> Result<Areas, Vec<Problem>> {
        let mut areas = Areas::default();
        let mut problems = Vec::new();
        for (number, feature) in self.features.iter().enumerate() {
            match crate::review::area(feature) {
                Ok(one) => areas.areas.extend(one.areas),
                Err(message) => problems.push(Problem { at: Place::Feature(number), message }),
            }
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        // The limits of a file, of all together.
        Areas::from_geojson(Path::new(crate::review::DRAWN), &areas.to_geojson())
            .map_err(|error| vec![Problem::of_map(&error)])
    }
}

/// The start of each robot as a place, if all start in cells of their own.
fn starts(scenario: &Scenario) -> Option<Vec<Area>> {
    let file = scenario.file();
    let is_own = |robot: &RobotTable| robot.start.is_some();
    if file.robots.start.is_none() && !file.robots.robot.iter().any(is_own) {
        return None;
    }
    let frame = scenario.georeference()?;
    let place = |robot: &dragnet_scenario::Robot| match robot.start {
        Start::Cell(cell) => Some(Area {
            name: format!("Start {}", robot.id),
            purpose: Purpose::Start(frame.point(scenario.terrain().center_meters(cell))),
        }),
        _ => None,
    };
    scenario.robots().iter().map(place).collect()
}

/// Files that a scenario names, besides its map, are relative to its folder.
fn settle_paths(file: &mut ScenarioFile, folder: &Path) {
    let settle = |path: &mut Option<String>| {
        let absolute = path.as_ref().and_then(|path| std::path::absolute(folder.join(path)).ok());
        if let Some(absolute) = absolute.as_deref().and_then(Path::to_str) {
            *path = Some(absolute.to_owned());
        }
    };
    settle(&mut file.prior.file);
    settle(&mut file.zenoh.config);
    let own = file.robots.robot.iter_mut().filter_map(|robot| robot.policy.as_mut());
    for policy in own.chain(std::iter::once(&mut file.robots.policy)) {
        if let PolicyField::Table(table) = policy {
            settle(&mut table.weights);
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
