//! Inspection of recordings, including truncated ones.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};

use dragnet_proto::convert::Codec;
use dragnet_proto::dragnet_msgs::{MissionStatus, Verdicts};
use dragnet_proto::message::{Message, MessageKind};
use dragnet_proto::verdict::Decision;
use dragnet_ros2::cdr;
use dragnet_ros2::wire::standard::OccupancyGrid;
use dragnet_scenario::located;
use dragnet_scenario::map_file::{Earth, Georeference, MapOrigin};
use dragnet_search::cell::Grid;
use dragnet_search::object_position::ObjectPositions;
use dragnet_search::observation::Source;
use mcap::records::{MessageHeader, Record};
use serde::Serialize;

use crate::mcap_file::read::McapReader;
use crate::mcap_file::{Ending, RecordingError};
use crate::record::topic::{RobotTopic, Topic};
use crate::record::{EARTH_METADATA, RUN_METADATA, SUMMARY_METADATA};

const NANOSECONDS: f64 = 1e9;

/// The contents of a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// The file.
    pub path: PathBuf,
    /// Its size, bytes.
    pub file_bytes: u64,
    /// The size of its readable part, bytes.
    pub readable_bytes: u64,
    /// How it ends.
    pub ending: Ending,
    /// The library that wrote it.
    pub library: String,
    /// From the first message to the last; `None` without a message.
    pub times: Option<TimeRange>,
    /// The date of mission time 0, as the coordinator knew it at the end: Unix time, nanoseconds; `None` without a status.
    pub began_unix_ns: Option<u64>,
    /// Pose of the map's south-western corner in the frame `map`; `None` without a map.
    pub origin: Option<MapOrigin>,
    /// Columns of the map; `None` without a map.
    pub columns: Option<u32>,
    /// Edge of a cell, meters; `None` without a map.
    pub cell_meters: Option<f64>,
    /// The map's position on the earth, if it has one.
    #[serde(skip)]
    pub frame: Option<Georeference>,
    /// Topics, by name.
    pub topics: BTreeMap<String, TopicContent>,
    /// Numbers of the robots with messages.
    pub robots: BTreeSet<u16>,
    /// Number of merged observations.
    pub observations: u64,
    /// The objects declared at the end, by cell.
    pub declared: Vec<DeclaredObject>,
    /// Objects that the operator has dismissed and that are not declared at the end, by cell.
    pub dismissed: Vec<DismissedObject>,
    /// Attached files and their sizes, bytes.
    pub attachments: BTreeMap<String, u64>,
    /// Facts about the run, from its start.
    pub run: BTreeMap<String, String>,
    /// Results of the run; empty in a truncated recording.
    pub summary: BTreeMap<String, String>,
}

/// A range of times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeRange {
    /// Unix time, nanoseconds.
    pub start_unix_ns: u64,
    /// Unix time, nanoseconds.
    pub end_unix_ns: u64,
}

impl TimeRange {
    /// Its duration, seconds.
    #[must_use]
    pub fn seconds(self) -> f64 {
        (self.end_unix_ns - self.start_unix_ns) as f64 / NANOSECONDS
    }

    fn with(range: Option<Self>, unix_ns: u64) -> Self {
        range.map_or(Self { start_unix_ns: unix_ns, end_unix_ns: unix_ns }, |range| Self {
            start_unix_ns: range.start_unix_ns.min(unix_ns),
            end_unix_ns: range.end_unix_ns.max(unix_ns),
        })
    }
}

/// The contents of a topic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TopicContent {
    /// ROS name of its messages.
    pub message: String,
    /// Their number.
    pub messages: u64,
}

/// An object that is declared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeclaredObject {
    /// Its cell, row-major number.
    pub cell: u32,
    /// Its probability.
    pub probability: f64,
    /// When it was declared, seconds of mission time.
    pub declared_seconds: f64,
    /// What the operator has decided about it: `confirmed`, or `dismissed` if it was declared again after that.
    pub operator: Option<&'static str>,
    /// Where it is, if a robot knows it better than by its cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<DeclaredPosition>,
}

/// The position of a declared object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeclaredPosition {
    /// Meters east of the map's south-western corner.
    pub east_meters: f64,
    /// Meters north of it.
    pub north_meters: f64,
    /// The largest distance of the object from there with a probability of 95 %, meters.
    pub accuracy_meters: f64,
}

/// An object that the operator has dismissed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DismissedObject {
    /// Its cell, row-major number.
    pub cell: u32,
    /// When it was dismissed, seconds of mission time.
    pub dismissed_seconds: f64,
}

/// Reads a recording and summarizes its contents.
///
/// # Errors
/// If the file cannot be read, or is not an MCAP file. Of a truncated or damaged one the intact parts are read.
pub fn inspect(path: &Path) -> Result<Inspection, RecordingError> {
    let mut reader = McapReader::open(path)?;
    let mut inspector = Inspector::default();
    for record in &mut reader {
        inspector.take(record?);
    }
    Ok(Inspection {
        path: path.to_owned(),
        file_bytes: reader.file_bytes(),
        readable_bytes: reader.readable(),
        ending: reader.ending(),
        library: reader.header().library.clone(),
        times: inspector.times,
        began_unix_ns: inspector.began_unix_ns,
        origin: inspector.origin,
        columns: inspector.columns,
        cell_meters: inspector.cell_meters,
        frame: inspector.frame(),
        robots: inspector
            .sources()
            .filter_map(|(source, ..)| match source {
                Source::Robot(robot) => Some(robot.number()),
                Source::Operator => None,
            })
            .collect(),
        observations: inspector.observations(),
        declared: inspector.declared(),
        dismissed: inspector.dismissed(),
        topics: inspector.topics(),
        attachments: inspector.attachments,
        run: inspector.metadata.remove(RUN_METADATA).unwrap_or_default(),
        summary: inspector.metadata.remove(SUMMARY_METADATA).unwrap_or_default(),
    })
}

#[derive(Default)]
struct Inspector {
    times: Option<TimeRange>,
    began_unix_ns: Option<u64>,
    origin: Option<MapOrigin>,
    columns: Option<u32>,
    cell_meters: Option<f64>,
    /// Of messages about the map; `None` before it.
    codec: Option<Codec>,
    positions: ObjectPositions,
    /// Names of messages, by schema.
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, ChannelContent>,
    attachments: BTreeMap<String, u64>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// The last status.
    status: Option<MissionStatus>,
    /// The operator's last verdicts.
    verdicts: Verdicts,
}

struct ChannelContent {
    topic: String,
    schema: u16,
    messages: u64,
}

impl Inspector {
    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let content = ChannelContent { topic: channel.topic, schema: channel.schema_id, messages: 0 };
                self.channels.entry(channel.id).or_insert(content);
            }
            Record::Message { header, data } => self.take_message(header, &data),
            Record::Attachment { header, data, .. } => {
                self.attachments.insert(header.name, data.len() as u64);
            }
            Record::Metadata(metadata) => {
                self.metadata.insert(metadata.name, metadata.metadata);
            }
            _ => {}
        }
    }

    /// A status of another version is counted but not read.
    fn take_message(&mut self, header: MessageHeader, data: &[u8]) {
        let Some(channel) = self.channels.get_mut(&header.channel_id) else { return };
        channel.messages += 1;
        self.times = Some(TimeRange::with(self.times, header.log_time));
        if channel.topic == Topic::MISSION_STATUS
            && let Ok(status) = cdr::decode::<MissionStatus>(data)
        {
            self.began_unix_ns = Some(header.publish_time.saturating_sub(status.time_ns));
            self.status = Some(status);
        }
        if RobotTopic::parse(&channel.topic) == Some((Source::Operator, RobotTopic::Verdicts))
            && let Ok(verdicts) = cdr::decode::<Verdicts>(data)
        {
            self.verdicts = verdicts;
        }
        if let (Some((_, RobotTopic::Observation)), Some(codec)) =
            (RobotTopic::parse(&channel.topic), &self.codec)
            && let Ok(Message::Observation(observation)) = codec.decode(MessageKind::Observation, data)
        {
            self.positions.add(&observation);
        }
        if channel.topic == Topic::Map.to_string()
            && let Ok(map) = cdr::decode::<OccupancyGrid>(data)
        {
            self.origin = Some(map.info.origin.into());
            self.columns = Some(map.info.width).filter(|&columns| columns > 0);
            self.cell_meters = Some(f64::from(map.info.resolution));
            self.codec = Grid::new(map.info.height, map.info.width).ok().map(Codec::new);
        }
    }

    fn frame(&self) -> Option<Georeference> {
        Earth::read_frame(self.metadata.get(EARTH_METADATA)?).ok()
    }

    /// Robots and the operator, with the contents of each of their channels.
    fn sources(&self) -> impl Iterator<Item = (Source, RobotTopic, u64)> + '_ {
        self.channels.values().filter_map(|channel| {
            let (source, topic) = RobotTopic::parse(&channel.topic)?;
            Some((source, topic, channel.messages))
        })
    }

    fn observations(&self) -> u64 {
        let observations = self.sources().filter(|(_, topic, _)| *topic == RobotTopic::Observation);
        observations.map(|(.., messages)| messages).sum()
    }

    fn topics(&self) -> BTreeMap<String, TopicContent> {
        let content = |channel: &ChannelContent| TopicContent {
            message: self.schemas.get(&channel.schema).cloned().unwrap_or_default(),
            messages: channel.messages,
        };
        self.channels.values().map(|channel| (channel.topic.clone(), content(channel))).collect()
    }

    fn declared(&self) -> Vec<DeclaredObject> {
        let declared = self.status.iter().flat_map(|status| &status.declared);
        declared
            .map(|object| DeclaredObject {
                cell: object.cell,
                probability: object.probability,
                declared_seconds: object.time_ns as f64 / NANOSECONDS,
                operator: self.decided().find(|it| it.0 == object.cell).and_then(|it| it.2.word()),
                position: self.position(object.cell),
            })
            .collect()
    }

    fn position(&self, cell: u32) -> Option<DeclaredPosition> {
        let position = self.positions.of(self.codec.as_ref()?.grid().cell_numbered(cell)?)?;
        let ((east_meters, north_meters), accuracy_meters) = (position.meters(), position.accuracy_meters());
        Some(DeclaredPosition { east_meters, north_meters, accuracy_meters })
    }

    /// The cell, number and decision of each verdict.
    fn decided(&self) -> impl Iterator<Item = (u32, u64, Decision)> + '_ {
        let Verdicts { cells, numbers, decisions, .. } = &self.verdicts;
        let decided = cells.iter().zip(numbers).zip(decisions);
        decided
            .filter_map(|((&cell, &number), &decision)| Some((cell, number, Decision::numbered(decision)?)))
    }

    fn dismissed(&self) -> Vec<DismissedObject> {
        let declared: BTreeSet<u32> =
            self.status.iter().flat_map(|status| &status.declared).map(|object| object.cell).collect();
        let dismissed = self
            .decided()
            .filter(|&(cell, _, decision)| decision == Decision::Dismissed && !declared.contains(&cell));
        dismissed
            .map(|(cell, number, _)| DismissedObject { cell, dismissed_seconds: number as f64 / NANOSECONDS })
            .collect()
    }
}

impl fmt::Display for Inspection {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let robots: Vec<String> = self.robots.iter().map(ToString::to_string).collect();
        writeln!(formatter, "recording     {}", self.path.display())?;
        writeln!(formatter, "size          {} bytes, {}", self.file_bytes, self.state())?;
        writeln!(formatter, "written by    {}", self.library)?;
        if let Some(times) = self.times {
            let start = times.start_unix_ns as f64 / NANOSECONDS;
            writeln!(formatter, "time          {:.3} s from Unix time {start:.3} s on", times.seconds())?;
        }
        if let Some(began) = self.began_unix_ns {
            writeln!(formatter, "mission time  0 s is Unix time {:.3} s", began as f64 / NANOSECONDS)?;
        }
        if let Some(origin) = self.origin {
            let corner =
                self.frame.map_or_else(|| origin.to_string(), |frame| frame.south_west().to_string());
            writeln!(formatter, "map           its south-western corner at {corner}")?;
        }
        writeln!(
            formatter,
            "robots        {}",
            if robots.is_empty() { "none".into() } else { robots.join(" ") }
        )?;
        writeln!(formatter, "observations  {}", self.observations)?;
        writeln!(formatter, "declared      {}", self.declared.len())?;
        for object in &self.declared {
            let DeclaredObject { cell, probability, declared_seconds, operator, position } = object;
            let operator = match *operator {
                Some("dismissed") => ", dismissed by hand before it was found again".to_owned(),
                Some(word) => format!(", {word} by hand"),
                None => String::new(),
            };
            writeln!(
                formatter,
                "  cell {}, probability {probability:.4}, since {declared_seconds:.1} s{operator}",
                self.object(*cell, position.as_ref())
            )?;
        }
        if !self.dismissed.is_empty() {
            writeln!(formatter, "dismissed     {}", self.dismissed.len())?;
        }
        for DismissedObject { cell, dismissed_seconds } in &self.dismissed {
            writeln!(formatter, "  cell {}, at {dismissed_seconds:.1} s", self.place(*cell))?;
        }
        for (name, bytes) in &self.attachments {
            writeln!(formatter, "attachment    {name}, {bytes} bytes")?;
        }
        for (title, facts) in [("run", &self.run), ("summary", &self.summary)] {
            for (name, value) in facts {
                writeln!(formatter, "{title:<12}  {name} = {value}")?;
            }
        }
        self.write_topics(formatter)
    }
}

impl Inspection {
    /// The position of a cell, in the notation of scenarios and on the earth; its number in a recording without a map.
    fn place(&self, cell: u32) -> String {
        let (Some(columns), Some(cell_meters)) = (self.columns, self.cell_meters) else {
            return cell.to_string();
        };
        let (row, column) = (cell / columns, cell % columns);
        let meters = |line: u32| (f64::from(line) + 0.5) * cell_meters;
        let center = self.frame.map(|frame| frame.point((meters(column), meters(row))));
        let center = center.map_or_else(String::new, |center| format!(" at {center}"));
        format!("[{row}, {column}]{center}")
    }

    /// The same at the position of an object, if that is known.
    fn object(&self, cell: u32, position: Option<&DeclaredPosition>) -> String {
        let (Some(position), Some(columns)) = (position, self.columns) else { return self.place(cell) };
        let &DeclaredPosition { east_meters: east, north_meters: north, accuracy_meters } = position;
        let place = located(self.frame.as_ref(), (east, north), accuracy_meters);
        format!("[{}, {}] at {place}", cell / columns, cell % columns)
    }

    fn state(&self) -> String {
        match &self.ending {
            Ending::Complete => "complete".into(),
            Ending::CutOff => format!("cut off: {} bytes can be read", self.readable_bytes),
            ending @ (Ending::Damaged { .. } | Ending::Followed { .. }) => {
                format!("{ending}; {} bytes can be read", self.readable_bytes)
            }
        }
    }

    fn write_topics(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.topics.keys().map(String::len).max().unwrap_or(0).max("topic".len());
        write!(formatter, "messages  {:<width$}  type", "topic")?;
        for (topic, TopicContent { message, messages }) in &self.topics {
            write!(formatter, "\n{messages:>8}  {topic:<width$}  {message}")?;
        }
        Ok(())
    }
}
