//! Messages to an autopilot.

use crate::MavMessage;
use crate::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, MavAutopilot, MavCmd, MavFrame, MavModeFlag, MavSeverity, MavState,
    MavType, PARAM_REQUEST_READ_DATA, PositionTargetTypemask as Ignore, SET_POSITION_TARGET_GLOBAL_INT_DATA,
    SET_POSITION_TARGET_LOCAL_NED_DATA, STATUSTEXT_DATA,
};
use crate::target::{Place, Target};

use super::event::{Level, Notice};

/// Characters of a `STATUSTEXT`.
const TEXT: usize = 50;
/// The component number of an autopilot.
pub(super) const AUTOPILOT: u8 = 1;

/// The heartbeat of a companion computer.
pub(super) fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype: MavType::MAV_TYPE_ONBOARD_CONTROLLER,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    })
}

/// A command with its parameters.
#[expect(clippy::cast_possible_truncation, reason = "MAVLink's parameters are single")]
pub(super) fn command(system: u8, command: MavCmd, parameters: [f64; 7]) -> MavMessage {
    let [param1, param2, param3, param4, param5, param6, param7] =
        parameters.map(|parameter| parameter as f32);
    MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        param1,
        param2,
        param3,
        param4,
        param5,
        param6,
        param7,
        command,
        target_system: system,
        target_component: AUTOPILOT,
        confirmation: 0,
    })
}

/// Asks for a parameter.
pub(super) fn parameter(system: u8, name: &str) -> MavMessage {
    MavMessage::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
        param_index: -1,
        target_system: system,
        target_component: AUTOPILOT,
        param_id: name.into(),
    })
}

/// A target; copters fly to it at `altitude_meters` above home, and turn to its heading.
#[expect(clippy::cast_possible_truncation, reason = "MAVLink's units: 1e-7 degrees, and single meters")]
pub(super) fn target(system: u8, boot_ms: u32, target: &Target, altitude_meters: Option<f64>) -> MavMessage {
    let mut ignored = Ignore::POSITION_TARGET_TYPEMASK_VX_IGNORE
        | Ignore::POSITION_TARGET_TYPEMASK_VY_IGNORE
        | Ignore::POSITION_TARGET_TYPEMASK_VZ_IGNORE
        | Ignore::POSITION_TARGET_TYPEMASK_AX_IGNORE
        | Ignore::POSITION_TARGET_TYPEMASK_AY_IGNORE
        | Ignore::POSITION_TARGET_TYPEMASK_AZ_IGNORE
        | Ignore::POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE;
    if altitude_meters.is_none() {
        ignored |= Ignore::POSITION_TARGET_TYPEMASK_YAW_IGNORE;
    }
    let altitude_meters = altitude_meters.unwrap_or(0.0) as f32;
    let yaw = target.yaw_radians as f32;
    match target.place {
        Place::Global { latitude_degrees, longitude_degrees } => {
            MavMessage::SET_POSITION_TARGET_GLOBAL_INT(SET_POSITION_TARGET_GLOBAL_INT_DATA {
                time_boot_ms: boot_ms,
                lat_int: (latitude_degrees * 1e7).round() as i32,
                lon_int: (longitude_degrees * 1e7).round() as i32,
                alt: altitude_meters,
                yaw,
                type_mask: ignored,
                target_system: system,
                target_component: AUTOPILOT,
                // Deprecated; PX4 knows the frame by this number alone.
                coordinate_frame: MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
                ..SET_POSITION_TARGET_GLOBAL_INT_DATA::default()
            })
        }
        Place::Local { north_meters, east_meters } => {
            MavMessage::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
                time_boot_ms: boot_ms,
                x: north_meters as f32,
                y: east_meters as f32,
                z: -altitude_meters,
                yaw,
                type_mask: ignored,
                target_system: system,
                target_component: AUTOPILOT,
                coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
                ..SET_POSITION_TARGET_LOCAL_NED_DATA::default()
            })
        }
    }
}

/// Stand still wherever that is: a velocity of zero, for a vehicle whose position is not known.
pub(super) fn standstill(system: u8, boot_ms: u32) -> MavMessage {
    MavMessage::SET_POSITION_TARGET_LOCAL_NED(SET_POSITION_TARGET_LOCAL_NED_DATA {
        time_boot_ms: boot_ms,
        type_mask: Ignore::POSITION_TARGET_TYPEMASK_X_IGNORE
            | Ignore::POSITION_TARGET_TYPEMASK_Y_IGNORE
            | Ignore::POSITION_TARGET_TYPEMASK_Z_IGNORE
            | Ignore::POSITION_TARGET_TYPEMASK_AX_IGNORE
            | Ignore::POSITION_TARGET_TYPEMASK_AY_IGNORE
            | Ignore::POSITION_TARGET_TYPEMASK_AZ_IGNORE
            | Ignore::POSITION_TARGET_TYPEMASK_YAW_IGNORE
            | Ignore::POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE,
        target_system: system,
        target_component: AUTOPILOT,
        coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
        ..SET_POSITION_TARGET_LOCAL_NED_DATA::default()
    })
}

/// A notice for ground stations, in as many parts as it needs; `number` is that of the notice, not 0.
pub(super) fn texts(number: u16, notice: &Notice) -> Vec<MavMessage> {
    let severity = match notice.level {
        Level::Ok => MavSeverity::MAV_SEVERITY_INFO,
        Level::Warning => MavSeverity::MAV_SEVERITY_WARNING,
        Level::Error => MavSeverity::MAV_SEVERITY_ERROR,
    };
    let text = format!("dragnet: {}: {}", notice.subject, notice.message);
    // Ground stations show ASCII.
    let text: Vec<u8> = text.chars().map(|letter| u8::try_from(letter).unwrap_or(b'?') & 0x7F).collect();
    // A part that is full says that another follows: a last one may be empty.
    let parts = text.chunks(TEXT).chain(text.len().is_multiple_of(TEXT).then_some([].as_slice()));
    let part = |(part, letters): (u8, &[u8])| {
        let mut padded = [0; TEXT];
        padded[..letters.len()].copy_from_slice(letters);
        MavMessage::STATUSTEXT(STATUSTEXT_DATA {
            severity,
            text: padded.into(),
            id: if text.len() < TEXT { 0 } else { number },
            chunk_seq: part,
        })
    };
    (0..).zip(parts).map(part).collect()
}
