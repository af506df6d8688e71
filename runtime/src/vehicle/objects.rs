//! Objects for the vehicle's network: declared ones and tracks, each with its position in meters and covariance.

use std::collections::BTreeSet;

use dragnet_lattice::plane::Pose;
use dragnet_ros2::input::PlanarPose;
use dragnet_ros2::output::{ObjectEstimate, PlanarEstimate};
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::object_position::ObjectPositions;
use dragnet_vehicle::tracker::track::{Standing, Track};
use nalgebra::{Matrix2, Vector2};

use super::Vehicle;

/// The class of all objects: a mission searches for one.
const CLASS: &str = "object";
/// Standard deviations from a track to the sides of its box.
const BOX_STD: f64 = 2.0;

impl Vehicle {
    /// Cells whose probability reaches the detection threshold.
    pub(crate) fn found<'a>(&'a self, belief: &'a Belief) -> impl Iterator<Item = Cell> + 'a {
        self.terrain.searched_cells().filter(|&cell| belief.is_found(cell, self.detection_threshold))
    }

    /// The position of the object that is declared in a cell, in the frame of the vehicle's network: by this robot's
    /// cameras, by those of teammates, or uniform in the cell if no robot has located it.
    pub(crate) fn place_of(&self, cell: Cell, positions: &ObjectPositions) -> PlanarEstimate {
        if let Some(find) = self.pilot.find(cell) {
            return self.estimate(find.position_meters, &find.position_covariance);
        }
        if let Some(position) = positions.of(cell) {
            let (east, north) = position.meters();
            let [xx, xy, yy] = position.covariance_square_meters().map(f64::from);
            return self.estimate(Vector2::new(east, north), &Matrix2::new(xx, xy, xy, yy));
        }
        let middle = self.cell_box(cell);
        PlanarEstimate::in_square(middle.x_meters, middle.y_meters, self.terrain.cell_meters())
    }

    /// The declared objects, each in the box of its cell.
    pub(super) fn objects(
        &self,
        belief: &Belief,
        positions: &ObjectPositions,
        declared: &BTreeSet<Cell>,
    ) -> Vec<ObjectEstimate> {
        let object = |&cell: &Cell| ObjectEstimate {
            id: cell.number().to_string(),
            class: CLASS.to_owned(),
            place: self.place_of(cell, positions),
            box_center: self.cell_box(cell),
            box_edges_meters: [self.terrain.cell_meters(); 2],
            probability: belief.probability(cell),
        };
        declared.iter().map(object).collect()
    }

    /// The confirmed tracks, each in a box along the axes of its covariance.
    pub(super) fn tracks(&self) -> Vec<ObjectEstimate> {
        let confirmed = self.pilot.tracks().iter().filter(|track| track.standing() == Standing::Confirmed);
        confirmed.map(|track| self.track(track)).collect()
    }

    fn track(&self, track: &Track) -> ObjectEstimate {
        let place = self.estimate(track.position_meters(), &track.position_covariance());
        let PlanarEstimate { x_meters, y_meters, .. } = place;
        ObjectEstimate {
            id: track.id().0.to_string(),
            class: CLASS.to_owned(),
            place,
            box_center: PlanarPose { x_meters, y_meters, yaw_radians: place.axis_radians() },
            box_edges_meters: place.std_meters().map(|std_meters| 2.0 * BOX_STD * std_meters),
            probability: 1.0 / (1.0 + (-track.score_nats()).exp()),
        }
    }

    /// An estimate on the search's map, converted to the frame of the vehicle's network.
    fn estimate(&self, position_meters: Vector2<f64>, covariance: &Matrix2<f64>) -> PlanarEstimate {
        let PlanarPose { x_meters, y_meters, .. } =
            self.in_frame(&Pose::new(position_meters.x, position_meters.y, 0.0));
        let turned = self.places.map().covariance_of_part(covariance);
        let covariance_square_meters = [[turned.m11, turned.m12], [turned.m21, turned.m22]];
        PlanarEstimate { x_meters, y_meters, covariance_square_meters }
    }

    /// The center of a cell, with the rotation of the map.
    fn cell_box(&self, cell: Cell) -> PlanarPose {
        let (x_meters, y_meters) = self.terrain.center_meters(cell);
        self.in_frame(&Pose::new(x_meters, y_meters, 0.0))
    }
}
