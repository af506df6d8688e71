//! The autopilot's own fence, by its parameters: the circle around home and the height. What other fences it has, it
//! guards alone.

use crate::common::{MavParamType, PARAM_VALUE_DATA};
use crate::mode::Firmware;
use crate::target::Limits;

/// Bits of ArduPilot's `FENCE_TYPE`.
const MAX_ALTITUDE_BIT: u32 = 1;
const CIRCLE_BIT: u32 = 2;

/// Parameters of ArduPilot's fence.
const ARDUPILOT: [&str; 4] = ["FENCE_ENABLE", "FENCE_TYPE", "FENCE_RADIUS", "FENCE_ALT_MAX"];
/// Parameters of PX4's fence.
const PX4: [&str; 3] = ["GF_ACTION", "GF_MAX_HOR_DIST", "GF_MAX_VER_DIST"];

/// Values of the parameters, those that have arrived.
#[derive(Clone, Debug, Default)]
pub(super) struct Fence {
    ardupilot: [Option<f64>; ARDUPILOT.len()],
    px4: [Option<f64>; PX4.len()],
}

impl Fence {
    /// A parameter arrives.
    pub(super) fn read(&mut self, data: &PARAM_VALUE_DATA) {
        let Ok(name) = data.param_id.to_str() else { return };
        let place_in = |names: &[&str]| names.iter().position(|one| *one == name);
        // PX4 sends the bytes of integers as if they were a number; ArduPilot converts them.
        let value = match (place_in(&PX4), data.param_type) {
            (Some(_), MavParamType::MAV_PARAM_TYPE_INT32) => {
                f64::from(i32::from_le_bytes(data.param_value.to_le_bytes()))
            }
            _ => f64::from(data.param_value),
        };
        let value = Some(value).filter(|value| value.is_finite());
        if let Some(place) = place_in(&ARDUPILOT) {
            self.ardupilot[place] = value;
        } else if let Some(place) = place_in(&PX4) {
            self.px4[place] = value;
        }
    }

    /// Parameters that have not arrived.
    pub(super) fn missing(&self, firmware: Firmware) -> Vec<&'static str> {
        let (names, values): (&[&'static str], &[Option<f64>]) = match firmware {
            Firmware::ArduPilot => (&ARDUPILOT, &self.ardupilot),
            Firmware::Px4 => (&PX4, &self.px4),
        };
        names.iter().zip(values).filter(|(_, value)| value.is_none()).map(|(name, _)| *name).collect()
    }

    /// What the fence allows; nothing is limited by parameters that have not arrived.
    pub(super) fn limits(&self) -> Limits {
        if let [Some(is_enabled), Some(kind), Some(radius), Some(height)] = self.ardupilot
            && is_enabled > 0.0
        {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small bit mask")]
            let has = |bit: u32| kind as u32 & bit != 0;
            return Limits {
                max_distance_meters: limit(radius, has(CIRCLE_BIT)),
                max_altitude_meters: limit(height, has(MAX_ALTITUDE_BIT)),
                ..Limits::NONE
            };
        }
        if let [Some(action), Some(distance), Some(height)] = self.px4
            && action > 0.0
        {
            return Limits {
                max_distance_meters: limit(distance, true),
                max_altitude_meters: limit(height, true),
                ..Limits::NONE
            };
        }
        Limits::NONE
    }
}

/// 0 is no limit.
fn limit(meters: f64, is_on: bool) -> f64 {
    if is_on && meters > 0.0 { meters } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fence(values: &[(&str, f32, MavParamType)]) -> Fence {
        let mut fence = Fence::default();
        for &(name, param_value, param_type) in values {
            let param_id = name.into();
            fence.read(&PARAM_VALUE_DATA {
                param_id,
                param_value,
                param_type,
                ..PARAM_VALUE_DATA::default()
            });
        }
        fence
    }

    #[test]
    fn parameters_of_both_firmwares_give_limits() {
        let real = MavParamType::MAV_PARAM_TYPE_REAL32;
        let ardupilot = |enabled, kind| {
            fence(&[
                ("FENCE_ENABLE", enabled, MavParamType::MAV_PARAM_TYPE_INT8),
                ("FENCE_TYPE", kind, MavParamType::MAV_PARAM_TYPE_INT8),
                ("FENCE_RADIUS", 300.0, real),
                ("FENCE_ALT_MAX", 100.0, real),
                ("ATC_ANG_RLL_P", 1.0, real),
            ])
        };
        let limits = |fence: &Fence| {
            let Limits { max_distance_meters, max_altitude_meters, .. } = fence.limits();
            (max_distance_meters, max_altitude_meters)
        };
        assert_eq!(limits(&ardupilot(1.0, 7.0)), (300.0, 100.0));
        assert_eq!(limits(&ardupilot(1.0, 1.0)), (f64::INFINITY, 100.0));
        assert_eq!(limits(&ardupilot(0.0, 7.0)), (f64::INFINITY, f64::INFINITY));
        let action = f32::from_le_bytes(2_i32.to_le_bytes());
        let px4 = fence(&[
            ("GF_ACTION", action, MavParamType::MAV_PARAM_TYPE_INT32),
            ("GF_MAX_HOR_DIST", 200.0, real),
            ("GF_MAX_VER_DIST", 0.0, real),
        ]);
        assert_eq!(limits(&px4), (200.0, f64::INFINITY));
        assert_eq!(px4.missing(Firmware::Px4).len(), 0);
        // Three of ArduPilot's are not those of PX4.
        let some =
            fence(&[("FENCE_ENABLE", 1.0, real), ("FENCE_TYPE", 2.0, real), ("FENCE_RADIUS", 300.0, real)]);
        assert_eq!(limits(&some), (f64::INFINITY, f64::INFINITY));
        assert_eq!(some.missing(Firmware::ArduPilot), ["FENCE_ALT_MAX"]);
        assert_eq!(Fence::default().missing(Firmware::ArduPilot).len(), 4);
    }
}
