//! What an autopilot is asked for: messages at a rate, and parameters.

use mavlink_core::MessageData;

use super::config::PositionSource;
use super::{Autopilot, SECOND_NS, orders};
use crate::common::{
    ATTITUDE_DATA, BATTERY_STATUS_DATA, FENCE_STATUS_DATA, GLOBAL_POSITION_INT_DATA, GPS_RAW_INT_DATA,
    HOME_POSITION_DATA, LOCAL_POSITION_NED_DATA, MISSION_CURRENT_DATA, MavCmd, SYS_STATUS_DATA,
    SYSTEM_TIME_DATA,
};

/// Time between two requests of the same, nanoseconds.
const AGAIN_NS: u64 = 3 * SECOND_NS;
/// Messages and their rates, 1/s, beside the position.
const RATES: [(u32, f64); 7] = [
    (ATTITUDE_DATA::ID, 10.0),
    (GPS_RAW_INT_DATA::ID, 2.0),
    (SYS_STATUS_DATA::ID, 1.0),
    (BATTERY_STATUS_DATA::ID, 1.0),
    (FENCE_STATUS_DATA::ID, 1.0),
    (SYSTEM_TIME_DATA::ID, 1.0),
    (MISSION_CURRENT_DATA::ID, 1.0),
];
/// The rate of positions, 1/s.
const POSITION_RATE: f64 = 10.0;

impl Autopilot {
    /// Asks again for whatever has not come lately.
    pub(super) fn request(&mut self) {
        let (Some(system), Some(craft)) = (self.system, self.craft) else { return };
        self.senses.begin(self.now_ns);
        if self.requested_ns.is_some_and(|requested_ns| self.now_ns - requested_ns < AGAIN_NS) {
            return;
        }
        self.requested_ns = Some(self.now_ns);
        let position = match self.config.position {
            PositionSource::Global => GLOBAL_POSITION_INT_DATA::ID,
            PositionSource::Local => LOCAL_POSITION_NED_DATA::ID,
        };
        for (message, rate) in [(position, POSITION_RATE)].into_iter().chain(RATES) {
            let is_missing = self.heard_ns.get(&message).is_none_or(|heard| self.now_ns - heard >= AGAIN_NS);
            if is_missing {
                let parameters = [f64::from(message), 1e6 / rate, 0.0, 0.0, 0.0, 0.0, 0.0];
                self.send(orders::command(system, MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, parameters));
            }
        }
        // Home may be set anew at any time.
        let home = [f64::from(HOME_POSITION_DATA::ID), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        self.send(orders::command(system, MavCmd::MAV_CMD_REQUEST_MESSAGE, home));
        for name in self.fence.missing(craft.firmware) {
            self.send(orders::parameter(system, name));
        }
    }
}
