//! Where a vehicle is on the search's map, from what its own network says.
//!
//! Three frames meet here: that of the search, whose origin is the map's south-western corner; that of the network's
//! maps and poses, in which the corner is somewhere ([`MapOrigin`]); and that of odometry, which is smooth and drifts.
//! A pose on the map, or a fix on the earth, is a correction: it tells where odometry's frame lies, as of its own time.
//! In between odometry tells where the vehicle is, so that it is known as often as odometry comes.
//!
//! Localization such as AMCL's speaks only when the vehicle moves. So its silence means nothing as long as the vehicle
//! stands, and after a stated time and way it means that nobody knows any more where the vehicle is.

mod trail;

use std::collections::VecDeque;
use std::time::Duration;

use dragnet_lattice::plane::Pose;
use dragnet_ros2::input::{Fix, Odometry, PlanarCovariance, PlanarPose, PoseEstimate};
use dragnet_scenario::map_file::{Georeference, MapOrigin};

use crate::ros::settings::{Localization, Uncorrected};
use trail::Trail;

/// So many corrections may wait for odometry of their time.
const MOST_WAITING: usize = 64;

/// Where a vehicle was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Located {
    /// Nanoseconds of mission time.
    pub(super) time_ns: u64,
    /// On the search's map.
    pub(super) pose: Pose,
    pub(super) deviation_meters: f64,
    pub(super) heading_deviation_radians: f64,
}

/// When something was heard, and when it was so, both nanoseconds of mission time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Moment {
    pub(super) heard_ns: u64,
    /// No earlier than the mission's start.
    pub(super) time_ns: u64,
    /// How old it was when it was heard, however long the mission lasts.
    pub(super) age: Duration,
}

/// How sure a place is: standard deviations, 0 if nobody says.
#[derive(Clone, Copy, Debug, Default)]
struct Sureness {
    meters: f64,
    radians: f64,
}

/// Where the vehicle was by localization.
#[derive(Clone, Copy, Debug)]
struct Correction {
    at: Moment,
    x_meters: f64,
    y_meters: f64,
    /// A fix says nothing of a heading: that is odometry's, whose frame then is turned as the earth is, x to the east.
    heading_radians: Option<f64>,
    sureness: Sureness,
}

/// Where odometry's frame lies on the search's map.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    map_from_odometry: Pose,
    sureness: Sureness,
    /// When the correction came that says so.
    heard_ns: u64,
    /// Where the vehicle was then, in odometry's frame.
    odometry: Pose,
}

/// What is known of the three frames.
#[derive(Clone, Debug)]
pub(super) struct Places {
    source: Localization,
    limits: Uncorrected,
    /// The search's map in the network's frame.
    map: Pose,
    earth: Option<Georeference>,
    /// Odometry, in its own frame.
    trail: Trail,
    /// Corrections of times for which there is no odometry yet.
    waiting: VecDeque<Correction>,
    anchor: Option<Anchor>,
    /// Why nobody knows where the vehicle is, if odometry is not what is missing.
    missing: Option<String>,
}

impl Places {
    pub(super) fn new(
        source: Localization,
        limits: Uncorrected,
        map: MapOrigin,
        earth: Option<Georeference>,
    ) -> Self {
        let map = Pose::new(map.x_meters, map.y_meters, map.yaw_radians);
        let missing =
            (source != Localization::Odometry).then(|| "nothing that can be used has come yet".to_owned());
        let (trail, waiting) = (Trail::default(), VecDeque::new());
        Self { source, limits, map, earth, trail, waiting, anchor: None, missing }
    }

    /// Where the search's map lies in the network's frame.
    pub(super) const fn map(&self) -> &Pose {
        &self.map
    }

    /// A pose of the network's frame on the search's map.
    fn on_map(&self, pose: &Pose) -> Pose {
        pose.seen_from(&self.map)
    }

    /// A pose on the search's map in the network's frame.
    pub(super) fn in_frame(&self, pose: &Pose) -> Pose {
        self.map.of_part(pose)
    }

    /// Why nobody knows where the vehicle is, as far as localization is the reason.
    pub(super) fn missing(&self) -> Option<&str> {
        self.missing.as_deref()
    }

    pub(super) fn odometry(&mut self, at: Moment, odometry: &Odometry) -> Option<Located> {
        let here = posed(odometry.place.pose);
        if self.source == Localization::Odometry {
            return Some(located(at, self.on_map(&here), sureness(odometry.place.covariance)));
        }
        self.trail.push(at.time_ns, here);
        while let Some(correction) =
            self.waiting.pop_front_if(|correction| correction.at.time_ns <= at.time_ns)
        {
            self.anchor(&correction);
        }
        let anchor = self.anchor?;
        self.watch(at, &here, &anchor);
        if self.missing.is_some() {
            return None;
        }
        Some(located(at, anchor.map_from_odometry.of_part(&here), anchor.sureness))
    }

    /// # Errors
    /// If the pose is too old to say where the vehicle is.
    pub(super) fn pose(&mut self, at: Moment, estimate: &PoseEstimate) -> Result<Option<Located>, String> {
        if self.source != Localization::Pose {
            return Ok(None);
        }
        let pose = self.on_map(&posed(estimate.pose));
        self.correct(Correction {
            at,
            x_meters: pose.x_meters,
            y_meters: pose.y_meters,
            heading_radians: Some(pose.heading_radians),
            sureness: sureness(estimate.covariance),
        })
    }

    /// # Errors
    /// If the fix is too old to say where the vehicle is.
    pub(super) fn fix(&mut self, at: Moment, fix: &Fix) -> Result<Option<Located>, String> {
        let Some(earth) = self.earth.as_ref().filter(|_| self.source == Localization::Fix) else {
            return Ok(None);
        };
        let (x_meters, y_meters) = fix.meters(earth);
        let [[east_variance, _], [_, north_variance]] = fix.covariance_square_meters.unwrap_or_default();
        let sureness = Sureness { meters: east_variance.max(north_variance).sqrt(), radians: 0.0 };
        self.correct(Correction { at, x_meters, y_meters, heading_radians: None, sureness })
    }

    /// Where odometry is, if there is any, is where the vehicle is; else it is known as often as it is corrected.
    fn correct(&mut self, correction: Correction) -> Result<Option<Located>, String> {
        self.check_age(&correction)?;
        if self.trail.latest_ns().is_some_and(|latest_ns| latest_ns >= correction.at.time_ns) {
            self.anchor(&correction);
            return Ok(None);
        }
        if self.waiting.len() == MOST_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(correction);
        let heading_radians = correction.heading_radians.filter(|_| self.trail.latest_ns().is_none());
        Ok(heading_radians.map(|heading_radians| {
            self.missing = None;
            let Correction { at, x_meters, y_meters, sureness, .. } = correction;
            located(at, Pose::new(x_meters, y_meters, heading_radians), sureness)
        }))
    }

    /// An old correction is as good as a new one where the vehicle has stood since. What was latched before this robot
    /// began is all that there is, if the vehicle stands.
    fn check_age(&self, correction: &Correction) -> Result<(), String> {
        let Moment { time_ns, age, .. } = correction.at;
        let Some((then, latest)) = self.trail.at(time_ns).zip(self.trail.latest()) else { return Ok(()) };
        let is_known = self.trail.reaches(time_ns) || self.anchor.is_none();
        if age <= Duration::from_nanos(self.limits.timeout_ns)
            || is_known && !self.limits.is_left(&then, &latest)
        {
            return Ok(());
        }
        let age = age.as_secs_f64();
        Err(format!(
            "stamped {age:.1} s before this computer's clock, and the vehicle has moved since; set `stamps = \"arrival\"` \
             if this computer's clock should count"
        ))
    }

    fn anchor(&mut self, correction: &Correction) {
        let &Correction { at, x_meters, y_meters, heading_radians, sureness } = correction;
        let Some(odometry) = self.trail.at(at.time_ns) else { return };
        let pose = Pose::new(x_meters, y_meters, heading_radians.unwrap_or(odometry.heading_radians));
        let map_from_odometry = pose.of_part(&Pose::default().seen_from(&odometry));
        self.anchor = Some(Anchor { map_from_odometry, sureness, heard_ns: at.heard_ns, odometry });
        self.missing = None;
    }

    /// Whether the vehicle has gone too far on odometry alone. Once it has, only a correction helps.
    fn watch(&mut self, at: Moment, here: &Pose, anchor: &Anchor) {
        let silence_ns = at.heard_ns.saturating_sub(anchor.heard_ns);
        if self.missing.is_none()
            && silence_ns > self.limits.timeout_ns
            && self.limits.is_left(&anchor.odometry, here)
        {
            let (meters, radians) = trail::apart(&anchor.odometry, here);
            self.missing = Some(format!(
                "nothing that can be used has come for {:.1} s, while the vehicle moved {meters:.1} m and turned {:.0} degrees",
                silence_ns as f64 / 1e9,
                radians.to_degrees(),
            ));
        }
    }
}

impl Uncorrected {
    /// Whether a vehicle has moved or turned farther than it may on odometry alone.
    fn is_left(&self, from: &Pose, to: &Pose) -> bool {
        let (meters, radians) = trail::apart(from, to);
        meters > self.meters || radians > self.radians
    }
}

fn located(at: Moment, pose: Pose, sureness: Sureness) -> Located {
    let Sureness { meters, radians } = sureness;
    Located { time_ns: at.time_ns, pose, deviation_meters: meters, heading_deviation_radians: radians }
}

fn sureness(covariance: Option<PlanarCovariance>) -> Sureness {
    let [[x, ..], [_, y, _], [.., yaw]] = covariance.unwrap_or_default();
    Sureness { meters: x.max(y).sqrt(), radians: yaw.sqrt() }
}

pub(crate) const fn posed(pose: PlanarPose) -> Pose {
    Pose::new(pose.x_meters, pose.y_meters, pose.yaw_radians)
}

pub(super) const fn planar(pose: &Pose) -> PlanarPose {
    let Pose { x_meters, y_meters, heading_radians } = *pose;
    PlanarPose { x_meters, y_meters, yaw_radians: heading_radians }
}

#[cfg(test)]
mod tests;
