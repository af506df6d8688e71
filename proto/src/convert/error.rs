//! Decoding errors.

use dragnet_ros2::cdr::DecodeError;
use dragnet_scenario::participant::Participant;
use dragnet_search::evidence::{MAX_VALUE, MAX_VARIANCE, MIN_VARIANCE};
use dragnet_search::object_position::ObjectPosition;

use super::field::Field;
use super::packed::PackedError;
use crate::message::MessageKind;

/// A rejected message: the field, its value and the allowed values.
#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    /// Not the bytes of such a message.
    #[error("{message}: {source}")]
    Bytes {
        /// Its ROS name.
        message: &'static str,
        /// The decoding error.
        source: DecodeError,
    },
    /// Not the packed bytes of such a message.
    #[error("{message}: {source}")]
    Packed {
        /// Its ROS name.
        message: &'static str,
        /// The decoding error.
        source: PackedError,
    },
    /// Another version of Dragnet's messages.
    #[error("{at}: {found}; this program uses version {expected}")]
    Version {
        /// The field.
        at: Field,
        /// The version.
        found: u8,
        /// This program's.
        expected: u8,
    },
    /// A cell that is not on the mission's map.
    #[error("{at}: cell {found} is not on the map; allowed are 0 to {last}")]
    Cell {
        /// The field.
        at: Field,
        /// The number.
        found: u32,
        /// The map's last cell.
        last: usize,
    },
    /// An impossible reading.
    #[error(
        "{at}: value {value}, variance {variance}; allowed are values from -{MAX_VALUE} to {MAX_VALUE} and variances from {MIN_VARIANCE} to {MAX_VARIANCE}"
    )]
    Reading {
        /// The field.
        at: Field,
        /// Its value.
        value: f32,
        /// Its variance.
        variance: f32,
    },
    /// Corresponding arrays of unequal length.
    #[error("{at}: {found} entries; allowed are {expected}, as many as `{partner}` has")]
    Lengths {
        /// The field.
        at: Field,
        /// Its length.
        found: usize,
        /// The corresponding array.
        partner: &'static str,
        /// The length of that.
        expected: usize,
    },
    /// An array that is too long.
    #[error("{at}: {found} entries; allowed are at most {most}")]
    TooMany {
        /// The field.
        at: Field,
        /// Its length.
        found: usize,
        /// The greatest length.
        most: usize,
    },
    /// A byte outside an enumeration.
    #[error("{at}: {found}; allowed are {allowed}")]
    Alternative {
        /// The field.
        at: Field,
        /// The byte.
        found: u8,
        /// The allowed values.
        allowed: &'static str,
    },
    /// A number out of its range.
    #[error("{at}: {found}; allowed are {allowed}")]
    Number {
        /// The field.
        at: Field,
        /// The number.
        found: f64,
        /// Its range.
        allowed: &'static str,
    },
    /// The position of an object that cannot be one.
    #[error(
        "{at}: {meters:?} m with covariance {covariance:?} m2; allowed are finite meters, and positive semi-definite \
         covariances with variances of at most {most} m2",
        most = ObjectPosition::MAX_VARIANCE_SQUARE_METERS
    )]
    Position {
        /// The field.
        at: Field,
        /// Meters east and north.
        meters: [f64; 2],
        /// East with east, east with north, north with north, square meters.
        covariance: [f32; 3],
    },
    /// A part of a message that names another robot than the whole.
    #[error("{at}: of robot {found}; allowed is robot {expected} only")]
    Robot {
        /// The field.
        at: Field,
        /// The robot there.
        found: u16,
        /// The robot of the message.
        expected: u16,
    },
    /// Observations of different incarnations.
    #[error("{at}: {found} after {expected}; allowed are observations of one incarnation")]
    Incarnation {
        /// The field.
        at: Field,
        /// The incarnation.
        found: u64,
        /// That of the observations before.
        expected: u64,
    },
    /// Observations out of order, or repeated.
    #[error("{at}: {found} after {before}; allowed are ascending numbers")]
    Order {
        /// The field.
        at: Field,
        /// The sequence number there.
        found: u64,
        /// The one before.
        before: u64,
    },
    /// A message under another participant's key.
    #[error("{message:?} of {author} under a key of {sender}")]
    Sender {
        /// The kind of the message.
        message: MessageKind,
        /// The author in the message.
        author: Participant,
        /// The participant of the key.
        sender: Participant,
    },
}
