//! Goals of an action, as reported by its server.

use super::InputError;
use super::check::Check;
use crate::schema::RosMessage;
use crate::wire::robot::GoalStatusArray;

/// The maximum number of goals in a message.
const MAX_GOALS: usize = 1024;

/// The identifier of a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct GoalId(pub [u8; 16]);

/// The status of a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GoalStatus {
    /// The goal.
    pub goal: GoalId,
    /// When its server accepted it, Unix nanoseconds by the server's clock.
    pub accepted_unix_ns: i64,
    /// Its state.
    pub state: GoalState,
}

/// The state of a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalState {
    /// Unknown to its server.
    Unknown,
    /// Accepted, not yet executing.
    Accepted,
    /// Executing.
    Executing,
    /// Being canceled on request.
    Canceling,
    /// Reached.
    Succeeded,
    /// Canceled on request.
    Canceled,
    /// Aborted by its server.
    Aborted,
}

impl GoalState {
    const ALL: [Self; 7] = [
        Self::Unknown,
        Self::Accepted,
        Self::Executing,
        Self::Canceling,
        Self::Succeeded,
        Self::Canceled,
        Self::Aborted,
    ];
}

pub(super) fn check(goals: &GoalStatusArray) -> Result<Vec<GoalStatus>, InputError> {
    let check = Check { message: GoalStatusArray::NAME };
    check.at_most("status_list", goals.status_list.len(), MAX_GOALS)?;
    let goals = goals.status_list.iter().enumerate();
    goals
        .map(|(index, goal)| {
            let state = usize::try_from(goal.status).ok().and_then(|number| GoalState::ALL.get(number));
            let Some(&state) = state else {
                return check.refused(format!("status_list[{index}].status"), goal.status, "0 to 6");
            };
            let stamp = format!("status_list[{index}].goal_info.stamp");
            let accepted_unix_ns = check.stamp(&stamp, goal.goal_info.stamp)?;
            Ok(GoalStatus { goal: GoalId(goal.goal_info.goal_id.uuid), accepted_unix_ns, state })
        })
        .collect()
}
