//! Maps, beliefs, poses and paths as standard messages for viewers.
//!
//! Frame `map`: meters, that of the map's file, in which the map's south-western corner has the pose [`MapOrigin`].
//! Frame `robot_<number>`: a robot, x along the rows of the map.

use dragnet_scenario::map_file::{GeoPoint, MapOrigin};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::RobotId;
use dragnet_search::terrain::Terrain;

use crate::wire::markers::{ColorRgba, Marker};
use crate::wire::robot::{CompressedImage, NavSatFix};
use crate::wire::standard::{
    Grid, Header, MapMetaData, OccupancyGrid, PackedElementField, Path, Point, Pose, PoseStamped, Quaternion,
    TFMessage, Time, Transform, TransformStamped, Vector2, Vector3,
};

/// The frame of all messages.
pub const MAP_FRAME: &str = "map";

/// Bytes of one `f32`.
const CELL_BYTES: u32 = 4;

/// Of finds, as on the live page.
const OBJECT_COLOR: ColorRgba = ColorRgba { r: 0.76, g: 0.25, b: 0.05, a: 0.9 };

/// Converts one mission to messages for viewers.
#[derive(Clone, Copy, Debug)]
pub struct Viewer<'a> {
    terrain: &'a Terrain,
    origin: MapOrigin,
    start_unix_ns: i64,
}

impl<'a> Viewer<'a> {
    /// A viewer of a mission on a map with this origin, which started at a Unix time, nanoseconds.
    #[must_use]
    pub const fn new(terrain: &'a Terrain, origin: MapOrigin, start_unix_ns: i64) -> Self {
        Self { terrain, origin, start_unix_ns }
    }

    /// Mission time as Unix time. Clamped to the years 1901 to 2038, the range of the message.
    #[must_use]
    pub fn stamp(&self, time: MissionTime) -> Time {
        Time::at_unix_ns(i128::from(self.start_unix_ns) + i128::from(time.0))
    }

    fn header(&self, time: MissionTime) -> Header {
        Header { stamp: self.stamp(time), frame_id: MAP_FRAME.into() }
    }

    /// Pose of the map's south-western corner.
    fn corner(&self) -> Pose {
        self.at(self.origin.point((0.0, 0.0)))
    }

    /// A pose along the map's rows.
    fn at(&self, (x, y): (f64, f64)) -> Pose {
        let (z, w) = (self.origin.yaw_radians / 2.0).sin_cos();
        Pose { position: Point { x, y, z: 0.0 }, orientation: Quaternion { x: 0.0, y: 0.0, z, w } }
    }

    /// The ground: 100 where not traversable, 0 where traversable and searched, -1 where nothing is searched.
    #[must_use]
    pub fn terrain(&self, time: MissionTime) -> OccupancyGrid {
        self.occupancy(time, |cell| {
            match (self.terrain.is_traversable(cell), self.terrain.is_searched(cell)) {
                (false, _) => 100,
                (true, true) => 0,
                (true, false) => -1,
            }
        })
    }

    /// A belief in whole percent, 0 to 100; -1 where nothing is searched. Takes [`Belief::probabilities`].
    ///
    /// [`Belief::probabilities`]: dragnet_search::belief::Belief::probabilities
    #[must_use]
    pub fn belief(&self, probabilities: &[f64], time: MissionTime) -> OccupancyGrid {
        self.occupancy(time, |cell| {
            if self.terrain.is_searched(cell) { percent(probabilities[cell.index()]) } else { -1 }
        })
    }

    #[expect(clippy::cast_possible_truncation, reason = "the message has single precision")]
    fn occupancy(&self, time: MissionTime, value: impl Fn(Cell) -> i8) -> OccupancyGrid {
        let grid = self.terrain.grid();
        OccupancyGrid {
            header: self.header(time),
            info: MapMetaData {
                map_load_time: self.stamp(MissionTime::START),
                resolution: self.terrain.cell_meters() as f32,
                width: grid.columns(),
                height: grid.rows(),
                origin: self.corner(),
            },
            data: grid.cells().map(value).collect(),
        }
    }

    /// A belief as probabilities: one `f32` per cell, field `probability`; 0 where nothing is searched.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "viewers draw single precision")]
    pub fn probability(&self, probabilities: &[f64], time: MissionTime) -> Grid {
        let (grid, edge) = (self.terrain.grid(), self.terrain.cell_meters());
        let floats: Vec<[u8; 4]> = probabilities.iter().map(|&it| (it as f32).to_le_bytes()).collect();
        Grid {
            timestamp: self.stamp(time),
            frame_id: MAP_FRAME.into(),
            pose: self.corner(),
            column_count: grid.columns(),
            cell_size: Vector2 { x: edge, y: edge },
            row_stride: grid.columns() * CELL_BYTES,
            cell_stride: CELL_BYTES,
            fields: vec![PackedElementField {
                name: "probability".into(),
                offset: 0,
                r#type: PackedElementField::FLOAT32,
            }],
            data: floats.into_flattened(),
        }
    }

    /// The center of a cell.
    #[must_use]
    pub fn pose(&self, cell: Cell, time: MissionTime) -> PoseStamped {
        PoseStamped { header: self.header(time), pose: self.at(self.origin.center(self.terrain, cell)) }
    }

    /// The centers of cells, in order, each with the time at which the robot is expected there.
    #[must_use]
    pub fn path(&self, cells: &[(Cell, MissionTime)], time: MissionTime) -> Path {
        let poses = cells.iter().map(|&(cell, expected)| self.pose(cell, expected)).collect();
        Path { header: self.header(time), poses }
    }

    /// Where a robot is on the earth.
    #[must_use]
    pub fn fix(&self, robot: RobotId, place: GeoPoint, time: MissionTime) -> NavSatFix {
        NavSatFix {
            header: Header { stamp: self.stamp(time), frame_id: robot_frame(robot) },
            latitude: place.latitude_degrees,
            longitude: place.longitude_degrees,
            altitude: f64::NAN,
            ..NavSatFix::default()
        }
    }

    /// A picture that a robot took.
    #[must_use]
    pub fn jpeg(&self, robot: RobotId, file: &[u8], time: MissionTime) -> CompressedImage {
        CompressedImage {
            header: Header { stamp: self.stamp(time), frame_id: robot_frame(robot) },
            format: "jpeg".into(),
            data: file.to_vec(),
        }
    }

    /// A ball of a cell's size for the object of each of these cells, at its position if that is known, in place of those of the
    /// marker before.
    #[must_use]
    pub fn marker<'o>(
        &self,
        objects: impl IntoIterator<Item = (Cell, Option<&'o ObjectPosition>)>,
        time: MissionTime,
    ) -> Marker {
        let edge = self.terrain.cell_meters();
        let point = |(cell, position): (Cell, Option<&ObjectPosition>)| {
            let meters = position.map_or_else(|| self.terrain.center_meters(cell), ObjectPosition::meters);
            let (x, y) = self.origin.point(meters);
            Point { x, y, z: edge / 2.0 }
        };
        let points: Vec<Point> = objects.into_iter().map(point).collect();
        Marker {
            header: self.header(time),
            ns: "objects".into(),
            r#type: Marker::SPHERE_LIST,
            action: if points.is_empty() { Marker::DELETE } else { Marker::ADD },
            scale: Vector3 { x: edge, y: edge, z: edge },
            color: OBJECT_COLOR,
            points,
            ..Marker::default()
        }
    }

    /// The pose of a robot's own frame on the map.
    #[must_use]
    pub fn map_from_robot(&self, robot: RobotId, cell: Cell, time: MissionTime) -> TFMessage {
        let Pose { position: Point { x, y, z }, orientation: rotation } =
            self.at(self.origin.center(self.terrain, cell));
        let translation = Vector3 { x, y, z };
        TFMessage {
            transforms: vec![TransformStamped {
                header: self.header(time),
                child_frame_id: robot_frame(robot),
                transform: Transform { translation, rotation },
            }],
        }
    }
}

/// For a pose without pitch and roll, as maps have.
impl From<Pose> for MapOrigin {
    fn from(pose: Pose) -> Self {
        let Pose { position, orientation } = pose;
        let yaw_radians = 2.0 * orientation.z.atan2(orientation.w);
        Self { x_meters: position.x, y_meters: position.y, yaw_radians }
    }
}

/// Name of a robot's own frame.
#[must_use]
pub fn robot_frame(robot: RobotId) -> String {
    format!("robot_{robot}")
}

#[expect(clippy::cast_possible_truncation, reason = "0 to 100")]
fn percent(probability: f64) -> i8 {
    (probability * 100.0).round() as i8
}

#[cfg(test)]
mod tests {
    use dragnet_search::belief::Belief;
    use dragnet_search::evidence::Reading;

    use super::*;

    // From the south: open, passage; out of reach, blocked.
    fn terrain() -> Terrain {
        Terrain::from_ascii("~#\n.,", 30.0).unwrap()
    }

    #[test]
    fn objects_are_balls_on_the_ground_in_the_frame_of_the_maps_file() {
        let terrain = terrain();
        let origin = MapOrigin { x_meters: 100.0, y_meters: -50.0, yaw_radians: 0.0 };
        let viewer = Viewer::new(&terrain, origin, 0);
        let [cell, other] = [1, 2].map(|number| terrain.grid().cell_numbered(number).unwrap());
        let position = ObjectPosition::new(other, [7.0, 41.0], [1.0, 0.0, 1.0]).unwrap();
        let marker = viewer.marker([(cell, None), (other, Some(&position))], MissionTime(5));
        assert_eq!((marker.r#type, marker.action), (Marker::SPHERE_LIST, Marker::ADD));
        assert_eq!(
            marker.points,
            [Point { x: 145.0, y: -35.0, z: 15.0 }, Point { x: 107.0, y: -9.0, z: 15.0 }]
        );
        assert_eq!((marker.scale.x, marker.header.frame_id.as_str()), (30.0, MAP_FRAME));
        assert_eq!(viewer.marker([], MissionTime(6)).action, Marker::DELETE, "none is left");
    }

    #[test]
    fn a_map_shows_blocked_free_and_unsearched_ground_from_the_south() {
        let terrain = terrain();
        let map =
            Viewer::new(&terrain, MapOrigin::default(), 1_500_000_000).terrain(MissionTime(600_000_000));
        assert_eq!(map.data, [0, -1, 100, 100]);
        assert_eq!((map.info.width, map.info.height), (2, 2));
        assert!((map.info.resolution - 30.0).abs() < f32::EPSILON);
        assert_eq!(map.header.stamp, Time { sec: 2, nanosec: 100_000_000 });
        assert_eq!(map.info.map_load_time, Time { sec: 1, nanosec: 500_000_000 });
    }

    #[test]
    fn a_belief_shows_percent_where_it_is_searched() {
        let terrain = terrain();
        let mut belief = Belief::uniform(&terrain, 0.2).unwrap();
        let out_of_reach = terrain.grid().cell_numbered(2).unwrap();
        belief.add(&Reading { cell: out_of_reach, value: 1.0, variance: 0.001 });
        let viewer = Viewer::new(&terrain, MapOrigin::default(), 0);
        assert_eq!(viewer.belief(&belief.probabilities(), MissionTime::START).data, [20, -1, 100, -1]);

        let grid = viewer.probability(&belief.probabilities(), MissionTime::START);
        assert_eq!((grid.column_count, grid.row_stride, grid.cell_stride), (2, 8, 4));
        let (floats, rest) = grid.data.as_chunks::<4>();
        let floats: Vec<f32> = floats.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect();
        assert!(rest.is_empty());
        for (shown, expected) in floats.into_iter().zip([0.2, 0.0, 1.0, 0.0]) {
            assert!((shown - expected).abs() < 1e-6, "{shown} {expected}");
        }
    }

    #[test]
    fn a_cell_is_drawn_at_its_center() {
        let terrain = terrain();
        let viewer = Viewer::new(&terrain, MapOrigin::default(), 0);
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let due = [1, 2].map(|seconds| MissionTime(seconds * 1_000_000_000));
        let path = viewer.path(&[(cells[1], due[0]), (cells[2], due[1])], MissionTime::START);
        let stamps: Vec<i32> = path.poses.iter().map(|pose| pose.header.stamp.sec).collect();
        assert_eq!((path.header.stamp.sec, stamps), (0, vec![1, 2]));
        let places: Vec<(f64, f64)> =
            path.poses.iter().map(|pose| (pose.pose.position.x, pose.pose.position.y)).collect();
        assert_eq!(places, [(45.0, 15.0), (15.0, 45.0)]);
        let frames = viewer.map_from_robot(RobotId::new(3).unwrap(), cells[1], MissionTime::START);
        let frame = &frames.transforms[0];
        assert_eq!((frame.header.frame_id.as_str(), frame.child_frame_id.as_str()), ("map", "robot_3"));
        assert_eq!(frame.transform.translation, Vector3 { x: 45.0, y: 15.0, z: 0.0 });
    }

    #[test]
    fn a_translated_map_translates_all_positions() {
        let terrain = terrain();
        let origin = MapOrigin { x_meters: -20.0, y_meters: -12.0, yaw_radians: std::f64::consts::FRAC_PI_2 };
        let viewer = Viewer::new(&terrain, origin, 0);
        let cell = terrain.grid().cells().nth(1).unwrap();
        let belief = Belief::uniform(&terrain, 0.2).unwrap();
        let frames = viewer.map_from_robot(RobotId::FIRST, cell, MissionTime::START);
        let Transform { translation, rotation } = frames.transforms[0].transform;
        let frame = Pose {
            position: Point { x: translation.x, y: translation.y, z: translation.z },
            orientation: rotation,
        };
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let check = |pose: Pose, expected: (f64, f64)| {
            let Pose { position, orientation } = pose;
            assert!((position.x - expected.0).hypot(position.y - expected.1) < 1e-9, "{position:?}");
            assert!((orientation.z - half).hypot(orientation.w - half) < 1e-9, "{orientation:?}");
        };
        check(viewer.terrain(MissionTime::START).info.origin, (-20.0, -12.0));
        check(viewer.belief(&belief.probabilities(), MissionTime::START).info.origin, (-20.0, -12.0));
        check(viewer.probability(&belief.probabilities(), MissionTime::START).pose, (-20.0, -12.0));
        // 45 m along its rows, which run north, and 15 m to their left, which is west.
        for pose in [
            viewer.pose(cell, MissionTime::START).pose,
            viewer.path(&[(cell, MissionTime::START)], MissionTime::START).poses[0].pose,
            frame,
        ] {
            check(pose, (-35.0, 33.0));
        }
    }

    #[test]
    fn a_time_before_1970_has_positive_nanoseconds() {
        let terrain = terrain();
        let stamp = |start, time| Viewer::new(&terrain, MapOrigin::default(), start).stamp(MissionTime(time));
        assert_eq!(stamp(-1, 0), Time { sec: -1, nanosec: 999_999_999 });
        assert_eq!(stamp(i64::MAX, u64::MAX).sec, i32::MAX);
        assert_eq!(stamp(i64::MIN, 0).sec, i32::MIN);
    }
}
