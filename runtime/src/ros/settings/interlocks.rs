//! What stops a vehicle beside its sensors and paths.

use dragnet_vehicle::settings::FaultResponse;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A topic that stops the robot.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EmergencyStop {
    /// `std_msgs/Bool`: true stops the robot until false arrives.
    #[schemars(extend("examples" = ["e_stop"]))]
    pub topic: String,
    /// Time without a message after which the topic is silent, seconds, above 0 to 3600; left out if it is published on
    /// changes only, and latched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timeout_seconds: Option<f64>,
    /// The response to silence, and to a topic on which nothing has arrived yet.
    #[serde(default = "stop")]
    pub on_timeout: FaultResponse,
}

/// The charge of the battery.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Battery {
    /// `sensor_msgs/BatteryState`.
    #[schemars(extend("examples" = ["battery_state"]))]
    pub topic: String,
    /// Charge below which the battery is low, percent, 0 to 100.
    #[serde(default = "min_percent")]
    pub min_percent: f64,
    /// The response to a low battery.
    #[serde(default)]
    pub on_low: LowBattery,
    /// With `home`: charge from which the robot searches again, percent, `min_percent` to 100.
    #[serde(default = "resume_percent")]
    pub resume_percent: f64,
}

/// The response to a low battery.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LowBattery {
    /// The robot stands until the battery is no longer low.
    #[default]
    Stop,
    /// It returns to its base, and searches again once it is charged.
    Home,
    /// It drives on.
    Continue,
}

const fn stop() -> FaultResponse {
    FaultResponse::Stop
}

const fn min_percent() -> f64 {
    20.0
}

const fn resume_percent() -> f64 {
    80.0
}

impl EmergencyStop {
    pub(super) fn check(&self) -> Result<(), String> {
        match self.timeout_seconds {
            Some(seconds) if seconds.is_nan() || seconds <= 0.0 || seconds > 3600.0 => {
                let key = "ros.emergency_stop.timeout_seconds";
                Err(format!("{key} is {seconds}; allowed is above 0, at most 3600"))
            }
            _ => Ok(()),
        }
    }
}

impl Battery {
    pub(super) fn check(&self) -> Result<(), String> {
        let Self { min_percent, resume_percent, .. } = *self;
        if !(0.0..=100.0).contains(&min_percent) {
            return Err(format!("ros.battery.min_percent is {min_percent}; allowed is 0 to 100"));
        }
        if self.on_low == LowBattery::Home && !(min_percent..=100.0).contains(&resume_percent) {
            let allowed = format!("allowed is ros.battery.min_percent ({min_percent}) to 100");
            return Err(format!("ros.battery.resume_percent is {resume_percent}; {allowed}"));
        }
        Ok(())
    }
}
