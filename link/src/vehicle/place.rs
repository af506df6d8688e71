//! Where a vehicle is on the search's map, from what its own network says.
//!
//! Three frames meet here: that of the search, whose origin is the map's south-western corner; that of the network's
//! maps and poses, in which the corner is somewhere ([`MapOrigin`]); and that of odometry, which is smooth and drifts.
//! A pose on the map, or a fix on the earth, tells where odometry's frame lies; in between odometry tells where the
//! vehicle is, so that it is known as often as odometry comes.

use dragnet_proto::map_file::{Georeference, MapOrigin};
use dragnet_proto::ros::input::{Fix, Odometry, PlanarCovariance, PlanarPose, PoseEstimate};
use dragnet_vehicle::plane::Pose;

use crate::ros::settings::Localization;

/// Axes that are less than this apart are the same, radians.
pub(super) const SQUARE_RADIANS: f64 = 1e-3;

/// Where a vehicle was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Located {
    pub(super) stamp_unix_ns: i64,
    /// On the search's map.
    pub(super) pose: Pose,
    pub(super) deviation_meters: f64,
    pub(super) heading_deviation_radians: f64,
}

/// How sure a place is: standard deviations, 0 if nobody says.
#[derive(Clone, Copy, Debug, Default)]
struct Sureness {
    meters: f64,
    radians: f64,
}

/// What is known of the three frames.
#[derive(Clone, Debug)]
pub(super) struct Places {
    source: Localization,
    /// The search's map in the network's frame.
    map: Pose,
    earth: Option<Georeference>,
    /// The last of odometry, in its own frame.
    odometry: Option<Pose>,
    /// Where odometry's frame lies on the search's map.
    drift: Option<(Pose, Sureness)>,
}

impl Places {
    pub(super) fn new(source: Localization, map: MapOrigin, earth: Option<Georeference>) -> Self {
        let map = Pose::new(map.x_meters, map.y_meters, map.yaw_radians);
        Self { source, map, earth, odometry: None, drift: None }
    }

    /// A pose of the network's frame on the search's map.
    pub(super) fn on_map(&self, pose: &Pose) -> Pose {
        pose.seen_from(&self.map)
    }

    /// A pose on the search's map in the network's frame.
    pub(super) fn in_frame(&self, pose: &Pose) -> Pose {
        self.map.of_part(pose)
    }

    pub(super) fn odometry(&mut self, odometry: &Odometry) -> Option<Located> {
        let place = &odometry.place;
        let here = posed(place.pose);
        self.odometry = Some(here);
        if self.source == Localization::Odometry {
            return Some(located(place.stamp_unix_ns, self.on_map(&here), sureness(place.covariance)));
        }
        let (frame, sureness) = self.drift?;
        Some(located(place.stamp_unix_ns, frame.of_part(&here), sureness))
    }

    pub(super) fn pose(&mut self, estimate: &PoseEstimate) -> Option<Located> {
        if self.source != Localization::Pose {
            return None;
        }
        let pose = self.on_map(&posed(estimate.pose));
        self.anchor(estimate.stamp_unix_ns, pose, sureness(estimate.covariance))
    }

    /// A fix says nothing of a heading: that is odometry's, whose frame then is turned as the earth is, x to the east.
    pub(super) fn fix(&mut self, fix: &Fix) -> Option<Located> {
        if self.source != Localization::Fix {
            return None;
        }
        let (east, north) = fix.meters(self.earth.as_ref()?);
        let heading_radians = self.odometry?.heading_radians;
        let [[east_variance, _], [_, north_variance]] = fix.covariance_square_meters.unwrap_or_default();
        let sureness = Sureness { meters: east_variance.max(north_variance).sqrt(), radians: 0.0 };
        self.anchor(fix.stamp_unix_ns, Pose::new(east, north, heading_radians), sureness)
    }

    /// Where odometry is, if there is any, is where the vehicle is; else it is known as often as this.
    fn anchor(&mut self, stamp_unix_ns: i64, pose: Pose, sureness: Sureness) -> Option<Located> {
        let Some(odometry) = self.odometry else { return Some(located(stamp_unix_ns, pose, sureness)) };
        let origin_from_here = Pose::default().seen_from(&odometry);
        self.drift = Some((pose.of_part(&origin_from_here), sureness));
        None
    }
}

fn located(stamp_unix_ns: i64, pose: Pose, sureness: Sureness) -> Located {
    let Sureness { meters, radians } = sureness;
    Located { stamp_unix_ns, pose, deviation_meters: meters, heading_deviation_radians: radians }
}

fn sureness(covariance: Option<PlanarCovariance>) -> Sureness {
    let [[x, ..], [_, y, _], [.., yaw]] = covariance.unwrap_or_default();
    Sureness { meters: x.max(y).sqrt(), radians: yaw.sqrt() }
}

pub(super) const fn posed(pose: PlanarPose) -> Pose {
    Pose::new(pose.x_meters, pose.y_meters, pose.yaw_radians)
}

pub(super) const fn planar(pose: &Pose) -> PlanarPose {
    let Pose { x_meters, y_meters, heading_radians } = *pose;
    PlanarPose { x_meters, y_meters, yaw_radians: heading_radians }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use dragnet_proto::map_file::GeoPoint;
    use dragnet_proto::ros::input::Velocity;

    use super::*;

    /// The search's map lies at (100, 50) in the network's frame and is turned to the left.
    const MAP: MapOrigin = MapOrigin { x_meters: 100.0, y_meters: 50.0, yaw_radians: FRAC_PI_2 };

    fn estimate(x_meters: f64, y_meters: f64, yaw_radians: f64) -> PoseEstimate {
        PoseEstimate {
            stamp_unix_ns: 7,
            frame: "map".to_owned(),
            pose: PlanarPose { x_meters, y_meters, yaw_radians },
            covariance: Some([[0.25, 0.0, 0.0], [0.0, 0.04, 0.0], [0.0, 0.0, 0.01]]),
        }
    }

    fn odometry(x_meters: f64, y_meters: f64, yaw_radians: f64) -> Odometry {
        let place = PoseEstimate { stamp_unix_ns: 8, ..estimate(x_meters, y_meters, yaw_radians) };
        Odometry { place, robot_frame: "base_link".to_owned(), velocity: Velocity::default() }
    }

    fn check(found: Option<Located>, stamp: i64, expected: [f64; 3]) {
        let Located { stamp_unix_ns, pose, .. } = found.unwrap();
        let difference = [
            pose.x_meters - expected[0],
            pose.y_meters - expected[1],
            dragnet_vehicle::plane::turn_radians(pose.heading_radians, expected[2]),
        ];
        assert!(difference.iter().all(|part| part.abs() < 1e-9), "{pose:?}, not {expected:?}");
        assert_eq!(stamp_unix_ns, stamp);
    }

    #[test]
    fn a_pose_on_the_networks_map_is_one_on_the_searchs() {
        let mut places = Places::new(Localization::Pose, MAP, None);
        let found = places.pose(&estimate(90.0, 53.0, FRAC_PI_2));
        check(found, 7, [3.0, 10.0, 0.0]);
        let Located { pose, deviation_meters, heading_deviation_radians, .. } = found.unwrap();
        assert!((deviation_meters - 0.5).abs() < 1e-9 && (heading_deviation_radians - 0.1).abs() < 1e-9);
        let back = places.in_frame(&pose);
        assert!((back.x_meters - 90.0).abs() < 1e-9 && (back.y_meters - 53.0).abs() < 1e-9);
    }

    #[test]
    fn between_poses_odometry_goes_on_from_the_last() {
        let mut places = Places::new(Localization::Pose, MapOrigin::default(), None);
        assert_eq!(places.odometry(&odometry(5.0, 5.0, 0.0)), None, "nobody knows where that is");
        assert_eq!(places.pose(&estimate(20.0, 30.0, FRAC_PI_2)), None, "odometry tells it next");
        check(places.odometry(&odometry(5.0, 5.0, 0.0)), 8, [20.0, 30.0, FRAC_PI_2]);
        // Two metres ahead, a metre to the left, turned back.
        check(places.odometry(&odometry(7.0, 6.0, -FRAC_PI_2)), 8, [19.0, 32.0, 0.0]);
    }

    #[test]
    fn odometry_alone_will_do_where_it_is_corrected_already() {
        let mut places = Places::new(Localization::Odometry, MapOrigin::default(), None);
        assert_eq!(places.pose(&estimate(1.0, 1.0, 0.0)), None);
        check(places.odometry(&odometry(4.0, 3.0, 1.0)), 8, [4.0, 3.0, 1.0]);
    }

    #[test]
    fn a_fix_gives_the_place_and_odometry_the_heading() {
        let corner = GeoPoint { longitude_degrees: -79.95, latitude_degrees: 40.44 };
        let earth = Georeference::new(corner, 40.44);
        let mut places = Places::new(Localization::Fix, MapOrigin::default(), Some(earth));
        let fix = Fix {
            stamp_unix_ns: 7,
            frame: "gps".to_owned(),
            point: GeoPoint { latitude_degrees: 40.441, ..corner },
            altitude_meters: None,
            covariance_square_meters: Some([[4.0, 0.0], [0.0, 9.0]]),
        };
        assert_eq!(places.fix(&fix), None, "no heading is known");
        assert_eq!(places.odometry(&odometry(0.0, 0.0, 0.5)), None);
        assert_eq!(places.fix(&fix), None);
        let found = places.odometry(&odometry(1.0, 0.0, 0.5));
        let north = earth.meters(fix.point).1;
        assert!((north - 111.0).abs() < 1.0);
        check(found, 8, [1.0, north, 0.5]);
        assert!((found.unwrap().deviation_meters - 3.0).abs() < 1e-9);
    }
}
