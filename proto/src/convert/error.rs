//! Why bytes are not the message they should be.

use dragnet_ros2::cdr::DecodeError;
use dragnet_scenario::participant::Participant;
use dragnet_search::evidence::{MAX_VALUE, MAX_VARIANCE, MIN_VARIANCE};

use super::field::Field;
use crate::dragnet_msgs::VERSION;
use crate::message::MessageKind;

/// A message that is refused: which field, what was found and what is allowed.
#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    /// Not the bytes of such a message at all.
    #[error("{message}: {source}")]
    Bytes {
        /// Its ROS name.
        message: &'static str,
        /// What is wrong with them.
        source: DecodeError,
    },
    /// Somebody speaks another version of our messages.
    #[error("{at}: {found}; this program speaks version {VERSION}")]
    Version {
        /// Where it stood.
        at: Field,
        /// The version.
        found: u8,
    },
    /// A cell that the mission's map does not have.
    #[error("{at}: cell {found} is not on the map; allowed are 0 to {last}")]
    Cell {
        /// Where it stood.
        at: Field,
        /// The number.
        found: u32,
        /// The map's last cell.
        last: usize,
    },
    /// A reading that no sensor makes.
    #[error(
        "{at}: value {value}, variance {variance}; allowed are values from -{MAX_VALUE} to {MAX_VALUE} and variances from {MIN_VARIANCE} to {MAX_VARIANCE}"
    )]
    Reading {
        /// Where it stood.
        at: Field,
        /// Its value.
        value: f32,
        /// Its variance.
        variance: f32,
    },
    /// Arrays that belong together and are of unequal length.
    #[error("{at}: {found} entries; allowed are {expected}, as many as `{partner}` has")]
    Lengths {
        /// Where it stood.
        at: Field,
        /// Its length.
        found: usize,
        /// The array that it belongs to.
        partner: &'static str,
        /// The length of that.
        expected: usize,
    },
    /// An array that is longer than it can be.
    #[error("{at}: {found} entries; allowed are at most {most}")]
    TooMany {
        /// Where it stood.
        at: Field,
        /// Its length.
        found: usize,
        /// The greatest length.
        most: usize,
    },
    /// A byte that names none of the alternatives.
    #[error("{at}: {found}; allowed are {allowed}")]
    Alternative {
        /// Where it stood.
        at: Field,
        /// The byte.
        found: u8,
        /// The alternatives.
        allowed: &'static str,
    },
    /// A number out of its range.
    #[error("{at}: {found}; allowed are {allowed}")]
    Number {
        /// Where it stood.
        at: Field,
        /// The number.
        found: f64,
        /// Its range.
        allowed: &'static str,
    },
    /// A part of another robot than the whole.
    #[error("{at}: of robot {found}; allowed is robot {expected} only")]
    Robot {
        /// Where it stood.
        at: Field,
        /// The robot there.
        found: u16,
        /// The robot of the message.
        expected: u16,
    },
    /// Observations of another incarnation than those before.
    #[error("{at}: {found} after {expected}; allowed are observations of one incarnation")]
    Incarnation {
        /// Where it stood.
        at: Field,
        /// The one there.
        found: u64,
        /// That of those before.
        expected: u64,
    },
    /// Observations out of order, or one twice.
    #[error("{at}: {found} after {before}; allowed are ascending numbers")]
    Order {
        /// Where it stood.
        at: Field,
        /// The sequence number there.
        found: u64,
        /// The one before.
        before: u64,
    },
    /// A message under another participant's key.
    #[error("{message:?} of {author} under a key of {sender}")]
    Sender {
        /// What kind of message.
        message: MessageKind,
        /// Whom the message names.
        author: Participant,
        /// Whom the key names.
        sender: Participant,
    },
}
