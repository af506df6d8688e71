//! Reads a recording as a list of records, in order.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::clock;
use dragnet_proto::convert::Codec;
use dragnet_proto::message::{Message, MessageKind};
use dragnet_proto::picture::Assembly;
use dragnet_ros2::cdr;
use dragnet_ros2::wire::standard::{Grid as WireGrid, OccupancyGrid};
use dragnet_scenario::map_file::{Earth, MapOrigin};
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Grid;
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::reach::Sight;
use dragnet_search::sensor::{Noise, Sensor};
use dragnet_search::subjects::Subjects;
use dragnet_search::terrain::{Ground, Terrain};
use mcap::records::{MessageHeader, Record as McapRecord};

use crate::mcap_file::read::McapReader;
use crate::mcap_file::{Ending, RecordingError, chunk};
use crate::mission::Record;
use crate::record::topic::{RobotTopic, Topic};
use crate::record::{
    AREAS_ATTACHMENT, BEGINNING_ATTACHMENT, EARTH_METADATA, LINE_OF_SIGHT, MISSION_TIME, NOISE_VARIANCE,
    REST_OF_WORLD, RUN_METADATA, SCENARIO_ATTACHMENT, SUBJECTS, SUMMARY_METADATA, THIN_WALLS,
};

/// For recordings without a detection threshold.
const DEFAULT_DETECTION_THRESHOLD: f64 = 0.95;
/// For a recording whose areas are lost.
const NO_AREAS: &str = r#"{"type":"FeatureCollection","features":[]}"#;

/// A recorded mission. Its records are [`Record::Observation`], [`Record::Intent`], [`Record::Heartbeat`],
/// [`Record::Status`], [`Record::Verdicts`], [`Record::Orders`], [`Record::Zones`], [`Record::Marks`] and [`Record::Picture`]; all others follow from them.
#[derive(Clone, Debug)]
pub struct Playback {
    /// The map at the start.
    pub terrain: Arc<Terrain>,
    /// Pose of the map in the frame of its file.
    pub origin: MapOrigin,
    /// The prior probability of an object, shape `[cells]`; 0 where nothing is searched.
    pub prior: Vec<f32>,
    /// The records with the time at which the coordinator received them, in that order.
    pub records: Vec<(MissionTime, Record)>,
    /// The date of mission time 0, as the coordinator knew it at the end: Unix time, nanoseconds.
    pub start_unix_ns: u64,
    /// The mission's position on the earth, if recorded.
    pub earth: Option<Earth>,
    /// Facts about the run, from its start.
    pub run: BTreeMap<String, String>,
    /// Results of the run; empty in a truncated recording.
    pub summary: BTreeMap<String, String>,
    /// How the recording ends.
    pub ending: Ending,
}

impl Playback {
    /// A fact that robots may differ in, for each robot by number: a recording has one value for all of them, or one for
    /// each. `None` if a value is missing or invalid.
    #[must_use]
    pub fn of_robots<T: Clone + FromStr>(&self, fact: &str) -> Option<Vec<T>> {
        let robots: usize = self.run.get("robots")?.parse().ok()?;
        let values = self.run.get(fact)?.split(',').map(|text| text.parse().ok());
        let values: Vec<T> = values.collect::<Option<_>>()?;
        match &values[..] {
            [value] => Some(vec![value.clone(); robots]),
            _ => Some(values).filter(|values| values.len() == robots),
        }
    }

    /// What each robot sees from where, if the recording says it.
    #[must_use]
    pub fn sights(&self) -> Option<Vec<Sight>> {
        let radii: Vec<u32> = self.of_robots("sensor_radius")?;
        let flies = self.of_robots("flies").unwrap_or_else(|| vec![false; radii.len()]);
        let sight =
            |(radius, flies)| if flies { Sight::from_above(radius) } else { Sight::on_ground(radius) };
        Some(radii.into_iter().zip(flies).map(sight).collect())
    }

    /// The sensor of each robot, if the recording says it.
    #[must_use]
    pub fn sensors(&self) -> Option<Vec<Sensor>> {
        let radii: Vec<u32> = self.of_robots("sensor_radius")?;
        let variances: Vec<f64> = self.of_robots(NOISE_VARIANCE)?;
        let sensor = |(radius, variance)| Sensor::new(radius, variance, Noise::Gaussian).ok();
        radii.into_iter().zip(variances).map(sensor).collect()
    }

    /// The detection threshold, or the usual one in recordings without it.
    #[must_use]
    pub fn detection_threshold(&self) -> f64 {
        let threshold = self.run.get("detection_threshold").and_then(|text| text.parse().ok());
        threshold.unwrap_or(DEFAULT_DETECTION_THRESHOLD)
    }

    /// That the number of objects is known, if the mission says so.
    #[must_use]
    pub fn subjects(&self) -> Option<Subjects> {
        let number = self.run.get(SUBJECTS).map_or(Some(1), |number| number.parse().ok())?;
        Subjects::new(number, self.run.get(REST_OF_WORLD)?.parse().ok()?)
    }

    /// Reads a recording. Of a truncated or damaged one the intact parts are read.
    ///
    /// # Errors
    /// If the file cannot be read, is not a recording of Dragnet, or has messages of another version.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let mut reader = McapReader::open(path)?;
        let mut tape = Tape::default();
        while let Some(record) = reader.next() {
            let Err(reason) = tape.take(record?) else { continue };
            // What follows says how the recording ends, and may hold the beginning again.
            let beginning = tape.beginning_in(&mut reader);
            if let Some(beginning) = beginning {
                (reader, tape) = (McapReader::open(path)?, beginning);
                continue;
            }
            let reason = match reader.ending() {
                damaged @ Ending::Damaged { .. } => format!("{reason}; the recording is {damaged}"),
                _ => reason,
            };
            return Err(RecordingError::Unreadable { path: path.to_owned(), reason });
        }
        let ending = reader.ending();
        let unreadable = |reason: &str| {
            let why = match &ending {
                Ending::Complete | Ending::Followed { .. } => "it is no recording of a mission".to_owned(),
                ending => {
                    format!("it is no recording of a mission, or its start is lost, for it is {ending}")
                }
            };
            RecordingError::Unreadable { path: path.to_owned(), reason: format!("{reason}: {why}") }
        };
        let terrain = tape.terrain.ok_or_else(|| unreadable("it has no map"))?;
        let facts = tape.metadata.remove(EARTH_METADATA);
        let areas = tape.areas.as_deref().unwrap_or(NO_AREAS);
        let earth = facts.map(|facts| Earth::read(&facts, areas)).transpose();
        let run = tape.metadata.remove(RUN_METADATA).unwrap_or_default();
        Ok(Self {
            terrain: Arc::new(with_line_of_sight(terrain, &run)),
            origin: tape.origin,
            start_unix_ns: tape.began_unix_ns.unwrap_or(tape.start_unix_ns),
            earth: earth.map_err(|reason| unreadable(&reason))?,
            prior: tape.prior.ok_or_else(|| unreadable("it has no belief"))?,
            records: tape.records,
            run,
            summary: tape.metadata.remove(SUMMARY_METADATA).unwrap_or_default(),
            ending,
        })
    }

    /// The time of the last record. Recordings of older versions may end with an earlier one.
    #[must_use]
    pub fn end(&self) -> MissionTime {
        self.records.iter().map(|(time, _)| *time).max().unwrap_or(MissionTime::START)
    }

    /// When the search was over, if recorded; otherwise the end. Robots exchange messages after the search is over.
    #[must_use]
    pub fn searched_until(&self) -> MissionTime {
        let seconds = self.summary.get(MISSION_TIME).and_then(|text| text.parse().ok());
        let searched = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        searched.map_or_else(|| self.end(), |searched| MissionTime::START + searched)
    }
}

/// The belief before the first reading, from a recorded prior: probabilities, shape `[cells]`, in single precision. If
/// the list has another length it is ignored, as are values that are not numbers.
#[must_use]
pub fn prior_belief(terrain: &Terrain, prior: &[f32]) -> Belief {
    let log_odds = prior.iter().map(|&p| f64::from(p)).map(|p| (p / (1.0 - p)).ln());
    let searched = terrain.grid().cells().map(|cell| terrain.is_searched(cell));
    let log_odds = log_odds
        .zip(searched)
        .map(|(it, is_searched)| if is_searched && !it.is_nan() { it } else { f64::NEG_INFINITY });
    Belief::from_log_odds(terrain, log_odds.collect())
        .or_else(|_| Belief::uniform(terrain, 0.0))
        .unwrap_or_else(|_| unreachable!("0 is a probability"))
}

/// The records read so far.
#[derive(Default)]
struct Tape {
    /// The date of mission time 0 by which the beginning is dated.
    start_unix_ns: u64,
    /// The same of the last message that tells it.
    began_unix_ns: Option<u64>,
    /// Areas on the earth, if they are not lost.
    areas: Option<String>,
    topics: BTreeMap<u16, String>,
    map: Option<OccupancyGrid>,
    terrain: Option<Terrain>,
    origin: MapOrigin,
    prior: Option<Vec<f32>>,
    records: Vec<(MissionTime, Record)>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
}

impl Tape {
    fn take(&mut self, record: McapRecord<'_>) -> Result<(), String> {
        match record {
            McapRecord::Channel(channel) => {
                self.topics.insert(channel.id, channel.topic);
            }
            McapRecord::Attachment { header, data, .. }
                if header.name == BEGINNING_ATTACHMENT && self.terrain.is_none() =>
            {
                self.begin(&data);
            }
            McapRecord::Attachment { header, .. } if header.name == SCENARIO_ATTACHMENT => {
                self.start_unix_ns = header.log_time;
            }
            McapRecord::Attachment { header, data, .. } if header.name == AREAS_ATTACHMENT => {
                self.areas = Some(String::from_utf8_lossy(&data).into_owned());
            }
            McapRecord::Metadata(metadata) => {
                self.metadata.insert(metadata.name, metadata.metadata);
            }
            McapRecord::Message { header, data } => {
                if let Some(topic) = self.topics.get(&header.channel_id).cloned() {
                    self.message(&topic, header, &data).map_err(|reason| format!("{topic}: {reason}"))?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Takes map and first belief from their copy. They follow as messages too, so that errors here lose nothing.
    fn begin(&mut self, copy: &[u8]) {
        let name = Path::new(BEGINNING_ATTACHMENT);
        let Ok(copy) = chunk::unpack_all(copy) else { return };
        let length = copy.len() as u64;
        let Ok(records) = McapReader::new(name, Cursor::new(copy), length) else { return };
        let mut begun = Self::default();
        for record in records {
            let Ok(Ok(())) = record.map(|record| begun.take(record)) else { return };
        }
        let Self { start_unix_ns, origin, terrain: terrain @ Some(_), prior: prior @ Some(_), .. } = begun
        else {
            return;
        };
        (self.start_unix_ns, self.origin) = (start_unix_ns, origin);
        (self.terrain, self.prior) = (terrain, prior);
    }

    /// A tape that begins with the copy in the rest of a recording, if this one has lost the beginning.
    fn beginning_in(
        &self,
        rest: impl Iterator<Item = Result<McapRecord<'static>, RecordingError>>,
    ) -> Option<Self> {
        let mut found = Self::default();
        for record in rest {
            if let Ok(McapRecord::Attachment { header, data, .. }) = record
                && header.name == BEGINNING_ATTACHMENT
            {
                found.begin(&data);
            }
        }
        (self.terrain.is_none() && found.terrain.is_some()).then_some(found)
    }

    fn message(&mut self, topic: &str, header: MessageHeader, data: &[u8]) -> Result<(), String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        if topic == Topic::Map.to_string() {
            self.map = Some(cdr::decode(data).map_err(|error| text(&error))?);
            // Also at the start, since the attachments may be lost.
            self.start_unix_ns = header.log_time;
        } else if topic == Topic::Belief.to_string() && self.terrain.is_none() {
            self.check_start(header)?;
            let belief = cdr::decode(data).map_err(|error| text(&error))?;
            let map = self.map.take().ok_or("before the map")?;
            self.origin = map.info.origin.into();
            self.terrain = Some(terrain(&map, &belief)?);
        } else if topic == Topic::BeliefProbability.to_string() && self.prior.is_none() {
            self.check_start(header)?;
            let grid = cdr::decode(data).map_err(|error| text(&error))?;
            self.prior = Some(self.prior_of(&grid)?);
        } else if let Some(kind) = kind(topic) {
            let message = self.codec()?.decode(kind, data).map_err(|error| text(&error))?;
            self.extend(header, record(message));
        } else if matches!(RobotTopic::parse(topic), Some((_, RobotTopic::Picture))) {
            let part = self.codec()?.decode_picture(data).map_err(|error| text(&error))?;
            let mut assembly = Assembly::of(&part);
            assembly.add(&part);
            let picture = assembly.whole().ok_or("a part of a picture, not the whole")?;
            self.extend(header, Some(Record::Picture(Arc::new(picture))));
        }
        Ok(())
    }

    fn codec(&self) -> Result<Codec, String> {
        let terrain = self.terrain.as_ref().ok_or("before the map and the first belief")?;
        Ok(Codec::new(terrain.grid()))
    }

    /// Takes a record with the time at which the coordinator received it. The date of mission time 0 is that by which the
    /// record is dated: the coordinator's clock may have been set since the last one.
    fn extend(&mut self, header: MessageHeader, record: Option<Record>) {
        let Some(record) = record else { return };
        let time_ns = own_time_ns(&record).filter(|&time_ns| Duration::from_nanos(time_ns) <= clock::LONGEST);
        self.began_unix_ns = match time_ns {
            Some(time_ns) => Some(header.publish_time.saturating_sub(time_ns)),
            None => self.began_unix_ns,
        };
        let began = self.began_unix_ns.unwrap_or(self.start_unix_ns);
        self.records.push((MissionTime(header.log_time.saturating_sub(began)), record));
    }

    /// A later belief would be mistaken for the prior if that is lost.
    fn check_start(&self, header: MessageHeader) -> Result<(), String> {
        if header.log_time == self.start_unix_ns {
            return Ok(());
        }
        Err("the initial belief is lost".to_owned())
    }

    fn prior_of(&self, grid: &WireGrid) -> Result<Vec<f32>, String> {
        let cells = self.terrain.as_ref().map_or(0, |terrain| terrain.grid().cell_count());
        let (floats, rest) = grid.data.as_chunks::<4>();
        if floats.len() != cells || !rest.is_empty() {
            return Err(format!("{} bytes for {cells} cells", grid.data.len()));
        }
        Ok(floats.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect())
    }
}

/// The terrain with what walls hide, if the recorded run says that they did.
fn with_line_of_sight(terrain: Terrain, run: &BTreeMap<String, String>) -> Terrain {
    let radius = run.get(LINE_OF_SIGHT).and_then(|radius| radius.parse().ok());
    match radius.filter(|&radius| radius > 0 && !LineOfSight::is_too_large(terrain.grid(), radius)) {
        Some(radius) => {
            let grid = terrain.grid();
            let numbers = run.get(THIN_WALLS).map_or("", String::as_str).split(' ');
            let thin = numbers.filter_map(|number| grid.cell_numbered(number.parse().ok()?));
            terrain.with_thin_walls(thin).with_opaque_walls(radius)
        }
        None => terrain,
    }
}

/// The terrain: the map defines which cells are traversable, the first belief which are searched.
fn terrain(map: &OccupancyGrid, belief: &OccupancyGrid) -> Result<Terrain, String> {
    const BLOCKED: i8 = 100;
    const NOT_SEARCHED: i8 = -1;
    let grid = Grid::new(map.info.height, map.info.width).map_err(|error| error.to_string())?;
    if belief.data.len() != map.data.len() {
        return Err(format!("{} cells, the map has {}", belief.data.len(), map.data.len()));
    }
    let ground = map.data.iter().zip(&belief.data).map(|(&ground, &percent)| Ground {
        traversable: ground != BLOCKED,
        searched: percent != NOT_SEARCHED,
    });
    Terrain::new(grid, f64::from(map.info.resolution), ground.collect()).map_err(|error| error.to_string())
}

/// The kind of message under a topic, if others follow from it.
fn kind(topic: &str) -> Option<MessageKind> {
    if topic == Topic::MISSION_STATUS {
        return Some(MessageKind::MissionStatus);
    }
    match RobotTopic::parse(topic)?.1 {
        RobotTopic::Observation => Some(MessageKind::Observation),
        RobotTopic::Intent => Some(MessageKind::Intent),
        RobotTopic::Heartbeat => Some(MessageKind::Heartbeat),
        RobotTopic::Verdicts => Some(MessageKind::Verdicts),
        RobotTopic::Orders => Some(MessageKind::Orders),
        RobotTopic::Zones => Some(MessageKind::Zones),
        RobotTopic::Marks => Some(MessageKind::Marks),
        RobotTopic::Pose | RobotTopic::Fix | RobotTopic::Path | RobotTopic::Picture => None,
    }
}

/// The mission time that a record says itself, nanoseconds.
fn own_time_ns(record: &Record) -> Option<u64> {
    match record {
        Record::Observation(observation) => Some(observation.time_ns),
        Record::Intent(intent) => Some(intent.time_ns),
        Record::Heartbeat(heartbeat) => Some(heartbeat.time_ns),
        Record::Status(status) => Some(status.time_ns),
        Record::Verdicts(report) => Some(report.time_ns),
        Record::Orders(report) => Some(report.time_ns),
        Record::Zones(report) => Some(report.time_ns),
        Record::Marks(report) => Some(report.time_ns),
        Record::Picture(picture) => Some(picture.facts.time_ns),
        Record::Pose { .. } | Record::Plan { .. } | Record::Belief(_) | Record::Began { .. } => None,
    }
}

fn record(message: Message) -> Option<Record> {
    match message {
        Message::Observation(observation) => Some(Record::Observation(observation)),
        Message::Intent(intent) => Some(Record::Intent(intent)),
        Message::Heartbeat(heartbeat) => Some(Record::Heartbeat(heartbeat)),
        Message::MissionStatus(status) => Some(Record::Status(status)),
        Message::Verdicts(report) => Some(Record::Verdicts(report)),
        Message::Orders(report) => Some(Record::Orders(report)),
        Message::Zones(report) => Some(Record::Zones(report)),
        Message::Marks(report) => Some(Record::Marks(report)),
        Message::SyncRequest(_) | Message::SyncReply(_) => None,
    }
}
