//! The scenario file as it is written: names and defaults, unchecked. The comments of this file are the descriptions in
//! `scenarios/scenario.schema.json`.

use std::collections::BTreeMap;
use std::fmt;

use dragnet_learn::policy::PolicyName;
use dragnet_search::generated::Generated;
use dragnet_search::policy::{AfterPattern, Pattern, PolicyName as Exact};
use dragnet_search::sensor::Sensor;
use dragnet_search::shape::Shape;
use dragnet_search::situation::DEFAULT_DETECTION_THRESHOLD;
use dragnet_search::utility::Utility;
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, DeserializeOwned, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// A Dragnet scenario: the map, the objects, the sensor, the robots, the mission and the network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// Name of the mission, part of its keys on the network: 1 to 64 letters, digits, `_` and `-`.
    #[schemars(regex(pattern = r"^[A-Za-z0-9_-]{1,64}$"))]
    pub name: String,
    /// The map that is searched.
    pub map: MapTable,
    /// The sensor of the robots.
    #[serde(default)]
    pub sensor: SensorTable,
    /// The belief before the first observation.
    #[serde(default)]
    pub prior: PriorTable,
    /// The objects.
    pub objects: ObjectsTable,
    /// The robots.
    #[serde(default)]
    pub robots: RobotsTable,
    /// Classes of robots by name (1 to 64 letters, digits, `_` and `-`): what unlike robots of a team can do.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub classes: BTreeMap<String, ClassTable>,
    /// Budget, detection threshold and communication.
    pub mission: MissionTable,
    /// Faults of the simulated network (simulation only).
    #[serde(default)]
    pub network: NetworkTable,
    /// The recording.
    #[serde(default)]
    pub recording: RecordingTable,
    /// The network between processes on several computers.
    #[serde(default)]
    pub zenoh: ZenohTable,
}

/// The map that is searched: a shape with rows and columns, or a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapTable {
    /// A built-in map, drawn at any size. Needs `rows` and `columns`; excludes `file`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = shape_names()))]
    pub shape: Option<String>,
    /// Rows of the shape, south to north, cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub rows: Option<i64>,
    /// Columns of the shape, west to east, cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1))]
    pub columns: Option<i64>,
    /// Seed of a generated shape (`caves`, `blocks`, `rooms`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 4_294_967_295_u32))]
    pub seed: Option<i64>,
    /// A map file, relative to the scenario: `.txt` drawing, `.yaml` ROS map, `.map` of `MovingAI`,
    /// `.geojson`, `.kml`, `.kmz`, `.gpx` or `.plan` areas. Excludes `shape`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// A keep-out mask of Nav2 beside a ROS map, relative to the scenario: its YAML. No robot enters a cell that an occupied
    /// pixel of it touches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keepout: Option<String>,
    /// Position of the map's south-western corner on the earth, for a map whose file has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub origin: Option<GeoPointTable>,
    /// Edge of a cell, meters, from 0.001.
    #[serde(default = "default_cell_meters")]
    #[schemars(range(min = 0.001))]
    pub cell_meters: f64,
    /// Number of neighbors that a robot can move to: 4, or 8 with diagonals.
    #[serde(default = "default_moves")]
    #[schemars(extend("enum" = [4, 8]))]
    pub connectivity: i64,
}

/// A point of WGS84.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GeoPointTable {
    /// North positive, -85 to 85.
    #[schemars(range(min = -85.0, max = 85.0))]
    pub latitude_degrees: f64,
    /// East positive, -180 to 180.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub longitude_degrees: f64,
}

/// The sensor, which observes all cells within a Manhattan radius.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SensorTable {
    /// Manhattan radius, cells, 1 to 100 and no more than the map's larger side.
    #[schemars(range(min = 1, max = 100))]
    pub radius: i64,
    /// Variance of a reading at distance 1; at distance d it is `noise_variance d^2`, in the robot's own cell
    /// `noise_variance / 5`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub noise_variance: f64,
    /// Distribution of readings: `gaussian` around the truth, or `clipped` to 0..1 as in the released code of NATS.
    #[schemars(extend("enum" = ["gaussian", "clipped"]))]
    pub noise: String,
    /// Whether walls hide what is behind them from robots on the ground. Walls are cells that are neither traversable nor
    /// searched, and those that a thinner wall of a pixel map leads along. Without it sensors see through them, as in the
    /// paper; vehicles with cameras never do.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub line_of_sight: bool,
}

/// A class of robots. What it does not give is as for all other robots.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ClassTable {
    /// Their sensor.
    #[serde(skip_serializing_if = "ClassSensorTable::is_default")]
    pub sensor: ClassSensorTable,
    /// Their speed, meters per second, from 0.001.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.001))]
    pub speed_meters_per_second: Option<f64>,
    /// As `mission.budget_meters`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub budget_meters: Option<f64>,
    /// As `mission.budget_seconds`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub budget_seconds: Option<f64>,
    /// Whether they cross every cell of the map, as drones do.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub flies: bool,
}

/// The sensor of a class.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ClassSensorTable {
    /// As `sensor.radius`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 100))]
    pub radius: Option<i64>,
    /// As `sensor.noise_variance`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub noise_variance: Option<f64>,
}

impl ClassSensorTable {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The belief before the first observation. Without a key it follows from the regions of the map, or else from the
/// objects' expected density.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PriorTable {
    /// Probability of an object in each searched cell, above 0 and below 1. Excludes `file`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub probability: Option<f64>,
    /// Probabilities of all cells, relative to the scenario, the northern edge first: numbers in `.csv` or `.txt`, or a
    /// `.pgm` or `.png` image. Or regions on the earth with their probabilities, `.geojson`, `.kml` or `.kmz`. Or what an
    /// earlier search believed in the end, `.belief.json` of `dragnet export`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The number of objects is known, and this is the probability that each of them is outside of the searched cells, the rest
    /// of the world (ROW), 0 to below 1. The probabilities of all cells are scaled so that they add up to the number expected
    /// inside. Needs `objects.count` from 1 to 100, or `objects.cells`; excludes `probability`. Without it cells are independent.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1))]
    pub rest_of_world: Option<f64>,
}

/// The objects (simulation only, except for the prior): exactly one of these keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ObjectsTable {
    /// Number of objects, in searched cells drawn as `placement` says, 0 to the number of searched cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub count: Option<i64>,
    /// Probability that a searched cell holds an object, independently of the others, above 0 and below 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub density: Option<f64>,
    /// The cells of the objects, all searched, each `[row, column]`: rows from 0 in the south, columns from 0 in the
    /// west.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<Vec<[i64; 2]>>,
    /// Where a simulation draws a `count` or a `density`: `prior`, in proportion to the prior's probability of each cell,
    /// or `uniform`, in all searched cells alike. None with `cells`. Default: `prior`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = ["prior", "uniform"]))]
    pub placement: Option<String>,
}

/// The robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RobotsTable {
    /// Number of robots, 1 to 1000; they are numbered from 1.
    #[schemars(range(min = 1, max = 1000))]
    pub count: i64,
    /// The policy of the robots.
    pub policy: PolicyField,
    /// The class of the robots, a name of `classes`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// Start cells of the robots. Default: where the map has features of kind `start`, robot k in the cell nearest to
    /// the kth of them, and so on in turn; else, on drawn search areas that no way connects, each robot in one of them, in
    /// proportion to their cells; else `random`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<StartField>,
    /// How far apart the centers of two robots stay at least, meters, 0 to 1000000, in whole cells; robots that fly keep apart
    /// from each other alone. Default: 0, several may be in one cell.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1_000_000.0))]
    pub separation_meters: f64,
    /// Robots that differ from the rest.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub robot: Vec<RobotTable>,
}

/// A robot that differs from the rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotTable {
    /// Its number, 1 to `count`.
    #[schemars(range(min = 1, max = 1000))]
    pub number: i64,
    /// Its policy, if it differs from the rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub policy: Option<PolicyField>,
    /// Its class, if it differs from the rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// Its start cell, if it differs from the rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<StartField>,
}

/// A policy by its name, or by a table of its name and parameters.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum PolicyField {
    /// The name alone.
    Name(#[schemars(extend("enum" = policy_names()))] String),
    /// The name and parameters.
    Table(PolicyTable),
}

/// By hand, so that an error within the table names its key.
impl<'de> Deserialize<'de> for PolicyField {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Of;
        impl<'de> Visitor<'de> for Of {
            type Value = PolicyField;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("the name of a policy, or a table of `name` and parameters")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<PolicyField, E> {
                Ok(PolicyField::Name(name.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<PolicyField, A::Error> {
                PolicyTable::deserialize(MapAccessDeserializer::new(table)).map(PolicyField::Table)
            }
        }
        deserializer.deserialize_any(Of)
    }
}

/// A policy and its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicyTable {
    /// The policy's name.
    #[schemars(extend("enum" = policy_names()))]
    pub name: String,
    /// For `path` and `path-additive`: `w_l` in the weight `1 / (1 + w_l L)` of a path of L cells, 0 to 1000, 0.2 by
    /// default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub path_length_weight: Option<f64>,
    /// For `greedy` and `path`: what observations are worth, the entropy that they are expected to remove
    /// (`information`, the default) or the objects that they are expected to find (`recall`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = Utility::ALL.map(Utility::as_str)))]
    pub utility: Option<String>,
    /// For `coverage`: its search pattern, as the IAMSAR Manual names them; `parallel_track` by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = Pattern::ALL.map(Pattern::as_str)))]
    pub pattern: Option<String>,
    /// For `coverage`: what follows once the pattern is done, the pattern again (`repeat`, the default) or the policy
    /// `path`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = AfterPattern::ALL.map(AfterPattern::as_str)))]
    pub after_pattern: Option<String>,
    /// For `coverage`: cells between its tracks, 1 to 1000; by default the most at which one pass finds an object
    /// anywhere between two of them with probability 0.9.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000))]
    pub lane_spacing_cells: Option<i64>,
    /// For `tour`: tours that it evaluates in a decision, ten times as many in its first, 0 to 1000000, 1000 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 1_000_000))]
    pub evaluations: Option<i64>,
    /// Number of cells after which the robot decides anew, 1 to 1000000; by default at the waypoint, of `tour` after 4.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub replan_after_cells: Option<i64>,
    /// For `gnn`: a weights file, relative to the scenario, instead of the built-in weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<String>,
}

/// Start cells of robots.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a start is \"random\", \"scattered\", a cell as [row, column], or a point as { latitude_degrees, longitude_degrees }"
)]
pub enum StartField {
    /// `random`: one cell for all, drawn in the largest connected area; `scattered`: a cell for each robot, drawn
    /// there.
    Word(#[schemars(extend("enum" = ["random", "scattered"]))] String),
    /// This traversable cell, `[row, column]`: rows from 0 in the south, columns from 0 in the west.
    Cell([i64; 2]),
    /// The traversable cell nearest to this point, on a georeferenced map.
    #[serde(deserialize_with = "from_table")]
    Point(GeoPointTable),
}

/// Reads a table only: serde would take a list of its values too, such as `[1.0, 1.0]`, which is meant as a cell.
fn from_table<'de, T: DeserializeOwned, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    toml::Table::deserialize(deserializer)?.try_into().map_err(de::Error::custom)
}

/// Budget, detection threshold and communication. At least one budget is required.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MissionTable {
    /// Probability from which a cell is declared to hold an object, above 0.5 and below 1.
    #[schemars(extend("exclusiveMinimum" = 0.5, "exclusiveMaximum" = 1))]
    pub detection_threshold: f64,
    /// Path length after which a robot makes no further step, meters, above 0: its last step may end beyond it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub budget_meters: Option<f64>,
    /// Time from the mission's start after which the search ends, seconds, above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub budget_seconds: Option<f64>,
    /// Whether each robot returns to its base, the cell that it starts in: its budget then covers the way back, and at the
    /// end of its search it drives there.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(extend("default" = false))]
    pub return_to_base: bool,
    /// Share of each budget that no plan uses, at least 0 and below 1: for waits, detours and slow ground on the way back.
    /// It counts with `return_to_base` only.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1, "default" = BUDGET_RESERVE))]
    #[serde(skip_serializing_if = "is_default_reserve")]
    pub budget_reserve: f64,
    /// Speed of a robot, meters per second, from 0.001; observations that imply a higher speed are rejected.
    #[schemars(range(min = 0.001))]
    pub speed_meters_per_second: f64,
    /// Stop when at most this number of objects are expected to remain outside the declared cells, counting only cells
    /// in reach, at least 0; with 0 the search ends when no observation is informative.
    #[schemars(range(min = 0.0))]
    pub stop_when_expected_remaining: f64,
    /// Heartbeat period of a robot, seconds, from 0.01.
    #[schemars(range(min = 0.01))]
    pub heartbeat_seconds: f64,
    /// Silence after which a robot counts as lost, seconds, above `heartbeat_seconds`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub liveness_timeout_seconds: f64,
    /// Delay between the first decisions of robots with consecutive numbers, seconds, at least 0, so that each knows
    /// the plans of those before it. With `network.bytes_per_second` it is at least 300 bytes over that.
    #[schemars(range(min = 0.0))]
    pub start_stagger_seconds: f64,
    /// Allowed difference between two robots' mission times, seconds, at least 0: observations that are dated later are
    /// not accepted yet.
    #[schemars(range(min = 0.0))]
    pub max_clock_skew_seconds: f64,
}

/// Faults of the simulated network (simulation only).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NetworkTable {
    /// Probability that a message to one receiver is lost, at least 0 and below 1.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1))]
    pub loss: f64,
    /// Delay of every message, seconds, at least 0.
    #[schemars(range(min = 0.0))]
    pub delay_seconds: f64,
    /// Maximum additional delay of a message, uniformly distributed, seconds, at least 0. It reorders messages.
    #[schemars(range(min = 0.0))]
    pub jitter_seconds: f64,
    /// Probability that a message is delivered twice, at least 0 and below 1.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1))]
    pub duplication: f64,
    /// Probability that a message is delayed by `reorder_seconds`, at least 0 and below 1.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1))]
    pub reorder: f64,
    /// The additional delay of `reorder`, seconds; above 0 if `reorder` is.
    #[schemars(range(min = 0.0))]
    pub reorder_seconds: f64,
    /// Rate at which each participant's radio sends, one message at a time, bytes per second, 10 to 1e9. Without it
    /// messages take no time. It counts the bytes of messages, not what a radio adds to them.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 10.0, max = 1e9))]
    pub bytes_per_second: Option<f64>,
    /// Times at which groups are disconnected from each other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub partitions: Vec<PartitionTable>,
}

/// A time at which groups are disconnected from each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartitionTable {
    /// Begin, seconds from the mission's start, at least 0.
    #[schemars(range(min = 0.0))]
    pub from_seconds: f64,
    /// End, seconds from the mission's start, above `from_seconds`.
    #[schemars(range(min = 0.0))]
    pub to_seconds: f64,
    /// Groups that are connected only within themselves: robots by number, and "coordinator". All participants that are
    /// not listed form one more group.
    #[schemars(length(min = 1))]
    pub groups: Vec<Vec<MemberField>>,
}

/// A robot by its number, or "coordinator".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a member of a group is a robot's number or \"coordinator\"")]
pub enum MemberField {
    /// A robot, 1 to `robots.count`.
    Robot(#[schemars(range(min = 1, max = 1000))] i64),
    /// The coordinator.
    Word(#[schemars(extend("enum" = ["coordinator"]))] String),
}

/// The recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RecordingTable {
    /// MCAP file to record to, relative to the working directory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Period of recorded beliefs, seconds, from 0.01.
    #[schemars(range(min = 0.01))]
    pub belief_period_seconds: f64,
}

/// The network between processes on several computers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ZenohTable {
    /// A Zenoh configuration file (JSON5), relative to the scenario.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub config: Option<String>,
}

impl Default for SensorTable {
    fn default() -> Self {
        Self {
            radius: Sensor::DEFAULT_RADIUS.into(),
            noise_variance: Sensor::DEFAULT_NOISE_VARIANCE,
            noise: "gaussian".to_owned(),
            line_of_sight: false,
        }
    }
}

impl Default for RobotsTable {
    fn default() -> Self {
        Self {
            count: 1,
            policy: PolicyField::Name(Exact::Path.as_str().to_owned()),
            class: None,
            start: None,
            separation_meters: 0.0,
            robot: Vec::new(),
        }
    }
}

impl Default for MissionTable {
    fn default() -> Self {
        Self {
            detection_threshold: DEFAULT_DETECTION_THRESHOLD,
            budget_meters: None,
            budget_seconds: None,
            return_to_base: false,
            budget_reserve: BUDGET_RESERVE,
            speed_meters_per_second: 2.0,
            stop_when_expected_remaining: 0.05,
            heartbeat_seconds: 10.0,
            liveness_timeout_seconds: 30.0,
            start_stagger_seconds: 0.1,
            max_clock_skew_seconds: 60.0,
        }
    }
}

impl Default for RecordingTable {
    fn default() -> Self {
        Self { file: None, belief_period_seconds: 10.0 }
    }
}

/// The usual reserve.
const BUDGET_RESERVE: f64 = 0.1;

// Not written, so that searches that do not use it are written as before.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_default_reserve(reserve: &f64) -> bool {
    reserve.total_cmp(&BUDGET_RESERVE).is_eq()
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(number: &f64) -> bool {
    number.total_cmp(&0.0).is_eq()
}

const fn default_cell_meters() -> f64 {
    30.0
}

const fn default_moves() -> i64 {
    4
}

pub(super) fn shape_names() -> Vec<&'static str> {
    let generated = Generated::ALL.into_iter().map(Generated::as_str);
    Shape::ALL.into_iter().map(Shape::as_str).chain(generated).collect()
}

fn policy_names() -> Vec<&'static str> {
    PolicyName::all().map(PolicyName::as_str).collect()
}
