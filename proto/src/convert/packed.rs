//! Messages in few bytes, for radios. A packed message holds exactly what its ROS 2 message holds, and is checked like it.
//!
//! It begins with [`MARK`], which no CDR message does, and [`PACKED_VERSION`]. The format is described by this module alone:
//! recordings, journals and ROS 2 nodes get CDR.

mod bytes;
mod readings;

use dragnet_ros2::cdr;
use dragnet_search::cell::Grid;

use self::bytes::{Reader, Writer};
use super::check::{Columns, MAX_ORIGINS};
use crate::dragnet_msgs as wire;
use crate::marks::{Marked, Marks};
use crate::message::SyncReply;

/// The first byte of a packed message; CDR begins with 0.
pub(super) const MARK: u8 = 0xD7;
/// The version of packed messages.
const PACKED_VERSION: u8 = 1;
/// The most robots in a list, of the largest team.
const MAX_ROBOTS: usize = u16::MAX as usize;

/// Why packed bytes cannot be decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PackedError {
    /// Longer than any message.
    #[error("{0} bytes; allowed are at most {max}", max = cdr::MAX_BYTES)]
    TooLong(usize),
    /// Another version.
    #[error("packed in version {0}; this program uses version {PACKED_VERSION}")]
    Version(u8),
    /// The bytes end early.
    #[error("the packed message ends early")]
    Short,
    /// More bytes than the message has.
    #[error("{0} bytes after the end of the packed message")]
    Trailing(usize),
    /// A list longer than any such list.
    #[error("a packed list of {found}; allowed are at most {most}")]
    TooMany {
        /// Its length.
        found: usize,
        /// The greatest length.
        most: usize,
    },
    /// A number that its field cannot hold.
    #[error("a packed number is larger than its field")]
    Large,
    /// Bytes of a text that are no text.
    #[error("a packed text is not UTF-8")]
    Text,
    /// Unknown flags of readings.
    #[error("flags of packed readings: {0}; allowed are 0 to 15")]
    Flags(u8),
    /// The robot's cell is not on the map.
    #[error("packed readings around cell {0}, which is not on the map")]
    Cell(u32),
    /// A wider footprint than any sensor's.
    #[error("packed footprint of radius {0} cells; allowed are 0 to {max}", max = dragnet_search::sensor::Sensor::MAX_RADIUS)]
    Radius(u32),
    /// The sensor model has no variance for a cell.
    #[error("a packed reading of the sensor model is not on the map, or beyond every sensor")]
    OffMap,
}

/// A message that can be packed.
pub(super) trait Packed: Sized {
    fn write(&self, to: &mut Writer, map: Map<'_>);
    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError>;
}

/// What packing uses of a mission; unpacking needs the grid alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Map<'a> {
    pub(super) grid: Grid,
    /// Noise variance of each robot's sensor; robots are numbered from 1.
    pub(super) noise_variances: &'a [f64],
}

/// The packed bytes of a message.
pub(super) fn pack<T: Packed>(message: &T, map: Map<'_>) -> Vec<u8> {
    let mut to = Writer::default();
    to.raw([MARK, PACKED_VERSION]);
    message.write(&mut to, map);
    to.bytes
}

/// The message of packed bytes.
pub(super) fn unpack<T: Packed>(bytes: &[u8], grid: Grid) -> Result<T, PackedError> {
    if bytes.len() > cdr::MAX_BYTES {
        return Err(PackedError::TooLong(bytes.len()));
    }
    let mut from = Reader::new(bytes);
    let [_, version] = from.raw()?;
    if version != PACKED_VERSION {
        return Err(PackedError::Version(version));
    }
    let message = T::read(&mut from, grid)?;
    from.end()?;
    Ok(message)
}

impl Packed for wire::Observation {
    fn write(&self, to: &mut Writer, Map { grid, noise_variances }: Map<'_>) {
        to.number(self.robot);
        to.number(self.incarnation);
        to.number(self.sequence);
        to.number(self.time_ns);
        to.number(self.cell);
        let Self { cells, values, variances, .. } = self;
        let columns = Columns { cells: cells.clone(), values: values.clone(), variances: variances.clone() };
        let noise_variance =
            usize::from(self.robot).checked_sub(1).and_then(|index| noise_variances.get(index));
        // The cell of an observation is on the map: it comes from a domain type.
        if let Some(from) = grid.cell_numbered(self.cell) {
            readings::write(to, grid, noise_variance.copied(), from, &columns, &self.positions);
        }
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        let (robot, incarnation, sequence) = (from.number()?, from.number()?, from.number()?);
        let (time_ns, cell) = (from.number()?, from.number()?);
        let (Columns { cells, values, variances }, positions) = readings::read(from, grid, cell)?;
        Ok(Self {
            version: wire::OBSERVATION_VERSION,
            robot,
            incarnation,
            sequence,
            time_ns,
            cell,
            cells,
            values,
            variances,
            positions,
        })
    }
}

impl Packed for wire::Intent {
    fn write(&self, to: &mut Writer, _: Map<'_>) {
        to.number(self.robot);
        to.number(self.incarnation);
        to.number(self.decision);
        to.number(self.time_ns);
        readings::write_cells(to, &self.path);
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        Ok(Self {
            version: wire::VERSION,
            robot: from.number()?,
            incarnation: from.number()?,
            decision: from.number()?,
            time_ns: from.number()?,
            path: readings::read_cells(from, grid.cell_count())?,
        })
    }
}

impl Packed for wire::Heartbeat {
    fn write(&self, to: &mut Writer, map: Map<'_>) {
        to.number(self.time_ns);
        to.byte(self.activity);
        to.number(self.cell);
        to.raw(self.path_meters.to_le_bytes());
        // It names the robot, whose heartbeat this is.
        self.intent.write(to, map);
        write_list(to, map, &self.version_vector);
        write_digest(to, self.digest);
        self.directive.write(to, map);
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        let (time_ns, activity, cell) = (from.number()?, from.byte()?, from.number()?);
        let path_meters = f64::from_le_bytes(from.raw()?);
        let intent = wire::Intent::read(from, grid)?;
        Ok(Self {
            version: wire::VERSION,
            robot: intent.robot,
            time_ns,
            activity,
            cell,
            path_meters,
            intent,
            version_vector: from.list(MAX_ORIGINS, |from| wire::Version::read(from, grid))?,
            digest: read_digest(from)?,
            directive: wire::Directive::read(from, grid)?,
        })
    }
}

impl Packed for wire::Version {
    fn write(&self, to: &mut Writer, _: Map<'_>) {
        to.number(self.robot);
        to.number(self.incarnation);
        to.number(self.next);
    }

    fn read(from: &mut Reader<'_>, _: Grid) -> Result<Self, PackedError> {
        let version = wire::VERSION;
        Ok(Self { version, robot: from.number()?, incarnation: from.number()?, next: from.number()? })
    }
}

impl Packed for wire::SyncRequest {
    fn write(&self, to: &mut Writer, _: Map<'_>) {
        to.byte(self.from_kind);
        to.number(self.from_robot);
        to.number(self.of_robot);
        to.number(self.of_incarnation);
        to.number(self.first);
    }

    fn read(from: &mut Reader<'_>, _: Grid) -> Result<Self, PackedError> {
        Ok(Self {
            version: wire::VERSION,
            from_kind: from.byte()?,
            from_robot: from.number()?,
            of_robot: from.number()?,
            of_incarnation: from.number()?,
            first: from.number()?,
        })
    }
}

impl Packed for wire::SyncReply {
    fn write(&self, to: &mut Writer, map: Map<'_>) {
        write_list(to, map, &self.observations);
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        let observations =
            from.list(SyncReply::MAX_OBSERVATIONS, |from| wire::Observation::read(from, grid))?;
        Ok(Self { version: wire::OBSERVATION_VERSION, observations })
    }
}

impl Packed for wire::Detection {
    fn write(&self, to: &mut Writer, _: Map<'_>) {
        to.number(self.cell);
        to.raw(self.probability.to_le_bytes());
        to.number(self.time_ns);
    }

    fn read(from: &mut Reader<'_>, _: Grid) -> Result<Self, PackedError> {
        let cell = from.number()?;
        let probability = f64::from_le_bytes(from.raw()?);
        Ok(Self { version: wire::VERSION, cell, probability, time_ns: from.number()? })
    }
}

impl Packed for wire::MissionStatus {
    fn write(&self, to: &mut Writer, map: Map<'_>) {
        to.number(self.time_ns);
        write_list(to, map, &self.declared);
        to.raw(self.expected_remaining.to_le_bytes());
        write_robots(to, &self.alive);
        to.number(self.observations);
        write_list(to, map, &self.version_vector);
        write_digest(to, self.digest);
        self.directive.write(to, map);
        write_robots(to, &self.doubled);
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        Ok(Self {
            version: wire::VERSION,
            time_ns: from.number()?,
            declared: from.list(grid.cell_count(), |from| wire::Detection::read(from, grid))?,
            expected_remaining: f64::from_le_bytes(from.raw()?),
            alive: from.list(MAX_ROBOTS, Reader::number)?,
            observations: from.number()?,
            version_vector: from.list(MAX_ORIGINS, |from| wire::Version::read(from, grid))?,
            digest: read_digest(from)?,
            directive: wire::Directive::read(from, grid)?,
            doubled: from.list(MAX_ROBOTS, Reader::number)?,
        })
    }
}

impl Packed for wire::Directive {
    fn write(&self, to: &mut Writer, _: Map<'_>) {
        to.number(self.number);
        to.byte(self.order);
        readings::write_cells(to, &self.firsts);
        self.counts.iter().for_each(|&count| to.number(count));
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        let (number, order) = (from.number()?, from.byte()?);
        let firsts = readings::read_cells(from, grid.cell_count())?;
        let counts = firsts.iter().map(|_| from.number()).collect::<Result<_, _>>()?;
        Ok(Self { version: wire::VERSION, number, order, firsts, counts })
    }
}

impl Packed for wire::Verdicts {
    fn write(&self, to: &mut Writer, _: Map) {
        to.number(self.robot);
        to.number(self.time_ns);
        readings::write_cells(to, &self.cells);
        for ((&number, &decision), &log_odds) in self.numbers.iter().zip(&self.decisions).zip(&self.log_odds)
        {
            to.number(number);
            to.byte(decision);
            to.signed(log_odds);
        }
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        let (robot, time_ns) = (from.number()?, from.number()?);
        let cells = readings::read_cells(from, grid.cell_count())?;
        let empty = Self { version: wire::VERSION, robot, time_ns, ..Self::default() };
        cells.iter().try_fold(Self { cells: cells.clone(), ..empty }, |mut verdicts, _| {
            verdicts.numbers.push(from.number()?);
            verdicts.decisions.push(from.byte()?);
            verdicts.log_odds.push(from.signed()?);
            Ok(verdicts)
        })
    }
}

impl Packed for wire::Orders {
    fn write(&self, to: &mut Writer, _: Map) {
        to.number(self.robot);
        to.number(self.time_ns);
        write_robots(to, &self.robots);
        for ((&number, &order), &cell) in self.numbers.iter().zip(&self.orders).zip(&self.cells) {
            to.number(number);
            to.byte(order);
            to.number(cell);
        }
    }

    fn read(from: &mut Reader<'_>, _: Grid) -> Result<Self, PackedError> {
        let (robot, time_ns) = (from.number()?, from.number()?);
        let robots = from.list(MAX_ROBOTS, Reader::number)?;
        let empty = Self { version: wire::VERSION, robot, time_ns, ..Self::default() };
        robots.iter().try_fold(Self { robots: robots.clone(), ..empty }, |mut orders, _| {
            orders.numbers.push(from.number()?);
            orders.orders.push(from.byte()?);
            orders.cells.push(from.number()?);
            Ok(orders)
        })
    }
}

impl Packed for wire::Zones {
    fn write(&self, to: &mut Writer, _: Map) {
        to.number(self.robot);
        to.number(self.time_ns);
        readings::write_cells(to, &self.firsts);
        for ((&count, &number), &zone) in self.counts.iter().zip(&self.numbers).zip(&self.zones) {
            to.number(count);
            to.number(number);
            to.byte(zone);
        }
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        let (robot, time_ns) = (from.number()?, from.number()?);
        let firsts = readings::read_cells(from, grid.cell_count())?;
        let empty = Self { version: wire::VERSION, robot, time_ns, ..Self::default() };
        firsts.iter().try_fold(Self { firsts: firsts.clone(), ..empty }, |mut zones, _| {
            zones.counts.push(from.number()?);
            zones.numbers.push(from.number()?);
            zones.zones.push(from.byte()?);
            Ok(zones)
        })
    }
}

impl Packed for wire::Marks {
    fn write(&self, to: &mut Writer, map: Map) {
        to.number(self.robot);
        to.number(self.time_ns);
        write_list(to, map, &self.marks);
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        let (robot, time_ns) = (from.number()?, from.number()?);
        let marks = from.list(Marks::OPERATORS * Marks::MOST, |from| wire::Mark::read(from, grid))?;
        Ok(Self { version: wire::VERSION, robot, time_ns, marks })
    }
}

impl Packed for wire::Mark {
    fn write(&self, to: &mut Writer, _: Map) {
        to.number(self.id);
        // Mostly it is as old as its mark.
        to.signed(self.number.wrapping_sub(self.id).cast_signed());
        to.byte(self.kind << 1 | u8::from(self.withdrawn));
        to.number(self.strength);
        to.number(self.radius);
        readings::write_cells(to, &self.firsts);
        self.counts.iter().for_each(|&count| to.number(count));
        to.length(self.note.len());
        self.note.bytes().for_each(|byte| to.byte(byte));
    }

    fn read(from: &mut Reader<'_>, grid: Grid) -> Result<Self, PackedError> {
        let id: u64 = from.number()?;
        let number = id.wrapping_add(from.signed()?.cast_unsigned());
        let flags = from.byte()?;
        let (strength, radius) = (from.number()?, from.number()?);
        let firsts = readings::read_cells(from, grid.cell_count())?;
        let counts = firsts.iter().map(|_| from.number()).collect::<Result<_, _>>()?;
        let note = String::from_utf8(from.list(Marked::MAX_NOTE_BYTES, Reader::byte)?);
        Ok(Self {
            version: wire::VERSION,
            id,
            number,
            withdrawn: flags & 1 == 1,
            kind: flags >> 1,
            strength,
            radius,
            firsts,
            counts,
            note: note.map_err(|_| PackedError::Text)?,
        })
    }
}

fn write_list<T: Packed>(to: &mut Writer, map: Map, list: &[T]) {
    to.length(list.len());
    for element in list {
        element.write(to, map);
    }
}

fn write_robots(to: &mut Writer, robots: &[u16]) {
    to.length(robots.len());
    for &robot in robots {
        to.number(robot);
    }
}

fn write_digest(to: &mut Writer, digest: [u64; 2]) {
    for half in digest {
        to.raw(half.to_le_bytes());
    }
}

fn read_digest(from: &mut Reader<'_>) -> Result<[u64; 2], PackedError> {
    Ok([u64::from_le_bytes(from.raw()?), u64::from_le_bytes(from.raw()?)])
}
