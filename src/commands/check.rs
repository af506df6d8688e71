//! `dragnet check`: summarizes and validates scenarios and settings.

use std::path::{Path, PathBuf};

use dragnet_files::read_text_at_most;
use dragnet_runtime::config::{self, AgentSettings, CoordinatorSettings, SimSettings};
use dragnet_runtime::session::{self, Endpoints};
use dragnet_scenario::map_file::areas::{Claims, Region, Rest};
use dragnet_scenario::map_file::{Georeference, MapOrigin, Purpose};
use dragnet_scenario::{Class, Drawn, Robot, Scenario, Start};

use super::earlier::{self, PriorFrom};
use super::settings::Kind;
use super::{Failure, complain, scenario};
use crate::terminal::{self, counted};

/// A region whose searched share is below this gets a warning: its whole POA is put on the searched part.
const MOST_OF_IT: f64 = 0.9;
/// The maximum size of a file whose kind is determined by its text, bytes.
const MAX_BYTES: u64 = 1 << 24;

/// Check scenario files, the maps that they name, and settings.
///
/// Prints a summary of each file with warnings about likely mistakes, or the reason why it is invalid. Settings of
/// `dragnet agent`, `coordinator` and `sim` are recognized by their keys; `dragnet doctor` checks the files and devices
/// that settings refer to on this computer.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet check scenarios/*.toml")]
pub(crate) struct Arguments {
    /// Files of scenarios or settings (TOML), or names that `dragnet scenarios` lists
    #[arg(required = true, value_name = "FILE")]
    scenarios: Vec<PathBuf>,
    #[command(flatten)]
    prior: PriorFrom,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let mut failed = 0;
    for path in &arguments.scenarios {
        match check(path, &arguments.prior) {
            Ok(summary) => terminal::print(&summary)?,
            Err(error) => {
                complain("error", &error);
                failed += 1;
            }
        }
    }
    if failed == 0 {
        return Ok(());
    }
    Err(Failure::Input(format!("{failed} of {} files are invalid", arguments.scenarios.len())))
}

fn check(path: &Path, prior: &PriorFrom) -> Result<String, String> {
    // A file that is not text is reported by the scenario reader.
    let kind = read_text_at_most(path, MAX_BYTES).map_or(Kind::Scenario, |text| Kind::of(&text));
    let file = path.display();
    let settings = match kind {
        Kind::Scenario => {
            let scenario = Scenario::load(path).map_err(|error| error.to_string())?;
            return prior.continued(scenario).map(|scenario| describe(&scenario));
        }
        _ if prior.is_given() => {
            let allowed = "a scenario, or common.prior_from in the settings";
            return Err(format!("{file}: settings with --prior-from; allowed is {allowed}"));
        }
        Kind::Agent => config::load::<AgentSettings>(path).and_then(|settings| {
            let checked = settings.common.check(path)?;
            settings.agent_config(path, &checked.scenario)?;
            settings.vehicle(path, &checked.scenario)?;
            let robots = checked.scenario.robots().len();
            let what = format!("robot {} of {robots} in mission {}", settings.robot, checked.mission);
            Ok((what, settings.common.zenoh))
        }),
        Kind::Coordinator => config::load::<CoordinatorSettings>(path).and_then(|settings| {
            let checked = settings.common.check(path)?;
            settings.tak(path, &checked.scenario)?;
            Ok((format!("coordinator of mission {}", checked.mission), settings.common.zenoh))
        }),
        Kind::Sim => config::load::<SimSettings>(path).and_then(|settings| {
            Ok((format!("simulator of mission {}", settings.check(path)?), settings.zenoh))
        }),
    };
    let (what, endpoints) = settings.map_err(|error| error.to_string())?;
    Ok(format!("{file}: ok: {what}\n{}", alone(path, endpoints)))
}

/// A warning, if a process with these endpoints can never meet another. Settings of Zenoh that are invalid are reported
/// by `dragnet doctor`.
fn alone(path: &Path, endpoints: Endpoints) -> String {
    session::alone(&endpoints.named_in(path)).map_or_else(String::new, |[found, advice]| {
        format!("{}: warning: {found}; {advice}\n", path.display())
    })
}

/// The objects, and how probable it is that each of them is elsewhere if their number is known.
fn sought(scenario: &Scenario) -> String {
    let objects = scenario.objects();
    let Some(subjects) = scenario.subjects() else { return objects.to_string() };
    let percent = scenario::percent_outside(subjects);
    let each = if subjects.number() == 1 { "" } else { "each " };
    format!("{objects}, their number known, {each}outside of the area with {percent} %")
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
        sought(scenario),
        robots(scenario),
        budget(scenario),
    );
    let drawn = scenario.drawn();
    let warnings = scenario.warnings_with(&drawn);
    let warnings = warnings.iter().map(|warning| format!("{file}: warning: {warning}\n"));
    let assumed = scenario
        .is_of_map()
        .then(|| format!("  all but the map is assumed; {}\n", scenario::changing_assumptions(scenario)));
    std::iter::once(summary)
        .chain(assumed)
        .chain(earlier::continues(scenario).map(|text| format!("  {text}\n")))
        .chain(starts(scenario))
        .chain(earth(scenario, &drawn))
        .chain(warnings)
        .collect::<Vec<_>>()
        .concat()
}

/// Where the robots start.
fn starts(scenario: &Scenario) -> Vec<String> {
    let start = |(start, robots): (Start, Vec<String>)| {
        let cell = match start {
            Start::Together { area: 0 } => "in a cell drawn by the seed".to_owned(),
            Start::Together { area } => {
                let cells = scenario.terrain().connected_areas()[area].len();
                format!("in a cell drawn by the seed, in another part of {cells} cells")
            }
            Start::Scattered => "each in a cell of its own, drawn by the seed".to_owned(),
            Start::Cell(cell) => {
                format!("in {}", scenario.places().on_earth(cell))
            }
        };
        let is_of_all = robots.len() == scenario.robots().len();
        let who =
            if is_of_all { "start".to_owned() } else { format!("start of robot {}", robots.join(", ")) };
        format!("  {who}: {cell}\n")
    };
    robots_by(scenario, |robot| robot.start).into_iter().map(start).collect()
}

/// The numbers of robots that have something in common, in the order of the first of each.
fn robots_by<'a, T: PartialEq>(scenario: &'a Scenario, of: impl Fn(&'a Robot) -> T) -> Vec<(T, Vec<String>)> {
    let mut groups: Vec<(T, Vec<String>)> = Vec::new();
    for robot in scenario.robots() {
        let (common, number) = (of(robot), robot.id.to_string());
        match groups.iter_mut().find(|(group, _)| *group == common) {
            Some((_, numbers)) => numbers.push(number),
            None => groups.push((common, vec![number])),
        }
    }
    groups
}

/// The map's position on the earth, and its areas.
fn earth(scenario: &Scenario, drawn: &[Drawn]) -> Vec<String> {
    let corner = scenario.georeference().map(Georeference::south_west);
    let corner = corner.map(|corner| format!("  south-western corner at {corner}\n"));
    let by_area: usize =
        drawn.iter().filter(|area| area.kind == Purpose::SEARCH).map(|area| area.cells).sum();
    let searched = scenario.terrain().searched_cells().count();
    let shared = (by_area > searched).then(|| {
        format!(
            "  in all {}: one that several areas touch counts in each\n",
            counted(searched, "searched cell")
        )
    });
    let drawn = drawn.iter().map(|Drawn { name, kind, cells, barriers, .. }| {
        let comes_of_it = match barriers {
            0 => counted(*cells, "searched cell"),
            _ => format!("closes {}", counted(*cells, "cell")),
        };
        format!("  {kind} {name:?}: {comes_of_it}\n")
    });
    let claims = scenario.claims().map(claims).unwrap_or_default();
    let lines = drawn.chain(shared);
    corner.into_iter().chain(frame(scenario)).chain(lines).chain(claims).collect()
}

/// The map's position in the frame of its file, if that is not the frame's origin.
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
    let robots = counted(scenario.robots().len(), "robot");
    let separation = scenario.separation();
    let apart = f64::from(separation.cells()) * scenario.terrain().cell_meters();
    let apart = if separation.is_kept() { format!(", at least {apart} m apart") } else { String::new() };
    let policies = scenario::policies(scenario) + &apart;
    if let Some(class) = scenario.only_class().filter(|class| class.name.is_none()) {
        return format!("{robots} ({policies}), sight {} m", sight_meters(scenario, class));
    }
    let class = |(class, numbers): (&Class, Vec<String>)| {
        let name = class.name.as_deref().unwrap_or("of no class");
        let flies = if class.flies { ", flies" } else { "" };
        let (sight, speed) = (sight_meters(scenario, class), class.speed_meters_per_second);
        format!("{name} (robot {}): sight {sight} m, {speed} m/s{flies}", numbers.join(", "))
    };
    let classes: Vec<String> = robots_by(scenario, |robot| &*robot.class).into_iter().map(class).collect();
    format!("{robots} ({policies}): {}", classes.join("; "))
}

fn sight_meters(scenario: &Scenario, class: &Class) -> f64 {
    let sight_meters = f64::from(class.sensor.radius()) * scenario.terrain().cell_meters();
    // Ten cells of 0.1 m are 1 m.
    (sight_meters * 1e6).round() / 1e6
}

fn budget(scenario: &Scenario) -> String {
    let budget = &scenario.mission().budget;
    let meters = budget.meters().map(|meters| format!("{meters} m"));
    let seconds = budget.time().map(|time| format!("{} s", time.as_secs_f64()));
    let parts: Vec<String> = meters.into_iter().chain(seconds).collect();
    let home = scenario.mission().return_reserve.map_or_else(String::new, |reserve| {
        format!(", with the way back to base and {:.0} % in reserve", 100.0 * reserve)
    });
    format!("budget {}, {:.0} cells{home}", parts.join(" and "), scenario.budget_cells())
}
