//! Which topic said what, so that what is missing can be told by its name.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use dragnet_ros2::input::InputKind;
use dragnet_ros2::name::TopicName;
use dragnet_vehicle::pilot::InputSource;

use super::diagnostics::RefusedInput;
use crate::ros::incoming::Incoming;
use crate::ros::settings::{Checked, Localization};

/// The topics of a vehicle.
#[derive(Clone, Debug)]
pub(super) struct Topics {
    odometry: Option<TopicName>,
    /// Of poses or fixes; none if odometry alone tells where the vehicle is.
    localization: Option<TopicName>,
    /// The last one that told where the vehicle is.
    located_by: Option<TopicName>,
    /// The last one of each camera.
    cameras: BTreeMap<Arc<str>, TopicName>,
    /// Those whose last message was refused.
    bad: BTreeSet<TopicName>,
}

impl Topics {
    pub(super) fn new(ros: &Checked) -> Self {
        let of = |kind| ros.subscriptions.iter().find(|one| one.kind == kind).map(|one| one.topic.clone());
        let localization = match ros.localization() {
            Localization::Pose => of(InputKind::Pose),
            Localization::Fix => of(InputKind::Fix),
            Localization::Odometry => None,
        };
        Self {
            odometry: of(InputKind::Odometry),
            localization,
            located_by: None,
            cameras: BTreeMap::new(),
            bad: BTreeSet::new(),
        }
    }

    /// Something comes on a topic.
    pub(super) fn hears(&mut self, topic: &TopicName, heard: &Incoming) {
        if matches!(heard, Incoming::Rejected { .. }) {
            self.bad.insert(topic.clone());
            return;
        }
        self.bad.remove(topic);
        match heard {
            Incoming::Odometry(_) | Incoming::Pose(_) | Incoming::Fix(_) => {
                self.located_by = Some(topic.clone());
            }
            Incoming::Detections { camera, .. } | Incoming::Image { camera, .. } => {
                self.cameras.insert(Arc::clone(camera), topic.clone());
            }
            Incoming::Map(_) | Incoming::Goals(_) | Incoming::Rejected { .. } => {}
        }
    }

    /// Where something came from.
    pub(super) fn of(&self, source: &InputSource) -> Option<&TopicName> {
        match source {
            InputSource::Pose => self.located_by.as_ref(),
            InputSource::Camera(name) => self.cameras.get(name.as_str()),
        }
    }

    /// Why no pose comes, if `missing` is what localization lacks.
    pub(super) fn why_no_pose(
        &self,
        missing: Option<&str>,
        refused: &BTreeMap<TopicName, RefusedInput>,
    ) -> String {
        let (topic, found) = match (&self.localization, missing, &self.odometry) {
            (Some(topic), Some(missing), _) => (topic, missing),
            (_, _, Some(topic)) | (Some(topic), None, None) => (topic, "nothing comes"),
            (None, _, None) => return "no topic of ros.subscribe tells where the vehicle is".to_owned(),
        };
        match refused.get(topic).filter(|_| self.bad.contains(topic)) {
            Some(RefusedInput { reason, .. }) => format!("{topic}: {found}; the last was refused: {reason}"),
            None => format!("{topic}: {found}"),
        }
    }
}
