//! Settings of processes: participant, mission and endpoints.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dragnet_agent::agent::AgentConfig;
use dragnet_export::cot::NotOnEarth;
use dragnet_files::read_text_at_most;
use dragnet_lattice::costmap::CostMap;
use dragnet_proto::key::Mission;
use dragnet_ros2::output::OutputKind;
use dragnet_scenario::Scenario;
use dragnet_scenario::toml_text::{self, TextError};
use dragnet_search::terrain::Terrain;
use dragnet_vehicle::pilot::Pilot;
use dragnet_vehicle::settings::{Measured, MotionTable, Settings as VehicleSettings};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::session::Endpoints;
use crate::vehicle::detector;
use crate::{RuntimeError, mavlink, ros, tak};

/// Settings that every process of a mission has.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Common {
    /// Name of the mission: 1 to 64 of `a-z`, `0-9`, `_` and `-`. Processes of other missions are ignored.
    #[schemars(extend("examples" = ["valley"]))]
    pub mission: String,
    /// The scenario file, relative to this one.
    #[schemars(extend("examples" = ["valley.toml"]))]
    pub scenario: PathBuf,
    /// Seed of random choices, 0 to 18446744073709551615.
    #[serde(default)]
    pub seed: u64,
    /// Text of the scenario, instead of the file's; files that it names are relative to that file.
    #[serde(default)]
    pub scenario_text: Option<String>,
    /// What an earlier search believed in the end, the prior where both search: its recording (`.mcap`) or a belief file
    /// (`.belief.json`), relative to this file; the same in all processes of a mission.
    #[serde(default)]
    pub prior_from: Option<PathBuf>,
    /// Mission seconds per second, 0.001 to 10000; the same in all processes of a mission.
    #[serde(default = "one")]
    pub real_time_factor: f64,
    /// The session with the team.
    #[serde(default)]
    pub zenoh: Endpoints,
}

/// Settings of one robot's process: `dragnet agent`.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AgentSettings {
    /// The robot's number in the scenario, from 1.
    #[schemars(extend("examples" = [1]))]
    pub robot: u16,
    /// The source of time.
    #[serde(default)]
    pub time: TimeSource,
    /// Whether to stop when standard input closes, as when the parent process ends.
    #[serde(default)]
    pub attached: bool,
    /// The robot's journal, relative to this file: from it a robot that restarts goes on. The default is
    /// `MISSION-robot-NUMBER.journal` beside this file; in simulated time there is none.
    #[serde(default)]
    pub journal: Option<PathBuf>,
    /// The robot's vehicle; without it the robot is simulated by `dragnet sim`.
    #[serde(default)]
    pub vehicle: Option<VehicleSettings>,
    /// The ROS 2 network of the vehicle.
    #[serde(default)]
    pub ros: Option<ros::settings::Settings>,
    /// The autopilot of the vehicle, instead of a ROS 2 network.
    #[serde(default)]
    pub mavlink: Option<mavlink::settings::Settings>,
    /// A detector for the images of the vehicle's cameras.
    #[serde(default)]
    pub detector: Option<detector::Settings>,
    /// Settings of every process.
    pub common: Common,
}

/// A robot's vehicle, checked.
#[derive(Clone, Debug)]
pub enum OwnVehicle {
    /// On a ROS 2 network.
    Ros(Box<Body>),
    /// Behind an autopilot.
    Mavlink(Box<MavlinkBody>),
}

/// A vehicle behind an autopilot, checked.
#[derive(Clone, Debug)]
pub struct MavlinkBody {
    /// Its autopilot.
    pub mavlink: mavlink::settings::Checked,
    /// Its pilot.
    pub pilot: Pilot,
}

/// A vehicle on a ROS 2 network, checked.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its network.
    pub ros: ros::settings::Checked,
    /// Its pilot.
    pub pilot: Pilot,
    /// The output that moves the vehicle.
    pub moved_by: OutputKind,
    /// The detector for the cameras' images.
    pub detector: Option<detector::Settings>,
}

/// The source of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeSource {
    /// The wall clock.
    #[default]
    Wall,
    /// The simulator, event by event.
    Simulator,
}

/// Settings of the coordinator's process: `dragnet coordinator`.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoordinatorSettings {
    /// The recording, relative to the working directory; if it exists, a number is added. Without it nothing is recorded.
    #[serde(default)]
    pub recording: Option<PathBuf>,
    /// The live page; without it there is none.
    #[serde(default)]
    pub live: Option<dragnet_live::page::Settings>,
    /// The mission for Foxglove and other clients of its WebSocket protocol; without it there is none.
    #[serde(default)]
    pub foxglove: Option<dragnet_live::foxglove::Settings>,
    /// The mission on the maps of TAK (ATAK, WinTAK, iTAK); without it nothing is sent there.
    #[serde(default)]
    pub tak: Option<tak::settings::Settings>,
    /// Settings of every process.
    pub common: Common,
}

/// Settings of the simulated world's process: `dragnet sim`.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimSettings {
    /// Name of the mission: 1 to 64 of `a-z`, `0-9`, `_` and `-`. Processes of other missions are ignored.
    #[schemars(extend("examples" = ["valley"]))]
    pub mission: String,
    /// Seed of objects, starts and noise, 0 to 18446744073709551615.
    #[serde(default)]
    pub seed: u64,
    /// Mission seconds per second, 0.001 to 10000; the same in all processes of a mission.
    #[serde(default = "one")]
    pub real_time_factor: f64,
    /// The session with the team.
    #[serde(default)]
    pub zenoh: Endpoints,
}

/// The maximum size of settings, bytes: with the text of a scenario in them, quoted.
const MAX_SETTINGS_BYTES: u64 = 4 * Scenario::MAX_BYTES as u64;
/// The maximum size of a file of motion primitives, bytes.
const MAX_PRIMITIVES_BYTES: u64 = 1 << 26;

const fn one() -> f64 {
    1.0
}

/// Reads settings from a TOML file.
///
/// # Errors
/// If it cannot be read or is invalid: with the line and the key.
pub fn load<T: DeserializeOwned + Serialize>(file: &Path) -> Result<T, RuntimeError> {
    let failed = |reason: String| RuntimeError::Settings { file: file.to_owned(), reason };
    let text = read_text_at_most(file, MAX_SETTINGS_BYTES).map_err(|error| failed(error.to_string()))?;
    toml_text::read(&text).map_err(|error| {
        let is_scenario = toml_text::has_key(&text, "map");
        let note =
            "this file holds no settings: it is a scenario, which run reads and settings name as common.scenario";
        let TextError { line, message } = if is_scenario { error.with(note) } else { error };
        let file = file.display();
        let place = line.map_or_else(|| file.to_string(), |line| format!("{file}, line {line}"));
        RuntimeError::SettingsText { place, message }
    })
}

/// Settings that have been checked.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The mission.
    pub mission: Mission,
    /// The scenario, as changed by the settings.
    pub scenario: Scenario,
}

impl AgentSettings {
    /// The path of the robot's journal. `file` is the file of the settings.
    #[must_use]
    pub fn journal(&self, file: &Path) -> PathBuf {
        let folder = file.parent().unwrap_or(Path::new(""));
        match &self.journal {
            Some(journal) => folder.join(journal),
            None => folder.join(format!("{}-robot-{}.journal", self.common.mission, self.robot)),
        }
    }
}

impl AgentSettings {
    /// The robot's configuration.
    ///
    /// # Errors
    /// If the scenario has no such robot.
    pub fn agent_config(&self, file: &Path, scenario: &Scenario) -> Result<AgentConfig, RuntimeError> {
        let robot = self.robot;
        let agent_config = AgentConfig::of_team(scenario, self.common.seed);
        agent_config.into_iter().find(|agent_config| agent_config.robot.id.number() == robot).ok_or_else(
            || {
                let reason = format!("robot is {robot}; allowed is from 1 to {}", scenario.robots().len());
                RuntimeError::Settings { file: file.to_owned(), reason }
            },
        )
    }

    /// The robot's vehicle, if the settings have one. `file` is the file of the settings.
    ///
    /// # Errors
    /// If a value is invalid, or vehicle, network and scenario do not match: with the key and the allowed values.
    pub fn vehicle(&self, file: &Path, scenario: &Scenario) -> Result<Option<OwnVehicle>, RuntimeError> {
        let failed =
            |reason: &str| RuntimeError::Settings { file: file.to_owned(), reason: reason.to_owned() };
        let own = match (&self.vehicle, &self.ros, &self.mavlink) {
            (None, None, None) if self.detector.is_some() => {
                return Err(failed("[detector] needs a [vehicle]"));
            }
            (None, None, None) => return Ok(None),
            (Some(_), None, None) => {
                return Err(failed("[vehicle] needs its network, [ros], or its autopilot, [mavlink]"));
            }
            (Some(_), Some(_), Some(_)) => {
                return Err(failed(
                    "[ros] and [mavlink]: allowed is one of the two, which moves the vehicle",
                ));
            }
            (None, Some(_), _) => return Err(failed("[ros] is the network of a [vehicle]")),
            (None, None, Some(_)) => return Err(failed("[mavlink] is the autopilot of a [vehicle]")),
            (Some(vehicle), Some(ros), None) => {
                OwnVehicle::Ros(Box::new(self.ros_body(vehicle, ros, file, scenario)?))
            }
            (Some(vehicle), None, Some(mavlink)) => {
                OwnVehicle::Mavlink(Box::new(self.mavlink_body(vehicle, mavlink, file, scenario)?))
            }
        };
        if self.time == TimeSource::Simulator || self.common.real_time_factor.to_bits() != 1.0_f64.to_bits() {
            let reason = "a [vehicle] lives by the wall clock: allowed are time = 'wall' and common.real_time_factor = 1";
            return Err(failed(reason));
        }
        Ok(Some(own))
    }

    fn ros_body(
        &self,
        vehicle: &VehicleSettings,
        ros: &ros::settings::Settings,
        file: &Path,
        scenario: &Scenario,
    ) -> Result<Body, RuntimeError> {
        let failed = |reason: String| RuntimeError::Settings { file: file.to_owned(), reason };
        if ros.localization == ros::settings::Localization::Fix && scenario.georeference().is_none() {
            let reason = "ros.localization is 'fix', which needs a map with an origin on the earth";
            return Err(failed(reason.to_owned()));
        }
        self.check_cameras(vehicle, ros).map_err(failed)?;
        let moved_by = match vehicle.motion {
            MotionTable::Lattice { .. } => OutputKind::Path,
            MotionTable::Goal {} => OutputKind::Goal,
        };
        let detector = self.detector.clone().map(|detector| detector::Settings {
            module: file.parent().unwrap_or(Path::new("")).join(&detector.module),
            ..detector
        });
        let pilot = self.pilot(vehicle, &ros.measured(), file, scenario)?;
        Ok(Body { pilot, ros: ros.check(file)?, moved_by, detector })
    }

    fn mavlink_body(
        &self,
        vehicle: &VehicleSettings,
        mavlink: &mavlink::settings::Settings,
        file: &Path,
        scenario: &Scenario,
    ) -> Result<MavlinkBody, RuntimeError> {
        let failed =
            |reason: &str| RuntimeError::Settings { file: file.to_owned(), reason: reason.to_owned() };
        if self.detector.is_some() {
            let reason = "[detector] needs the images of a ROS 2 network; beside [mavlink], detectors send what they \
                          see to mavlink.detections.listen";
            return Err(failed(reason));
        }
        if !matches!(vehicle.motion, MotionTable::Goal {}) {
            let reason = "vehicle.motion.kind is 'lattice'; an autopilot goes to targets, allowed is 'goal'";
            return Err(failed(reason));
        }
        let is_global = mavlink.position == mavlink::settings::PositionTable::Global;
        if is_global && scenario.georeference().is_none() {
            let reason = "mavlink.position is 'global', which needs a map with an origin on the earth";
            return Err(failed(reason));
        }
        let pilot = self.pilot(vehicle, &BTreeMap::new(), file, scenario)?;
        Ok(MavlinkBody { mavlink: mavlink.check(file)?, pilot })
    }

    /// The pilot of a vehicle in a scenario, and what the vehicle's network says of its cameras.
    fn pilot(
        &self,
        vehicle: &VehicleSettings,
        measured: &BTreeMap<String, Measured>,
        file: &Path,
        scenario: &Scenario,
    ) -> Result<Pilot, RuntimeError> {
        let class = self.agent_config(file, scenario)?.robot.class;
        let failed = |reason: String| RuntimeError::Settings { file: file.to_owned(), reason };
        let primitives = match &vehicle.motion {
            MotionTable::Lattice { primitives: Some(named), .. } => {
                let path = file.parent().unwrap_or(Path::new("")).join(named);
                let reported = |error: std::io::Error| {
                    failed(format!("vehicle.motion.primitives: {}: {error}", path.display()))
                };
                Some(read_text_at_most(&path, MAX_PRIMITIVES_BYTES).map_err(reported)?)
            }
            MotionTable::Lattice { .. } | MotionTable::Goal {} => None,
        };
        let checked = vehicle
            .check_measured(primitives.as_deref(), measured)
            .map_err(|error| failed(error.to_string()))?;
        let (terrain, sensor) = (scenario.terrain().clone(), (*class.sensor).clone());
        let map = CostMap::from_terrain(&terrain, parts(&terrain));
        let map = map.map_err(|error| failed(format!("vehicle: {error}")))?;
        Pilot::new(checked, terrain, sensor, &map).map_err(|error| failed(error.to_string()))
    }

    /// Checks that each camera of the network is one of the vehicle's, and has one detector.
    fn check_cameras(&self, vehicle: &VehicleSettings, ros: &ros::settings::Settings) -> Result<(), String> {
        let has_images =
            |camera: &ros::settings::Camera| !(camera.image.is_empty() && camera.compressed_image.is_empty());
        for camera in &ros.cameras {
            let name = &camera.name;
            if vehicle.cameras.iter().all(|seen| seen.name != *name) {
                let names: Vec<&str> = vehicle.cameras.iter().map(|seen| seen.name.as_str()).collect();
                let names = names.join(", ");
                return Err(format!("ros.cameras: {name:?}; allowed are those of vehicle: {names}"));
            }
            if self.detector.is_none() && camera.detections.is_empty() {
                return Err(format!(
                    "ros.cameras: {name:?} has images, for which a [detector] is needed, or detections"
                ));
            }
        }
        let is_looked_at =
            |camera: &ros::settings::Camera| has_images(camera) && camera.detections.is_empty();
        if self.detector.is_some() && !ros.cameras.iter().any(is_looked_at) {
            let needed = "the images of a camera of ros.cameras that has no detections";
            return Err(format!("[detector] has no images; needed are {needed}"));
        }
        Ok(())
    }
}

impl CoordinatorSettings {
    /// The mission's target of TAK, if the settings have one. `file` is the file of the settings.
    ///
    /// # Errors
    /// If a value is invalid, or the scenario's map does not lie on the earth: with the key and what is needed.
    pub fn tak(
        &self,
        file: &Path,
        scenario: &Scenario,
    ) -> Result<Option<tak::settings::Checked>, RuntimeError> {
        let failed = |reason: String| RuntimeError::Settings { file: file.to_owned(), reason };
        let Some(settings) = &self.tak else { return Ok(None) };
        if scenario.georeference().is_none() {
            return Err(failed(format!("[tak]: {NotOnEarth}")));
        }
        settings.check(file).map(Some).map_err(failed)
    }
}

impl Body {
    /// Constructs the detector for the cameras' images. `file` is the file of the settings.
    ///
    /// # Errors
    /// If the detector cannot be constructed.
    pub fn make_detector(
        &self,
        file: &Path,
        make: detector::Make<'_>,
    ) -> Result<Option<Box<dyn detector::Detector>>, RuntimeError> {
        let failed =
            |reason| RuntimeError::Settings { file: file.to_owned(), reason: format!("detector: {reason}") };
        self.detector.as_ref().map(make).transpose().map_err(failed)
    }
}

/// Approximate resolution of the initial cost map, which is made of the scenario's map until the vehicle receives one.
const PART_METERS: f64 = 0.5;

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "at least 1; the map's size is checked"
)]
fn parts(terrain: &Terrain) -> u32 {
    (terrain.cell_meters() / PART_METERS).round().max(1.0) as u32
}

impl Common {
    /// Checks the settings, and loads the scenario. `file` is the file of the settings.
    ///
    /// # Errors
    /// If a value is invalid: with its key and the allowed values.
    pub fn check(&self, file: &Path) -> Result<Checked, RuntimeError> {
        let failed = |reason: String| RuntimeError::Settings { file: file.to_owned(), reason };
        check_real_time_factor(self.real_time_factor).map_err(failed)?;
        let mission = self.mission.parse().map_err(|error| failed(format!("common.mission: {error}")))?;
        self.zenoh.check("common.zenoh", file).map_err(failed)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let path = folder.join(&self.scenario);
        let scenario = match &self.scenario_text {
            Some(text) => Scenario::from_text(&path, text.clone()),
            None => Scenario::load(&path),
        };
        let mut scenario = scenario.map_err(|error| failed(error.to_string()))?;
        if let Some(earlier) = &self.prior_from {
            scenario = crate::earlier::continuing(&scenario, &folder.join(earlier))
                .map_err(|reason| failed(format!("common.prior_from: {reason}")))?;
        }
        Ok(Checked { mission, scenario })
    }
}

impl SimSettings {
    /// Checks the settings, and returns the mission. `file` is the file of the settings.
    ///
    /// # Errors
    /// If a value is invalid: with its key and the allowed values.
    pub fn check(&self, file: &Path) -> Result<Mission, RuntimeError> {
        let failed = |reason: String| RuntimeError::Settings { file: file.to_owned(), reason };
        check_real_time_factor(self.real_time_factor).map_err(failed)?;
        self.zenoh.check("zenoh", file).map_err(failed)?;
        self.mission.parse().map_err(|error| failed(format!("mission: {error}")))
    }
}

/// Checks a real-time factor.
///
/// # Errors
/// If it is out of range: the allowed values.
pub fn check_real_time_factor(real_time_factor: f64) -> Result<(), String> {
    if real_time_factor.is_finite() && (1e-3..=1e4).contains(&real_time_factor) {
        Ok(())
    } else {
        Err(format!(
            "real_time_factor is {real_time_factor:?}; allowed is from 0.001 to 10000 mission seconds a second"
        ))
    }
}
