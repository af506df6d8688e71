//! Commands of the operator to a running mission, given at the coordinator.

use dragnet_search::cell::Cell;
use dragnet_search::mark::Mark;
use dragnet_search::observation::RobotId;

use crate::directive::TeamOrder;
use crate::marks::MarkId;
use crate::orders::RobotOrder;
use crate::verdict::Decision;
use crate::zones::Zone;

/// A command of the operator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// An order to all robots.
    Team(TeamOrder),
    /// The mission ends at once: nothing waits for the robots, which return to their bases all the same.
    EndNow,
    /// An order to one robot.
    Robot(RobotId, RobotOrder),
    /// Mark something, with a note of at most [`crate::marks::Marked::MAX_NOTE_BYTES`].
    Mark(Mark, String),
    /// Withdraw a mark.
    Unmark(MarkId),
    /// Add these cells to the search area.
    Search(Vec<Cell>),
    /// Take these cells out of the search, or open them again.
    Zone(Zone, Vec<Cell>),
    /// Decide about the find in a cell.
    Judge(Decision, Cell),
}
