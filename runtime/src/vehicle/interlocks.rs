//! What stops a vehicle beside its sensors and paths: an emergency stop, and a low battery.

use dragnet_mavlink::autopilot::battery::Batteries;
use dragnet_ros2::input::Battery;
use dragnet_ros2::name::TopicName;
use dragnet_ros2::output::{Diagnostic, Level};
use dragnet_vehicle::pilot::{Event, Interlock, InterlockFault};
use dragnet_vehicle::settings::FaultResponse;

use super::{AgentEvent, Effect, Now, Vehicle};
use crate::ros::settings::{Battery as BatterySettings, Checked, EmergencyStop, LowBattery};

/// Charge above the least one at which a battery is no longer low, percent: a load lets it seem lower.
const RECOVERED_PERCENT: f64 = 2.0;
/// The number of the battery.
const BATTERY: u8 = 0;
/// The subject of diagnostics about a stop whose silence is no reason to stop.
const SILENCE: &str = "silence of the emergency stop";
/// The subject of diagnostics about the charge.
const CHARGE: &str = "charge";

/// The state of both.
#[derive(Clone, Debug)]
pub(super) struct Interlocks {
    stop: Option<EmergencyStop>,
    /// The last message of the emergency stop: whether it is pressed, and when it arrived, nanoseconds of mission time.
    heard: Option<(bool, u64)>,
    battery: Option<BatterySettings>,
    charges: Batteries,
    is_low: bool,
}

impl Interlocks {
    pub(super) fn new(ros: &Checked) -> Self {
        let (stop, battery) = (ros.emergency_stop.clone(), ros.battery.clone());
        Self { stop, heard: None, battery, charges: Batteries::default(), is_low: false }
    }

    /// Why the emergency stop is to stop the vehicle, or is silent. `None` if there is no such topic, or nothing is wrong.
    fn stop_fault(&self, now_ns: u64) -> Option<(FaultResponse, InterlockFault)> {
        let EmergencyStop { topic, timeout_seconds, on_timeout } = self.stop.as_ref()?;
        let fault = |kind, message| InterlockFault { kind, message };
        match self.heard {
            Some((true, _)) => {
                let message = format!("{topic} is true: the vehicle stands until it is false");
                Some((FaultResponse::Stop, fault("stopped", message)))
            }
            None => Some((*on_timeout, fault("silent", format!("nothing has arrived on {topic} yet")))),
            Some((false, heard_ns)) => {
                let seconds = now_ns.saturating_sub(heard_ns) as f64 / 1e9;
                timeout_seconds.filter(|&timeout_seconds| seconds > timeout_seconds).map(|_| {
                    (
                        *on_timeout,
                        fault("silent", format!("nothing has arrived on {topic} for {seconds:.1} s")),
                    )
                })
            }
        }
    }
}

impl Vehicle {
    pub(super) fn receive_stop(&mut self, now: Now, is_stopped: bool) -> Vec<Effect> {
        self.interlocks.heard = Some((is_stopped, now.mission.0));
        self.tell_stop(now)
    }

    /// Tells the pilot what the emergency stop says by now.
    pub(super) fn tell_stop(&mut self, now: Now) -> Vec<Effect> {
        if self.interlocks.stop.is_none() {
            return Vec::new();
        }
        let fault = match self.interlocks.stop_fault(now.mission.0) {
            Some((FaultResponse::Stop, fault)) => Some(fault),
            Some((FaultResponse::Continue, fault)) => {
                self.aggregator.note_as(now.mission, SILENCE, fault.kind, &fault.message);
                None
            }
            None => {
                self.aggregator.well(now.mission, SILENCE);
                None
            }
        };
        let mut effects = self.news();
        effects.extend(self.tell(now, Event::Interlock(Interlock::EmergencyStop, fault)));
        effects
    }

    pub(super) fn receive_battery(&mut self, now: Now, topic: &TopicName, battery: &Battery) -> Vec<Effect> {
        let Some(percent) = battery.percent else { return Vec::new() };
        if let Err(reason) = self.interlocks.charges.read(now.mission.0, BATTERY, whole(percent)) {
            self.aggregator.refuse(now.mission, topic, &reason);
        }
        let (Some(lowest), Some(settings)) =
            (self.interlocks.charges.lowest_percent().map(f64::from), &self.interlocks.battery)
        else {
            return self.news();
        };
        let BatterySettings { min_percent, on_low, resume_percent, .. } = *settings;
        let recovered = match on_low {
            LowBattery::Home => resume_percent,
            LowBattery::Stop | LowBattery::Continue => min_percent + RECOVERED_PERCENT,
        };
        let needed = if self.interlocks.is_low { recovered } else { min_percent };
        let was_low = std::mem::replace(&mut self.interlocks.is_low, lowest < needed);
        let message = format!("the battery is at {lowest} %; needed are {needed} %");
        let fault = self.interlocks.is_low.then_some(InterlockFault { kind: "low", message });
        self.aggregator.show(charge(lowest, fault.as_ref()));
        let is_to_stop = on_low == LowBattery::Stop;
        match &fault {
            Some(fault) if !is_to_stop => {
                self.aggregator.note_as(now.mission, "battery", fault.kind, &fault.message);
            }
            _ => self.aggregator.well(now.mission, "battery"),
        }
        let mut effects = self.news();
        let fault = fault.filter(|_| is_to_stop);
        effects.extend(self.tell(now, Event::Interlock(Interlock::Battery, fault)));
        if on_low == LowBattery::Home && was_low != self.interlocks.is_low {
            effects.push(Effect::Report(AgentEvent::MustReturn(self.interlocks.is_low)));
        }
        effects
    }
}

/// What diagnostics show of the charge, percent.
fn charge(percent: f64, fault: Option<&InterlockFault>) -> Diagnostic {
    Diagnostic {
        level: if fault.is_some() { Level::Warning } else { Level::Ok },
        name: CHARGE.to_owned(),
        message: format!("{percent} %"),
        values: vec![("percent".to_owned(), percent.to_string())],
    }
}

#[expect(clippy::cast_possible_truncation, reason = "0 to 100")]
fn whole(percent: f64) -> i8 {
    percent.round() as i8
}
