//! A vehicle's pose on the search's map, from the messages of its own network.
//!
//! There are three frames: that of the search, with its origin at the map's south-western corner; that of the network's
//! maps and poses, in which the corner has a pose ([`MapOrigin`]); and that of odometry, which is smooth and drifts. A
//! pose on the map, or a GNSS fix, is a correction: it gives the pose of odometry's frame at its time. In between
//! odometry gives the vehicle's pose, so that it is known at odometry's rate.
//!
//! Localization such as AMCL's publishes only when the vehicle moves. So its silence means nothing while the vehicle
//! stands, and after a configured time and distance it means that the vehicle's pose is unknown.

mod trail;

use std::collections::VecDeque;
use std::time::Duration;

use dragnet_lattice::plane::Pose;
use dragnet_ros2::input::{Fix, Odometry, PlanarCovariance, PlanarPose, PoseEstimate};
use dragnet_scenario::map_file::{Georeference, MapOrigin};

use crate::ros::settings::{Localization, PoseStd, Uncorrected};
use trail::Trail;

/// Maximum number of corrections that wait for odometry of their time.
const MOST_WAITING: usize = 64;

/// Age from which a first pose was latched before this robot started: where the vehicle is now, odometry says.
const LATCHED: Duration = Duration::from_secs(1);

/// A pose of a vehicle with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Located {
    /// Nanoseconds of mission time.
    pub(super) time_ns: u64,
    /// On the search's map.
    pub(super) pose: Pose,
    pub(super) deviation_meters: f64,
    pub(super) heading_deviation_radians: f64,
}

/// The arrival time and the stamp of a message, both nanoseconds of mission time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Moment {
    pub(super) received_ns: u64,
    /// No earlier than the mission's start.
    pub(super) time_ns: u64,
    /// Its age on arrival, even if it is older than the mission.
    pub(super) age: Duration,
}

/// A pose by localization.
#[derive(Clone, Copy, Debug)]
struct Correction {
    at: Moment,
    x_meters: f64,
    y_meters: f64,
    /// A fix has no heading: that is odometry's, whose frame then has its x axis to the east.
    heading_radians: Option<f64>,
    std: PoseStd,
}

/// The pose of odometry's frame on the search's map.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    map_from_odometry: Pose,
    std: PoseStd,
    /// When its correction arrived.
    received_ns: u64,
    /// The vehicle's pose then, in odometry's frame.
    odometry: Pose,
}

/// The state of the three frames.
#[derive(Clone, Debug)]
pub(super) struct Places {
    source: Localization,
    limits: Uncorrected,
    /// Where a message gives none.
    unstated: PoseStd,
    /// The pose of the search's map in the network's frame.
    map: Pose,
    earth: Option<Georeference>,
    /// Odometry, in its own frame.
    trail: Trail,
    /// Corrections of times without odometry yet.
    waiting: VecDeque<Correction>,
    anchor: Option<Anchor>,
    /// Why the vehicle's pose is unknown, if not for lack of odometry.
    missing: Option<String>,
}

impl Places {
    pub(super) fn new(
        source: Localization,
        limits: Uncorrected,
        unstated: PoseStd,
        map: MapOrigin,
        earth: Option<Georeference>,
    ) -> Self {
        let map = Pose::new(map.x_meters, map.y_meters, map.yaw_radians);
        let missing =
            (source != Localization::Odometry).then(|| "no valid message has arrived yet".to_owned());
        let (trail, waiting) = (Trail::default(), VecDeque::new());
        Self { source, limits, unstated, map, earth, trail, waiting, anchor: None, missing }
    }

    /// Where positions come from.
    pub(super) const fn source(&self) -> Localization {
        self.source
    }

    /// The pose of the search's map in the network's frame.
    pub(super) const fn map(&self) -> &Pose {
        &self.map
    }

    /// Converts a pose of the network's frame to the search's map.
    fn on_map(&self, pose: &Pose) -> Pose {
        pose.seen_from(&self.map)
    }

    /// Converts a pose on the search's map to the network's frame.
    pub(super) fn in_frame(&self, pose: &Pose) -> Pose {
        self.map.of_part(pose)
    }

    /// Why the vehicle's pose is unknown, if localization is the reason.
    pub(super) fn missing(&self) -> Option<&str> {
        self.missing.as_deref()
    }

    pub(super) fn odometry(&mut self, at: Moment, odometry: &Odometry) -> Option<Located> {
        let here = posed(odometry.place.pose);
        if self.source == Localization::Tf {
            return None;
        }
        if self.source == Localization::Odometry {
            return Some(located(at, self.on_map(&here), self.std(odometry.place.covariance)));
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
        Some(located(at, anchor.map_from_odometry.of_part(&here), anchor.std))
    }

    /// A pose by transforms, in the network's frame; it has no covariance.
    pub(super) fn transformed(&self, at: Moment, pose: &Pose) -> Located {
        located(at, self.on_map(pose), self.unstated)
    }

    /// Adds a pose on the map.
    ///
    /// # Errors
    /// If it is too old to give the vehicle's position.
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
            std: self.std(estimate.covariance),
        })
    }

    /// Adds a GNSS fix.
    ///
    /// # Errors
    /// If it is too old to give the vehicle's position.
    pub(super) fn fix(&mut self, at: Moment, fix: &Fix) -> Result<Option<Located>, String> {
        let Some(earth) = self.earth.as_ref().filter(|_| self.source == Localization::Fix) else {
            return Ok(None);
        };
        let (x_meters, y_meters) = fix.meters(earth);
        let [[east, _], [_, north]] = fix.covariance_square_meters.unwrap_or_default();
        let std = self.std(Some([[east, 0.0, 0.0], [0.0, north, 0.0], [0.0; 3]]));
        self.correct(Correction { at, x_meters, y_meters, heading_radians: None, std })
    }

    /// With odometry the vehicle's pose is known at odometry's rate; without, at that of corrections.
    fn correct(&mut self, correction: Correction) -> Result<Option<Located>, String> {
        self.check_age(&correction)?;
        if self.trail.latest_ns().is_some_and(|latest_ns| latest_ns >= correction.at.time_ns) {
            self.anchor(&correction);
            return Ok(None);
        }
        let is_latched = self.waiting.is_empty() && correction.at.age > LATCHED;
        if self.waiting.len() == MOST_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(correction);
        let is_alone = self.trail.latest_ns().is_none() && !is_latched;
        let heading_radians = correction.heading_radians.filter(|_| is_alone);
        Ok(heading_radians.map(|heading_radians| {
            self.missing = None;
            let Correction { at, x_meters, y_meters, std, .. } = correction;
            located(at, Pose::new(x_meters, y_meters, heading_radians), std)
        }))
    }

    /// An old correction is as good as a new one if the vehicle has stood since. A latched one from before this robot's
    /// start is the only one, if the vehicle stands.
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
        let &Correction { at, x_meters, y_meters, heading_radians, std } = correction;
        let Some(odometry) = self.trail.at(at.time_ns) else { return };
        let pose = Pose::new(x_meters, y_meters, heading_radians.unwrap_or(odometry.heading_radians));
        let map_from_odometry = pose.of_part(&Pose::default().seen_from(&odometry));
        self.anchor = Some(Anchor { map_from_odometry, std, received_ns: at.received_ns, odometry });
        self.missing = None;
    }

    /// What a message states, and what the settings do where it states nothing: no pose is exact.
    fn std(&self, covariance: Option<PlanarCovariance>) -> PoseStd {
        let [[x, ..], [_, y, _], [.., yaw]] = covariance.unwrap_or_default();
        let or = |variance: f64, unstated: f64| if variance > 0.0 { variance.sqrt() } else { unstated };
        PoseStd { meters: or(x.max(y), self.unstated.meters), radians: or(yaw, self.unstated.radians) }
    }

    /// Checks whether the vehicle has moved too far on odometry alone. Once it has, only a correction helps.
    fn watch(&mut self, at: Moment, here: &Pose, anchor: &Anchor) {
        let silence_ns = at.received_ns.saturating_sub(anchor.received_ns);
        if self.missing.is_none()
            && silence_ns > self.limits.timeout_ns
            && self.limits.is_left(&anchor.odometry, here)
        {
            let (meters, radians) = trail::apart(&anchor.odometry, here);
            self.missing = Some(format!(
                "no valid message has arrived for {:.1} s, while the vehicle moved {meters:.1} m and turned {:.0} degrees",
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

fn located(at: Moment, pose: Pose, std: PoseStd) -> Located {
    let PoseStd { meters, radians } = std;
    Located { time_ns: at.time_ns, pose, deviation_meters: meters, heading_deviation_radians: radians }
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
