//! A mission by the wall clock, as a field team starts it: each part in a separate process.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

use dragnet_runtime::session::{Endpoints, free_endpoints};
use dragnet_scenario::Scenario;
use tempfile::TempDir;

pub(crate) const DRAGNET: &str = env!("CARGO_BIN_EXE_dragnet");

/// The real-time factor.
pub(crate) const PACE: f64 = 100.0;

/// A process that ends with the test.
pub(crate) struct Process(Child);

impl Process {
    pub(crate) fn start(command: &mut Command) -> Self {
        // Log lines about others would hide those that the test checks.
        let command = command.env("RUST_LOG", "warn,zenoh=error");
        Self(command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap())
    }

    /// The same with all of its usual log in a file, as under a service manager.
    pub(crate) fn start_logged(command: &mut Command, log: &Path) -> Self {
        let log = std::fs::File::create(log).unwrap();
        let command = command.env_remove("RUST_LOG").stdin(Stdio::null()).stdout(Stdio::piped());
        Self(command.stderr(log).spawn().unwrap())
    }

    /// As in a power failure, or by the out-of-memory killer.
    pub(crate) fn kill(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// Asks it to stop.
    pub(crate) fn terminate(self) {
        assert!(self.signal("TERM").success());
    }

    /// Its exit status after a signal.
    pub(crate) fn signal(mut self, name: &str) -> ExitStatus {
        let sent = Command::new("kill").args(["-s", name, &self.0.id().to_string()]).status().unwrap();
        assert!(sent.success());
        self.0.wait().unwrap()
    }

    pub(crate) fn id(&self) -> u32 {
        self.0.id()
    }

    /// Its exit status once it has ended by itself.
    pub(crate) fn ended(mut self) -> ExitStatus {
        self.0.wait().unwrap()
    }

    /// Closes its standard output; returns its exit status.
    pub(crate) fn deafen(mut self) -> ExitStatus {
        drop(self.0.stdout.take());
        self.0.wait().unwrap()
    }

    /// Its output until it ends.
    pub(crate) fn output(mut self) -> String {
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

/// The mission `field`: the world has the first endpoint, the coordinator or its substitute the second, then the
/// robots. Each connects to all before it.
pub(crate) struct Field {
    folder: TempDir,
    endpoints: Vec<String>,
    seed: u64,
}

impl Field {
    pub(crate) fn new(scenario: &str, robots: usize, seed: u64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("field.toml"), scenario).unwrap();
        Self { folder, endpoints: free_endpoints(robots + 2).unwrap(), seed }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn scenario(&self) -> Scenario {
        Scenario::load(&self.path("field.toml")).unwrap()
    }

    pub(crate) fn endpoints(&self, place: usize) -> Endpoints {
        Endpoints {
            listen: vec![self.endpoints[place].clone()],
            connect: self.endpoints[..place].to_vec(),
            ..Endpoints::default()
        }
    }

    fn common(&self, place: usize) -> String {
        let zenoh = self.zenoh(place);
        let seed = self.seed;
        format!(
            "[common]\nmission = \"field\"\nscenario = \"field.toml\"\nseed = {seed}\nreal_time_factor = {PACE:?}\n\
             [common.zenoh]\n{zenoh}"
        )
    }

    fn zenoh(&self, place: usize) -> String {
        let Endpoints { listen, connect, .. } = self.endpoints(place);
        format!("listen = {listen:?}\nconnect = {connect:?}\n")
    }

    fn write(&self, name: &str, config: &str) -> PathBuf {
        let file = self.path(name);
        std::fs::write(&file, config).unwrap();
        file
    }

    pub(crate) fn coordinator(&self) -> Process {
        let settings = self.coordinator_settings(&self.path("field.mcap"));
        Process::start(Command::new(DRAGNET).args(["coordinator", "--config"]).arg(settings))
    }

    /// The settings of a coordinator that records to this file.
    pub(crate) fn coordinator_settings(&self, recording: &Path) -> PathBuf {
        let config = format!("recording = \"{}\"\n{}", recording.display(), self.common(1));
        self.write("coordinator.toml", &config)
    }

    pub(crate) fn robot(&self, number: usize) -> Process {
        Process::start(
            Command::new(DRAGNET).args(["agent", "--config"]).arg(self.robot_settings(number, None)),
        )
    }

    /// The settings of a robot with this journal.
    pub(crate) fn robot_settings(&self, number: usize, journal: Option<&Path>) -> PathBuf {
        let journal = journal.map(|path| format!("journal = \"{}\"\n", path.display())).unwrap_or_default();
        let config = format!("robot = {number}\n{journal}{}", self.common(number + 1));
        self.write(&format!("robot_{number}.toml"), &config)
    }

    pub(crate) fn world(&self) -> Process {
        let seed = self.seed;
        let config = format!(
            "mission = \"field\"\nseed = {seed}\nreal_time_factor = {PACE:?}\n[zenoh]\n{}",
            self.zenoh(0)
        );
        let (file, scenario) = (self.write("sim.toml", &config), self.path("field.toml"));
        Process::start(Command::new(DRAGNET).arg("sim").arg(scenario).args(["--json", "--config"]).arg(file))
    }
}
