//! Robots, coordinator and world as processes of their own.

use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use dragnet_link::session::free_endpoints;
use dragnet_link::team::{self, Options};

use crate::committed;

const DRAGNET: &str = env!("CARGO_BIN_EXE_dragnet");

#[test]
fn a_run_of_processes_is_the_run_in_one_process() {
    let cone = committed("ice_cream_cone.toml");
    let run = |processes| {
        let options = Options { processes, version: "test".to_owned(), ..Options::default() };
        team::run(&cone, 2, &options, &mut |_, _| ()).unwrap().episode
    };
    let (one, many) = (run(None), run(Some(PathBuf::from(DRAGNET))));
    assert_eq!(one.outcome.digest, many.outcome.digest);
    assert_eq!(one.path_cells, many.path_cells);
    assert!(many.outcome.beliefs_equal);
}

#[test]
fn a_process_that_cannot_start_fails_the_run_by_name() {
    let options = Options { processes: Some("/no/such/program".into()), ..Options::default() };
    let error = team::run(&committed("ice_cream_cone.toml"), 2, &options, &mut |_, _| ()).unwrap_err();
    assert!(
        error.to_string().contains("robot 1") && error.to_string().contains("/no/such/program"),
        "{error}"
    );
}

#[test]
fn a_process_that_dies_fails_the_run_by_name() {
    let options = Options { processes: Some("/bin/false".into()), ..Options::default() };
    let error = team::run(&committed("ice_cream_cone.toml"), 2, &options, &mut |_, _| ()).unwrap_err();
    assert!(error.to_string().contains("ended before the mission"), "{error}");
}

/// A process that does not outlive the test.
struct Process(Child);

impl Process {
    fn start(command: &mut Command) -> Self {
        Self(command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap())
    }

    /// Asks it to stop, as a person would.
    fn terminate(mut self) {
        assert!(Command::new("kill").arg(self.0.id().to_string()).status().unwrap().success());
        assert!(self.0.wait().unwrap().success());
    }

    /// What it prints until it ends.
    fn output(mut self) -> String {
        let mut text = String::new();
        self.0.stdout.take().unwrap().read_to_string(&mut text).unwrap();
        assert!(self.0.wait().unwrap().success(), "{text}");
        text
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A mission of two robots by the wall clock, as a field team would start it.
struct Field {
    folder: tempfile::TempDir,
    endpoints: Vec<String>,
}

impl Field {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let scenario = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 15\ncolumns = 15\n\
                        [objects]\ncount = 4\n[robots]\ncount = 2\npolicy = \"path\"\n\
                        [mission]\nbudget_seconds = 3600.0\nexpected_undeclared = 0.001\n";
        std::fs::write(folder.path().join("field.toml"), scenario).unwrap();
        Self { folder, endpoints: free_endpoints(4).unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Listens at the endpoint of this place, and calls all before it.
    fn zenoh(&self, place: usize) -> String {
        format!("listen = [{:?}]\nconnect = {:?}\n", self.endpoints[place], &self.endpoints[..place])
    }

    fn common(&self, place: usize) -> String {
        let zenoh = self.zenoh(place);
        format!(
            "[common]\nmission = \"field\"\nscenario = \"field.toml\"\nseed = 3\npace = 100.0\n[common.zenoh]\n{zenoh}"
        )
    }

    fn start(&self, name: &str, arguments: &[&str], config: &str) -> Process {
        let file = self.path(name);
        std::fs::write(&file, config).unwrap();
        Process::start(Command::new(DRAGNET).args(arguments).arg("--config").arg(file))
    }

    fn coordinator(&self) -> Process {
        let recording = self.path("field.mcap");
        let config = format!("recording = \"{}\"\n{}", recording.display(), self.common(1));
        self.start("coordinator.toml", &["coordinator"], &config)
    }

    fn robot(&self, number: usize) -> Process {
        let config = format!("robot = {number}\n{}", self.common(number + 1));
        self.start(&format!("robot_{number}.toml"), &["agent"], &config)
    }

    fn world(&self) -> Process {
        let config = format!("mission = \"field\"\nseed = 3\npace = 100.0\n[zenoh]\n{}", self.zenoh(0));
        let scenario = self.path("field.toml");
        self.start("sim.toml", &["sim", scenario.to_str().unwrap(), "--json"], &config)
    }
}

fn check_outcome(json: &str) -> serde_json::Value {
    let outcome: serde_json::Value = serde_json::from_str(json).unwrap();
    assert_eq!(outcome["beliefs_equal"], true, "{outcome}");
    assert_eq!(outcome["recall"], 1.0, "{outcome}");
    outcome
}

#[test]
fn a_mission_started_by_hand_in_any_order_is_searched_and_recorded() {
    let field = Field::new();
    let second = field.robot(2);
    let (coordinator, world) = (field.coordinator(), field.world());
    let first = field.robot(1);
    let outcome = check_outcome(&world.output());
    first.terminate();
    second.terminate();
    coordinator.terminate();
    let recording = dragnet_coordinator::inspect::inspect(&field.path("field.mcap")).unwrap();
    assert_eq!(recording.ending, dragnet_coordinator::Ending::Complete);
    assert_eq!(Some(recording.observations as u64), outcome["observations_sent"].as_u64());
}

#[test]
fn robots_search_on_when_the_coordinator_is_killed() {
    let field = Field::new();
    let coordinator = field.coordinator();
    let robots = [field.robot(1), field.robot(2)];
    let world = field.world();
    // The search takes 4 s; once something of it is on disk the coordinator dies without a word.
    let recording = field.path("field.mcap");
    let observations =
        || dragnet_coordinator::inspect::inspect(&recording).map_or(0, |inspection| inspection.observations);
    while observations() == 0 {
        std::thread::yield_now();
    }
    drop(coordinator);
    check_outcome(&world.output());
    robots.into_iter().for_each(Process::terminate);
    dragnet_coordinator::recover::recover(&recording, &field.path("mended.mcap")).unwrap();
    let mended = dragnet_coordinator::inspect::inspect(&field.path("mended.mcap")).unwrap();
    assert_eq!(mended.ending, dragnet_coordinator::Ending::Complete);
    assert!(mended.observations > 0);
}
