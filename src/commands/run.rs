//! `dragnet run`: one search, shown and recorded.

use std::net::SocketAddr;
use std::path::PathBuf;

use dragnet_live::page::Page;
use dragnet_live::view::About;
use dragnet_runtime::config::check_real_time_factor;
use dragnet_runtime::tak;
use dragnet_runtime::team::{self, Medium, Options, RunObserver};
use dragnet_scenario::Scenario;
use dragnet_scenario::file::PolicyField;
use dragnet_search::utility::UtilityTable;
use dragnet_sim::simulation::StepObserver;
use dragnet_sim::world::World;

use super::earlier::{self, PriorFrom};
use super::search::{self, Ended, Style};
use super::{Failure, foxglove, live, output, scenario};
use crate::VERSION;

/// Real-time factor of a search that is shown while it runs.
const LIVE_REAL_TIME_FACTOR: f64 = 10.0;

/// Run one search in simulation, and record it.
///
/// Prints each decision and each find as it happens, then the map, the finds, and the measures of the search. The
/// recording opens in Foxglove and other readers of MCAP. The same scenario and seed always give the same search.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet run scenarios/ice_cream_cone.toml
  dragnet run scenarios/team.toml --policy greedy --robots 4 --seed 7 --json
  dragnet run scenarios/team.toml --robots 100
  dragnet run scenarios/team.toml --live
  dragnet run scenarios/team.toml --live --foxglove
  dragnet run area.kml --live --tak udp://239.2.3.1:6969
  dragnet run area.kml --robots 2
  dragnet run area.kml --prior-from area-0.mcap
  dragnet run scenarios/team.toml --policy gnn --weights mine.safetensors")]
pub(crate) struct Arguments {
    /// Scenario file (TOML): map, objects, sensor and robots; or a name that `dragnet scenarios` lists; or a map alone,
    /// such as areas in KML: then the rest is assumed, and told
    scenario: PathBuf,
    #[command(flatten)]
    prior: PriorFrom,
    /// Policy of all robots, instead of the scenario's. Parameters in parentheses, as in 'tour(evaluations=4000)', are
    /// those of scenarios; all others have their defaults
    #[arg(long, value_parser = scenario::POLICY)]
    policy: Option<PolicyField>,
    /// Weights file for --policy gnn, instead of the built-in weights
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Number of robots, 1 to 1000, instead of the scenario's
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    robots: Option<u32>,
    /// Seed of object positions, start cells, sensor noise and random decisions: a whole number from 0
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = scenario::parse_seed, allow_negative_numbers = true)]
    seed: u64,
    /// Medium of the messages. The search and its recording do not depend on it [default: zenoh with --processes,
    /// --real-time-factor, --live or --foxglove; otherwise memory]
    #[arg(long, value_name = "MEDIUM")]
    over: Option<Over>,
    /// Number of threads that deliver messages with --over memory, 1 to 1024. The search and its recording do not
    /// depend on it [default: the number of cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Run every robot in its own process
    #[arg(long)]
    processes: bool,
    /// Mission seconds per second of the wall clock, 0.001 to 10000 [default: as fast as possible, or 10 with
    /// --live or --foxglove]
    #[arg(long, value_name = "X", value_parser = parse_real_time_factor, allow_negative_numbers = true)]
    real_time_factor: Option<f64>,
    /// Serve a live page of the search until Ctrl-C, at this address: IP:PORT, IP or PORT [default without ADDRESS:
    /// 127.0.0.1 and any free port]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = live::ANYWHERE, value_parser = live::parse_address)]
    live: Option<SocketAddr>,
    /// Serve the search to Foxglove and other clients of its WebSocket protocol until Ctrl-C, at this address: IP:PORT, IP
    /// or PORT. They see what the recording holds, and can change nothing [default without ADDRESS: 127.0.0.1:8765]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = foxglove::HERE, value_parser = foxglove::parse_address)]
    foxglove: Option<SocketAddr>,
    /// Send the search to the maps of TAK (ATAK, WinTAK, iTAK) too: `udp://239.2.3.1:6969` is the multicast group of all
    /// devices on the network; `udp://HOST:PORT` and `tcp://HOST:PORT` are one device or server
    #[arg(long, value_name = "URL", requires = "live")]
    tak: Option<String>,
    /// Map to show on the page under the search: a PMTiles file with raster tiles
    #[arg(long, value_name = "FILE", requires = "live")]
    basemap: Option<PathBuf>,
    /// Write the recording (MCAP) to this file, which must not exist [default: `recording.file` of the scenario, or
    /// else NAME-SEED.mcap in the working directory, with a number added if that exists]
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// Medium of the messages of a team.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Over {
    /// Each participant has its own Zenoh session, as in the field
    Zenoh,
    /// Messages stay in the memory of this process: faster, but in simulated time only
    Memory,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let weights = arguments.weights.as_deref();
    scenario::check_weights(weights, "--policy", arguments.policy.as_slice())?;
    let mut scenario = arguments.prior.load(&arguments.scenario)?;
    if let Some(policy) = &arguments.policy {
        scenario = scenario::with_policy(&scenario, "--policy", policy, weights)?;
    }
    let scenario = scenario::with(scenario, "--robots", arguments.robots, Scenario::with_robots)?;
    let medium = medium(arguments)?;
    let options = options(arguments, medium, place_recording(arguments, &scenario)?)?;
    team::check(&scenario, &options)?;
    scenario::warn(&scenario);
    earlier::tell(&scenario);
    UtilityTable::warm_up();
    let style = if arguments.json { Style::Json } else { Style::Text };
    let Shown { page, foxglove, observer } = show(arguments, &scenario)?;
    search::tell(&scenario, style, |spectator| {
        run(&scenario, arguments.seed, &options, observer, spectator)
    })?;
    match (page, foxglove) {
        (Some(page), _foxglove) => page.stay(),
        (None, Some(foxglove)) => foxglove.stay(),
        (None, None) => {}
    }
    Ok(())
}

/// Where the search is shown while it runs.
struct Shown {
    page: Option<live::Announced>,
    foxglove: Option<foxglove::Announced>,
    observer: RunObserver,
}

fn show(arguments: &Arguments, scenario: &Scenario) -> Result<Shown, Failure> {
    let (foxglove, messages) = arguments.foxglove.map(foxglove::serve).transpose()?.unzip();
    let mut observer = RunObserver { messages, ..RunObserver::default() };
    let page = match arguments.live {
        Some(listen) => {
            // The search is simulated, so the objects are known.
            let objects = World::new(scenario, arguments.seed).truth().objects().to_vec();
            let about = About::of(scenario, Some(objects));
            let settings = live::settings(listen, arguments.basemap.as_deref());
            let (page, listener, commands) = Page::of_mission(&settings, about)?;
            (observer.listener, observer.commands) = (Some(listener), Some(commands));
            Some(live::announce(page, live::LIVE_PAGE))
        }
        None => None,
    };
    Ok(Shown { page, foxglove, observer })
}

fn run(
    scenario: &Scenario,
    seed: u64,
    options: &Options,
    observer: RunObserver,
    spectator: StepObserver<'_>,
) -> Result<Ended, Failure> {
    let run = team::run_watched(scenario, seed, options, observer, spectator)?;
    Ok(Ended {
        seed,
        episode: run.episode,
        observations_merged: Some(run.observations_merged),
        medium: options.medium,
        recording: run.recording,
        failure: run.unrecorded.map(Failure::from),
    })
}

fn options(arguments: &Arguments, medium: Medium, recording: PathBuf) -> Result<Options, Failure> {
    let is_shown = arguments.live.is_some() || arguments.foxglove.is_some();
    let processes = arguments.processes.then(std::env::current_exe).transpose();
    Ok(Options {
        medium,
        threads: arguments.threads.map_or(0, usize::from),
        recording: Some(recording),
        processes: processes.map_err(|error| Failure::Run(format!("cannot find this program: {error}")))?,
        real_time_factor: arguments.real_time_factor.or(is_shown.then_some(LIVE_REAL_TIME_FACTOR)),
        version: VERSION.to_owned(),
        tak: arguments.tak.as_deref().map(tak::settings::Settings::of),
    })
}

fn medium(arguments: &Arguments) -> Result<Medium, Failure> {
    let needs_zenoh = [
        ("--processes", arguments.processes),
        ("--real-time-factor", arguments.real_time_factor.is_some()),
        ("--live", arguments.live.is_some()),
        ("--foxglove", arguments.foxglove.is_some()),
    ];
    let needs_zenoh = needs_zenoh.into_iter().find(|&(_, is_asked)| is_asked);
    match (arguments.over, needs_zenoh) {
        (Some(Over::Memory), Some((option, _))) => {
            Err(Failure::Input(format!("--over memory: {option} needs Zenoh; allowed is --over zenoh")))
        }
        // Over Zenoh each event is a query to one session.
        (Some(Over::Memory) | None, None) => Ok(Medium::Memory),
        (Some(Over::Zenoh), _) | (None, Some(_)) => Ok(Medium::Zenoh),
    }
}

/// The file to record to. No recording is overwritten: a given file must not exist, and the default is the first unused
/// name.
fn place_recording(arguments: &Arguments, scenario: &Scenario) -> Result<PathBuf, Failure> {
    if let Some(path) = &arguments.record {
        return output::free("--record", path, "no recording is");
    }
    if let Some(path) = &scenario.recording().file {
        return output::free("recording.file", path, "no recording is");
    }
    let stem = format!("{}-{}", scenario.name(), arguments.seed);
    let numbered = (2..).map(|number| format!("{stem}-{number}.mcap"));
    let mut names = std::iter::once(format!("{stem}.mcap")).chain(numbered).map(PathBuf::from);
    names.find(|path| !path.exists()).ok_or_else(|| Failure::Input(format!("{stem}.mcap: no name is free")))
}

fn parse_real_time_factor(text: &str) -> Result<f64, String> {
    let real_time_factor: f64 = text.parse().map_err(|_| format!("{text:?} is no number"))?;
    check_real_time_factor(real_time_factor).map(|()| real_time_factor)
}
