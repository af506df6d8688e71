//! The mission as messages that viewers read: each with its topic, its definition, its times and its bytes.
//!
//! A recording holds them, and viewers of a running mission get the same: the same records make the same messages.

use std::collections::BTreeSet;
use std::sync::Arc;

use dragnet_proto::dragnet_msgs as wire;
use dragnet_proto::message::{Detection, MissionStatus};
use dragnet_proto::picture::Picture;
pub use dragnet_ros2::cdr::ENCODING as MESSAGE_ENCODING;
pub use dragnet_ros2::schema::ENCODING as SCHEMA_ENCODING;
use dragnet_ros2::schema::RosMessage;
use dragnet_ros2::viewer::Viewer;
use dragnet_ros2::wire::standard::GeoJson;
use dragnet_scenario::map_file::{Earth, GeoPoint, MapOrigin};
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Places, accuracy};
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::object_position::{ObjectPosition, ObjectPositions};
use dragnet_search::observation::{Observation, RobotId};
use dragnet_search::terrain::Terrain;

use serde_json::{Value, json};

use super::Header;
use super::topic::{RobotTopic, Topic};
use crate::mission::Record;
use crate::node::Listener;

/// A message as viewers read it.
#[derive(Clone, Debug)]
pub struct Encoded {
    topic: Topic,
    /// The robot whose transform it is; messages of other topics have none.
    transformed: Option<RobotId>,
    schema_name: &'static str,
    /// Text of its definition, which is long.
    schema: fn() -> String,
    times: UnixTimes,
    data: Vec<u8>,
}

/// When a message was received, and when its sender published it: Unix time, nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnixTimes {
    /// When the coordinator received it.
    pub logged: u64,
    /// When its sender published it.
    pub published: u64,
}

/// What a message is the state of: the next one with the same replaces it.
pub type StateOf = (Topic, Option<RobotId>);

impl Encoded {
    /// Its topic.
    #[must_use]
    pub const fn topic(&self) -> Topic {
        self.topic
    }

    /// Package, `msg` and name of its definition, such as `nav_msgs/msg/OccupancyGrid`.
    #[must_use]
    pub const fn schema_name(&self) -> &'static str {
        self.schema_name
    }

    /// Text of its definition and of those in it, in [`SCHEMA_ENCODING`].
    #[must_use]
    pub fn schema(&self) -> String {
        (self.schema)()
    }

    /// When it was received and published.
    #[must_use]
    pub const fn times(&self) -> UnixTimes {
        self.times
    }

    /// Its bytes, in [`MESSAGE_ENCODING`].
    #[must_use]
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// Its bytes.
    #[must_use]
    pub fn into_data(self) -> Vec<u8> {
        self.data
    }

    /// What it is the state of: a viewer that comes later needs the newest message of each. `None` if it reports an event.
    #[must_use]
    pub const fn state_of(&self) -> Option<StateOf> {
        if self.topic.is_of_events() { None } else { Some((self.topic, self.transformed)) }
    }
}

/// Makes the messages of one mission.
pub struct Encoder {
    /// The date of mission time 0, by which the next messages are dated.
    start_unix_ns: i64,
    terrain: Arc<Terrain>,
    origin: MapOrigin,
    /// Where cells are on the earth, if that is known.
    places: Places,
    /// Text with the areas drawn on the map, if it lies on the earth and there are any.
    areas: Option<String>,
    /// Cells and times, nanoseconds, of the objects declared at the last status.
    declared: BTreeSet<(Cell, u64)>,
    /// Positions of objects, as far as robots know them.
    positions: ObjectPositions,
}

/// When the coordinator received a message, and when its sender published it.
#[derive(Clone, Copy)]
struct Times {
    logged: MissionTime,
    published: MissionTime,
}

impl Encoder {
    /// For the mission that a header describes.
    #[must_use]
    pub fn new(header: &Header) -> Self {
        Self {
            start_unix_ns: header.start_unix_ns,
            terrain: Arc::clone(&header.terrain),
            origin: header.origin,
            places: Places::new(&header.terrain, header.earth.as_ref().map(|earth| &earth.frame)),
            areas: header.earth.as_ref().filter(|earth| !earth.areas.is_empty()).map(Earth::areas_geojson),
            declared: BTreeSet::new(),
            positions: ObjectPositions::default(),
        }
    }

    /// The map, the belief before any reading, and the areas if there are any.
    #[must_use]
    pub fn opening(&self, prior: &Belief) -> Vec<Encoded> {
        let (start, map) = (MissionTime::START, self.viewer().terrain(MissionTime::START));
        let times = Times { logged: start, published: start };
        let map = self.message(Topic::Map, times, &map);
        let areas = self.areas.clone().map(|geojson| self.message(Topic::Areas, times, &GeoJson { geojson }));
        std::iter::once(map).chain(self.belief(start, prior)).chain(areas).collect()
    }

    /// The messages of a record, which the coordinator makes at this time.
    pub fn encode(&mut self, now: MissionTime, record: &Record) -> Vec<Encoded> {
        let at = |time_ns| Times { logged: now, published: MissionTime(time_ns) };
        match record {
            Record::Observation(observation) => {
                let topic = Topic::Robot(observation.origin.source, RobotTopic::Observation);
                let message =
                    self.message(topic, at(observation.time_ns), &wire::Observation::from(&**observation));
                [message].into_iter().chain(self.locate(at(now.0), observation)).collect()
            }
            Record::Intent(intent) => {
                let topic = Topic::Robot(intent.robot.into(), RobotTopic::Intent);
                vec![self.message(topic, at(intent.time_ns), &wire::Intent::from(intent))]
            }
            Record::Heartbeat(heartbeat) => {
                let topic = Topic::Robot(heartbeat.robot.into(), RobotTopic::Heartbeat);
                vec![self.message(topic, at(heartbeat.time_ns), &wire::Heartbeat::from(heartbeat))]
            }
            Record::Pose { robot, cell, time } => self.pose(at(time.0), *robot, *cell),
            Record::Plan { robot, path } => {
                let path = self.viewer().path(path, now);
                vec![self.message(Topic::Robot((*robot).into(), RobotTopic::Path), at(now.0), &path)]
            }
            Record::Status(status) => self.status(now, status),
            Record::Verdicts(report) => {
                let topic = Topic::Robot(report.from.into(), RobotTopic::Verdicts);
                vec![self.message(topic, at(report.time_ns), &wire::Verdicts::from(report))]
            }
            Record::Orders(report) => {
                let topic = Topic::Robot(report.from.into(), RobotTopic::Orders);
                vec![self.message(topic, at(report.time_ns), &wire::Orders::from(report))]
            }
            Record::Marks(report) => {
                let topic = Topic::Robot(report.from.into(), RobotTopic::Marks);
                vec![self.message(topic, at(report.time_ns), &wire::Marks::from(report))]
            }
            Record::Zones(report) => {
                let topic = Topic::Robot(report.from.into(), RobotTopic::Zones);
                vec![self.message(topic, at(report.time_ns), &wire::Zones::from(report))]
            }
            Record::Picture(picture) => self.picture(at(picture.facts.time_ns), picture),
            Record::Belief(belief) => self.belief(now, belief).into(),
            Record::Began { unix_ns } => {
                self.start_unix_ns = *unix_ns;
                Vec::new()
            }
        }
    }

    fn belief(&self, now: MissionTime, belief: &Belief) -> [Encoded; 2] {
        let (viewer, probabilities) = (self.viewer(), belief.probabilities());
        let times = Times { logged: now, published: now };
        [
            self.message(Topic::Belief, times, &viewer.belief(&probabilities, now)),
            self.message(Topic::BeliefProbability, times, &viewer.probability(&probabilities, now)),
        ]
    }

    fn pose(&self, times: Times, robot: RobotId, cell: Cell) -> Vec<Encoded> {
        let pose = self.viewer().pose(cell, times.published);
        let transform = self.viewer().map_from_robot(robot, cell, times.published);
        let transform = self.message(Topic::Transforms, times, &transform);
        let fix = self.places.center(cell).map(|place| self.viewer().fix(robot, place, times.published));
        let fix = fix.map(|fix| self.message(Topic::Robot(robot.into(), RobotTopic::Fix), times, &fix));
        let pose = self.message(Topic::Robot(robot.into(), RobotTopic::Pose), times, &pose);
        [pose, Encoded { transformed: Some(robot), ..transform }].into_iter().chain(fix).collect()
    }

    /// For playback, and for viewers of images.
    fn picture(&self, times: Times, picture: &Picture) -> Vec<Encoded> {
        let topic = Topic::Robot(picture.facts.robot.into(), RobotTopic::Picture);
        let whole = wire::Picture::from(&picture.part(0, Picture::MAX_BYTES));
        let image = self.viewer().jpeg(picture.facts.robot, &picture.jpeg, times.published);
        vec![self.message(topic, times, &whole), self.message(Topic::Pictures, times, &image)]
    }

    /// Objects declared since the last status are messages of their own, once each.
    fn status(&mut self, now: MissionTime, status: &MissionStatus) -> Vec<Encoded> {
        let times = Times { logged: now, published: MissionTime(status.time_ns) };
        let name = |object: &Detection| (object.cell, object.time_ns);
        let before = std::mem::replace(&mut self.declared, status.declared.iter().map(name).collect());
        let new = status.declared.iter().filter(|object| !before.contains(&name(object)));
        let objects = new.map(|object| self.message(Topic::Objects, times, &wire::Detection::from(object)));
        let places = (before != self.declared).then(|| self.declared_places(times));
        let status = self.message(Topic::MissionStatus, times, &wire::MissionStatus::from(status));
        objects.chain(places.into_iter().flatten()).chain([status]).collect()
    }

    /// Takes the positions of objects; viewers get the declared ones anew if one of them is elsewhere now.
    fn locate(&mut self, times: Times, observation: &Observation) -> Vec<Encoded> {
        let place = |encoder: &Self, cell| encoder.positions.of(cell).copied();
        let cells = observation.positions.iter().map(ObjectPosition::cell);
        let declared = cells.filter(|&cell| self.declared.iter().any(|&(declared, _)| declared == cell));
        let before: Vec<_> = declared.map(|cell| (cell, place(self, cell))).collect();
        self.positions.add(observation);
        let has_moved = before.into_iter().any(|(cell, before)| place(self, cell) != before);
        if has_moved { self.declared_places(times).collect() } else { Vec::new() }
    }

    /// All declared objects as viewers draw them: on the map, and on the earth if that is known.
    fn declared_places(&self, times: Times) -> impl Iterator<Item = Encoded> + use<> {
        let objects = self.declared.iter().map(|&(cell, _)| (cell, self.positions.of(cell)));
        let marker = self.viewer().marker(objects, times.published);
        let earth = self.places_on_earth();
        let earth = earth.map(|places| self.message(Topic::Places, times, &places));
        std::iter::once(self.message(Topic::Marker, times, &marker)).chain(earth)
    }

    fn places_on_earth(&self) -> Option<GeoJson> {
        let feature = |&(cell, _): &(Cell, u64)| {
            let position = self.positions.of(cell);
            let GeoPoint { longitude_degrees, latitude_degrees } =
                self.places.object_point(cell, position)?;
            let known = position
                .map_or_else(String::new, |position| format!(", {}", accuracy(position.accuracy_meters())));
            Some(json!({
                "type": "Feature",
                "geometry": { "type": "Point", "coordinates": [longitude_degrees, latitude_degrees] },
                "properties": { "name": format!("object in cell {}{known}", self.places.cell(cell)) },
            }))
        };
        let features: Vec<Value> = self.declared.iter().map(feature).collect::<Option<_>>()?;
        Some(GeoJson { geojson: json!({ "type": "FeatureCollection", "features": features }).to_string() })
    }

    fn message<T: RosMessage>(&self, topic: Topic, times: Times, message: &T) -> Encoded {
        let times =
            UnixTimes { logged: self.unix_ns(times.logged), published: self.unix_ns(times.published) };
        let (schema_name, schema) = (T::NAME, T::schema as fn() -> String);
        Encoded { topic, transformed: None, schema_name, schema, times, data: message.to_cdr() }
    }

    fn viewer(&self) -> Viewer<'_> {
        Viewer::new(&self.terrain, self.origin, self.start_unix_ns)
    }

    /// Viewers count from 1970 on.
    pub(super) fn unix_ns(&self, time: MissionTime) -> u64 {
        let unix_ns = i128::from(self.start_unix_ns) + i128::from(time.0);
        u64::try_from(unix_ns.max(0)).unwrap_or(u64::MAX)
    }
}

/// Receives each message of a mission.
pub type MessageListener = Box<dyn FnMut(Encoded) + Send>;

/// A listener for the coordinator's records that passes on their messages, those of the opening at once.
#[must_use]
pub fn telling(header: &Header, mut tell: MessageListener) -> Listener {
    let mut encoder = Encoder::new(header);
    encoder.opening(&header.prior).into_iter().for_each(&mut tell);
    Box::new(move |now, record| encoder.encode(now, record).into_iter().for_each(&mut tell))
}
