//! Who has control of the vehicle, and what the robot sends while it is the robot.

use std::fmt;

use super::config::Response;
use super::engage::{Next, Progress};
use super::{Action, Autopilot, Level, SECOND_NS, STREAM_NS, Subject, orders};
use crate::common::MavCmd;
use crate::mode::{Firmware, Mode};
use crate::target::{Place, Target};

/// Height above home below which a copter stands on the ground, meters.
const GROUND_METERS: f64 = 1.0;
/// Distance that is progress, meters, and up to which a vehicle is at its target.
const PROGRESS_METERS: f64 = 1.0;
/// Share of its altitude from which a copter flies to its target; below it climbs where it is.
const CLIMBED_SHARE: f64 = 0.5;

/// What the robot wants of its vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wish {
    /// Nothing yet.
    Nothing,
    /// To stay there, once the place is known.
    Hold(Option<Target>),
    /// To go there.
    Go(Target),
}

/// Who has control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Control {
    /// Unknown: no heartbeat of a vehicle that can be steered.
    Unknown,
    /// It is guided and disarmed.
    Nobody,
    /// The pilot, or the autopilot itself.
    Pilot(Mode),
    /// The robot, but the copter stands on the ground.
    Ground,
    /// The robot, which still makes it ready.
    Start,
    /// The robot.
    Robot,
}

/// What is sent to a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Order {
    /// Go there, or stay there.
    Target(Target),
    /// Stop: where, is not known.
    Standstill,
    /// Return.
    Home,
}

impl Autopilot {
    pub(super) fn controlled_by(&self) -> Control {
        let Some(mode) = self.mode().filter(|_| self.is_linked()) else { return Control::Unknown };
        if self.starter.is_busy() {
            return Control::Start;
        }
        if !mode.is_guided() {
            return Control::Pilot(mode);
        }
        if !self.is_armed() {
            return Control::Nobody;
        }
        // A height that is lost in flight is still known from before.
        let is_low = self.senses.position().is_none_or(|last| last.altitude_meters < GROUND_METERS);
        // PX4 takes off by a target, ArduPilot by a command.
        if self.flies() && is_low && !self.is_px4() {
            return Control::Ground;
        }
        Control::Robot
    }

    /// Reports who has control, when that changes.
    pub(super) fn notice_control(&mut self) {
        let control = self.controlled_by();
        if self.control == Some(control) {
            return;
        }
        let before = self.control.replace(control);
        (self.sent, self.progress) = (None, None);
        // A place to hold is that at which the robot got control.
        if let Wish::Hold(place) = &mut self.wish {
            *place = None;
        }
        if control == Control::Unknown {
            return;
        }
        if matches!(control, Control::Pilot(_)) && before == Some(Control::Robot) {
            self.starter.stop();
        }
        let level = if before == Some(Control::Robot) { Level::Warning } else { Level::Ok };
        let guided = self.craft.map_or("GUIDED", |craft| craft.guided_name());
        let item = self.senses.mission_item().map(|item| format!(", item {item} of its mission"));
        let message = match control {
            Control::Pilot(mode) => {
                let item = item.filter(|_| mode.to_string().starts_with("AUTO")).unwrap_or_default();
                format!("the vehicle is not the robot's: mode {mode}{item}; it goes on in {guided}")
            }
            other => other.to_string(),
        };
        self.tell(level, "control", message);
    }

    /// Sends what the vehicle is to do, if that changes or is due again.
    pub(super) fn steer(&mut self) {
        let Some(system) = self.system else { return };
        let Some(order) = self.order() else { return };
        let period_ns = if self.is_px4() && order != Order::Home { STREAM_NS } else { SECOND_NS };
        if let Some((sent, sent_ns)) = self.sent
            && sent == order
            && self.now_ns - sent_ns < period_ns
        {
            return;
        }
        self.sent = Some((order, self.now_ns));
        let boot_ms = self.clock.latest_ms();
        self.send(match order {
            Order::Target(target) => orders::target(system, boot_ms, &target, self.target_altitude_meters()),
            Order::Standstill => orders::standstill(system, boot_ms),
            Order::Home => orders::command(system, MavCmd::MAV_CMD_NAV_RETURN_TO_LAUNCH, [0.0; 7]),
        });
    }

    /// What the vehicle is to do now; `None` if that is not the robot's to say.
    fn order(&mut self) -> Option<Order> {
        match self.controlled_by() {
            Control::Robot => {}
            // PX4 accepts its mode only while targets come.
            Control::Pilot(_) | Control::Nobody | Control::Start if self.is_px4() => {
                return self.position().map(|here| Order::Target(target_at(here.place, here.yaw_radians)));
            }
            _ => return None,
        }
        // Before its first position nothing is known of the vehicle.
        self.senses.position()?;
        match self.response() {
            Response::Home => Some(Order::Home),
            Response::Hold => Some(self.hold()),
            Response::Continue => match self.wish {
                Wish::Nothing if !self.is_px4() => None,
                Wish::Nothing | Wish::Hold(_) => Some(self.hold()),
                Wish::Go(target) => Some(self.approach(target)),
            },
        }
    }

    /// The strictest response to what is wrong.
    fn response(&self) -> Response {
        let on_fault = self.config.on_fault;
        let of = |subject: &Subject| match subject {
            Subject::Battery => on_fault.battery,
            Subject::Fence => on_fault.fence,
            Subject::Identity | Subject::Position | Subject::Charge => on_fault.data,
            Subject::Link | Subject::Vehicle | Subject::Target | Subject::Input => Response::Continue,
        };
        self.alarms.standing().map(of).max().unwrap_or(Response::Continue)
    }

    /// Stays at the place at which it began to; if that is unknown it only stops.
    fn hold(&mut self) -> Order {
        let here = self.position().map(|here| target_at(here.place, here.yaw_radians));
        // A fault makes a wish of staying from that of going: afterwards the wish is as it was.
        let kept = match (&mut self.wish, &self.sent) {
            (Wish::Hold(kept), _) => {
                if kept.is_none() {
                    *kept = here;
                }
                *kept
            }
            (_, Some((Order::Target(target), _))) if self.held => Some(*target),
            _ => here,
        };
        self.held = true;
        kept.filter(|_| here.is_some()).map_or(Order::Standstill, Order::Target)
    }

    /// On the way to a target, which lies within the limits.
    fn approach(&mut self, target: Target) -> Order {
        self.held = false;
        let altitude_meters = self.target_altitude_meters();
        if let Err(reason) = self.limits().check(&target.place, self.senses.home(), altitude_meters) {
            self.ill(Subject::Target, Level::Warning, reason.clone());
            // Home comes soon, and the target may then be allowed.
            if self.senses.home().is_some() {
                self.give_up(reason);
            }
            return self.hold();
        }
        self.well(Subject::Target);
        match (altitude_meters, self.position()) {
            (Some(wanted), Some(here)) if here.altitude_meters < CLIMBED_SHARE * wanted => {
                Order::Target(target_at(here.place, here.yaw_radians))
            }
            _ => Order::Target(target),
        }
    }

    fn give_up(&mut self, reason: String) {
        self.wish = Wish::Hold(None);
        self.progress = None;
        self.actions.push(Action::Failed(reason));
    }

    /// Gives up a target to which the vehicle makes no progress.
    pub(super) fn notice_standstill(&mut self) {
        let (Wish::Go(target), Control::Robot) = (self.wish, self.controlled_by()) else { return };
        let Some(here) = self.position().copied() else { return };
        let (place, since_ns) = *self.progress.get_or_insert((here.place, self.now_ns));
        let is_there = here.place.meters_to(&target.place) <= PROGRESS_METERS;
        let is_told_to = self.response() == Response::Continue;
        if is_there || !is_told_to || here.place.meters_to(&place) > PROGRESS_METERS {
            self.progress = Some((here.place, self.now_ns));
        } else if self.now_ns - since_ns > self.config.stuck_ns {
            let seconds = self.config.stuck_ns / 1_000_000_000;
            let reason = format!("the vehicle has not moved for {seconds} s");
            self.ill(Subject::Target, Level::Warning, reason.clone());
            self.give_up(reason);
        }
    }

    /// Makes the vehicle ready, if that is the robot's.
    pub(super) fn start(&mut self) {
        let (Some(system), Some(craft), Some(mode)) = (self.system, self.craft, self.mode()) else { return };
        // Only with a position is it known whether a copter stands on the ground.
        let Some(altitude_meters) = self.position().map(|here| here.altitude_meters) else { return };
        let by_command = craft.firmware == Firmware::ArduPilot;
        let progress = Progress {
            is_guided: mode.is_guided(),
            is_armed: self.is_armed(),
            altitude_meters: Some(altitude_meters),
            takeoff_meters: self.target_altitude_meters().filter(|_| by_command),
        };
        match self.starter.step(self.now_ns, craft, progress) {
            Next::Wait | Next::Done => {}
            Next::Command(command, parameters) => {
                self.send(orders::command(system, command, parameters));
            }
            Next::Yield => {
                let message = "somebody else has the vehicle; the robot does not arm it any more".to_owned();
                self.tell(Level::Warning, "start", message);
            }
            Next::GiveUp(reason) => self.tell(Level::Error, "start", reason),
        }
    }
}

const fn target_at(place: Place, yaw_radians: f64) -> Target {
    Target { place, yaw_radians }
}

impl fmt::Display for Control {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => formatter.write_str("nobody is known to have the vehicle"),
            Self::Nobody => {
                formatter.write_str("the vehicle is disarmed; the robot goes on once it is armed")
            }
            Self::Pilot(mode) => write!(formatter, "the vehicle is not the robot's: mode {mode}"),
            Self::Ground => {
                formatter.write_str("the copter is on the ground; the robot goes on once it has taken off")
            }
            Self::Start => formatter.write_str("the robot arms the vehicle"),
            Self::Robot => formatter.write_str("the robot steers the vehicle"),
        }
    }
}
