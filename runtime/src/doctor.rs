//! Checks of a robot before a mission: whether everything that its settings name exists and works.
//!
//! The checks change nothing and are not announced on the network, so they can run while the robot runs.

mod autopilot;
mod clocks;
mod computer;
mod frames;
mod ports;
mod team;
mod vehicle;

use std::fmt;
use std::path::Path;
use std::time::Duration;

use crate::config::{self, AgentSettings, Checked, OwnVehicle};
use crate::journal::Subject;
use crate::session;
use crate::vehicle::detector::Make;

/// An endpoint that no process connects to.
const ANY_PORT: &str = "tcp/127.0.0.1:0";

/// The result of one check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The verdict.
    pub verdict: Verdict,
    /// The subject of the check.
    pub subject: String,
    /// The result in words.
    pub message: String,
    /// The remedy, if any.
    pub advice: String,
}

/// The verdict of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// It works.
    Pass,
    /// It works, with a caveat.
    Warn,
    /// It does not work; the advice gives a remedy.
    Fail,
}

impl fmt::Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = match self.verdict {
            Verdict::Pass => "pass",
            Verdict::Warn => "WARN",
            Verdict::Fail => "FAIL",
        };
        write!(formatter, "{verdict}  {}: {}", self.subject, self.message)?;
        if self.advice.is_empty() { Ok(()) } else { write!(formatter, "\n      {}", self.advice) }
    }
}

impl Finding {
    /// A passed check.
    pub fn pass(subject: impl Into<String>, message: impl Into<String>) -> Self {
        let (subject, message) = (subject.into(), message.into());
        Self { verdict: Verdict::Pass, subject, message, advice: String::new() }
    }

    /// A warning.
    pub fn warn(subject: impl Into<String>, message: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { verdict: Verdict::Warn, ..Self::fail(subject, message, advice) }
    }

    /// A failed check.
    pub fn fail(subject: impl Into<String>, message: impl Into<String>, advice: impl Into<String>) -> Self {
        let advice = advice.into();
        Self { verdict: Verdict::Fail, advice, ..Self::pass(subject, message) }
    }
}

/// Checks everything that the settings of a robot name; listens to its networks for this duration. `tell` receives each
/// finding as soon as it is known. `make` constructs the detector, if the settings have one. If the settings are
/// invalid nothing else is checked.
pub fn examine(file: &Path, listen: Duration, make: Make<'_>, tell: &mut dyn FnMut(Finding)) {
    let advice = "correct the settings: docs/guide.md and docs/field-guide.md explain them";
    let config = match config::load::<AgentSettings>(file) {
        Ok(config) => config,
        Err(error) => return tell(Finding::fail("settings", error.to_string(), advice)),
    };
    let checked = config.common.check(file).and_then(|checked| {
        let own = config.vehicle(file, &checked.scenario)?;
        Ok((checked, own))
    });
    let (Checked { mission, scenario }, own) = match checked {
        Ok(checked) => checked,
        Err(error) => return tell(Finding::fail("settings", error.to_string(), advice)),
    };
    let team = scenario.robots().len();
    let Ok(agent_config) = config.agent_config(file, &scenario) else {
        let found = format!("robot is {}, of a team of {team}", config.robot);
        return tell(Finding::fail("settings", found, "robot is from 1 to the number of robots.count"));
    };
    let robot = agent_config.robot.id;
    tell(Finding::pass("settings", format!("robot {robot} of {team} in mission {mission}")));
    let (journal, real_time_factor) = (config.journal(file), config.common.real_time_factor);
    let runs_here = ports::runs_here(&journal);
    let subject = Subject { mission: &mission, robot, terrain: scenario.terrain() };
    let (findings, resumed) = computer::journal(&journal, subject, runs_here, real_time_factor);
    findings.into_iter().for_each(&mut *tell);
    tell(computer::decisions(&agent_config));
    if let Some(OwnVehicle::Ros(body)) = &own {
        computer::detector(body, file, make).into_iter().for_each(&mut *tell);
    }
    if let Some(vehicle) = &config.vehicle {
        tell(computer::speed(vehicle.speed_meters_per_second, &agent_config.robot.class));
    }
    if let Some(OwnVehicle::Ros(body)) = &own {
        vehicle::cameras(body).into_iter().for_each(&mut *tell);
    }
    let mut endpoints = config.common.zenoh.clone().named_in(file);
    let ports = match ports::examine(&endpoints, runs_here) {
        Ok(ports) => ports,
        Err(error) => return tell(Finding::fail("network", error.to_string(), advice)),
    };
    if runs_here || ports.iter().any(|port| port.verdict == Verdict::Fail) {
        // Even if the robot's own ports are taken, others can be connected to.
        endpoints.listen = vec![ANY_PORT.to_owned()];
    }
    ports.into_iter().for_each(&mut *tell);
    if let Some([found, advice]) = session::alone(&config.common.zenoh.clone().named_in(file)) {
        tell(Finding::warn("network", found, advice));
    }
    let member = team::Member { mission, robot, scenario: &scenario, runs_here, resumed, real_time_factor };
    let networks = async {
        team::examine(&endpoints, &member, listen, tell).await;
        match own {
            Some(OwnVehicle::Ros(body)) => vehicle::examine(*body, &scenario, listen, tell).await,
            Some(OwnVehicle::Mavlink(body)) => {
                autopilot::examine(&body.mavlink, runs_here, listen, tell).await;
            }
            None => {}
        }
        Ok(())
    };
    if let Err(error) = session::block_on(networks) {
        tell(Finding::fail("network", error.to_string(), ""));
    }
}
