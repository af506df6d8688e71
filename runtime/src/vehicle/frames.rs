//! The frames of a vehicle's network: the vehicle's pose by them, and the mounting of its cameras.

use dragnet_lattice::plane::Pose;
use dragnet_ros2::input::{Transform, Transforms};
use dragnet_vehicle::frames::{FrameTree, LookupError, StampedTransform, Validity};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::ros::settings::Checked;

/// Shortest time between two poses, nanoseconds: transforms may come a thousand times a second.
const STEP_NS: i64 = 20_000_000;

/// The frames, and those of them that matter.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    tree: FrameTree,
    map_frame: String,
    robot_frame: String,
    /// The time of the last pose, nanoseconds by the clock of stamps.
    located_ns: Option<i64>,
    /// Why the last transform was rejected that was, since the last pose.
    rejected: Option<String>,
}

impl Frames {
    pub(crate) fn new(ros: &Checked) -> Self {
        let (map_frame, robot_frame) = (ros.map_frame.clone(), ros.robot_frame.clone());
        Self { tree: FrameTree::default(), map_frame, robot_frame, located_ns: None, rejected: None }
    }

    /// Adds the transforms of a message, each at the time that `validity` gives it by its stamp. Returns why some were
    /// rejected.
    pub(crate) fn receive(
        &mut self,
        transforms: Transforms,
        validity: impl Fn(i64) -> Validity,
    ) -> Vec<String> {
        let Transforms { valid, mut rejected } = transforms;
        for transform in valid {
            let stamped = stamped(transform, &validity);
            if let Err(error) = self.tree.insert(&stamped) {
                rejected.push(error.to_string());
            }
        }
        if let Some(last) = rejected.last() {
            self.rejected = Some(last.clone());
        }
        rejected
    }

    /// The vehicle's newest pose in the map's frame, with its time by the clock of stamps, if it is news.
    pub(crate) fn news(&mut self) -> Option<(i64, Pose)> {
        let time_ns = self.tree.newest_ns(&self.map_frame, &self.robot_frame).ok()??;
        let since_ns = self.located_ns.map_or(i64::MAX, |located_ns| time_ns.saturating_sub(located_ns));
        // A time that has gone back is news: the clock was set.
        if (0..STEP_NS).contains(&since_ns) {
            return None;
        }
        let pose = self.tree.transform(&self.map_frame, &self.robot_frame, time_ns).ok()?;
        self.located_ns = Some(time_ns);
        self.rejected = None;
        Some((time_ns, planar(&pose)))
    }

    /// The pose of a camera's optical frame in the vehicle's frame at a time.
    pub(crate) fn mounting(&self, frame: &str, time_ns: i64) -> Result<Isometry3<f64>, LookupError> {
        self.tree.transform(&self.robot_frame, frame, time_ns)
    }

    /// Why the vehicle's pose is unknown at a time.
    pub(crate) fn why_no_pose(&self, now_ns: i64) -> String {
        let why = match self.tree.transform(&self.map_frame, &self.robot_frame, now_ns) {
            Err(LookupError::NotYet { .. }) | Ok(_) => self.oldest_link(now_ns),
            Err(error) => error.to_string(),
        };
        match &self.rejected {
            Some(rejected) => format!("{why}; the last transform that was rejected: {rejected}"),
            None => why,
        }
    }

    /// The transform that is missed for longest.
    fn oldest_link(&self, now_ns: i64) -> String {
        let links = self.tree.links(&self.map_frame, &self.robot_frame).unwrap_or_default();
        let moving = links.into_iter().filter_map(|link| Some((link.newest_ns?, link.parent, link.child)));
        match moving.min() {
            Some((newest_ns, parent, child)) => {
                let seconds = now_ns.saturating_sub(newest_ns) as f64 / 1e9;
                format!("the newest transform from {parent:?} to {child:?} is {seconds:.1} s old")
            }
            None => {
                "all transforms from the map to the vehicle are static: nothing says that it moves".to_owned()
            }
        }
    }

    /// The links from the vehicle to the map in words, for a check by people: those that are known, or what is missing.
    pub(crate) fn chain(&self) -> Result<String, LookupError> {
        let links = self.tree.links(&self.map_frame, &self.robot_frame)?;
        let names = links.iter().rev().map(|link| link.child);
        Ok(std::iter::once(self.map_frame.as_str()).chain(names).collect::<Vec<_>>().join(" -> "))
    }

    /// Why the last transform was rejected that was, since the last pose.
    pub(crate) fn rejected(&self) -> Option<&str> {
        self.rejected.as_deref()
    }
}

fn stamped(transform: Transform, validity: &impl Fn(i64) -> Validity) -> StampedTransform {
    let Transform { stamp_unix_ns, parent, child, translation_meters, rotation: [x, y, z, w] } = transform;
    let parent_from_child = Isometry3::from_parts(
        Translation3::from(Vector3::from(translation_meters)),
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
    );
    StampedTransform { parent, child, parent_from_child, validity: validity(stamp_unix_ns) }
}

/// A pose reduced to the plane: its yaw in the decomposition into yaw, pitch and roll.
fn planar(pose: &Isometry3<f64>) -> Pose {
    let forward = pose.rotation * Vector3::x();
    let place = pose.translation.vector;
    Pose::new(place.x, place.y, forward.y.atan2(forward.x))
}
