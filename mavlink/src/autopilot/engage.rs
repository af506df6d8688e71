//! Arming a vehicle that is to arm itself: once, at the robot's start, never against a pilot.

use crate::common::{MavCmd, MavModeFlag, MavResult};
use crate::mode::Craft;

use super::config::Engage;

/// Time between two attempts, nanoseconds.
const RETRY_NS: u64 = 1_000_000_000;
/// Attempts at each step.
const ATTEMPTS: u32 = 30;
/// Share of its altitude that a copter must have before it is steered.
const RISEN_SHARE: f64 = 0.9;

/// What a vehicle has reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    pub(super) is_guided: bool,
    pub(super) is_armed: bool,
    /// Height above home, meters.
    pub(super) altitude_meters: Option<f64>,
    /// The height to take off to, meters; `None` on the ground.
    pub(super) takeoff_meters: Option<f64>,
}

/// The steps to a vehicle that follows targets.
#[derive(Clone, Debug, Default)]
pub(super) struct Starter {
    state: State,
    /// The last command and the autopilot's answer to it.
    answer: Option<(MavCmd, MavResult)>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    /// It is the pilot's, or done.
    #[default]
    Over,
    /// Nothing was seen of the vehicle yet.
    Waiting,
    Starting {
        step: Step,
        attempts: u32,
        tried_ns: u64,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Mode,
    Arm,
    TakeOff,
}

/// What to do next.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Next {
    /// Nothing.
    Wait,
    /// Send this command.
    Command(MavCmd, [f64; 7]),
    /// The vehicle follows targets, by the robot's doing.
    Done,
    /// A pilot has armed the vehicle or switched its mode: it is the pilot's.
    Yield,
    /// The autopilot refuses; the reason.
    GiveUp(String),
}

impl Starter {
    pub(super) fn new(engage: Engage) -> Self {
        let state = match engage {
            Engage::Pilot => State::Over,
            Engage::Robot => State::Waiting,
        };
        Self { state, answer: None }
    }

    /// Whether the robot is still taking off: it is not steered meanwhile.
    pub(super) const fn is_busy(&self) -> bool {
        matches!(self.state, State::Starting { .. })
    }

    /// The autopilot answers a command.
    pub(super) const fn hear(&mut self, command: MavCmd, result: MavResult) {
        self.answer = Some((command, result));
    }

    /// The vehicle is the pilot's from now on.
    pub(super) const fn stop(&mut self) {
        self.state = State::Over;
    }

    pub(super) fn step(&mut self, now_ns: u64, craft: Craft, progress: Progress) -> Next {
        if self.state == State::Waiting {
            if progress.is_armed {
                self.state = State::Over;
                return Next::Yield;
            }
            self.state = State::Starting { step: Step::Mode, attempts: 0, tried_ns: 0 };
        }
        let State::Starting { step, attempts, tried_ns } = self.state else { return Next::Wait };
        let has_risen = match (progress.takeoff_meters, progress.altitude_meters) {
            (None, _) => true,
            (Some(wanted), Some(reached)) => reached >= RISEN_SHARE * wanted,
            (Some(_), None) => false,
        };
        let next = match (progress.is_guided, progress.is_armed, has_risen) {
            // A pilot arms it in another mode, or switches to one.
            (false, is_armed, _) if is_armed || step != Step::Mode => {
                self.state = State::Over;
                return Next::Yield;
            }
            (_, false, _) if step == Step::TakeOff => {
                self.state = State::Over;
                return Next::GiveUp("it was disarmed during takeoff".to_owned());
            }
            (false, ..) => Step::Mode,
            (true, false, _) => Step::Arm,
            (true, true, false) => Step::TakeOff,
            (true, true, true) => {
                self.state = State::Over;
                return Next::Done;
            }
        };
        let attempts = if next == step { attempts } else { 0 };
        if attempts > 0 && next == step && now_ns.saturating_sub(tried_ns) < RETRY_NS {
            return Next::Wait;
        }
        if attempts == ATTEMPTS {
            self.state = State::Over;
            return Next::GiveUp(self.refusal(next));
        }
        self.state = State::Starting { step: next, attempts: attempts + 1, tried_ns: now_ns };
        next.command(craft, progress.takeoff_meters)
    }

    fn refusal(&self, step: Step) -> String {
        let what = match step {
            Step::Mode => "switch to its guided mode",
            Step::Arm => "arm",
            Step::TakeOff => "take off",
        };
        match self.answer {
            Some((command, result)) => {
                format!(
                    "the autopilot does not {what} in {ATTEMPTS} attempts; it answered {command:?} with {result:?}"
                )
            }
            None => format!("the autopilot does not {what} in {ATTEMPTS} attempts, and does not answer"),
        }
    }
}

impl Step {
    fn command(self, craft: Craft, takeoff_meters: Option<f64>) -> Next {
        match self {
            Self::Mode => {
                let [mode, submode] = craft.guided().map(f64::from);
                let base = f64::from(MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED.bits());
                let parameters = [base, mode, submode, 0.0, 0.0, 0.0, 0.0];
                Next::Command(MavCmd::MAV_CMD_DO_SET_MODE, parameters)
            }
            Self::Arm => {
                Next::Command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
            }
            Self::TakeOff => Next::Command(
                MavCmd::MAV_CMD_NAV_TAKEOFF,
                [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, takeoff_meters.unwrap_or(0.0)],
            ),
        }
    }
}
