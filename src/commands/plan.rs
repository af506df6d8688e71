//! `dragnet plan`: a page on which a mission is planned.

use std::ffi::OsStr;
use std::io::{self, BufRead, BufReader};
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use dragnet_experiments::forecast::forecast;
use dragnet_experiments::progress::{Progress, Work};
use dragnet_files::read_at_most;
use dragnet_live::planning::{self, Planner, Watched};
use dragnet_planning::MissionPlan;
use dragnet_runtime::stop;
use dragnet_scenario::Scenario;
use dragnet_scenario::map_file::{Areas, MapFileError};

use super::{Failure, complain, live};

/// Plan a mission on a page in a browser.
///
/// Draw areas on the map or open a file of them, place the robots, read what the mission is expected to find, and save it
/// as a scenario that `dragnet run` and `dragnet check` read. The page is served until Ctrl-C.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet plan
  dragnet plan area.kml
  dragnet plan valley.toml --into missions")]
pub(crate) struct Arguments {
    /// Areas (.kml, .kmz, .geojson, .gpx, .plan), a scenario (TOML) that names such a file, or a name that `dragnet scenarios` lists
    /// [default: an empty map]
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Folder to save plans to, which must exist; recordings of simulations go there too
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    into: PathBuf,
    /// Address of the page: IP:PORT, IP or PORT [default: 127.0.0.1 and any free port]
    #[arg(long, value_name = "ADDRESS", default_value = live::ANYWHERE, hide_default_value = true, value_parser = live::parse_address)]
    listen: SocketAddr,
    /// Map to draw on: a PMTiles file with raster tiles. Without it there are lines of latitude and longitude
    #[arg(long, value_name = "FILE")]
    basemap: Option<PathBuf>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { file, into, listen, basemap } = arguments;
    let plan = match file {
        Some(file) => read(file)?,
        None => MissionPlan::of_areas("", &Areas::default()).map_err(Failure::input)?,
    };
    let folder = into
        .canonicalize()
        .ok()
        .filter(|folder| folder.is_dir())
        .ok_or_else(|| Failure::Input(format!("--into {}: no such folder", into.display())))?;
    let simulations = Arc::new(Simulations::default());
    let basemap = basemap.as_ref().map(std::path::absolute).transpose().map_err(Failure::input)?;
    let settings = live::settings(*listen, basemap.as_deref());
    let planner = Local { simulations: Arc::clone(&simulations), address: listen.ip(), basemap };
    let page = planning::serve(&settings, plan, folder, Box::new(planner))?;
    live::announce(page, "planning page").stay();
    simulations.end();
    Ok(())
}

/// The plan of a file. Areas that are no scenario yet, such as some without a search area, can be completed.
fn read(file: &Path) -> Result<MissionPlan, Failure> {
    if Areas::is_file(file) {
        let bytes = read_at_most(file, Areas::MAX_BYTES)
            .map_err(|source| Failure::input(MapFileError::Read { file: file.to_owned(), source }))?;
        let (areas, invalid) = Areas::valid_from_bytes(file, bytes).map_err(Failure::input)?;
        for error in invalid {
            complain("not read", &error.to_string());
        }
        return MissionPlan::of_areas(&Scenario::name_of_map(file), &areas).map_err(Failure::input);
    }
    let scenario = Scenario::load(file).map_err(Failure::input)?;
    MissionPlan::of_scenario(&scenario).map_err(Failure::input)
}

/// Forecasts in this process, and simulations beside it.
struct Local {
    simulations: Arc<Simulations>,
    /// Where the pages of simulations are served.
    address: IpAddr,
    /// The map under them.
    basemap: Option<PathBuf>,
}

/// The most simulations of one page, which all run until it ends.
const MOST_SIMULATIONS: usize = 8;

impl Planner for Local {
    fn forecast(
        &self,
        scenario: &Scenario,
        robots: &[u32],
        missions: u64,
        watched: Arc<Watched>,
    ) -> Result<serde_json::Value, String> {
        // A scenario that names its robots may not do with fewer.
        let teams: Vec<Scenario> =
            robots.iter().filter_map(|&count| scenario.with_robots(count).ok()).collect();
        if teams.is_empty() {
            return Err("the scenario names robots beyond these teams: allowed are larger ones".to_owned());
        }
        let seeds = missions.to_string().parse()?;
        let done = forecast(&teams, seeds, None, &Watching(watched)).map_err(|error| error.to_string())?;
        serde_json::to_value(done.results).map_err(|error| error.to_string())
    }

    /// The simplest thing that is true: this program runs the saved file as anybody would, `dragnet run PLAN.toml --live`,
    /// as a process of its own, and the viewer is led to the page whose address it prints. So what is shown is what the
    /// file does, and a simulation that fails does not take the plan with it.
    fn simulate(&self, scenario: &Path) -> Result<String, String> {
        let mut simulations = self.simulations.running();
        simulations.retain_mut(|child| matches!(child.try_wait(), Ok(None)));
        if simulations.len() >= MOST_SIMULATIONS {
            let what = format!("{MOST_SIMULATIONS} simulations are open already");
            return Err(format!("{what}; they end with this page's program"));
        }
        let (child, address) =
            start(scenario, self.address, self.basemap.as_deref()).map_err(|error| error.to_string())?;
        simulations.push(child);
        Ok(address)
    }
}

/// Time in which simulations finish their recordings.
const PATIENCE: Duration = Duration::from_secs(10);

/// Simulations as processes of their own, which end with the page.
#[derive(Default)]
struct Simulations(Mutex<Vec<Child>>);

impl Simulations {
    fn running(&self) -> MutexGuard<'_, Vec<Child>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn end(&self) {
        stop::end(&mut self.running(), PATIENCE);
    }
}

/// Starts this program with a scenario; returns the process, and the address of its page.
fn start(scenario: &Path, address: IpAddr, basemap: Option<&Path>) -> io::Result<(Child, String)> {
    let page = format!("--live={}", SocketAddr::new(address, 0));
    let mut child = Command::new(std::env::current_exe()?)
        .arg("run")
        .arg(scenario)
        .arg(page)
        .args(basemap.into_iter().flat_map(|file| [OsStr::new("--basemap"), file.as_os_str()]))
        // Recordings are written here.
        .current_dir(scenario.parent().unwrap_or(Path::new(".")))
        .stdin(Stdio::null())
        // It ends when nobody reads this any more: with this process, however that ends.
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let mut printed = child.stdout.take().ok_or(io::ErrorKind::BrokenPipe)?;
    std::thread::spawn(move || io::copy(&mut printed, &mut io::sink()));
    let mut reported = BufReader::new(child.stderr.take().ok_or(io::ErrorKind::BrokenPipe)?);
    let mut lines = String::new();
    let mark = format!("{}: ", live::LIVE_PAGE);
    while reported.read_line(&mut lines)? > 0 {
        if let Some((_, address)) = lines.split_once(&mark) {
            let address = address.trim().to_owned();
            // Otherwise it would wait for a reader.
            std::thread::spawn(move || io::copy(&mut reported, &mut io::sink()));
            return Ok((child, address));
        }
    }
    child.wait()?;
    Err(io::Error::other(format!("the simulation did not start: {}", lines.trim())))
}

/// Passes the progress of a forecast on to its viewers.
#[derive(Clone)]
struct Watching(Arc<Watched>);

impl Progress for Watching {
    fn begin(&self, steps: u64, _unit: &str) -> Box<dyn Work> {
        self.0.begin(steps);
        Box::new(self.clone())
    }
}

impl Work for Watching {
    fn advance(&self, steps: u64) {
        self.0.advance(steps);
    }

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}
