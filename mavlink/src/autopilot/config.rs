//! Settings of an autopilot's state machine.

use crate::target::Limits;

/// Settings of the state machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The autopilot's system number; `None` for the only one.
    pub autopilot_system: Option<u8>,
    /// This program's system number: that of the autopilot, on the same vehicle.
    pub system: u8,
    /// This program's component number.
    pub component: u8,
    /// Who arms the vehicle and switches its mode.
    pub engage: Engage,
    /// Which of the autopilot's positions counts.
    pub position: PositionSource,
    /// Height of a copter's targets above home, meters. Without one copters are not steered.
    pub altitude_meters: Option<f64>,
    /// How far targets may lie, beside what the autopilot's own fence allows.
    pub limits: Limits,
    /// Charge below which the battery is low, percent.
    pub min_battery_percent: f64,
    /// The responses to faults.
    pub on_fault: OnFault,
    /// Time without a heartbeat after which the link is lost, nanoseconds.
    pub link_timeout_ns: u64,
    /// Time without progress after which a target is given up, nanoseconds.
    pub stuck_ns: u64,
    /// Standard deviation of a position that comes without one, meters.
    pub position_std_meters: f64,
}

/// Who arms the vehicle and switches to the mode in which it follows targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engage {
    /// The pilot; until then the robot waits.
    Pilot,
    /// The robot: once, at its start, if the vehicle is disarmed then.
    Robot,
}

/// A position of the autopilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PositionSource {
    /// On the earth: `GLOBAL_POSITION_INT`.
    Global,
    /// From the autopilot's local origin: `LOCAL_POSITION_NED`.
    Local,
}

/// The response to a fault, from the mildest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Response {
    /// The vehicle goes on; the fault is reported.
    Continue,
    /// The vehicle stays where it is until the fault is over.
    Hold,
    /// The robot commands a return, which the autopilot flies or drives by its own settings.
    Home,
}

/// The response to each kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OnFault {
    /// The battery is low.
    pub battery: Response,
    /// The autopilot reports a breach of its fence.
    pub fence: Response,
    /// Data that cannot be: no valid position, a battery whose charge jumps, two autopilots.
    pub data: Response,
}
