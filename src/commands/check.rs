//! `dragnet check`: what scenarios say, and what is wrong with them.

use std::path::PathBuf;

use dragnet_proto::scenario::Scenario;

use super::{Failure, complain, scenario};
use crate::terminal::{self, counted};

/// Check scenario files, and the maps that they name.
///
/// Says what each scenario comes to, what is odd about it, or why it cannot be run.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet check scenarios/*.toml")]
pub(crate) struct Arguments {
    /// Scenario files (TOML)
    #[arg(required = true, value_name = "SCENARIO")]
    scenarios: Vec<PathBuf>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let mut failed = 0;
    for path in &arguments.scenarios {
        match Scenario::load(path) {
            Ok(scenario) => terminal::print(&describe(&scenario))?,
            Err(error) => {
                complain("error", &error.to_string());
                failed += 1;
            }
        }
    }
    if failed == 0 {
        return Ok(());
    }
    Err(Failure::Input(format!("{failed} of {} scenarios cannot be run", arguments.scenarios.len())))
}

fn describe(scenario: &Scenario) -> String {
    let (terrain, file) = (scenario.terrain(), scenario.source().path.display());
    let grid = terrain.grid();
    let summary = format!(
        "{file}: ok: {} x {} cells of {} m, {} traversable, {} searched; {}; {}; {}\n",
        grid.rows(),
        grid.columns(),
        terrain.cell_meters(),
        terrain.traversable_cells().count(),
        terrain.searched_cells().count(),
        scenario.objects(),
        robots(scenario),
        budget(scenario),
    );
    let warnings = scenario.warnings();
    let warnings = warnings.iter().map(|warning| format!("{file}: warning: {warning}\n"));
    std::iter::once(summary).chain(warnings).collect::<Vec<_>>().concat()
}

fn robots(scenario: &Scenario) -> String {
    format!("{} ({})", counted(scenario.robots().len(), "robot"), scenario::policies(scenario))
}

fn budget(scenario: &Scenario) -> String {
    let budget = &scenario.mission().budget;
    let meters = budget.meters().map(|meters| format!("{meters} m"));
    let seconds = budget.time().map(|time| format!("{} s", time.as_secs_f64()));
    let parts: Vec<String> = meters.into_iter().chain(seconds).collect();
    format!("budget {}, {:.0} cells", parts.join(" and "), scenario.budget_cells())
}
