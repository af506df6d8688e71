//! The vehicle's body, which follows a path within the limits of its steering.
//!
//! Pure pursuit (Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm", 1992): it steers along the
//! circle to a point of the path a little ahead, no tighter than its turning radius, and accelerates and brakes evenly.
//! Where a path changes gear, it stops, and follows the next part in the other direction.

use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, PI};

use dragnet_lattice::plane::{Pose, bearing_radians, turn_radians, wrapped_radians};
use nalgebra::Vector2;

use super::site::TURNING_RADIUS_METERS;

/// Distance to the target point on the path.
const LOOKAHEAD_METERS: f64 = 3.0;
/// Acceleration, m/s^2; braking is twice as strong.
const ACCELERATION: f64 = 1.0;
/// Period of steering.
const STEP_SECONDS: f64 = 0.05;
/// Distance to its end at which a part of a path counts as driven.
const CLOSE_METERS: f64 = 0.05;

/// The pose of a vehicle, and the path that it follows.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pose: Pose,
    full_speed: f64,
    speed: f64,
    driven_meters: f64,
    /// The remaining parts of the path, each in one gear.
    parts: VecDeque<Part>,
}

/// A part of a path that is driven in one gear.
#[derive(Clone, Debug)]
struct Part {
    gear: Gear,
    points: Vec<Vector2<f64>>,
    /// Index of the last nearest point.
    passed: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Gear {
    Forward,
    Reverse,
}

impl Body {
    pub(super) const fn new(pose: Pose, full_speed: f64) -> Self {
        Self { pose, full_speed, speed: 0.0, driven_meters: 0.0, parts: VecDeque::new() }
    }

    pub(super) const fn pose(&self) -> Pose {
        self.pose
    }

    pub(super) const fn driven_meters(&self) -> f64 {
        self.driven_meters
    }

    /// Follows another path; with an empty one it stops.
    pub(super) fn follow(&mut self, path: &[Pose]) {
        let before = self.parts.front().map(|part| part.gear);
        self.parts = parts(path);
        if self.parts.front().map(|part| part.gear) != before {
            self.speed = 0.0;
        }
    }

    pub(super) fn move_on(&mut self, elapsed_seconds: f64) {
        let mut left = elapsed_seconds;
        while left > 1e-9 {
            let step = left.min(STEP_SECONDS);
            self.step(step);
            left -= step;
        }
    }

    fn step(&mut self, seconds: f64) {
        let Some((gear, point, left_meters)) = self.target() else {
            self.speed = 0.0;
            return;
        };
        // The speed from which it can still stop: v^2 = 2 a s.
        let allowed = (2.0 * ACCELERATION * left_meters).sqrt().min(self.full_speed);
        let change = (allowed - self.speed).clamp(-2.0 * ACCELERATION * seconds, ACCELERATION * seconds);
        self.speed = (self.speed + change).max(0.0);
        let way = self.speed * seconds;
        // In reverse gear everything is as if it drove forward with its back to the front.
        let front = match gear {
            Gear::Forward => 0.0,
            Gear::Reverse => PI,
        };
        let heading = self.pose.heading_radians + front;
        let turn = curvature(self.pose.position_meters(), heading, point) * way;
        let course = heading + turn / 2.0;
        self.pose = Pose::new(
            self.pose.x_meters + way * course.cos(),
            self.pose.y_meters + way * course.sin(),
            wrapped_radians(self.pose.heading_radians + turn),
        );
        self.driven_meters += way;
    }

    /// The gear, the target point, and the remaining length in this gear, meters.
    fn target(&mut self) -> Option<(Gear, Vector2<f64>, f64)> {
        let here = self.pose.position_meters();
        while let Some(part) = self.parts.front_mut() {
            let left_meters = part.advance(here);
            if left_meters > CLOSE_METERS {
                let rest = &part.points[part.passed..];
                let ahead = rest.iter().find(|&point| (point - here).norm() >= LOOKAHEAD_METERS);
                return Some((part.gear, *ahead.or(rest.last())?, left_meters));
            }
            self.parts.pop_front();
            self.speed = 0.0;
        }
        None
    }
}

impl Part {
    /// Updates the vehicle's progress; returns the remaining length, meters. Progress never decreases, and goes no
    /// farther than the first nearest point.
    fn advance(&mut self, here: Vector2<f64>) -> f64 {
        while let [at, next, ..] = &self.points[self.passed..]
            && (next - here).norm() <= (at - here).norm()
        {
            self.passed += 1;
        }
        match &self.points[self.passed..] {
            [before @ .., a, b] => {
                let points = before.iter().chain([a, b]);
                points.clone().zip(points.skip(1)).map(|(a, b)| (b - a).norm()).sum()
            }
            // Past its last point but one: the remainder of the last segment.
            [last] => match self.passed.checked_sub(1).map(|index| self.points[index]) {
                Some(before) if last != &before => (last - here).dot(&(last - before).normalize()).max(0.0),
                _ => 0.0,
            },
            [] => 0.0,
        }
    }
}

/// Splits a path where the gear changes.
fn parts(path: &[Pose]) -> VecDeque<Part> {
    let mut parts: VecDeque<Part> = VecDeque::new();
    for pair in path.windows(2) {
        let (from, to) = (pair[0].position_meters(), pair[1].position_meters());
        if from == to {
            continue;
        }
        let beside = turn_radians(pair[0].heading_radians, bearing_radians(from, to)).abs();
        let gear = if beside > FRAC_PI_2 { Gear::Reverse } else { Gear::Forward };
        match parts.back_mut() {
            Some(part) if part.gear == gear => part.points.push(to),
            _ => parts.push_back(Part { gear, points: vec![from, to], passed: 0 }),
        }
    }
    parts
}

/// Curvature of the circle through a point that the heading touches, 1/m, limited by the turning radius;
/// counter-clockwise is positive.
fn curvature(here: Vector2<f64>, heading_radians: f64, point: Vector2<f64>) -> f64 {
    let range_meters = (point - here).norm().max(0.1);
    let bearing = wrapped_radians(bearing_radians(here, point) - heading_radians);
    let tightest = 1.0 / TURNING_RADIUS_METERS;
    let wanted = 2.0 * bearing.sin() / range_meters;
    // It turns as tightly as possible to points behind it.
    if bearing.abs() > FRAC_PI_2 { tightest.copysign(bearing) } else { wanted.clamp(-tightest, tightest) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The maximum distance of a body from the path that it follows, meters, and its final state.
    fn follow(start: Pose, path: &[Pose]) -> (f64, Body) {
        let mut body = Body::new(start, 2.0);
        body.follow(path);
        let mut farthest = 0.0_f64;
        for _ in 0..200 {
            body.move_on(0.2);
            let beside = |pose: &Pose| (pose.position_meters() - body.pose().position_meters()).norm();
            farthest = farthest.max(path.iter().map(beside).fold(f64::INFINITY, f64::min));
        }
        (farthest, body)
    }

    #[test]
    fn a_body_follows_a_bend_and_stops_at_its_end() {
        let straight = (0..=20).map(|step| Pose::new(f64::from(step), 0.0, 0.0));
        let bend = (1..=8).map(|step| {
            let angle = f64::from(step) * FRAC_PI_2 / 8.0;
            Pose::new(20.0 + 5.0 * angle.sin(), 5.0 - 5.0 * angle.cos(), angle)
        });
        let up = (1..=10).map(|step| Pose::new(25.0, 5.0 + f64::from(step), FRAC_PI_2));
        let path: Vec<Pose> = straight.chain(bend).chain(up).collect();
        let (farthest, mut body) = follow(Pose::new(0.0, 0.5, 0.2), &path);
        assert!(farthest < 1.2, "{farthest}");
        let end = body.pose();
        assert!((end.x_meters - 25.0).hypot(end.y_meters - 15.0) < 0.7, "{end:?}");
        let driven = body.driven_meters();
        body.move_on(5.0);
        assert!((body.driven_meters() - driven).abs() < 1e-9, "it stands");
    }

    #[test]
    fn a_body_backs_out_and_drives_on() {
        let back = (0..=10).map(|step| Pose::new(-f64::from(step), 0.0, 0.0));
        let on = (1..=20).map(|step| Pose::new(f64::from(step) - 10.0, 0.0, 0.0));
        let path: Vec<Pose> = back.chain(on).collect();
        let (farthest, body) = follow(Pose::new(0.0, 0.3, 0.1), &path);
        assert!(farthest < 1.0, "{farthest}");
        assert!((body.pose().x_meters - 10.0).abs() < 0.5 && body.driven_meters() > 29.0, "{body:?}");
        assert!(body.pose().heading_radians.abs() < 0.2, "it never turned around");
    }
}
