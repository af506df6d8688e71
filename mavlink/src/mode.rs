//! Who has control, by an autopilot's heartbeat: its firmware, its kind of vehicle and its mode.

use std::fmt;

use crate::common::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavType};

/// Modes of ArduPilot's rovers and boats, by number.
const ROVER_MODES: &[(u32, &str)] = &[
    (0, "MANUAL"),
    (1, "ACRO"),
    (3, "STEERING"),
    (4, "HOLD"),
    (5, "LOITER"),
    (6, "FOLLOW"),
    (7, "SIMPLE"),
    (8, "DOCK"),
    (9, "CIRCLE"),
    (10, "AUTO"),
    (11, "RTL"),
    (12, "SMART_RTL"),
    (15, "GUIDED"),
    (16, "INITIALISING"),
];
/// Modes of ArduPilot's copters, by number.
const COPTER_MODES: &[(u32, &str)] = &[
    (0, "STABILIZE"),
    (1, "ACRO"),
    (2, "ALT_HOLD"),
    (3, "AUTO"),
    (4, "GUIDED"),
    (5, "LOITER"),
    (6, "RTL"),
    (7, "CIRCLE"),
    (9, "LAND"),
    (11, "DRIFT"),
    (13, "SPORT"),
    (14, "FLIP"),
    (15, "AUTOTUNE"),
    (16, "POSHOLD"),
    (17, "BRAKE"),
    (18, "THROW"),
    (19, "AVOID_ADSB"),
    (20, "GUIDED_NOGPS"),
    (21, "SMART_RTL"),
    (27, "AUTO_RTL"),
];
/// Main modes of PX4, by the third byte of its mode.
const PX4_MODES: &[(u32, &str)] = &[
    (1, "MANUAL"),
    (2, "ALTCTL"),
    (3, "POSCTL"),
    (4, "AUTO"),
    (5, "ACRO"),
    (6, "OFFBOARD"),
    (7, "STABILIZED"),
];
/// PX4's modes within `AUTO`, by the fourth byte.
const PX4_AUTO_MODES: &[(u32, &str)] = &[
    (1, "AUTO.READY"),
    (2, "AUTO.TAKEOFF"),
    (3, "AUTO.LOITER"),
    (4, "AUTO.MISSION"),
    (5, "AUTO.RTL"),
    (6, "AUTO.LAND"),
    (8, "AUTO.FOLLOW"),
    (9, "AUTO.PRECLAND"),
];

/// An autopilot's firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Firmware {
    /// ArduPilot.
    ArduPilot,
    /// PX4.
    Px4,
}

/// An autopilot that can be steered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Craft {
    /// Its firmware.
    pub firmware: Firmware,
    /// Whether it is a copter; else a rover or a boat.
    pub flies: bool,
}

/// An autopilot's mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    craft: Craft,
    custom: u32,
}

impl Craft {
    /// Firmware and kind of vehicle.
    ///
    /// # Errors
    /// If it is not one that can be steered: what it is, and what is allowed.
    pub fn of(heartbeat: &HEARTBEAT_DATA) -> Result<Self, String> {
        let firmware = match heartbeat.autopilot {
            MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA => Firmware::ArduPilot,
            MavAutopilot::MAV_AUTOPILOT_PX4 => Firmware::Px4,
            other => return Err(format!("the autopilot is {other:?}; allowed are ArduPilot and PX4")),
        };
        let flies = match heartbeat.mavtype {
            MavType::MAV_TYPE_GROUND_ROVER | MavType::MAV_TYPE_SURFACE_BOAT => false,
            MavType::MAV_TYPE_QUADROTOR
            | MavType::MAV_TYPE_HEXAROTOR
            | MavType::MAV_TYPE_OCTOROTOR
            | MavType::MAV_TYPE_TRICOPTER
            | MavType::MAV_TYPE_COAXIAL
            | MavType::MAV_TYPE_HELICOPTER
            | MavType::MAV_TYPE_DODECAROTOR
            | MavType::MAV_TYPE_DECAROTOR
            | MavType::MAV_TYPE_GENERIC_MULTIROTOR => true,
            other => {
                return Err(format!("the vehicle is {other:?}; allowed are rovers, boats and copters"));
            }
        };
        Ok(Self { firmware, flies })
    }

    /// The mode in which it follows targets, as `MAV_CMD_DO_SET_MODE` has it: its second and third parameter.
    #[must_use]
    pub const fn guided(self) -> [u8; 2] {
        match (self.firmware, self.flies) {
            (Firmware::ArduPilot, false) => [15, 0],
            (Firmware::ArduPilot, true) => [4, 0],
            (Firmware::Px4, _) => [6, 0],
        }
    }

    /// The name of that mode.
    #[must_use]
    pub const fn guided_name(self) -> &'static str {
        match self.firmware {
            Firmware::ArduPilot => "GUIDED",
            Firmware::Px4 => "OFFBOARD",
        }
    }
}

impl Mode {
    /// The mode of a heartbeat.
    #[must_use]
    pub const fn of(craft: Craft, heartbeat: &HEARTBEAT_DATA) -> Self {
        Self { craft, custom: heartbeat.custom_mode }
    }

    /// Whether the autopilot follows targets.
    #[must_use]
    pub fn is_guided(self) -> bool {
        self.number() == u32::from(self.craft.guided()[0])
    }

    const fn number(self) -> u32 {
        match self.craft.firmware {
            Firmware::ArduPilot => self.custom,
            Firmware::Px4 => (self.custom >> 16) & 0xFF,
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = |modes: &[(u32, &'static str)], number: u32| {
            modes.iter().find(|(one, _)| *one == number).map(|(_, name)| *name)
        };
        let name = match (self.craft.firmware, self.craft.flies) {
            (Firmware::ArduPilot, false) => named(ROVER_MODES, self.custom),
            (Firmware::ArduPilot, true) => named(COPTER_MODES, self.custom),
            (Firmware::Px4, _) => named(PX4_AUTO_MODES, self.custom >> 24)
                .filter(|_| self.number() == 4)
                .or_else(|| named(PX4_MODES, self.number())),
        };
        match name {
            Some(name) => formatter.write_str(name),
            None => write!(formatter, "number {}", self.custom),
        }
    }
}

/// Whether an autopilot's motors may turn.
#[must_use]
pub fn is_armed(heartbeat: &HEARTBEAT_DATA) -> bool {
    heartbeat.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_have_the_numbers_of_their_firmware() {
        let check = |autopilot, mavtype, custom_mode: u32, name: &str, is_guided: bool| {
            let heartbeat = HEARTBEAT_DATA { autopilot, mavtype, custom_mode, ..HEARTBEAT_DATA::default() };
            let mode = Mode::of(Craft::of(&heartbeat).unwrap(), &heartbeat);
            assert_eq!((mode.to_string().as_str(), mode.is_guided()), (name, is_guided));
        };
        let [ardupilot, px4] = [MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA, MavAutopilot::MAV_AUTOPILOT_PX4];
        let [rover, boat, copter] =
            [MavType::MAV_TYPE_GROUND_ROVER, MavType::MAV_TYPE_SURFACE_BOAT, MavType::MAV_TYPE_QUADROTOR];
        check(ardupilot, rover, 15, "GUIDED", true);
        check(ardupilot, boat, 11, "RTL", false);
        check(ardupilot, copter, 4, "GUIDED", true);
        check(ardupilot, copter, 15, "AUTOTUNE", false);
        check(ardupilot, rover, 4, "HOLD", false);
        check(px4, copter, 6 << 16, "OFFBOARD", true);
        check(px4, rover, (4 << 16) | (5 << 24), "AUTO.RTL", false);
        check(px4, rover, 3 << 16, "POSCTL", false);
        check(ardupilot, copter, 99, "number 99", false);
    }

    #[test]
    fn what_cannot_be_steered_is_named() {
        let plane = HEARTBEAT_DATA {
            autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            mavtype: MavType::MAV_TYPE_FIXED_WING,
            ..HEARTBEAT_DATA::default()
        };
        crate::mentions::assert_mentions(&Craft::of(&plane).unwrap_err(), "MAV_TYPE_FIXED_WING .. copters");
        let other = HEARTBEAT_DATA { autopilot: MavAutopilot::MAV_AUTOPILOT_PPZ, ..plane };
        crate::mentions::assert_mentions(&Craft::of(&other).unwrap_err(), "MAV_AUTOPILOT_PPZ .. PX4");
    }
}
