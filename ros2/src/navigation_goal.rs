//! The state of a waypoint that was sent to Nav2 on its goal topic.
//!
//! Nav2 converts the waypoint to a goal of its action `navigate_to_pose`, with an identifier that it does not publish.
//! So the first goal that is accepted after the waypoint was sent is taken for it. Feedback of the action is not used:
//! the robot's own odometry gives its position, also when another program drives it.

use std::collections::BTreeSet;

use super::input::{GoalId, GoalState, GoalStatus};

/// A waypoint that was sent to Nav2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NavigationGoal {
    /// Goals that existed before.
    older: BTreeSet<GoalId>,
    mine: Option<GoalId>,
    progress: Progress,
}

/// The progress of a waypoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Nav2 has not accepted it, or its status was not received: after too long it is sent again.
    Unanswered,
    /// The robot drives to it.
    Underway,
    /// The robot has reached it.
    Reached,
    /// Nav2 has aborted it.
    Failed,
    /// It was canceled on request.
    Canceled,
    /// Another goal has replaced it.
    Replaced,
}

impl NavigationGoal {
    /// A waypoint that is sent now; `goals` are the goals that exist already.
    #[must_use]
    pub fn begin(goals: &[GoalStatus]) -> Self {
        let older = goals.iter().map(|goal| goal.goal).collect();
        Self { older, mine: None, progress: Progress::Unanswered }
    }

    /// Its progress.
    #[must_use]
    pub const fn progress(&self) -> Progress {
        self.progress
    }

    /// Applies a status message of Nav2. A final state does not change.
    pub fn follow(&mut self, goals: &[GoalStatus]) {
        if !matches!(self.progress, Progress::Unanswered | Progress::Underway) {
            return;
        }
        let newer = || goals.iter().filter(|goal| !self.older.contains(&goal.goal));
        let first = newer().min_by_key(|goal| (goal.accepted_unix_ns, goal.goal));
        let Some(mine) = self.mine.or(first.map(|goal| goal.goal)) else { return };
        self.mine = Some(mine);
        let is_replaced = newer().any(|goal| goal.goal != mine);
        let Some(status) = goals.iter().find(|goal| goal.goal == mine) else { return };
        self.progress = match status.state {
            GoalState::Succeeded => Progress::Reached,
            _ if is_replaced => Progress::Replaced,
            GoalState::Aborted => Progress::Failed,
            GoalState::Canceled => Progress::Canceled,
            GoalState::Unknown | GoalState::Accepted | GoalState::Executing | GoalState::Canceling => {
                Progress::Underway
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn goal(name: u8, accepted_unix_ns: i64, state: GoalState) -> GoalStatus {
        GoalStatus { goal: GoalId([name; 16]), accepted_unix_ns, state }
    }

    fn check(reported: &[&[GoalStatus]], expected: Progress) {
        let mut sent_goal = NavigationGoal::begin(&[goal(1, 10, GoalState::Executing)]);
        assert_eq!(sent_goal.progress(), Progress::Unanswered);
        for goals in reported {
            sent_goal.follow(goals);
        }
        assert_eq!(sent_goal.progress(), expected, "{reported:?}");
    }

    #[test]
    fn a_waypoint_ends_as_its_own_goal_does() {
        use GoalState::{Aborted, Accepted, Canceled, Executing, Succeeded};
        let before = goal(1, 10, Aborted);
        check(&[&[before]], Progress::Unanswered);
        check(&[&[before, goal(2, 20, Accepted)]], Progress::Underway);
        check(&[&[before, goal(2, 20, Executing)], &[goal(2, 20, Succeeded)]], Progress::Reached);
        check(&[&[before, goal(2, 20, Aborted)]], Progress::Failed);
        check(&[&[goal(2, 20, Canceled), before]], Progress::Canceled);
        check(&[&[goal(2, 20, Executing)], &[]], Progress::Underway);
    }

    #[test]
    fn a_later_goal_replaces_it_without_a_result() {
        use GoalState::{Aborted, Executing, Succeeded};
        let by_another = goal(3, 30, Executing);
        check(&[&[by_another, goal(2, 20, Aborted)]], Progress::Replaced);
        check(&[&[goal(2, 20, Executing)], &[goal(2, 20, Executing), by_another]], Progress::Replaced);
        check(&[&[goal(2, 20, Succeeded)], &[goal(3, 30, Succeeded)]], Progress::Reached);
        check(&[&[goal(2, 20, Succeeded), by_another]], Progress::Reached);
    }
}
