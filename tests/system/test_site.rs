//! A test site, and a vehicle in it that communicates like ROS 2 behind a bridge: for tests and for a benchmark.

use std::time::{SystemTime, UNIX_EPOCH};

use dragnet_lattice::plane;
use dragnet_ros2::cdr;
use dragnet_ros2::wire::robot::Odometry;
use dragnet_ros2::wire::standard::{Header, Path, Pose, Time};
use dragnet_ros2::wire::vision::{BoundingBox2D, Detection2D, Detection2DArray, Point2D, Pose2D};
use dragnet_vehicle::camera::{Camera, CameraSettings};

pub(crate) const SPEED_METERS_PER_SECOND: f64 = 10.0;
const WIDTH_PIXELS: u32 = 1000;
/// Each covers a third of the horizon.
const YAWS_DEGREES: [f64; 3] = [0.0, 120.0, -120.0];

/// A square test site, one object in the middle of its north-eastern cell.
#[derive(Clone, Copy)]
pub(crate) struct TestSite {
    /// Cells along each side.
    pub(crate) side: u32,
    pub(crate) cell_meters: f64,
    /// As TOML has it.
    pub(crate) policy: &'static str,
}

impl TestSite {
    pub(crate) fn scenario(self) -> String {
        let Self { side, cell_meters, policy } = self;
        format!(
            "name = \"test_site\"\n[map]\nshape = \"all_traversable\"\nrows = {side}\ncolumns = {side}\n\
             cell_meters = {cell_meters:?}\n[objects]\ncount = 1\n[sensor]\nradius = 2\n[robots]\ncount = 1\n\
             policy = {policy}\n[mission]\nbudget_seconds = 36000.0\nspeed_meters_per_second = 20.0\n"
        )
    }

    /// The object's position, meters to the east and to the north.
    pub(crate) fn object_meters(self) -> f64 {
        (f64::from(self.side) - 0.5) * self.cell_meters
    }
}

/// A vehicle that follows the last received path, with perfect cameras.
pub(crate) struct Vehicle {
    pub(crate) test_site: TestSite,
    /// The path that it follows, from its position.
    pub(crate) way: Vec<plane::Pose>,
    pub(crate) here: plane::Pose,
}

impl Vehicle {
    /// In the south-west.
    pub(crate) fn new(test_site: TestSite) -> Self {
        Self { test_site, way: Vec::new(), here: plane::Pose::new(10.0, 10.0, 0.3) }
    }

    /// Follows a path, encoded as CDR.
    pub(crate) fn follow(&mut self, path: &[u8]) {
        let path: Path = cdr::decode(path).unwrap();
        self.way = path.poses.iter().map(|stamped| plane_pose(&stamped.pose)).collect();
    }

    pub(crate) fn drive(&mut self, mut meters: f64) {
        while let Some(&next) = self.way.first() {
            let offset = next.position_meters() - self.here.position_meters();
            if offset.norm() > meters {
                let reached = self.here.position_meters() + offset * (meters / offset.norm());
                self.here = plane::Pose::new(reached.x, reached.y, next.heading_radians);
                return;
            }
            meters -= offset.norm();
            self.here = self.way.remove(0);
        }
    }

    /// Its current messages, by key: odometry, and its cameras' detections.
    pub(crate) fn messages(&self, cameras: &[Camera]) -> Vec<(String, Vec<u8>)> {
        let seen = cameras.iter().map(|camera| {
            (format!("{}/detections", camera.settings().name), cdr::encode(&self.sees(camera)))
        });
        [("odom".to_owned(), cdr::encode(&self.odometry()))].into_iter().chain(seen).collect()
    }

    fn odometry(&self) -> Odometry {
        let mut odometry = Odometry { header: header(), ..Odometry::default() };
        "base_link".clone_into(&mut odometry.child_frame_id);
        odometry.pose.pose = posed(self.here);
        odometry
    }

    fn sees(&self, camera: &Camera) -> Detection2DArray {
        let eye = self.here.of_part(&camera.settings().mounting);
        let object = plane::Pose::new(self.test_site.object_meters(), self.test_site.object_meters(), 0.0);
        let bearing = plane::bearing_radians(eye.position_meters(), object.position_meters());
        let is_near =
            (object.position_meters() - eye.position_meters()).norm() < camera.settings().max_range_meters;
        let column = camera.column_pixels(plane::turn_radians(eye.heading_radians, bearing));
        let found = column.filter(|_| is_near).map(|x| {
            let center = Pose2D { position: Point2D { x, y: 300.0 }, theta: 0.0 };
            let bbox = BoundingBox2D { center, size_x: 10.0, size_y: 30.0 };
            Detection2D { header: header(), bbox, ..Detection2D::default() }
        });
        Detection2DArray { header: header(), detections: found.into_iter().collect() }
    }
}

pub(crate) fn header() -> Header {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    Header { stamp: Time::at_unix_ns(i128::try_from(now.as_nanos()).unwrap()), frame_id: "map".to_owned() }
}

pub(crate) fn posed(pose: plane::Pose) -> Pose {
    let mut posed = Pose::default();
    (posed.position.x, posed.position.y) = (pose.x_meters, pose.y_meters);
    (posed.orientation.z, posed.orientation.w) = (pose.heading_radians / 2.0).sin_cos();
    posed
}

fn plane_pose(pose: &Pose) -> plane::Pose {
    let heading = 2.0 * pose.orientation.z.atan2(pose.orientation.w);
    plane::Pose::new(pose.position.x, pose.position.y, heading)
}

pub(crate) fn cameras() -> [Camera; 3] {
    [0, 1, 2].map(|number| {
        let settings = CameraSettings {
            name: format!("camera_{number}"),
            width_pixels: WIDTH_PIXELS,
            height_pixels: 600,
            field_of_view_radians: 125.0_f64.to_radians(),
            mounting: plane::Pose::new(0.0, 0.0, YAWS_DEGREES[number].to_radians()),
            z_meters: 0.0,
            pitch_radians: 0.0,
            min_range_meters: 0.5,
            max_range_meters: 80.0,
        };
        Camera::new(settings).unwrap()
    })
}

/// Settings of the three cameras, of this many columns and rows; `more` is added to each, and topics have these names.
pub(crate) fn camera_tables([columns, rows]: [u32; 2], more: &str, topic: &str) -> String {
    let tables = [0, 1, 2].map(|number| {
        format!(
            "[[vehicle.cameras]]\nname = \"camera_{number}\"\nwidth_pixels = {columns}\nheight_pixels = {rows}\n\
             field_of_view_degrees = 125.0\nyaw_degrees = {:?}\nmin_range_meters = 0.5\nmax_range_meters = 80.0\n{more}\
             [[ros.cameras]]\nname = \"camera_{number}\"\n{topic} = \"camera_{number}/{topic}\"\n",
            YAWS_DEGREES[number]
        )
    });
    tables.concat()
}

/// Settings of the robot: the endpoints of its team and of its vehicle's bridge.
pub(crate) fn settings(team: &str, bridge: &str) -> String {
    let cameras = camera_tables([WIDTH_PIXELS, 600], "", "detections");
    format!(
        "robot = 1\n[common]\nmission = \"test_site\"\nscenario = \"test_site.toml\"\nzenoh = {{ listen = [{team:?}] }}\n\
         [vehicle]\nspeed_meters_per_second = 20.0\nfootprint = {{ shape = \"disc\", radius_meters = 0.5 }}\n\
         [ros]\ntransport = \"bridge\"\nlocalization = \"odometry\"\nodometry_frame = \"map\"\n\
         zenoh = {{ connect = [{bridge:?}] }}\n{cameras}"
    )
}
