//! Who tells observations, as a number: that of a robot, or 0, which no robot has, for the operator.

use dragnet_search::observation::{Origin, RobotId, Source};

/// The number of a source, on the wire and wherever observations are kept.
#[must_use]
pub const fn source_number(source: Source) -> u16 {
    match source {
        Source::Operator => 0,
        Source::Robot(robot) => robot.number(),
    }
}

/// The source of a number.
#[must_use]
pub fn numbered_source(number: u16) -> Source {
    RobotId::new(number).map_or(Source::Operator, Source::Robot)
}

/// An origin by the number of its source.
pub(super) fn origin(number: u16, incarnation: u64) -> Origin {
    Origin { source: numbered_source(number), incarnation }
}
