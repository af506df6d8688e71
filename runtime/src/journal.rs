//! The journal: the state that a robot needs for a restart, stored on disk before anything is published.
//!
//! One file for each robot, a [`redb`](https://docs.rs/redb) database: commits are atomic, even if the process or the
//! power fails, which a recording in chunks does not guarantee; and a second process of the same robot is locked out. A
//! disk that fails does not stop the robot: pending data wait in memory, and are written once that is possible.

mod damage;
mod error;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::ErrorKind;
use std::ops::RangeBounds;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use dragnet_proto::clock::Kept;
use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::Mission;
use dragnet_proto::message::{Message, MessageKind};
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::{Observation, Origin, RobotId};
use dragnet_search::terrain::Terrain;
use redb::backends::InMemoryBackend;
use redb::{Builder, Database, ReadableDatabase, StorageBackend, TableDefinition, TableError};

pub use error::JournalError;

use crate::clock::Clock;

/// Facts about a journal, by name: see [`fact`].
const FACTS: TableDefinition<'_, &str, &str> = TableDefinition::new("facts");
/// Of an observation: robot, incarnation and sequence number.
type Name = (u16, u64, u64);
/// By name: the encoded message of an observation.
const OBSERVATIONS: TableDefinition<'_, Name, &[u8]> = TableDefinition::new("observations");
/// By the name of its kind: the last encoded message that passed on instructions of the operator. Journals of earlier
/// versions have no such table.
const INSTRUCTIONS: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("instructions");
/// The kinds of messages in which a robot passes on instructions, each with its name: a directive before zones and orders that
/// rest on the cells that it adds.
const PASSED_ON: [(MessageKind, &str); 5] = [
    (MessageKind::Heartbeat, "directive"),
    (MessageKind::Verdicts, "verdicts"),
    (MessageKind::Orders, "orders"),
    (MessageKind::Zones, "zones"),
    (MessageKind::Marks, "marks"),
];

mod fact {
    pub(super) const FORMAT: &str = "format";
    pub(super) const MISSION: &str = "mission";
    pub(super) const ROBOT: &str = "robot";
    pub(super) const MAP: &str = "map";
    pub(super) const STARTED: &str = "started_unix_ns";
    /// Name of the stored mission time, absent before the first: see [`super::Kept`].
    pub(super) const TIME: &str = "time";
}

/// Incremented with each change of the format.
const FORMAT: &str = "1";
/// Cache of the database, bytes: a journal is written often and seldom read.
const CACHE: usize = 256 << 10;
/// Time after which a failed disk is tried again.
const RETRY: Duration = Duration::from_secs(1);

/// The subject of a journal: one of another robot, mission or map is rejected.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The mission.
    pub mission: &'a Mission,
    /// The robot.
    pub robot: RobotId,
    /// The map.
    pub terrain: &'a Terrain,
}

type Facts = [(&'static str, String); 5];

/// The stored state of a restarted robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    /// Time of its first start by the date of its computer: Unix time, nanoseconds. For display only: nothing depends
    /// on it.
    pub started_unix_ns: u64,
    /// All observations that it knew, its own in the order in which it made them.
    pub observations: Vec<Arc<Observation>>,
    /// The last messages in which it passed on instructions of the operator, at most one of each kind.
    pub instructions: Vec<Message>,
}

impl Memory {
    /// The mission time at which a restarted robot continues, if any: by the stored time `noted`, and no earlier than
    /// its observations.
    #[must_use]
    pub fn resumed(&self, noted: Option<&Kept>, clock: &Clock) -> Option<MissionTime> {
        let latest = self.observations.iter().map(|observation| MissionTime(observation.time_ns)).max();
        noted.map(|kept| clock.resumed(kept)).max(latest)
    }
}

/// The result that [`Journal::open`] would have.
#[derive(Clone, Debug, PartialEq)]
pub enum Prospect {
    /// The robot continues with this state and the stored mission time.
    GoesOn(Memory, Option<Kept>),
    /// The journal is damaged: the robot moves it aside, and begins a new one.
    SetAside {
        /// The damage.
        damage: String,
    },
}

/// Checks a journal while its robot does not run. The file is never changed.
///
/// # Errors
/// If [`Journal::open`] would fail.
pub fn peek(path: &Path, subject: Subject<'_>) -> Result<Prospect, JournalError> {
    check_is_file(path)?;
    let failed = |source| JournalError::of(path, redb::Error::Io(source));
    if let Err(source) = File::options().read(true).write(true).open(path) {
        // A read-only disk is not an error.
        full_disk(failed(source))?;
    }
    match read_copy(path, subject) {
        Ok((memory, noted)) => Ok(Prospect::GoesOn(memory, noted)),
        Err(error) => Ok(Prospect::SetAside { damage: damage::of(path, error)? }),
    }
}

fn read_copy(path: &Path, subject: Subject<'_>) -> Result<(Memory, Option<Kept>), JournalError> {
    let failed = |source: redb::Error| JournalError::of(path, source);
    let database = copied(path, &subject.facts(0)).map_err(failed)?;
    Ok((remember(&database, path, subject)?, noted_time(&database).map_err(failed)?))
}

/// A folder or a device cannot be a journal. Other errors are reported on opening.
fn check_is_file(path: &Path) -> Result<(), JournalError> {
    match path.metadata() {
        Ok(metadata) if !metadata.is_file() => Err(JournalError::NotAFile { path: path.to_owned() }),
        _ => Ok(()),
    }
}

/// A robot's journal.
pub struct Journal {
    path: PathBuf,
    codec: Codec,
    /// The facts of a new journal.
    facts: Facts,
    /// Absent after the disk failed.
    database: Option<Database>,
    /// Observations that are not on disk yet.
    waiting: Vec<Arc<Observation>>,
    /// The last messages with instructions of the operator, and the kinds of those that are not on disk yet.
    instructions: BTreeMap<MessageKind, Message>,
    instructions_waiting: BTreeSet<MessageKind>,
    /// The stored mission time.
    time: Option<Kept>,
    /// Whether that is not on disk yet.
    is_time_waiting: bool,
    /// When the disk failed, if it still does.
    failed: Option<Instant>,
}

impl Journal {
    /// Opens a robot's journal, or begins one if there is none. `now_unix_ns` is the current Unix time, nanoseconds.
    ///
    /// The robot should start in any case: a damaged journal is moved aside and a new one begun; a journal on a full
    /// disk is read now and written later.
    ///
    /// # Errors
    /// If the file cannot be read or written for another reason, if it is in use, or if it is not this robot's journal.
    pub fn open(path: &Path, subject: Subject<'_>, now_unix_ns: u64) -> Result<(Self, Memory), JournalError> {
        check_is_file(path)?;
        let mut journal = Self {
            path: path.to_owned(),
            codec: Codec::new(subject.terrain.grid()),
            facts: subject.facts(now_unix_ns),
            database: None,
            waiting: Vec::new(),
            instructions: BTreeMap::new(),
            instructions_waiting: BTreeSet::new(),
            time: None,
            is_time_waiting: false,
            failed: None,
        };
        let error = match journal.remember(open(path, &journal.facts), subject) {
            Ok((database, memory)) => {
                journal.database = Some(database);
                return Ok((journal, memory));
            }
            Err(error) => error,
        };
        let error = match full_disk(error) {
            Err(error) => error,
            Ok(full) => {
                journal.fail(&full);
                match journal.remember(copied(path, &journal.facts), subject) {
                    Ok((_, memory)) => return Ok((journal, memory)),
                    Err(error) => error,
                }
            }
        };
        damage::set_aside(path, &damage::of(path, error)?)?;
        match journal.remember(open(path, &journal.facts), subject) {
            Ok((database, memory)) => {
                journal.database = Some(database);
                Ok((journal, memory))
            }
            Err(error) => {
                journal.fail(&full_disk(error)?);
                let (observations, instructions) = Default::default();
                Ok((journal, Memory { started_unix_ns: now_unix_ns, observations, instructions }))
            }
        }
    }

    /// The database with its content, if that is valid.
    fn remember(
        &mut self,
        database: Result<Database, redb::Error>,
        subject: Subject<'_>,
    ) -> Result<(Database, Memory), JournalError> {
        let database = database.map_err(|source| JournalError::of(&self.path, source))?;
        let memory = remember(&database, &self.path, subject)?;
        self.time = noted_time(&database).map_err(|source| JournalError::of(&self.path, source))?;
        let instructions = memory.instructions.iter().cloned();
        self.instructions = instructions.map(|message| (message.kind(), message)).collect();
        Ok((database, memory))
    }

    /// Adds observations; they are on disk after the next [`Journal::commit`].
    pub fn note(&mut self, observations: Vec<Arc<Observation>>) {
        self.waiting.extend(observations);
    }

    /// Adds the instructions in a message that the robot publishes, if they have changed; they are on disk after the next
    /// [`Journal::commit`].
    pub fn note_instructions(&mut self, message: &Message) {
        let kind = message.kind();
        let known = self.instructions.get(&kind);
        if message.instructions().is_some()
            && known.is_none_or(|known| known.instructions() != message.instructions())
        {
            self.instructions.insert(kind, message.clone());
            self.instructions_waiting.insert(kind);
        }
    }

    /// Sets the mission time; it is on disk after the next [`Journal::commit`].
    pub fn note_time(&mut self, time: Kept) {
        self.time = Some(time);
        self.is_time_waiting = true;
    }

    /// The stored mission time.
    #[must_use]
    pub const fn time(&self) -> Option<&Kept> {
        self.time.as_ref()
    }

    /// Writes all pending data. If the disk fails, they stay pending: the failure and its end are logged.
    pub fn commit(&mut self) {
        let is_all_written =
            self.waiting.is_empty() && self.instructions_waiting.is_empty() && !self.is_time_waiting;
        if is_all_written || self.failed.is_some_and(|failed| failed.elapsed() < RETRY) {
            return;
        }
        if let Err(error) = self.write() {
            return self.fail(&error);
        }
        if self.failed.take().is_some() {
            let (path, count) = (self.path.display(), self.waiting.len());
            tracing::info!("{path}: written again, {count} observations that had waited first");
        }
        self.waiting.clear();
        self.instructions_waiting.clear();
        self.is_time_waiting = false;
    }

    fn fail(&mut self, error: &dyn std::error::Error) {
        if self.failed.replace(Instant::now()).is_none() {
            let path = self.path.display();
            tracing::warn!("{path}: {error}; the robot goes on, and keeps its observations in memory");
        }
    }

    /// At most this many observations of an origin from a sequence number on, in order; none while the disk fails.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn since(&self, of: Origin, first: u64, most: usize) -> Result<Vec<Arc<Observation>>, JournalError> {
        let Some(database) = &self.database else { return Ok(Vec::new()) };
        let names = [first, u64::MAX].map(|sequence| (of.source.number(), of.incarnation, sequence));
        let bytes = read(database, names[0]..=names[1], most);
        decode(&self.codec, &bytes.map_err(|source| JournalError::of(&self.path, source))?)
            .map_err(|reason| JournalError::Content { path: self.path.clone(), reason })
    }

    /// Number of observations that are not on disk.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.waiting.len()
    }

    fn write(&mut self) -> Result<(), redb::Error> {
        let database = match self.database.take() {
            Some(database) => database,
            // After an error only the data on disk are certain.
            None => open(&self.path, &self.facts)?,
        };
        let transaction = database.begin_write()?;
        {
            let mut table = transaction.open_table(OBSERVATIONS)?;
            for observation in &self.waiting {
                let Origin { source, incarnation } = observation.origin;
                let name = (source.number(), incarnation, observation.sequence);
                let bytes = convert::encode(&Message::Observation(Arc::clone(observation)));
                table.insert(name, bytes.as_slice())?;
            }
            for (kind, name) in PASSED_ON {
                if let Some(message) =
                    self.instructions.get(&kind).filter(|_| self.instructions_waiting.contains(&kind))
                {
                    transaction
                        .open_table(INSTRUCTIONS)?
                        .insert(name, convert::encode(message).as_slice())?;
                }
            }
            if let Some(time) = self.time.as_ref().filter(|_| self.is_time_waiting) {
                transaction.open_table(FACTS)?.insert(fact::TIME, written_time(time).as_str())?;
            }
        }
        transaction.commit()?;
        self.database = Some(database);
        Ok(())
    }
}

fn open(path: &Path, facts: &Facts) -> Result<Database, redb::Error> {
    let database = builder().create(path)?;
    begin(&database, facts)?;
    Ok(database)
}

/// A copy of the journal in memory, as it would be if its disk had space.
fn copied(path: &Path, facts: &Facts) -> Result<Database, redb::Error> {
    let bytes = std::fs::read(path)?;
    let copy = InMemoryBackend::new();
    copy.set_len(bytes.len() as u64)?;
    copy.write(0, &bytes)?;
    let database = builder().create_with_backend(copy)?;
    begin(&database, facts)?;
    Ok(database)
}

fn builder() -> Builder {
    let mut builder = Builder::new();
    // Detects pages that have changed since they were written.
    builder.set_cache_size(CACHE).set_check_integrity_on_open(true);
    builder
}

/// Writes the facts of a new journal; those of an existing one are kept.
fn begin(database: &Database, facts: &Facts) -> Result<(), redb::Error> {
    let transaction = database.begin_write()?;
    if transaction.list_tables()?.next().is_some() {
        return Ok(transaction.abort()?);
    }
    let mut table = transaction.open_table(FACTS)?;
    for (name, value) in facts {
        table.insert(*name, value.as_str())?;
    }
    drop(table);
    transaction.open_table(OBSERVATIONS)?;
    Ok(transaction.commit()?)
}

/// The error of a full or read-only disk; any other error is returned.
fn full_disk(error: JournalError) -> Result<redb::Error, JournalError> {
    let is_full = |error: &std::io::Error| {
        matches!(
            error.kind(),
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::ReadOnlyFilesystem
        )
    };
    match error {
        JournalError::Storage { source, .. } if matches!(&*source, redb::Error::Io(error) if is_full(error)) => {
            Ok(*source)
        }
        error => Err(error),
    }
}

fn remember(database: &Database, path: &Path, subject: Subject<'_>) -> Result<Memory, JournalError> {
    let failed = |source: redb::Error| JournalError::of(path, source);
    let read_fact = |name| read_fact(database, name).map_err(failed);
    for (name, expected) in subject.named() {
        let found = read_fact(name)?;
        if found != expected {
            return Err(JournalError::Foreign { path: path.to_owned(), what: name, found, expected });
        }
    }
    let codec = Codec::new(subject.terrain.grid());
    let observations = decode(&codec, &read(database, .., usize::MAX).map_err(failed)?);
    let instructions = passed_on(&codec, &read_instructions(database).map_err(failed)?);
    let content = |reason| JournalError::Content { path: path.to_owned(), reason };
    let started = read_fact(fact::STARTED)?;
    Ok(Memory {
        started_unix_ns: started.parse().map_err(|_| content(format!("it began at {started:?}")))?,
        observations: observations.map_err(content)?,
        instructions: instructions.map_err(content)?,
    })
}

fn read_fact(database: &Database, name: &str) -> Result<String, redb::Error> {
    let facts = database.begin_read()?.open_table(FACTS)?;
    Ok(facts.get(name)?.map(|value| value.value().to_owned()).unwrap_or_default())
}

/// The mission time as a fact: boot identifier, uptime and time, nanoseconds.
fn written_time(Kept { boot, uptime, time }: &Kept) -> String {
    format!("{boot} {} {}", uptime.as_nanos(), time.0)
}

/// The stored mission time, if valid: without it the observations give a lower bound.
fn noted_time(database: &Database) -> Result<Option<Kept>, redb::Error> {
    let text = read_fact(database, fact::TIME)?;
    let mut words = text.split(' ');
    let mut next = || words.next();
    let kept = (|| {
        let (boot, uptime, time) = (next()?, next()?.parse().ok()?, next()?.parse().ok()?);
        Some(Kept { boot: boot.to_owned(), uptime: Duration::from_nanos(uptime), time: MissionTime(time) })
    })();
    Ok(kept)
}

/// The first observations of these names, as they were written.
fn read(
    database: &Database,
    names: impl RangeBounds<Name>,
    most: usize,
) -> Result<Vec<Vec<u8>>, redb::Error> {
    let table = database.begin_read()?.open_table(OBSERVATIONS)?;
    let mut observations = Vec::new();
    for entry in table.range(names)?.take(most) {
        observations.push(entry?.1.value().to_owned());
    }
    Ok(observations)
}

/// The instructions as they were written, each with its kind.
fn read_instructions(database: &Database) -> Result<Vec<(MessageKind, Vec<u8>)>, redb::Error> {
    let table = match database.begin_read()?.open_table(INSTRUCTIONS) {
        Err(TableError::TableDoesNotExist(_)) => return Ok(Vec::new()),
        table => table?,
    };
    let mut instructions = Vec::new();
    for (kind, name) in PASSED_ON {
        instructions.extend(table.get(name)?.map(|bytes| (kind, bytes.value().to_owned())));
    }
    Ok(instructions)
}

fn passed_on(codec: &Codec, instructions: &[(MessageKind, Vec<u8>)]) -> Result<Vec<Message>, String> {
    let one = |(kind, bytes): &(_, Vec<u8>)| codec.decode(*kind, bytes).map_err(|error| error.to_string());
    instructions.iter().map(one).collect()
}

fn decode(codec: &Codec, observations: &[Vec<u8>]) -> Result<Vec<Arc<Observation>>, String> {
    let one = |bytes: &Vec<u8>| match codec.decode(MessageKind::Observation, bytes) {
        Ok(Message::Observation(observation)) => Ok(observation),
        Ok(message) => Err(format!("a {:?}", message.kind())),
        Err(error) => Err(error.to_string()),
    };
    observations.iter().map(one).collect()
}

impl Subject<'_> {
    fn facts(self, now_unix_ns: u64) -> Facts {
        let [format, mission, robot, map] = self.named();
        [format, mission, robot, map, (fact::STARTED, now_unix_ns.to_string())]
    }

    /// The facts that distinguish journals.
    fn named(self) -> [(&'static str, String); 4] {
        let (grid, digest) = (self.terrain.grid(), self.terrain.digest());
        let meters = self.terrain.cell_meters();
        let map = format!("{} x {} cells of {meters} m, {digest}", grid.rows(), grid.columns());
        [
            (fact::FORMAT, FORMAT.to_owned()),
            (fact::MISSION, self.mission.to_string()),
            (fact::ROBOT, self.robot.to_string()),
            (fact::MAP, map),
        ]
    }
}

#[cfg(test)]
mod tests;
