//! `dragnet check`: what scenarios say, and what is wrong with them.

use std::path::PathBuf;

use dragnet_scenario::map_file::areas::{Claims, Region, Rest};
use dragnet_scenario::map_file::{GeoPoint, Georeference, MapOrigin};
use dragnet_scenario::{Drawn, Scenario};

use super::{Failure, complain, scenario};
use crate::terminal::{self, counted};

/// A region that is searched to a smaller share than this is told of: its whole POA is put on what is searched.
const MOST_OF_IT: f64 = 0.9;

/// Check scenario files and the maps that they name.
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
    std::iter::once(summary).chain(earth(scenario)).chain(warnings).collect::<Vec<_>>().concat()
}

/// Where the map lies, and what is drawn there.
fn earth(scenario: &Scenario) -> Vec<String> {
    let corner = scenario.georeference().map(Georeference::south_west).map(|corner| {
        let GeoPoint { latitude_degrees, longitude_degrees } = corner;
        format!(
            "  south-western corner at latitude {latitude_degrees:.6}, longitude {longitude_degrees:.6}\n"
        )
    });
    let drawn = scenario.drawn().into_iter().map(|Drawn { name, kind, cells, barriers, .. }| {
        let comes_of_it = match barriers {
            0 => counted(cells, "searched cell"),
            _ => format!("closes {}", counted(cells, "cell")),
        };
        format!("  {kind} {name:?}: {comes_of_it}\n")
    });
    let claims = scenario.claims().map(claims).unwrap_or_default();
    corner.into_iter().chain(frame(scenario)).chain(drawn).chain(claims).collect()
}

/// Where the map lies in the frame of its file, if that is not where the frame begins.
fn frame(scenario: &Scenario) -> Option<String> {
    let origin = scenario.origin();
    (origin != MapOrigin::default()).then(|| format!("  south-western corner in the frame map: {origin}\n"))
}

fn claims(claims: &Claims) -> Vec<String> {
    let region = |region: &Region| {
        let Region { name, poa, cells, searched_share } = region;
        let partly = if *searched_share < MOST_OF_IT {
            format!(", though only {:.0} % of it is searched", 100.0 * searched_share)
        } else {
            String::new()
        };
        format!("  prior {name:?}: POA {:.1} % in {}{partly}\n", 100.0 * poa, counted(*cells, "cell"))
    };
    let Rest { poa, cells } = claims.rest;
    let place = match cells {
        0 => "beyond the map".to_owned(),
        _ => format!("spread over {} outside of all areas", counted(cells, "cell")),
    };
    let rest = format!("  rest: POA {:.1} %, {place}\n", 100.0 * poa);
    claims.regions.iter().map(region).chain(std::iter::once(rest)).collect()
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
