//! Damaged scenario files: each can be run, or is rejected with a clear message.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use dragnet_agent::agent::Agent;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::Effects;
use dragnet_scenario::Scenario;
use dragnet_search::seed::{Purpose, stream};
use dragnet_sim::episode::{self, Observer};
use dragnet_sim::simulation::End;
use rand::seq::IndexedRandom;

use crate::alone::{alone, begin};
use crate::spoil_text::spoil;

const FILES: u64 = 100_000;
/// One of this many valid files is run for some steps, if it is no larger than this.
const BEGIN_EVERY: u64 = 4;
const MOST_CELLS: usize = 2500;
const MOST_ROBOTS: usize = 20;
/// Number of events of a robot in such a run.
const HAPPENINGS: u32 = 60;

/// Memory limit for reading a scenario, bytes: 64 for each cell of the largest map. Caves take 38 while they are
/// generated, and a text of maximum length half of that.
const MOST_BYTES: u64 = 64 << 24;

/// Keys that no scenario of the repository has.
const OTHER_KEYS: [&str; 2] = [
    "name = 'other_keys'\n[map]\nshape = 'caves'\nrows = 20\ncolumns = 24\nseed = 7\n[sensor]\nnoise = 'clipped'\n\
     [prior]\nprobability = 0.02\n[objects]\ncount = 2\n[robots]\ncount = 3\n\
     policy = { name = 'coverage', lane_spacing_cells = 2, replan_after_cells = 3 }\n[[robots.robot]]\nnumber = 2\n\
     policy = 'random'\nstart = 'scattered'\n[mission]\nbudget_meters = 900\n[recording]\nfile = 'a.mcap'\n",
    "name = 'more_keys'\n[map]\nfile = 'maps/warehouse.yaml'\ncell_meters = 1.0\n[prior]\nprobability = 0.5\n\
     [objects]\ncells = [[8, 35], [8, 34]]\n[robots]\npolicy = 'gnn'\n[mission]\nbudget_seconds = 600\n\
     stop_when_expected_remaining = 0.1\nmax_clock_skew_seconds = 5\n",
];

/// A scenario of the repository, as written or as printed by the program: with all defaults.
struct Honest {
    path: PathBuf,
    text: String,
}

fn honest() -> Vec<Honest> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let files = [folder.join("paper"), folder.clone()].map(|folder| fs::read_dir(folder).unwrap());
    let others = OTHER_KEYS.map(|text| Honest { path: folder.join("other.toml"), text: text.to_owned() });
    let mut paths: Vec<PathBuf> = files.into_iter().flatten().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort_unstable();
    let is_scenario = |file: &Honest| Scenario::from_text(&file.path, file.text.clone()).is_ok();
    assert!(others.iter().all(is_scenario));
    let load = |path: PathBuf| {
        let scenario = Scenario::load(&path).unwrap();
        let [written, said] = [scenario.source().text.clone(), toml::to_string(scenario.file()).unwrap()];
        [Honest { path: path.clone(), text: written }, Honest { path, text: said }]
    };
    paths.into_iter().flat_map(load).chain(others).collect()
}

/// Stops after this many events.
struct Patience(u32);

impl Observer for Patience {
    fn reacts(&mut self, _: &Effects<Message>) -> ControlFlow<()> {
        self.0 -= 1;
        if self.0 == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Computes the warnings of a search, and runs its beginning.
fn run_beginning(scenario: &Scenario, seed: u64) {
    assert!(scenario.warnings().iter().all(|warning| !warning.to_string().is_empty()));
    let mut robots = episode::team(scenario, seed, Agent::new);
    episode::watch(scenario, seed, End::Resting, &mut robots, &mut Patience(HAPPENINGS)).unwrap();
}

/// A process that receives the scenario as text has the same one.
fn check_says_itself(scenario: &Scenario) {
    let said = toml::to_string(scenario.file()).unwrap();
    let again = Scenario::from_text(&scenario.source().path, said).unwrap();
    assert_eq!(again.file(), scenario.file());
}

#[test]
fn of_a_hundred_thousand_spoiled_files_each_is_a_scenario_or_a_clear_error() {
    let name = "scenarios::of_a_hundred_thousand_spoiled_files_each_is_a_scenario_or_a_clear_error";
    alone(name, MOST_BYTES, || {
        let honest = honest();
        let texts: Vec<&str> = honest.iter().map(|file| &*file.text).collect();
        let (mut accepted, mut begun) = (0, 0);
        for number in 0..FILES {
            begin(format_args!("file {number}"));
            let mut random = stream(number, Purpose::Soak, 0);
            let Honest { path, text } = honest.choose(&mut random).unwrap();
            match Scenario::from_text(path, spoil(&mut random, text, &texts)) {
                Ok(scenario) => {
                    accepted += 1;
                    let is_small = scenario.terrain().grid().cell_count() <= MOST_CELLS
                        && scenario.robots().len() <= MOST_ROBOTS;
                    if is_small && accepted % BEGIN_EVERY == 0 {
                        check_says_itself(&scenario);
                        run_beginning(&scenario, number);
                        begun += 1;
                    }
                }
                Err(error) => check_is_clear(path, &error.to_string()),
            }
        }
        println!("{accepted} of {FILES} files are scenarios, {begun} were begun");
        assert!(accepted >= 15_000 && FILES - accepted >= 50_000 && begun >= 2000);
    });
}

/// The message names the file, and says in a few words what is wrong with it.
fn check_is_clear(path: &Path, error: &str) {
    let rest = error.strip_prefix(&path.display().to_string());
    let rest = rest.unwrap_or_else(|| panic!("another file is named: {error}"));
    let is_placed = rest.starts_with(": ") || rest.starts_with(", line ");
    assert!(is_placed && (10..1000).contains(&rest.len()), "{error}");
}

#[test]
fn the_largest_maps_and_the_longest_texts_stay_within_the_bound() {
    let name = "scenarios::the_largest_maps_and_the_longest_texts_stay_within_the_bound";
    let path = Path::new("large.toml");
    alone(name, MOST_BYTES, || {
        for (shape, rows, columns) in [
            ("caves", 4096, 4096),
            ("blocks", 4096, 4096),
            ("rooms", 1 << 24, 1),
            ("figure_four", 1, 1 << 24),
        ] {
            begin(format_args!("{shape}, {rows} x {columns}"));
            let text = format!(
                "name = 'large'\nmap = {{ shape = '{shape}', rows = {rows}, columns = {columns} }}\n\
                 objects.count = 1\nmission.budget_seconds = 60.0\n"
            );
            assert_eq!(Scenario::from_text(path, text).unwrap().terrain().grid().cell_count(), 1 << 24);
        }
        for unit in ["[1],", "[],", "{},", "0,", "\n"] {
            begin(format_args!("{unit:?} repeated"));
            let text = format!("a = [{}]", unit.repeat((Scenario::MAX_BYTES - 6) / unit.len()));
            check_is_clear(path, &Scenario::from_text(path, text).unwrap_err().to_string());
        }
    });
}
