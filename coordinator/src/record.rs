//! The recording of a mission: an MCAP file that ROS 2 tools and viewers read.
//!
//! ```text
//! /map                       the ground, once
//! /belief                    in percent, at the start and periodically
//! /belief/probability        the same, as probabilities
//! /tf, /robots/<robot>/pose  robots' poses, when they change
//! /robots/<robot>/fix        the same on the earth
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
//! /robots/<robot>/picture    robots' pictures of finds, when they arrive
//! /objects/picture           the same for viewers of images
//! /objects/marker            all declared objects, when they change
//! /objects/geojson           the same on the earth
//! /areas/geojson             the areas drawn on the map, once
//! /mission/status            with all declared objects
//! ```
//!
//! Positions are in the frame `map` of the map's file, as on a robot's own network. `fix` and `geojson` are there if the map lies
//! on the earth.
//!
//! The map and the first belief are never lost by damage in one place: what a recording begins with is attached as
//! `beginning.mcap.zst` too, before the first chunk and, in a recording that is finished, at the end. The scenario is
//! attached as `scenario.toml`. For a georeferenced mission, the metadata `earth` hold its position, and
//! `areas.geojson` its areas. The metadata `run` hold facts about the run from its start, the metadata `summary` its
//! results. The log time of a message is the date of the mission time at which the coordinator received it, its publish time
//! that of the message's own time. The same records make the same bytes.
//!
//! A coordinator knows the date of mission time 0 only once it hears a robot, and better when its clock is set forward. What
//! is written before stays as it is dated; each message tells that date by its publish time and its own, so that none
//! depends on another.

mod channels;
pub mod encoder;
pub mod topic;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::directive::Directive;
use dragnet_proto::message::{MarkReport, OrderReport, VerdictReport, ZoneReport};
use dragnet_scenario::map_file::{Earth, MapOrigin};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::terrain::Terrain;
use mcap::records::AttachmentHeader;
use mcap::write::Metadata;

use self::channels::Channels;
use self::encoder::{Encoded, Encoder};
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
/// Name within `summary` of who has ended the mission, if the operator has, and without which robots.
pub const ENDED: &str = "ended";
/// Name within `summary` of the mission time at which the search was over, seconds.
pub const MISSION_TIME: &str = "mission_time_s";

/// Name within `run` of the prior probability that a subject is outside of the searched cells, if their number is known;
/// within `summary` of the number of subjects that are expected there at the end.
pub const REST_OF_WORLD: &str = "rest_of_world";
/// Fact of such a run: the number of subjects, if there are several.
pub const SUBJECTS: &str = "subjects";
/// Fact of the run: the variance of a reading at a distance of one cell, of each robot.
pub const NOISE_VARIANCE: &str = "noise_variance";
/// Fact of a run in which walls hide what is behind them: the radius within which they do, cells.
pub const LINE_OF_SIGHT: &str = "line_of_sight_radius";
/// Fact of such a run: the numbers of the cells that walls thinner than a cell lead along, if there are such.
pub const THIN_WALLS: &str = "thin_walls";
/// Name within `summary` of the number of subjects that are expected in declared cells at the end.
pub const SUCCESS: &str = "pos";
/// Name within `summary` of where the subjects are, in words.
pub const SOUGHT: &str = "sought";

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
    encoder: Encoder,
    channels: Channels,
    /// The directive of the last status.
    directive: Directive,
    next_flush: MissionTime,
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
            encoder: Encoder::new(&header),
            header,
            file,
            channels: Channels::default(),
            directive: Directive::default(),
            next_flush: MissionTime::START + FLUSH_PERIOD,
        };
        recorder.put_header()?;
        Ok(recorder)
    }

    fn put_header(&mut self) -> Result<(), RecordingError> {
        let opening = self.encoder.opening(&self.header.prior);
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
        self.put(&opening)?;
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
        if let Record::Began { unix_ns } = record {
            // For a further file.
            self.header.start_unix_ns = *unix_ns;
        }
        let messages = self.encoder.encode(now, record);
        self.put(&messages)?;
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
        self.attach_beginning(&self.encoder.opening(&self.header.prior))?;
        self.file.finish()
    }

    fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), RecordingError> {
        let start = self.encoder.unix_ns(MissionTime::START);
        let header = AttachmentHeader {
            log_time: start,
            create_time: start,
            name: name.into(),
            media_type: media_type.into(),
        };
        self.file.attach(&header, data)
    }

    fn attach_beginning(&mut self, opening: &[Encoded]) -> Result<(), RecordingError> {
        self.attach(BEGINNING_ATTACHMENT, "application/zstd", &self.beginning(opening)?)
    }

    /// The opening as a file.
    fn beginning(&self, opening: &[Encoded]) -> Result<Vec<u8>, RecordingError> {
        let mut bytes = Vec::new();
        let mut file = McapWriter::plain(&self.path, &mut bytes, PROFILE, LIBRARY)?;
        let mut channels = Channels::default();
        opening.iter().try_for_each(|message| channels.put(&mut file, message))?;
        file.finish()?;
        chunk::pack(&bytes).map_err(|source| RecordingError::Write {
            path: self.path.clone(),
            what: BEGINNING_ATTACHMENT.into(),
            source: source.into(),
        })
    }

    fn put(&mut self, messages: &[Encoded]) -> Result<(), RecordingError> {
        messages.iter().try_for_each(|message| self.channels.put(&mut self.file, message))
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
