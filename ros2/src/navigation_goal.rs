//! What has become of a waypoint that was handed to Nav2 on its goal topic.
//!
//! Nav2 makes a goal of its action `navigate_to_pose` of it, under a name that it does not tell. So the first goal that
//! is accepted after the waypoint was handed over is taken for it. Feedback of the action is not used: the robot's own
//! odometry says where it is, and does so too when somebody else drives.

use std::collections::BTreeSet;

use super::input::{GoalId, GoalState, GoalStatus};

/// A waypoint on its way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NavigationGoal {
    /// Goals that were there before.
    older: BTreeSet<GoalId>,
    mine: Option<GoalId>,
    progress: Progress,
}

/// How it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Nav2 has not taken it up, or nothing of it was heard: whoever waits too long hands it over again.
    Unanswered,
    /// The robot is on its way.
    Underway,
    /// It is there.
    Reached,
    /// Nav2 has given it up.
    Failed,
    /// Somebody has called it off.
    Canceled,
    /// Somebody has sent the robot elsewhere.
    Replaced,
}

impl NavigationGoal {
    /// A waypoint that is handed over now, after these goals were last told of.
    #[must_use]
    pub fn begin(goals: &[GoalStatus]) -> Self {
        let older = goals.iter().map(|goal| goal.goal).collect();
        Self { older, mine: None, progress: Progress::Unanswered }
    }

    /// How it stands.
    #[must_use]
    pub const fn progress(&self) -> Progress {
        self.progress
    }

    /// Takes in what Nav2 tells of its goals. What has ended stays as it ended.
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

    fn check(told: &[&[GoalStatus]], expected: Progress) {
        let mut errand = NavigationGoal::begin(&[goal(1, 10, GoalState::Executing)]);
        assert_eq!(errand.progress(), Progress::Unanswered);
        for goals in told {
            errand.follow(goals);
        }
        assert_eq!(errand.progress(), expected, "{told:?}");
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
    fn a_goal_after_it_replaces_it_and_says_nothing_of_how_it_went() {
        use GoalState::{Aborted, Executing, Succeeded};
        let by_another = goal(3, 30, Executing);
        check(&[&[by_another, goal(2, 20, Aborted)]], Progress::Replaced);
        check(&[&[goal(2, 20, Executing)], &[goal(2, 20, Executing), by_another]], Progress::Replaced);
        check(&[&[goal(2, 20, Succeeded)], &[goal(3, 30, Succeeded)]], Progress::Reached);
        check(&[&[goal(2, 20, Succeeded), by_another]], Progress::Reached);
    }
}
