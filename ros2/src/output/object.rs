//! Objects in space: expected position, covariance and bounding box.

use super::pose;
use crate::input::PlanarPose;
use crate::wire::robot::Covariance;
use crate::wire::standard::{Header, Vector3};
use crate::wire::vision::{BoundingBox3D, Detection3D, ObjectHypothesis, ObjectHypothesisWithPose};

/// An expected position on the plane, with its covariance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanarEstimate {
    /// The mean, meters.
    pub x_meters: f64,
    /// The mean, meters.
    pub y_meters: f64,
    /// Covariance of x and y, square meters, row-major, shape `[2, 2]`: symmetric, with a diagonal of at least 0.
    pub covariance_square_meters: [[f64; 2]; 2],
}

/// An object in space: a declared one, or a track of one.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectEstimate {
    /// Constant over time.
    pub id: String,
    /// The class of object that is searched for.
    pub class: String,
    /// Its expected position.
    pub place: PlanarEstimate,
    /// Center and direction of its bounding box.
    pub box_center: PlanarPose,
    /// Edges of the box along its own x and y, meters.
    pub box_edges_meters: [f64; 2],
    /// Its probability, `0..=1`.
    pub probability: f64,
}

impl PlanarEstimate {
    /// Uniformly distributed in a square: the variance of either coordinate is a twelfth of the squared edge.
    #[must_use]
    pub fn in_square(x_meters: f64, y_meters: f64, edge_meters: f64) -> Self {
        let variance = edge_meters.powi(2) / 12.0;
        Self { x_meters, y_meters, covariance_square_meters: [[variance, 0.0], [0.0, variance]] }
    }

    /// Standard deviations along the principal axes, meters, the larger one first.
    #[must_use]
    pub fn std_meters(&self) -> [f64; 2] {
        let [[x, xy], [_, y]] = self.covariance_square_meters;
        let (middle, reach) = (f64::midpoint(x, y), ((x - y) / 2.0).hypot(xy));
        [middle + reach, middle - reach].map(|variance| variance.max(0.0).sqrt())
    }

    /// Direction of the axis with the larger standard deviation, radians counter-clockwise from x.
    #[must_use]
    pub fn axis_radians(&self) -> f64 {
        let [[x, xy], [_, y]] = self.covariance_square_meters;
        (2.0 * xy).atan2(x - y) / 2.0
    }
}

/// As `vision_msgs`: the estimate is that of the hypothesis, and the box is the box. Its height is left 0.
pub(super) fn detection(object: ObjectEstimate, header: &Header) -> Detection3D {
    let PlanarEstimate { x_meters, y_meters, covariance_square_meters: [[x, xy], [yx, y]] } = object.place;
    let mut result = ObjectHypothesisWithPose {
        hypothesis: ObjectHypothesis { class_id: object.class, score: object.probability },
        ..ObjectHypothesisWithPose::default()
    };
    let mut covariance = Covariance::default();
    ([covariance[0][0], covariance[0][1]], [covariance[1][0], covariance[1][1]]) = ([x, xy], [yx, y]);
    result.pose.pose = pose(PlanarPose { x_meters, y_meters, yaw_radians: 0.0 });
    result.pose.covariance = covariance;
    let [along, across] = object.box_edges_meters;
    let size = Vector3 { x: along, y: across, z: along.max(across) };
    let bbox = BoundingBox3D { center: pose(object.box_center), size };
    Detection3D { header: header.clone(), results: vec![result], bbox, id: object.id }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    #[test]
    fn an_estimate_has_the_deviations_of_its_principal_axes() {
        // 3 m to the north-east, 1 m across: (9 + 1) / 2 and (9 - 1) / 2.
        let estimate = PlanarEstimate {
            covariance_square_meters: [[5.0, 4.0], [4.0, 5.0]],
            ..PlanarEstimate::default()
        };
        let [most, least] = estimate.std_meters();
        assert!((most - 3.0).abs() < 1e-12 && (least - 1.0).abs() < 1e-12, "{most} {least}");
        assert!((estimate.axis_radians() - FRAC_PI_4).abs() < 1e-12);
        let anywhere = PlanarEstimate::in_square(1.0, 2.0, 12.0);
        assert!(anywhere.std_meters().iter().all(|std_meters| (std_meters.powi(2) - 12.0).abs() < 1e-12));
    }
}
