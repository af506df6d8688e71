//! Checks of single fields. Errors name the field.

use std::fmt::Display;
use std::ops::RangeInclusive;

use super::InputError;
use crate::wire::standard::{Header, Quaternion, Time};

/// The longest name of a frame or a class, bytes.
const MAX_TEXT_BYTES: usize = 256;
/// The norm of a rotation's quaternion is 1, up to rounding.
const ROTATION_LENGTH: RangeInclusive<f64> = 0.99..=1.01;
const NANOSECONDS: u32 = 1_000_000_000;

/// Checks the fields of one message.
#[derive(Clone, Copy, Debug)]
pub(super) struct Check {
    /// Its ROS name.
    pub(super) message: &'static str,
}

impl Check {
    pub(super) fn refused<T>(
        self,
        field: impl Into<String>,
        found: impl Display,
        allowed: impl Into<String>,
    ) -> Result<T, InputError> {
        let (field, allowed) = (field.into(), allowed.into());
        Err(InputError::Value { message: self.message, field, found: found.to_string(), allowed })
    }

    pub(super) fn finite(self, field: &str, value: f64) -> Result<f64, InputError> {
        if value.is_finite() { Ok(value) } else { self.refused(field, value, "a finite number") }
    }

    pub(super) fn within(
        self,
        field: &str,
        value: f64,
        range: &RangeInclusive<f64>,
    ) -> Result<f64, InputError> {
        if range.contains(&value) {
            Ok(value)
        } else {
            self.refused(field, value, format!("{} to {}", range.start(), range.end()))
        }
    }

    pub(super) fn at_most(self, field: &str, count: usize, most: usize) -> Result<(), InputError> {
        if count <= most {
            Ok(())
        } else {
            self.refused(field, format!("{count} long"), format!("at most {most}"))
        }
    }

    pub(super) fn text<'a>(self, field: &str, text: &'a str) -> Result<&'a str, InputError> {
        self.at_most(field, text.len(), MAX_TEXT_BYTES).map(|()| text)
    }

    /// A rotation.
    pub(super) fn rotation(self, field: &str, quaternion: Quaternion) -> Result<Quaternion, InputError> {
        let Quaternion { x, y, z, w } = quaternion;
        let length = (x * x + y * y + z * z + w * w).sqrt();
        if ROTATION_LENGTH.contains(&length) {
            Ok(quaternion)
        } else {
            self.refused(field, format!("({x}, {y}, {z}, {w})"), "a quaternion of length 1")
        }
    }

    /// Unix nanoseconds.
    pub(super) fn stamp(self, field: &str, stamp: Time) -> Result<i64, InputError> {
        if stamp.nanosec < NANOSECONDS {
            Ok(i64::from(stamp.sec) * i64::from(NANOSECONDS) + i64::from(stamp.nanosec))
        } else {
            self.refused(format!("{field}.nanosec"), stamp.nanosec, "0 to 999999999")
        }
    }

    /// Unix nanoseconds, and the frame.
    pub(super) fn header(self, header: &Header) -> Result<(i64, String), InputError> {
        let stamp_unix_ns = self.stamp("header.stamp", header.stamp)?;
        Ok((stamp_unix_ns, self.text("header.frame_id", &header.frame_id)?.to_owned()))
    }
}
