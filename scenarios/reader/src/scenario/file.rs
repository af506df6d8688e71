//! The scenario file as it is written: names, defaults and nothing checked yet. The comments of this file are
//! the descriptions in
//! `scenarios/scenario.schema.json`.

use dragnet_learn::policy::PolicyName;
use dragnet_search::generated::Generated;
use dragnet_search::policy::PolicyName as Exact;
use dragnet_search::sensor::Sensor;
use dragnet_search::shape::Shape;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A Dragnet scenario: what is searched, by whom, with what, for how long, and over which network.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScenarioFile {
    /// Name of the mission, part of its keys on the network: 1 to 64 letters, digits, `_` and `-`.
    #[schemars(regex(pattern = r"^[A-Za-z0-9_-]{1,64}$"))]
    pub name: String,
    /// What is searched.
    pub map: MapTable,
    /// What a robot sees with.
    #[serde(default)]
    pub sensor: SensorTable,
    /// What is believed before the first look.
    #[serde(default)]
    pub prior: PriorTable,
    /// What is there to be found.
    pub objects: ObjectsTable,
    /// Who searches.
    #[serde(default)]
    pub robots: RobotsTable,
    /// For how long, and when an object counts as found.
    pub mission: MissionTable,
    /// What goes wrong between the robots (simulation only).
    #[serde(default)]
    pub network: NetworkTable,
    /// What is recorded.
    #[serde(default)]
    pub recording: RecordingTable,
    /// How processes find each other when they run on several machines.
    #[serde(default)]
    pub zenoh: ZenohTable,
}

/// What is searched: a shape with rows and columns, or a file.
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
    /// Which map of a generated shape (`caves`, `blocks`, `rooms`).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0, max = 4_294_967_295_u32))]
    pub seed: Option<i64>,
    /// A map file, relative to the scenario: `.txt` drawing, `.yaml` ROS map, `.map` of `MovingAI`,
    /// `.geojson` or `.kml` areas. Excludes `shape`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Where the map's south-western corner lies on the earth; of a map that does not say so itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub origin: Option<OriginTable>,
    /// Edge of a cell, meters, from 0.001.
    #[serde(default = "default_cell_meters")]
    #[schemars(range(min = 0.001))]
    pub cell_meters: f64,
    /// To how many neighbors a robot moves: 4, or 8 with diagonals.
    #[serde(default = "default_moves")]
    #[schemars(extend("enum" = [4, 8]))]
    pub connectivity: i64,
}

/// A point of WGS84.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OriginTable {
    /// North positive, -85 to 85.
    #[schemars(range(min = -85.0, max = 85.0))]
    pub latitude_degrees: f64,
    /// East positive, -180 to 180.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub longitude_degrees: f64,
}

/// What a robot sees with: all cells within a Manhattan radius.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SensorTable {
    /// Manhattan radius, cells, 1 to 100 and no more than the map's larger side.
    #[schemars(range(min = 1, max = 100))]
    pub radius: i64,
    /// Variance of a reading at distance 1; at distance d it is `noise_variance d^2`, of the robot's own cell
    /// `noise_variance / 5`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub noise_variance: f64,
    /// How readings scatter: `gaussian` around the truth, or `clipped` to 0..1 as in the released code of
    /// NATS.
    #[schemars(extend("enum" = ["gaussian", "clipped"]))]
    pub noise: String,
}

/// What is believed before the first look; without a key, what regions of the map say, or else the objects' expected
/// density.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PriorTable {
    /// Probability of an object in each searched cell, above 0 and below 1. Excludes `file`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub probability: Option<f64>,
    /// A probability per cell, relative to the scenario, the northern edge first: numbers in `.csv` or
    /// `.txt`, or a `.pgm` or `.png` image. Or regions on the earth with their probabilities, `.geojson` or `.kml`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
}

/// What is there to be found (simulation only, but for the prior): exactly one of these.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ObjectsTable {
    /// So many objects in searched cells drawn at random, 0 to the number of searched cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub count: Option<i64>,
    /// Each searched cell holds an object with this probability, above 0 and below 1, independently.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub density: Option<f64>,
    /// Exactly these searched cells, each `[row, column]`: rows from 0 in the south, columns from 0 in the
    /// west.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<Vec<[i64; 2]>>,
}

/// Who searches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RobotsTable {
    /// Robots, 1 to 1000; they are numbered from 1.
    #[schemars(range(min = 1, max = 1000))]
    pub count: i64,
    /// How they decide where to go.
    pub policy: PolicyField,
    /// Where they start.
    pub start: StartField,
    /// Robots that differ from the rest.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub robot: Vec<RobotTable>,
}

/// A robot that differs from the rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotTable {
    /// Which one, 1 to `count`.
    #[schemars(range(min = 1, max = 1000))]
    pub number: i64,
    /// How it decides; without, like the rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub policy: Option<PolicyField>,
    /// Where it starts; without, like the rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<StartField>,
}

/// A policy by its name, or by a table of its name and parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a policy is its name, or a table of `name`, `path_length_weight` (number), `lane_spacing_cells` (whole number), `replan_after_cells` (whole number) and `weights` (file)"
)]
pub enum PolicyField {
    /// The name alone.
    Name(#[schemars(extend("enum" = policy_names()))] String),
    /// The name and parameters.
    Table(PolicyTable),
}

/// A policy and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicyTable {
    /// Which policy.
    #[schemars(extend("enum" = policy_names()))]
    pub name: String,
    /// Of `path` and `path-additive`: `w_l` in the weight `1 / (1 + w_l L)` of a path of L cells, 0 to 1000,
    /// 0.2 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub path_length_weight: Option<f64>,
    /// Of `coverage`: cells between its lanes, 1 to 1000, 1 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1000))]
    pub lane_spacing_cells: Option<i64>,
    /// Decide anew after so many cells, 1 to 1000000; by default at the waypoint.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub replan_after_cells: Option<i64>,
    /// Of `gnn`: a weights file, relative to the scenario, instead of the weights that are part of the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<String>,
}

/// Where robots start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a start is \"random\", \"scattered\", or a cell as [row, column]")]
pub enum StartField {
    /// `random`: one cell for all, drawn in the largest connected area; `scattered`: each robot draws its own
    /// there.
    Word(#[schemars(extend("enum" = ["random", "scattered"]))] String),
    /// This traversable cell, `[row, column]`: rows from 0 in the south, columns from 0 in the west.
    Cell([i64; 2]),
}

/// For how long, and when an object counts as found. At least one budget.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MissionTable {
    /// A cell whose probability reaches this is declared an object, above 0.5 and below 1.
    #[schemars(extend("exclusiveMinimum" = 0.5, "exclusiveMaximum" = 1))]
    pub detection_threshold: f64,
    /// The way that each robot may cover, meters, above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub budget_meters: Option<f64>,
    /// The time from the mission's start, seconds, above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub budget_seconds: Option<f64>,
    /// Speed of a robot, meters a second, from 0.001; whoever claims to be faster is not believed.
    #[schemars(range(min = 0.001))]
    pub speed_meters_per_second: f64,
    /// Stop when this number of objects or fewer are expected outside the declared cells, of those that robots can see, at
    /// least 0; 0 is not before nothing is worth a look.
    #[schemars(range(min = 0.0))]
    pub stop_when_expected_remaining: f64,
    /// Time between two signs of life of a robot, seconds, from 0.01.
    #[schemars(range(min = 0.01))]
    pub heartbeat_seconds: f64,
    /// Silence after which a robot is taken for lost, seconds, above `heartbeat_seconds`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub liveness_timeout_seconds: f64,
    /// Robot k takes its first decision (k - 1) times this later, so that it knows the plans before it,
    /// seconds, at least 0.
    #[schemars(range(min = 0.0))]
    pub start_stagger_seconds: f64,
    /// What two robots count as the mission's time may differ by this: observations that are dated later are not taken yet, seconds, at least 0.
    #[schemars(range(min = 0.0))]
    pub max_clock_skew_seconds: f64,
}

/// What goes wrong between the robots (simulation only).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NetworkTable {
    /// Probability that a message is lost on its way to one receiver, at least 0 and below 1.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1))]
    pub loss: f64,
    /// Time that every message takes, seconds, at least 0.
    #[schemars(range(min = 0.0))]
    pub delay_seconds: f64,
    /// Each message takes up to this longer, uniformly, seconds, at least 0. Messages overtake each other so.
    #[schemars(range(min = 0.0))]
    pub jitter_seconds: f64,
    /// Probability that a message arrives twice, at least 0 and below 1.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1))]
    pub duplication: f64,
    /// Probability that a message takes `reorder_seconds` longer, at least 0 and below 1.
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1))]
    pub reorder: f64,
    /// How much longer, seconds; above 0 where `reorder` is.
    #[schemars(range(min = 0.0))]
    pub reorder_seconds: f64,
    /// Times at which groups cannot hear each other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub partitions: Vec<PartitionTable>,
}

/// A time at which groups cannot hear each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartitionTable {
    /// Begin, seconds from the mission's start, at least 0.
    #[schemars(range(min = 0.0))]
    pub from_seconds: f64,
    /// End, seconds from the mission's start, above `from_seconds`.
    #[schemars(range(min = 0.0))]
    pub to_seconds: f64,
    /// Groups that hear only themselves: robots by number, and "coordinator". All who are not named are one
    /// more group.
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

/// What is recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RecordingTable {
    /// MCAP file to write, relative to the working directory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Time between two recorded beliefs, seconds, from 0.01.
    #[schemars(range(min = 0.01))]
    pub belief_period_seconds: f64,
}

/// How processes find each other when they run on several machines.
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
            noise_variance: Sensor::DEFAULT_SIGMA2,
            noise: "gaussian".to_owned(),
        }
    }
}

impl Default for RobotsTable {
    fn default() -> Self {
        Self {
            count: 1,
            policy: PolicyField::Name(Exact::Path.as_str().to_owned()),
            start: StartField::Word("random".to_owned()),
            robot: Vec::new(),
        }
    }
}

impl Default for MissionTable {
    fn default() -> Self {
        Self {
            detection_threshold: 0.95,
            budget_meters: None,
            budget_seconds: None,
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
