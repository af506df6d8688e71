//! A battery's charge.

use super::InputError;
use super::check::Check;
use crate::schema::RosMessage;
use crate::wire::robot::BatteryState;

/// A battery.
#[derive(Clone, Debug, PartialEq)]
pub struct Battery {
    /// When, Unix nanoseconds.
    pub stamp_unix_ns: i64,
    /// Its charge, percent, `0..=100`; `None` if it is not measured.
    pub percent: Option<f64>,
}

impl Battery {
    pub(super) fn check(battery: &BatteryState) -> Result<Self, InputError> {
        let check = Check { message: BatteryState::NAME };
        let stamp_unix_ns = check.stamp("header.stamp", battery.header.stamp)?;
        let share = f64::from(battery.percentage);
        if share.is_nan() {
            return Ok(Self { stamp_unix_ns, percent: None });
        }
        // Some drivers publish 0 to 100: 1 would then be nearly empty or full.
        if !(0.0..=1.0).contains(&share) {
            return check.refused("percentage", share, "0 to 1, a share, or NaN if it is not measured");
        }
        Ok(Self { stamp_unix_ns, percent: Some(100.0 * share) })
    }
}
