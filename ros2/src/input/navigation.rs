//! Goals of an action, as its server tells of them.

use super::InputError;
use super::check::Check;
use crate::schema::RosMessage;
use crate::wire::robot::GoalStatusArray;

/// More goals than a server remembers.
const MAX_GOALS: usize = 1024;

/// Names a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct GoalId(pub [u8; 16]);

/// How a goal stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GoalStatus {
    /// Which one.
    pub goal: GoalId,
    /// When its server accepted it, Unix nanoseconds by the server's clock.
    pub accepted_unix_ns: i64,
    /// How it stands.
    pub state: GoalState,
}

/// How a goal stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalState {
    /// Its server does not know.
    Unknown,
    /// It is to be pursued.
    Accepted,
    /// It is being pursued.
    Executing,
    /// It is being given up, as somebody asked.
    Canceling,
    /// It is reached.
    Succeeded,
    /// It was given up, as somebody asked.
    Canceled,
    /// It was given up by its server.
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
