//! Scenario files: map, objects, sensor, robots, mission and network.
//!
//! [`mod@file`] mirrors the TOML as it is written; a [`Scenario`] is checked and can be run. `scenarios/README.md`
//! explains every key.

mod check;
mod class;
mod drawn;
mod error;
pub mod file;
mod mission;
mod network;
mod objects;
mod of_map;
mod policy_text;
mod prior;
mod robots;
mod schema;
mod separation;
mod start;
mod warning;
mod world;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use dragnet_files::text_of;
use dragnet_learn::policy::Shipped;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::route::Connectivity;
use dragnet_search::sensor::Sensor;
use dragnet_search::separation::Separation;
use dragnet_search::subjects::Subjects;
use dragnet_search::terrain::Terrain;

use crate::map_file::areas::Claims;
use crate::map_file::{Areas, Earth, Georeference, MapFile, MapOrigin};
use crate::{Places, shipped, toml_text};

pub use check::Invalid;
pub use class::Class;
pub use drawn::Drawn;
pub use error::ScenarioError;
pub use mission::{Budget, Mission};
pub use network::{Network, Partition};
pub use objects::Objects;
pub use policy_text::{PolicyTextError, policies};
pub use prior::EarlierBelief;
pub use robots::{Policy, Robot, Start};
pub use schema::{schema_json, schema_of};
pub use warning::{Reason, Warning};

use class::Classes;
use error::Fault;
use file::{PolicyField, PolicyTable, RecordingTable, ScenarioFile};
use prior::Prior;

/// A search that can be run: with a seed, it is an episode.
#[derive(Clone, Debug)]
pub struct Scenario {
    source: Source,
    /// The file that the fields below are computed from; overrides change it, and the fields are computed again.
    file: ScenarioFile,
    map: Arc<MapFile>,
    /// What it continues beside what its file says.
    earlier: Option<Arc<EarlierBelief>>,
    connectivity: Connectivity,
    /// What robots of no named class can do.
    unnamed: Arc<Class>,
    prior: Arc<Prior>,
    objects: Objects,
    object_weights: Option<Vec<f64>>,
    robots: Vec<Robot>,
    separation: Separation,
    mission: Mission,
    network: Network,
    recording: Recording,
    zenoh_config: Option<PathBuf>,
}

/// The source of a scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file; files that it names are relative to its folder.
    pub path: PathBuf,
    /// Its text, as read.
    pub text: String,
}

/// Settings of the recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recording {
    /// The file, relative to the working directory; `None`: the caller chooses one.
    pub file: Option<PathBuf>,
    /// Time between two recorded beliefs.
    pub belief_period: Duration,
}

impl Scenario {
    /// The maximum size of a text, bytes: enough for 300,000 objects. Parsing takes up to 125 times as much memory.
    pub const MAX_BYTES: usize = 1 << 22;

    /// Reads a scenario file and the files that it names. Where no file is, the path may be the name of a
    /// [shipped] scenario. Of a map alone it is a scenario in which all else is assumed: see
    /// [`Scenario::text_of_map`].
    ///
    /// # Errors
    /// If one cannot be read, is not valid in its format, or a value is out of range or contradicts another.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let path = shipped::resolve(path);
        if of_map::is_map(&path) {
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            return Self::from_text(&path, Self::text_of_map(&path, &file));
        }
        let text = shipped::read_at_most(&path, Self::MAX_BYTES as u64).and_then(text_of);
        let text = text.map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => ScenarioError::Missing { file: path.clone(), source },
            _ => ScenarioError::Read { file: path.clone(), source },
        })?;
        Self::from_text(&path, text)
    }

    /// The text of a scenario for a map, which it names as `file`: one subject, who is in the searched cells or where the
    /// map's regions leave the rest, one robot that starts in a random cell with the policy `tour`, cells so long that
    /// the map's longer side has at most 80, and six hours.
    #[must_use]
    pub fn text_of_map(map: &Path, file: &str) -> String {
        of_map::text(map, file)
    }

    /// Whether it was made for a map alone.
    #[must_use]
    pub fn is_of_map(&self) -> bool {
        of_map::is_map(&self.source.path)
    }

    /// A scenario from its text, as if read from a path: messages name it, and files are relative to its
    /// folder.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn from_text(path: &Path, text: String) -> Result<Self, ScenarioError> {
        let (source, file) = parse(path, text)?;
        let map = world::map(&file.map, source.folder()).map_err(|fault| source.error(fault))?;
        Self::new(source.clone(), file, Arc::new(map), None).map_err(|fault| source.error(fault))
    }

    /// A scenario from its text and the areas of the map file that it names, which need not exist yet.
    ///
    /// # Errors
    /// As [`Scenario::from_text`], and if the text does not name a file of areas.
    pub fn from_text_and_areas(path: &Path, text: String, areas: Areas) -> Result<Self, ScenarioError> {
        let (source, file) = parse(path, text)?;
        let map = world::map_of_areas(&file.map, areas).map_err(|fault| source.error(fault))?;
        Self::new(source.clone(), file, Arc::new(map), None).map_err(|fault| source.error(fault))
    }

    /// The text of a scenario for areas, as [`Scenario::text_of_map`]; it names them as `file`.
    #[must_use]
    pub fn text_of_areas(areas: &Areas, name: &str, file: &str) -> String {
        of_map::text_of_areas(areas, name, file)
    }

    /// The name of a scenario for a map: that of its file, with `_` for what names cannot contain.
    #[must_use]
    pub fn name_of_map(map: &Path) -> String {
        of_map::name(map)
    }

    /// The edge of the cells that is assumed for areas alone, meters, and the cells of the map's longer side; `None` if
    /// the areas make no map.
    #[must_use]
    pub fn cells_of_areas(areas: &Areas) -> Option<(f64, u32)> {
        of_map::cells_of_areas(areas)
    }

    fn new(
        source: Source,
        file: ScenarioFile,
        map: Arc<MapFile>,
        earlier: Option<Arc<EarlierBelief>>,
    ) -> Result<Self, Fault> {
        check_name("name", &file.name)?;
        let terrain = &map.terrain;
        let objects = Objects::new(&file.objects, terrain)?;
        let map_file = file.map.file.as_deref();
        let prior = Prior::new(&file.prior, source.folder(), map_file, &map, &objects, earlier.as_deref())?;
        let mut mission = Mission::new(&file.mission)?;
        prior.check_undecided(terrain, mission.detection_threshold)?;
        let object_weights = if objects::is_by_prior(&file.objects)? {
            objects::weights(&objects, &prior.belief, terrain)?
        } else {
            None
        };
        let recording = recording(&file.recording)?;
        let classes = Classes::new(&file, terrain.grid(), &mission)?;
        for (key, period) in
            [("mission.heartbeat_seconds", mission.heartbeat), (BELIEF_PERIOD, recording.belief_period)]
        {
            for class in classes.all() {
                mission::check_period(key, period, terrain.cell_meters(), class)?;
            }
        }
        let map = world::with_line_of_sight(map, &file.sensor, &classes)?;
        let mut robots = robots::robots(&file.robots, &classes, source.folder(), &map)?;
        let separation = separation::separation(file.robots.separation_meters, &mut robots, &map.terrain)?;
        let network = Network::new(&file.network, u16::try_from(robots.len()).unwrap_or(u16::MAX))?;
        mission.stagger = mission.stagger.max(network.plan_time());
        Ok(Self {
            connectivity: world::connectivity(file.map.connectivity)?,
            unnamed: classes.unnamed,
            prior: Arc::new(prior),
            objects,
            object_weights,
            mission,
            network,
            robots,
            separation,
            recording,
            zenoh_config: zenoh_config(file.zenoh.config.as_deref(), source.folder())?,
            source,
            file,
            map,
            earlier,
        })
    }

    /// A copy of the scenario in which every robot uses this policy. Without parameters it has the defaults, not the
    /// scenario's.
    ///
    /// # Errors
    /// If a parameter is not one of the policy, or out of its range.
    pub fn with_policy(&self, policy: impl Into<PolicyField>) -> Result<Self, ScenarioError> {
        let policy = policy.into();
        self.changed(|file| {
            file.robots.policy = policy;
            for robot in &mut file.robots.robot {
                robot.policy = None;
            }
        })
    }

    /// A copy of the scenario in which every robot uses the policy `gnn` with these weights; the file is relative to
    /// the working directory.
    ///
    /// # Errors
    /// If it is not a weights file, or its path cannot be made absolute or is not UTF-8.
    pub fn with_weights(&self, file: &Path) -> Result<Self, ScenarioError> {
        let table = PolicyTable { name: Shipped::General.as_str().to_owned(), ..PolicyTable::default() };
        self.with_weights_of_table(table, file)
    }

    /// Like [`Scenario::with_policy`], but a weights file is relative to the working directory, not to the scenario.
    ///
    /// # Errors
    /// As [`Scenario::with_policy`] and [`Scenario::with_weights`].
    pub fn with_local_policy(&self, policy: PolicyField) -> Result<Self, ScenarioError> {
        let PolicyField::Table(mut table) = policy else { return self.with_policy(policy) };
        match table.weights.take() {
            Some(file) => self.with_weights_of_table(table, Path::new(&file)),
            None => self.with_policy(PolicyField::Table(table)),
        }
    }

    fn with_weights_of_table(&self, mut table: PolicyTable, file: &Path) -> Result<Self, ScenarioError> {
        let absolute = std::path::absolute(file).ok();
        let Some(weights) = absolute.as_deref().and_then(Path::to_str) else {
            let found = format!("{:?}", file.display());
            let invalid = Invalid::new("robots.policy.weights", found, "the path of a file, in UTF-8");
            return Err(self.source.override_error(invalid.into()));
        };
        table.weights = Some(weights.to_owned());
        self.with_policy(PolicyField::Table(table))
    }

    /// A copy of the scenario with this number of robots.
    ///
    /// # Errors
    /// If there are none, too many, or too few for a robot that the scenario names.
    pub fn with_robots(&self, count: u32) -> Result<Self, ScenarioError> {
        self.changed(|file| file.robots.count = count.into())
    }

    /// A copy of the scenario with objects of this density; the prior changes accordingly unless the scenario sets it.
    ///
    /// # Errors
    /// If it is not above 0 and below 1.
    pub fn with_density(&self, density: f64) -> Result<Self, ScenarioError> {
        self.changed(|file| {
            let placement = file.objects.placement.take();
            file.objects = file::ObjectsTable { density: Some(density), placement, ..Default::default() };
        })
    }

    /// A copy of the scenario in which a budget of this path length (cells) replaces all budgets.
    ///
    /// # Errors
    /// If it is 0.
    pub fn with_budget_cells(&self, cells: u32) -> Result<Self, ScenarioError> {
        self.changed(|file| {
            file.mission.budget_meters = Some(f64::from(cells) * file.map.cell_meters);
            file.mission.budget_seconds = None;
            for class in file.classes.values_mut() {
                (class.budget_meters, class.budget_seconds) = (None, None);
            }
        })
    }

    /// A copy of the scenario that begins with what an earlier search believed: where both search, that is the prior, and
    /// elsewhere the scenario's own.
    ///
    /// # Errors
    /// If the earlier search was of another place, has no searched cell in common with the scenario, or sought one subject
    /// and the scenario does not, or the other way around.
    pub fn continuing(&self, earlier: EarlierBelief) -> Result<Self, ScenarioError> {
        Self::new(self.source.clone(), self.file.clone(), Arc::clone(&self.map), Some(Arc::new(earlier)))
            .map_err(|fault| self.source.override_error(fault))
    }

    fn changed(&self, change: impl FnOnce(&mut ScenarioFile)) -> Result<Self, ScenarioError> {
        let mut file = self.file.clone();
        change(&mut file);
        Self::new(self.source.clone(), file, Arc::clone(&self.map), self.earlier.clone())
            .map_err(|fault| self.source.override_error(fault))
    }

    /// Name of the mission: 1 to 64 letters, digits, `_` and `-`.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.file.name
    }

    /// Its source.
    #[must_use]
    pub const fn source(&self) -> &Source {
        &self.source
    }

    /// The scenario as a file, overrides included.
    #[must_use]
    pub const fn file(&self) -> &ScenarioFile {
        &self.file
    }

    /// The map: at least one cell is traversable, and at least one is searched.
    #[must_use]
    pub fn terrain(&self) -> &Terrain {
        &self.map.terrain
    }

    /// The map with its position, shared.
    #[must_use]
    pub const fn map(&self) -> &Arc<MapFile> {
        &self.map
    }

    /// The map's position on the earth, if its file has one.
    #[must_use]
    pub fn georeference(&self) -> Option<&Georeference> {
        self.map.georeference.as_ref()
    }

    /// The map's pose in the frame of its file.
    #[must_use]
    pub fn origin(&self) -> MapOrigin {
        self.map.origin
    }

    /// The neighbors that robots can move to.
    #[must_use]
    pub const fn connectivity(&self) -> Connectivity {
        self.connectivity
    }

    /// The sensor of robots of no named class. What a robot has is its class's.
    #[must_use]
    pub fn sensor(&self) -> &Sensor {
        &self.unnamed.sensor
    }

    /// The sensor of the team that sees the most cells.
    #[must_use]
    pub fn widest_sensor(&self) -> &Sensor {
        let sensors = self.robots.iter().map(|robot| &*robot.class.sensor);
        sensors.max_by_key(|sensor| sensor.radius()).unwrap_or(&self.unnamed.sensor)
    }

    /// The one class that all robots are of, if they are.
    #[must_use]
    pub fn only_class(&self) -> Option<&Class> {
        let class = &self.robots.first()?.class;
        self.robots.iter().all(|robot| robot.class == *class).then_some(&**class)
    }

    /// The belief before the first observation.
    #[must_use]
    pub fn prior(&self) -> &Belief {
        &self.prior.belief
    }

    /// That the number of objects is known, if so: each is in a cell with the probability of the prior, or outside of all.
    #[must_use]
    pub fn subjects(&self) -> Option<Subjects> {
        self.prior.subjects
    }

    /// What it continues by [`Scenario::continuing`], if anything.
    #[must_use]
    pub fn earlier(&self) -> Option<&EarlierBelief> {
        self.earlier.as_deref()
    }

    /// The share of the searched cells that an earlier search covers, 0 to 1, if it continues one.
    #[must_use]
    pub fn continued_share(&self) -> Option<f64> {
        self.prior.continued
    }

    /// The regions that the prior was computed from, if any.
    #[must_use]
    pub fn claims(&self) -> Option<&Claims> {
        self.prior.claims.as_ref()
    }

    /// The areas of the map and of the prior, including ignored ones.
    #[must_use]
    pub fn areas(&self) -> Areas {
        let (map, prior) = (&self.map.areas, &self.prior.areas);
        Areas {
            areas: [&map.areas[..], &prior.areas].concat(),
            left_out: [&map.left_out[..], &prior.left_out].concat(),
            mended: [&map.mended[..], &prior.mended].concat(),
            results: map.results + prior.results,
        }
    }

    /// Writes where its cells are.
    #[must_use]
    pub fn places(&self) -> Places {
        let mut places = Places::new(self.terrain(), self.georeference());
        places.is_of_subjects = self.subjects().is_some();
        places
    }

    /// The search's position on the earth, if known.
    #[must_use]
    pub fn earth(&self) -> Option<Earth> {
        let expected_objects = self.objects.expected_count(self.terrain());
        self.georeference().map(|&frame| Earth { frame, areas: self.areas().areas, expected_objects })
    }

    /// The objects.
    #[must_use]
    pub const fn objects(&self) -> &Objects {
        &self.objects
    }

    /// How likely each cell is to hold an object of a simulation, shape `[cells]`, up to a common factor; `None` if all
    /// searched cells are alike.
    #[must_use]
    pub fn object_weights(&self) -> Option<&[f64]> {
        self.object_weights.as_deref()
    }

    /// The team, by number from 1; at least one robot.
    #[must_use]
    pub fn robots(&self) -> &[Robot] {
        &self.robots
    }

    /// How far apart robots keep.
    #[must_use]
    pub const fn separation(&self) -> Separation {
        self.separation
    }

    /// The cells in which the robots start, by number, if these are drawn for them: where robots keep apart, each the nearest one
    /// that is apart from the others.
    #[must_use]
    pub fn apart(&self, drawn: Vec<Cell>) -> Vec<Cell> {
        separation::placed(self.separation, &self.robots, self.terrain(), drawn)
    }

    /// Budget, detection threshold and communication.
    #[must_use]
    pub const fn mission(&self) -> &Mission {
        &self.mission
    }

    /// Path length that each robot may drive, cells: the budget of path length, or else the length that it can drive in
    /// the budget of time. Of unlike robots the longest.
    #[must_use]
    pub fn budget_cells(&self) -> f64 {
        let meters = self.robots.iter().map(|robot| robot.class.budget_meters()).fold(0.0, f64::max);
        // Cells that were converted to meters become the same whole number again.
        (meters / self.terrain().cell_meters() * 1e6).round() / 1e6
    }

    /// Faults of the simulated network.
    #[must_use]
    pub const fn network(&self) -> &Network {
        &self.network
    }

    /// Settings of the recording.
    #[must_use]
    pub const fn recording(&self) -> &Recording {
        &self.recording
    }

    /// The Zenoh configuration file that the scenario names, if any; the file exists.
    #[must_use]
    pub fn zenoh_config(&self) -> Option<&Path> {
        self.zenoh_config.as_deref()
    }
}

impl Source {
    fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }
}

/// A scenario file from its text.
fn parse(path: &Path, text: String) -> Result<(Source, ScenarioFile), ScenarioError> {
    check_length(path, text.len())?;
    let source = Source { path: path.to_owned(), text };
    let file = toml_text::read(&source.text).map_err(|error| {
        let is_settings = toml_text::has_key(&source.text, "common");
        let note = "this file is no scenario: it holds the settings of a process, which agent or coordinator reads with --config";
        source.text_error(if is_settings { error.with(note) } else { error })
    })?;
    Ok((source, file))
}

fn check_length(path: &Path, bytes: usize) -> Result<(), ScenarioError> {
    if bytes <= Scenario::MAX_BYTES {
        return Ok(());
    }
    let allowed = format!("at most {} bytes", Scenario::MAX_BYTES);
    let invalid = Invalid::new("the text", format!("{bytes} bytes long"), allowed);
    Err(ScenarioError::Value { place: path.display().to_string(), invalid })
}

fn check_name(key: &str, name: &str) -> Result<(), Invalid> {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'-';
    if (1..=64).contains(&name.len()) && name.bytes().all(is_plain) {
        Ok(())
    } else {
        let allowed = "1 to 64 letters, digits, '_' and '-'";
        Err(Invalid::new(key, format!("{name:?}"), allowed))
    }
}

const BELIEF_PERIOD: &str = "recording.belief_period_seconds";

fn recording(table: &RecordingTable) -> Result<Recording, Invalid> {
    Ok(Recording {
        file: table.file.as_ref().map(PathBuf::from),
        belief_period: check::period(BELIEF_PERIOD, table.belief_period_seconds)?,
    })
}

fn zenoh_config(config: Option<&str>, folder: &Path) -> Result<Option<PathBuf>, Invalid> {
    let Some(config) = config else { return Ok(None) };
    let path = folder.join(config);
    if path.is_file() {
        Ok(Some(path))
    } else {
        let allowed = "a JSON5 file, relative to the scenario";
        Err(Invalid::new("zenoh.config", format!("{}, no such file", path.display()), allowed))
    }
}

#[cfg(test)]
mod tests;
