//! Robots in separate processes.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use dragnet_proto::key::Mission;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;
use tempfile::TempDir;

use crate::RuntimeError;
use crate::config::{AgentSettings, Common, TimeSource};
use crate::session::Endpoints;

/// Started processes. They end when this is dropped, because their standard input closes.
#[derive(Default)]
pub(super) struct Children {
    /// Each with the folder of its settings and its journal.
    running: Vec<(Participant, Child, TempDir)>,
}

/// The settings that all robots' processes share.
pub(super) struct Brief<'a> {
    pub(super) program: &'a Path,
    pub(super) scenario: &'a Scenario,
    pub(super) seed: u64,
    pub(super) mission: &'a Mission,
    pub(super) time: TimeSource,
    pub(super) real_time_factor: f64,
}

impl Children {
    /// Starts a robot's process.
    pub(super) fn start(
        &mut self,
        brief: &Brief<'_>,
        robot: RobotId,
        zenoh: Endpoints,
    ) -> Result<(), RuntimeError> {
        let participant = Participant::Robot(robot);
        let failed = |reason: String| RuntimeError::Process { participant, reason };
        let settings = brief.settings(robot, zenoh).map_err(failed)?;
        let folder = tempfile::tempdir().map_err(|error| failed(error.to_string()))?;
        let file = folder.path().join("robot.toml");
        std::fs::write(&file, settings).map_err(|error| failed(error.to_string()))?;
        let child = Command::new(brief.program)
            .args(["agent", "--config"])
            .arg(&file)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .env("RUST_LOG", std::env::var("RUST_LOG").unwrap_or_else(|_| "warn,zenoh=error".to_owned()))
            .spawn()
            .map_err(|error| failed(format!("{}: {error}", brief.program.display())))?;
        self.running.push((participant, child, folder));
        Ok(())
    }

    /// Whether all are still running.
    pub(super) fn check(&mut self) -> Result<(), RuntimeError> {
        for (participant, child, _) in &mut self.running {
            if let Ok(Some(status)) = child.try_wait() {
                return Err(RuntimeError::Process {
                    participant: *participant,
                    reason: format!("it ended before the mission did: {status}"),
                });
            }
        }
        Ok(())
    }
}

impl Brief<'_> {
    fn settings(&self, robot: RobotId, zenoh: Endpoints) -> Result<String, String> {
        let path = &self.scenario.source().path;
        let scenario = std::path::absolute(path).map_err(|error| error.to_string())?;
        let earlier = self.scenario.earlier().map(|it| std::path::absolute(&it.file)).transpose();
        let text = toml::to_string(self.scenario.file()).map_err(|error| error.to_string())?;
        let common = Common {
            mission: self.mission.to_string(),
            scenario,
            scenario_text: Some(text),
            prior_from: earlier.map_err(|error| error.to_string())?,
            seed: self.seed,
            real_time_factor: self.real_time_factor,
            zenoh,
        };
        let config = AgentSettings {
            robot: robot.number(),
            time: self.time,
            attached: true,
            journal: None,
            vehicle: None,
            ros: None,
            mavlink: None,
            detector: None,
            common,
        };
        toml::to_string(&config).map_err(|error| error.to_string())
    }
}

impl Drop for Children {
    fn drop(&mut self) {
        for (_, child, _) in &mut self.running {
            drop(child.stdin.take());
        }
        for (participant, child, _) in &mut self.running {
            if let Err(error) = child.wait() {
                tracing::warn!("the process of {participant} was not seen to end: {error}");
            }
        }
    }
}
