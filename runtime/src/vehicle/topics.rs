//! The topics of messages, so that diagnostics can name them.

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
    /// `None` if transforms say it too.
    odometry: Option<TopicName>,
    /// That of poses or fixes; `None` if only odometry is used.
    localization: Option<TopicName>,
    /// The topic of the last pose.
    located_by: Option<TopicName>,
    /// The last one of each camera.
    cameras: BTreeMap<Arc<str>, TopicName>,
    /// Those whose last message was invalid.
    bad: BTreeSet<TopicName>,
}

impl Topics {
    pub(super) fn new(ros: &Checked) -> Self {
        let of = |kind| ros.subscriptions.iter().find(|one| one.kind == kind).map(|one| one.topic.clone());
        let localization = match ros.localization() {
            Localization::Pose => of(InputKind::Pose),
            Localization::Fix => of(InputKind::Fix),
            Localization::Tf => of(InputKind::Transforms),
            Localization::Odometry => None,
        };
        Self {
            odometry: of(InputKind::Odometry).filter(|_| ros.localization() != Localization::Tf),
            localization,
            located_by: None,
            cameras: BTreeMap::new(),
            bad: BTreeSet::new(),
        }
    }

    /// A message arrives on a topic.
    pub(super) fn on_message(&mut self, topic: &TopicName, received: &Incoming) {
        if matches!(received, Incoming::Rejected { .. }) {
            self.bad.insert(topic.clone());
            return;
        }
        self.bad.remove(topic);
        match received {
            Incoming::Odometry(_) if self.odometry.is_none() => {}
            Incoming::Odometry(_) | Incoming::Pose(_) | Incoming::Fix(_) | Incoming::Transforms(_) => {
                self.located_by = Some(topic.clone());
            }
            Incoming::Detections { camera, .. } | Incoming::Image { camera, .. } => {
                self.cameras.insert(Arc::clone(camera), topic.clone());
            }
            Incoming::Map(_)
            | Incoming::Goals(_)
            | Incoming::StaticTransforms(_)
            | Incoming::CameraInfo { .. }
            | Incoming::Stop(_)
            | Incoming::Battery(_)
            | Incoming::Rejected { .. } => {}
        }
    }

    /// The topic of an input.
    pub(super) fn of(&self, source: &InputSource) -> Option<&TopicName> {
        match source {
            InputSource::Pose => self.located_by.as_ref(),
            InputSource::Camera(name) => self.cameras.get(name.as_str()),
        }
    }

    /// Why there is no pose, if `missing` is localization's reason.
    pub(super) fn why_no_pose(
        &self,
        missing: Option<&str>,
        refused: &BTreeMap<TopicName, RefusedInput>,
    ) -> String {
        let (topic, found) = match (&self.localization, missing, &self.odometry) {
            (Some(topic), Some(missing), _) => (topic, missing),
            (_, _, Some(topic)) | (Some(topic), None, None) => (topic, "no message arrives"),
            (None, _, None) => return "no topic of ros.subscribe gives the vehicle's pose".to_owned(),
        };
        match refused.get(topic).filter(|_| self.bad.contains(topic)) {
            Some(RefusedInput { reason, .. }) => format!("{topic}: {found}; the last was rejected: {reason}"),
            None => format!("{topic}: {found}"),
        }
    }
}
