//! The recording of a mission: an MCAP file that ROS 2 tools and viewers read.
//!
//! ```text
//! /map                       the ground, once
//! /belief                    in percent, at the start and periodically
//! /belief/probability        the same, as probabilities
//! /tf, /robots/<robot>/pose  robots' poses, when they change
//! /robots/<robot>/path       their plans, when they change
//! /robots/<robot>/{observation,intent,heartbeat}
//! /robots/0/verdicts         the operator's verdicts on finds, when they change
//! /robots/<robot>/verdicts   those that a robot has received; both only once there are any
//! /robots/0/orders           the operator's orders to single robots, when they change
//! /robots/<robot>/orders     those that a robot has received; both only once there are any
//! /robots/0/zones            the operator's no-go zones and skipped cells, when they change
//! /robots/<robot>/zones      those that a robot has received; both only once there are any
//! /robots/0/marks            the operator's marks, when they change
//! /robots/<robot>/marks      those that a robot has received; both only once there are any
//! /objects                   each declaration of an object
//! /mission/status            with all declared objects
//! ```
//!
//! Positions are in the frame `map` of the map's file, as on a robot's own network.
//!
//! The map and the first belief are never lost by damage in one place: what a recording begins with is attached as
//! `beginning.mcap.zst` too, before the first chunk and, in a recording that is finished, at the end. The scenario is
//! attached as `scenario.toml`. For a georeferenced mission, the metadata `earth` hold its position, and
//! `areas.geojson` its areas. The metadata `run` hold facts about the run from its start, the metadata `summary` its
//! results. The log time of a message is the mission time at which the coordinator received it, its publish time that
//! of its sender. The same records make the same bytes.

mod channels;
pub(crate) mod topic;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::directive::Directive;
use dragnet_proto::dragnet_msgs as wire;
use dragnet_proto::message::{Detection, MarkReport, MissionStatus, OrderReport, VerdictReport, ZoneReport};
use dragnet_ros2::schema::RosMessage;
use dragnet_ros2::viewer::Viewer;
use dragnet_scenario::map_file::{Earth, MapOrigin};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use dragnet_search::terrain::Terrain;
use mcap::records::AttachmentHeader;
use mcap::write::Metadata;

use self::channels::{Channels, Encoded, UnixTimes};
use self::topic::{RobotTopic, Topic};
use crate::mcap_file::write::{LiveMcapWriter, McapWriter};
use crate::mcap_file::{RecordingError, chunk};
use crate::mission::Record;

/// Name of the attachment that holds the map and the first belief, as a recording of its own. It is compressed as a
/// whole: a reader that searches a damaged file for records must not find those of another file.
pub(crate) const BEGINNING_ATTACHMENT: &str = "beginning.mcap.zst";
/// Name of the attachment that holds the scenario.
pub const SCENARIO_ATTACHMENT: &str = "scenario.toml";
/// Name of the metadata with facts about the run.
pub const RUN_METADATA: &str = "run";
/// Name of the attachment that holds the areas on the earth.
pub const AREAS_ATTACHMENT: &str = "areas.geojson";
/// Name of the metadata with the mission's position on the earth.
pub const EARTH_METADATA: &str = "earth";
/// Name of the metadata with the results of the run.
pub const SUMMARY_METADATA: &str = "summary";
/// Name within `summary` of the numbers of finds, if the operator has decided about some.
pub const FINDS: &str = "finds";
/// Name within `summary` of who has ended the mission, unless the coordinator was stopped.
pub const ENDED: &str = "ended";
/// The operator has, for [`ENDED`].
pub const BY_THE_OPERATOR: &str = "by the operator";
/// Name within `summary` of the mission time at which the search was over, seconds.
pub const MISSION_TIME: &str = "mission_time_s";

/// Name within `run` of the prior probability that the one subject is outside of the searched cells, if exactly one is
/// sought; within `summary` of the same probability at the end.
pub const REST_OF_WORLD: &str = "rest_of_world";
/// Name within `summary` of the probability at the end that the one subject is in a declared cell.
pub const SUCCESS: &str = "pos";

/// A crash loses at most the records of this much mission time.
pub const FLUSH_PERIOD: Duration = Duration::from_secs(1);

const PROFILE: &str = "ros2";
const LIBRARY: &str = concat!("dragnet ", env!("CARGO_PKG_VERSION"));

/// The content of a recording's beginning.
#[derive(Clone, Debug)]
pub struct Header {
    /// The mission's start, Unix time, nanoseconds.
    pub start_unix_ns: i64,
    /// The map.
    pub terrain: Arc<Terrain>,
    /// Pose of the map in the frame of its file, which all positions are in.
    pub origin: MapOrigin,
    /// The belief before any reading.
    pub prior: Belief,
    /// The text of the scenario file.
    pub scenario: String,
    /// The mission's position on the earth, if known.
    pub earth: Option<Earth>,
    /// Facts about the run: scenario, seed, commit, version, policy.
    pub run: BTreeMap<String, String>,
}

/// Writes one recording. Dropping it finishes the recording without a summary.
pub struct Recorder {
    path: PathBuf,
    header: Header,
    file: LiveMcapWriter,
    channels: Channels,
    /// Cells and times, nanoseconds, of the objects declared at the last status.
    declared: BTreeSet<(Cell, u64)>,
    /// The directive of the last status.
    directive: Directive,
    next_flush: MissionTime,
}

/// When the coordinator received a message, and when its sender published it.
#[derive(Clone, Copy)]
struct Times {
    logged: MissionTime,
    published: MissionTime,
}

impl Recorder {
    /// Creates the file and writes its beginning.
    ///
    /// # Errors
    /// If the path exists, or cannot be written.
    pub fn create(path: &Path, header: Header) -> Result<Self, RecordingError> {
        let file = LiveMcapWriter::create(path, PROFILE, LIBRARY)?;
        Self::begin(path.to_owned(), file, header)
    }

    /// Creates the file or, if the path exists, the first unused one after it: `today-2.mcap` after `today.mcap`.
    ///
    /// # Errors
    /// If nothing can be written there.
    pub fn create_beside(path: &Path, header: Header) -> Result<Self, RecordingError> {
        if path.exists() && !path.is_file() {
            return Err(RecordingError::NoPlainFile { path: path.to_owned() });
        }
        let mut free = path.to_owned();
        for number in 2.. {
            match LiveMcapWriter::create(&free, PROFILE, LIBRARY) {
                Err(RecordingError::Exists { .. }) => free = numbered(path, number),
                file => return Self::begin(free, file?, header),
            }
        }
        Err(RecordingError::Exists { path: path.to_owned() })
    }

    fn begin(path: PathBuf, file: LiveMcapWriter, header: Header) -> Result<Self, RecordingError> {
        let mut recorder = Self {
            path,
            header,
            file,
            channels: Channels::default(),
            declared: BTreeSet::new(),
            directive: Directive::default(),
            next_flush: MissionTime::START + FLUSH_PERIOD,
        };
        recorder.put_header()?;
        Ok(recorder)
    }

    fn put_header(&mut self) -> Result<(), RecordingError> {
        let start = MissionTime::START;
        let opening = self.opening();
        self.attach_beginning(&opening)?;
        let metadata = Metadata { name: RUN_METADATA.into(), metadata: self.header.run.clone() };
        self.file.metadata(&metadata)?;
        self.attach(SCENARIO_ATTACHMENT, "application/toml", self.header.scenario.clone().as_bytes())?;
        if let Some(earth) = &self.header.earth {
            let metadata = Metadata { name: EARTH_METADATA.into(), metadata: earth.facts() };
            let areas = earth.areas_geojson();
            self.file.metadata(&metadata)?;
            self.attach(AREAS_ATTACHMENT, "application/geo+json", areas.as_bytes())?;
        }
        let times = Times { logged: start, published: start };
        opening.iter().try_for_each(|message| self.put_encoded(times, message))?;
        self.file.flush()
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Why the disk is currently not writable, if it is not; records wait in memory meanwhile.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        self.file.trouble()
    }

    /// Gives up a file that cannot be written any more, and returns its header for the next one.
    pub(crate) fn give_up(self) -> Header {
        self.header
    }

    /// Writes a record of the mission.
    ///
    /// # Errors
    /// If it cannot be written, for example when the disk has been full for so long that no more can wait in memory.
    /// What was flushed before stays readable, but nothing more can be recorded.
    pub fn record(&mut self, now: MissionTime, record: &Record) -> Result<(), RecordingError> {
        let at = |time_ns| Times { logged: now, published: MissionTime(time_ns) };
        match record {
            Record::Observation(observation) => {
                let topic = Topic::Robot(observation.origin.source, RobotTopic::Observation);
                self.put(topic, at(observation.time_ns), &wire::Observation::from(&**observation))?;
            }
            Record::Intent(intent) => {
                let topic = Topic::Robot(intent.robot.into(), RobotTopic::Intent);
                self.put(topic, at(intent.time_ns), &wire::Intent::from(intent))?;
            }
            Record::Heartbeat(heartbeat) => {
                let topic = Topic::Robot(heartbeat.robot.into(), RobotTopic::Heartbeat);
                self.put(topic, at(heartbeat.time_ns), &wire::Heartbeat::from(heartbeat))?;
            }
            Record::Pose { robot, cell, time } => self.put_pose(at(time.0), *robot, *cell)?,
            Record::Plan { robot, path } => {
                let path = self.viewer().path(path, now);
                self.put(Topic::Robot((*robot).into(), RobotTopic::Path), at(now.0), &path)?;
            }
            Record::Status(status) => self.put_status(now, status)?,
            Record::Verdicts(report) => {
                let topic = Topic::Robot(report.from.into(), RobotTopic::Verdicts);
                self.put(topic, at(report.time_ns), &wire::Verdicts::from(report))?;
            }
            Record::Orders(report) => {
                let topic = Topic::Robot(report.from.into(), RobotTopic::Orders);
                self.put(topic, at(report.time_ns), &wire::Orders::from(report))?;
            }
            Record::Marks(report) => {
                let topic = Topic::Robot(report.from.into(), RobotTopic::Marks);
                self.put(topic, at(report.time_ns), &wire::Marks::from(report))?;
            }
            Record::Zones(report) => {
                let topic = Topic::Robot(report.from.into(), RobotTopic::Zones);
                self.put(topic, at(report.time_ns), &wire::Zones::from(report))?;
            }
            Record::Belief(belief) => self.put_belief(now, belief)?,
        }
        if self.is_of_operator(record) {
            return self.flush();
        }
        self.tick(now)
    }

    /// Whether a record is a new instruction of the operator, or the status with it: the mission's time may stand still then.
    fn is_of_operator(&mut self, record: &Record) -> bool {
        match record {
            Record::Status(status) => {
                let is_new = self.directive != status.directive;
                self.directive.clone_from(&status.directive);
                is_new
            }
            Record::Verdicts(VerdictReport { from, .. })
            | Record::Orders(OrderReport { from, .. })
            | Record::Zones(ZoneReport { from, .. })
            | Record::Marks(MarkReport { from, .. }) => *from == Participant::Coordinator,
            _ => false,
        }
    }

    /// Flushes the file if the flush period has passed. [`Recorder::record`] does this too; call this function when
    /// there are no records for longer than that period.
    ///
    /// # Errors
    /// As [`Recorder::record`].
    pub fn tick(&mut self, now: MissionTime) -> Result<(), RecordingError> {
        if now < self.next_flush {
            return Ok(());
        }
        self.next_flush = now + FLUSH_PERIOD;
        self.file.flush()
    }

    /// Passes everything to the operating system.
    ///
    /// # Errors
    /// As [`Recorder::record`].
    pub(crate) fn flush(&mut self) -> Result<(), RecordingError> {
        self.file.flush()
    }

    /// Writes the results of the run, and ends the file.
    ///
    /// # Errors
    /// As [`Recorder::record`].
    pub fn finish(mut self, summary: BTreeMap<String, String>) -> Result<(), RecordingError> {
        self.file.metadata(&Metadata { name: SUMMARY_METADATA.into(), metadata: summary })?;
        self.attach_beginning(&self.opening())?;
        self.file.finish()
    }

    fn viewer(&self) -> Viewer<'_> {
        Viewer::new(&self.header.terrain, self.header.origin, self.header.start_unix_ns)
    }

    fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), RecordingError> {
        let start = self.unix_ns(MissionTime::START);
        let header = AttachmentHeader {
            log_time: start,
            create_time: start,
            name: name.into(),
            media_type: media_type.into(),
        };
        self.file.attach(&header, data)
    }

    /// The map and the belief before any reading.
    fn opening(&self) -> [Encoded; 3] {
        let [percent, probability] = self.belief(MissionTime::START, &self.header.prior);
        let map = self.viewer().terrain(MissionTime::START);
        [Encoded::new(Topic::Map, &map), percent, probability]
    }

    fn attach_beginning(&mut self, opening: &[Encoded]) -> Result<(), RecordingError> {
        self.attach(BEGINNING_ATTACHMENT, "application/zstd", &self.beginning(opening)?)
    }

    /// The opening as a file.
    fn beginning(&self, opening: &[Encoded]) -> Result<Vec<u8>, RecordingError> {
        let mut bytes = Vec::new();
        let mut file = McapWriter::plain(&self.path, &mut bytes, PROFILE, LIBRARY)?;
        let mut channels = Channels::default();
        let start = self.unix_ns(MissionTime::START);
        let times = UnixTimes { logged: start, published: start };
        opening.iter().try_for_each(|message| channels.put(&mut file, times, message))?;
        file.finish()?;
        chunk::pack(&bytes).map_err(|source| RecordingError::Write {
            path: self.path.clone(),
            what: BEGINNING_ATTACHMENT.into(),
            source: source.into(),
        })
    }

    fn belief(&self, now: MissionTime, belief: &Belief) -> [Encoded; 2] {
        let (viewer, probabilities) = (self.viewer(), belief.probabilities());
        [
            Encoded::new(Topic::Belief, &viewer.belief(&probabilities, now)),
            Encoded::new(Topic::BeliefProbability, &viewer.probability(&probabilities, now)),
        ]
    }

    fn put_belief(&mut self, now: MissionTime, belief: &Belief) -> Result<(), RecordingError> {
        let times = Times { logged: now, published: now };
        self.belief(now, belief).iter().try_for_each(|message| self.put_encoded(times, message))
    }

    fn put_pose(&mut self, times: Times, robot: RobotId, cell: Cell) -> Result<(), RecordingError> {
        let pose = self.viewer().pose(cell, times.published);
        self.put(Topic::Robot(robot.into(), RobotTopic::Pose), times, &pose)?;
        let transform = self.viewer().map_from_robot(robot, cell, times.published);
        self.put(Topic::Transforms, times, &transform)
    }

    /// Objects declared since the last status are recorded once each.
    fn put_status(&mut self, now: MissionTime, status: &MissionStatus) -> Result<(), RecordingError> {
        let times = Times { logged: now, published: MissionTime(status.time_ns) };
        let name = |object: &Detection| (object.cell, object.time_ns);
        let before = std::mem::replace(&mut self.declared, status.declared.iter().map(name).collect());
        for object in status.declared.iter().filter(|object| !before.contains(&name(object))) {
            self.put(Topic::Objects, times, &wire::Detection::from(object))?;
        }
        self.put(Topic::MissionStatus, times, &wire::MissionStatus::from(status))
    }

    fn put<T: RosMessage>(&mut self, topic: Topic, times: Times, message: &T) -> Result<(), RecordingError> {
        self.put_encoded(times, &Encoded::new(topic, message))
    }

    fn put_encoded(&mut self, times: Times, message: &Encoded) -> Result<(), RecordingError> {
        let times =
            UnixTimes { logged: self.unix_ns(times.logged), published: self.unix_ns(times.published) };
        self.channels.put(&mut self.file, times, message)
    }

    /// MCAP counts from 1970 on.
    fn unix_ns(&self, time: MissionTime) -> u64 {
        let unix_ns = i128::from(self.header.start_unix_ns) + i128::from(time.0);
        u64::try_from(unix_ns.max(0)).unwrap_or(u64::MAX)
    }
}

/// The name of a further file beside one.
fn numbered(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}
