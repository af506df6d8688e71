//! Transforms between frames, as on `/tf` and `/tf_static`.

use super::InputError;
use super::check::Check;
use crate::schema::RosMessage;
use crate::wire::standard::{Quaternion, TFMessage, TransformStamped, Vector3};

/// The maximum number of transforms in a message.
const MAX_TRANSFORMS: usize = 1024;

/// The transforms of a message. Each speaks of another part of the robot, and nodes that collect them from several
/// sources publish them together: so an invalid one is rejected alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transforms {
    /// Valid ones.
    pub valid: Vec<Transform>,
    /// Why others are rejected.
    pub rejected: Vec<String>,
}

/// The pose of a frame in another one.
#[derive(Clone, Debug, PartialEq)]
pub struct Transform {
    /// When, Unix nanoseconds; without meaning if it is static.
    pub stamp_unix_ns: i64,
    /// The frame in which the pose is given; not empty, at most 256 bytes.
    pub parent: String,
    /// The frame whose pose it is; not empty, at most 256 bytes.
    pub child: String,
    /// The child's origin in the parent, meters along x, y and z.
    pub translation_meters: [f64; 3],
    /// The child's rotation in the parent: a quaternion x, y, z, w of length 1, up to rounding.
    pub rotation: [f64; 4],
}

impl Transforms {
    pub(super) fn check(message: TFMessage) -> Result<Self, InputError> {
        let check = Check { message: TFMessage::NAME };
        check.at_most("transforms", message.transforms.len(), MAX_TRANSFORMS)?;
        let mut transforms = Self::default();
        for transform in message.transforms {
            match check.transform(&transform) {
                Ok(transform) => transforms.valid.push(transform),
                Err(error) => transforms.rejected.push(error.to_string()),
            }
        }
        Ok(transforms)
    }
}

impl Check {
    fn transform(self, stamped: &TransformStamped) -> Result<Transform, InputError> {
        let (stamp_unix_ns, parent) = self.header(&stamped.header)?;
        let child = self.text("child_frame_id", &stamped.child_frame_id)?.to_owned();
        for (field, name) in [("header.frame_id", &parent), ("child_frame_id", &child)] {
            if name.trim_start_matches('/').is_empty() {
                return self.refused(field, format!("{name:?}"), "the name of a frame");
            }
        }
        let at = |field: &str| format!("transform from {parent:?} to {child:?}: {field}");
        let Vector3 { x, y, z } = stamped.transform.translation;
        let translation_meters = [
            self.finite(&at("translation.x"), x)?,
            self.finite(&at("translation.y"), y)?,
            self.finite(&at("translation.z"), z)?,
        ];
        let Quaternion { x, y, z, w } = self.rotation(&at("rotation"), stamped.transform.rotation)?;
        Ok(Transform { stamp_unix_ns, translation_meters, rotation: [x, y, z, w], parent, child })
    }
}
