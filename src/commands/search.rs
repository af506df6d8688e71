//! The output of a search: lines while it runs, then a report.

mod narrator;
mod report;
mod traffic;

use std::path::PathBuf;

use dragnet_runtime::team::Medium;
use dragnet_scenario::Scenario;
use dragnet_sim::episode::Episode;
use dragnet_sim::simulation::StepObserver;

use super::Failure;
use crate::terminal::{self, progress};
use narrator::Narrator;
use report::Report;

/// The output format of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// Lines, a map, and measures.
    Text,
    /// One JSON object.
    Json,
}

/// A completed search.
pub(super) struct Ended {
    pub(super) seed: u64,
    pub(super) episode: Episode,
    /// As counted by the coordinator; unknown if that is another process.
    pub(super) observations_merged: Option<u64>,
    /// Medium of the messages.
    pub(super) medium: Medium,
    pub(super) recording: Option<PathBuf>,
    /// What went wrong although the search was completed: it is told after the results.
    pub(super) failure: Option<Failure>,
}

/// Runs a search and prints it on stdout.
pub(super) fn tell(
    scenario: &Scenario,
    style: Style,
    search: impl FnOnce(StepObserver<'_>) -> Result<Ended, Failure>,
) -> Result<(), Failure> {
    if style == Style::Json {
        let ended = search(&mut |_, _| ())?;
        terminal::print_json(&Report::new(scenario, &ended))?;
        return ended.failure.map_or(Ok(()), Err);
    }
    let steps = narrator::steps(scenario.budget_cells());
    let mut narrator = Narrator::new(scenario, progress::below_lines(steps, "cells"));
    let ended = search(&mut |now, scene| narrator.see(now, &scene))?;
    let watched = narrator.finish()?;
    let report = Report::new(scenario, &ended);
    terminal::print(&report.text(scenario, &ended.episode, &watched))?;
    ended.failure.map_or(Ok(()), Err)
}
