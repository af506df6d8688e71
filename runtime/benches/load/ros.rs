//! Latency of a robot's own ROS 2 network: from a publisher's put over a router to typed input, and the part of
//! decoding.

use std::path::Path;
use std::time::Instant;

use dragnet_ros2::cdr;
use dragnet_ros2::input::InputKind;
use dragnet_ros2::rmw_zenoh::data_key;
use dragnet_ros2::wire::robot::{CompressedImage, Image, Odometry};
use dragnet_ros2::wire::vision::{Detection2D, Detection2DArray, ObjectHypothesisWithPose};
use dragnet_runtime::ros::incoming::Incoming;
use dragnet_runtime::ros::node::Node;
use dragnet_runtime::ros::settings::Settings;
use dragnet_runtime::session::{Endpoints, Mode, free_endpoints, open};
use zenoh::qos::CongestionControl;

use crate::percentiles;

const ROUNDS: u32 = 2000;
const IMAGES: u32 = 200;
const BOXES: usize = 10;

pub(crate) async fn run() {
    let endpoint = free_endpoints(1).unwrap().remove(0);
    let listen = vec![endpoint.clone()];
    let router = Endpoints { listen: listen.clone(), mode: Some(Mode::Router), ..Endpoints::default() };
    let robot = Endpoints { connect: listen, ..Endpoints::default() };
    let (_router, robot) = (open(&router).await.unwrap(), open(&robot).await.unwrap());
    let camera = "{ name = 'front', detections = 'detections', image = 'image' }";
    let settings = format!("transport = 'rmw_zenoh'\nzenoh.connect = [{endpoint:?}]\ncameras = [{camera}]");
    let settings: Settings = toml::from_str(&settings).unwrap();
    let checked = settings.check(Path::new("robot.toml")).unwrap();
    let node = Node::open(checked).await.unwrap();
    for (what, kind, bytes, rounds) in [
        ("detections of 10 boxes", InputKind::Detections, cdr::encode(&detections()), ROUNDS),
        ("odometry", InputKind::Odometry, cdr::encode(&odometry()), ROUNDS),
        ("an image of 640 x 480", InputKind::Image, cdr::encode(&image()), IMAGES),
        ("the same as JPEG", InputKind::CompressedImage, cdr::encode(&jpeg()), IMAGES),
    ] {
        let mut reading: Vec<_> = (0..rounds)
            .map(|_| {
                let start = Instant::now();
                kind.understand(&bytes).unwrap();
                start.elapsed()
            })
            .collect();
        let (read, read_p99) = percentiles(&mut reading);
        println!("{what}, {} bytes: read in median {read:.3} ms, p99 {read_p99:.3} ms", bytes.len());
        let wanted = |topic: &str| node.topics().find(|known| known.chunks() == topic).cloned();
        let topic = match kind {
            InputKind::Detections => wanted("detections"),
            InputKind::Odometry => wanted("odom"),
            InputKind::Image => wanted("image"),
            _ => None,
        };
        let Some(topic) = topic else { continue };
        let publisher = robot.declare_publisher(data_key(0, &topic, &kind.message()));
        // An image that is dropped is never received.
        let publisher = publisher.congestion_control(CongestionControl::Block).express(true).await.unwrap();
        while !publisher.matching_status().await.unwrap().matching() {
            tokio::task::yield_now().await;
        }
        let mut received = Vec::new();
        for _ in 0..rounds {
            let start = Instant::now();
            publisher.put(bytes.clone()).await.unwrap();
            let next = node.receive().await;
            received.push(start.elapsed());
            assert!(!matches!(next, Incoming::Rejected { .. }), "{next:?}");
        }
        let (put, put_p99) = percentiles(&mut received);
        println!("    put to input, by a router: median {put:.3} ms, p99 {put_p99:.3} ms");
    }
}

fn detections() -> Detection2DArray {
    let mut seen =
        Detection2D { results: vec![ObjectHypothesisWithPose::default()], ..Detection2D::default() };
    (seen.bbox.size_x, seen.bbox.size_y) = (20.0, 40.0);
    Detection2DArray { detections: vec![seen; BOXES], ..Detection2DArray::default() }
}

fn odometry() -> Odometry {
    let mut odometry = Odometry::default();
    odometry.header.frame_id = "odom".into();
    odometry
}

fn image() -> Image {
    let (width, height) = (640, 480);
    let pixels = (0_u32..3 * width * height).map(|byte| byte.wrapping_mul(2_654_435_761).to_le_bytes()[3]);
    let encoding = "bgr8".to_owned();
    Image { height, width, encoding, step: 3 * width, data: pixels.collect(), ..Image::default() }
}

/// Smooth colors, as in an outdoor scene.
fn jpeg() -> CompressedImage {
    let picture = image::RgbImage::from_fn(640, 480, |x, y| {
        image::Rgb([x / 3, y / 2, (x + y) / 5].map(|shade| shade.to_le_bytes()[0]))
    });
    let mut data = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut data, image::ImageFormat::Jpeg).unwrap();
    CompressedImage { data: data.into_inner(), ..CompressedImage::default() }
}
