//! A search as it is told: line by line while it goes on, then what it came to.

mod narrator;
mod report;

use std::path::PathBuf;

use dragnet_scenario::Scenario;
use dragnet_sim::episode::Episode;
use dragnet_sim::simulation::StepObserver;

use super::Failure;
use crate::terminal::{self, progress};
use narrator::Narrator;
pub(super) use narrator::place;
use report::Report;

/// How a search is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// Lines, a map, and measures.
    Text,
    /// One JSON object.
    Json,
}

/// A search that has ended.
pub(super) struct Ended {
    pub(super) seed: u64,
    pub(super) episode: Episode,
    /// By the coordinator; unknown where that is a process elsewhere.
    pub(super) observations_merged: Option<u64>,
    pub(super) recording: Option<PathBuf>,
}

/// Runs a search and tells it on stdout.
pub(super) fn tell(
    scenario: &Scenario,
    style: Style,
    search: impl FnOnce(StepObserver<'_>) -> Result<Ended, Failure>,
) -> Result<(), Failure> {
    if style == Style::Json {
        let ended = search(&mut |_, _| ())?;
        return Ok(terminal::print_json(&Report::new(scenario, &ended))?);
    }
    let steps = narrator::steps(scenario.budget_cells());
    let mut narrator = Narrator::new(scenario, progress::below_lines(steps, "cells"));
    let ended = search(&mut |now, scene| narrator.see(now, &scene))?;
    let watched = narrator.finish()?;
    let report = Report::new(scenario, &ended);
    Ok(terminal::print(&report.text(scenario, &ended.episode, &watched))?)
}
