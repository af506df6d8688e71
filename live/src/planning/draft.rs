//! The plan in hand: its revision, its review, and whether it is saved. Each change replaces it as a whole.

use std::path::{Path, PathBuf};

use axum::http::StatusCode;
use dragnet_planning::written::PlanFiles;
use dragnet_planning::{MissionPlan, Problem, Review};
use dragnet_scenario::Scenario;
use serde_json::{Value, json};

use super::{Refused, saving};

/// The plan in hand.
pub(super) struct Draft {
    revision: u64,
    reviewed: Reviewed,
    /// The files as last saved.
    saved: Option<PlanFiles>,
    /// All that were saved, under any name.
    own: saving::Own,
}

/// A plan with its review.
pub(super) struct Reviewed {
    plan: MissionPlan,
    review: Review,
}

/// A change to a plan that has changed meanwhile.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the plan was changed in another window meanwhile, and is shown as it is now; please repeat your last change"
)]
pub(super) struct Stale;

impl Draft {
    pub(super) fn new(plan: MissionPlan) -> Self {
        Self { revision: 1, reviewed: Self::reviewed(plan), saved: None, own: saving::Own::new() }
    }

    /// A plan with its review, which may take a while.
    pub(super) fn reviewed(plan: MissionPlan) -> Reviewed {
        let plan = plan.settled();
        Reviewed { review: plan.review(), plan }
    }

    pub(super) const fn revision(&self) -> u64 {
        self.revision
    }

    /// The plan, if it still has this revision.
    pub(super) fn plan_at(&self, revision: u64) -> Result<&MissionPlan, Stale> {
        if revision == self.revision { Ok(&self.reviewed.plan) } else { Err(Stale) }
    }

    /// Replaces the plan, if it still has this revision. The same plan stays.
    pub(super) fn replace(&mut self, revision: u64, by: Reviewed) -> Result<(), Stale> {
        if *self.plan_at(revision)? != by.plan {
            self.reviewed = by;
            self.revision += 1;
        }
        Ok(())
    }

    pub(super) fn state(&self) -> Value {
        let Reviewed { plan, review } = &self.reviewed;
        let saved = self.saved.as_ref().map(|files| {
            json!({
                "scenario": files.scenario_name,
                "areas": files.areas_name,
                "is_current": *files == plan.files(),
            })
        });
        json!({ "revision": self.revision, "plan": plan, "review": review, "saved": saved })
    }

    /// The scenario of the plan, with the revision.
    pub(super) fn scenario(&self) -> Result<(u64, Scenario), Vec<Problem>> {
        Ok((self.revision, self.reviewed.plan.scenario()?))
    }

    /// Writes the files of the plan into a folder; returns what was done.
    pub(super) fn save(&mut self, revision: u64, folder: &Path, overwrite: bool) -> Result<String, Refused> {
        let files = self.plan_at(revision)?.files();
        if !self.reviewed.review.problems.is_empty() {
            return Err(Refused::of_problems(&self.reviewed.review.problems));
        }
        let message = saving::save(folder, &files, &mut self.own, overwrite)?;
        self.saved = Some(files);
        Ok(message)
    }

    /// The path of the saved scenario, if the plan has not changed since, nor its files.
    pub(super) fn saved_scenario(&self, folder: &Path) -> Result<PathBuf, Refused> {
        let files = self.reviewed.plan.files();
        let is_current = self.saved.as_ref() == Some(&files) && saving::is_on_disk(folder, &files);
        if is_current {
            Ok(folder.join(files.scenario_name))
        } else {
            Err(Refused::new(
                StatusCode::CONFLICT,
                "save the plan first: the saved plan is what is simulated",
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use dragnet_scenario::map_file::Areas;

    use super::*;

    fn plan(robots: i64) -> MissionPlan {
        let mut plan = MissionPlan::of_areas("moor", &Areas::default()).unwrap();
        plan.scenario.robots.count = robots;
        plan
    }

    #[test]
    fn of_two_windows_the_second_is_told_that_the_plan_has_changed() {
        let mut draft = Draft::new(plan(1));
        let seen_by_both = draft.revision();
        draft.replace(seen_by_both, Draft::reviewed(plan(2))).unwrap();
        assert_eq!(draft.replace(seen_by_both, Draft::reviewed(plan(3))), Err(Stale));
        assert_eq!(draft.plan_at(draft.revision()), Ok(&plan(2)));
        // The same once more changes nothing, so that a forecast stays true.
        let revision = draft.revision();
        draft.replace(revision, Draft::reviewed(plan(2))).unwrap();
        assert_eq!(draft.revision(), revision);
    }
}
