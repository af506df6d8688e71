//! A robot with localization like AMCL's: latched poses, published only when the vehicle moves.

use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use dragnet_ros2::cdr;
use dragnet_ros2::wire::robot::{DiagnosticArray, PoseWithCovarianceStamped};
use dragnet_runtime::session::{Endpoints, Mode, free_endpoints, open};
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig, MissDetectionConfig};

use crate::field::{DRAGNET, Process};
use crate::test_site::{SPEED_METERS_PER_SECOND, TestSite, Vehicle, cameras, header, posed, settings};

const YARD: TestSite = TestSite { side: 4, cell_meters: 40.0, policy: "'path'" };
const TICK: Duration = Duration::from_millis(50);

/// The robot's last messages.
#[derive(Default)]
struct Said {
    path: Option<Vec<u8>>,
    diagnostics: DiagnosticArray,
}

/// A vehicle that moves on command, and a localization that publishes on command.
struct Site {
    vehicle: Vehicle,
    said: Arc<Mutex<Said>>,
    localization: AdvancedPublisher<'static>,
    session: zenoh::Session,
}

impl Site {
    async fn new(endpoint: &str) -> Self {
        let bridge =
            Endpoints { listen: vec![endpoint.to_owned()], mode: Some(Mode::Router), ..Endpoints::default() };
        let session = open(&bridge).await.unwrap();
        let said = Arc::new(Mutex::new(Said::default()));
        let received = Arc::clone(&said);
        session
            .declare_subscriber("**")
            .callback(move |sample| {
                let (mut received, bytes) = (received.lock().unwrap(), sample.payload().to_bytes());
                match sample.key_expr().as_str() {
                    "dragnet/path" => received.path = Some(bytes.to_vec()),
                    "diagnostics" => received.diagnostics = cdr::decode(&bytes).unwrap(),
                    _ => {}
                }
            })
            .background()
            .await
            .unwrap();
        // As a bridge publishes transient-local topics.
        let localization = session
            .declare_publisher("amcl_pose")
            .advanced()
            .publisher_detection()
            .cache(CacheConfig::default().max_samples(1))
            .sample_miss_detection(MissDetectionConfig::default())
            .await
            .unwrap();
        Self { vehicle: Vehicle::new(YARD), said, localization, session }
    }

    /// Publishes the vehicle's pose, with optional errors.
    async fn locate(&self, spoil: impl FnOnce(&mut PoseWithCovarianceStamped)) {
        let mut pose = PoseWithCovarianceStamped { header: header(), ..PoseWithCovarianceStamped::default() };
        pose.pose.pose = posed(self.vehicle.here);
        spoil(&mut pose);
        self.localization.put(cdr::encode(&pose)).await.unwrap();
    }

    /// Continues, with odometry and cameras, until a message has arrived.
    async fn go_on(&mut self, until: impl Fn(&Said) -> bool) {
        let cameras = cameras();
        let mut ticks = tokio::time::interval(TICK);
        for elapsed in 0.. {
            ticks.tick().await;
            {
                let mut said = self.said.lock().unwrap();
                if until(&said) {
                    return;
                }
                if let Some(path) = said.path.take() {
                    self.vehicle.follow(&path);
                }
                assert!(elapsed < 20 * 120, "{:?}, {:?}", self.vehicle.here, said.diagnostics.status);
            }
            self.vehicle.drive(SPEED_METERS_PER_SECOND * TICK.as_secs_f64());
            for (key, bytes) in self.vehicle.messages(&cameras) {
                self.session.put(key, bytes).await.unwrap();
            }
        }
    }
}

impl Said {
    fn has_path(&self) -> bool {
        self.path.as_ref().is_some_and(|path| {
            let path: dragnet_ros2::wire::standard::Path = cdr::decode(path).unwrap();
            !path.poses.is_empty()
        })
    }

    /// Whether there is a diagnostic of a subject, with these words.
    fn reports(&self, subject: &str, level: u8, words: &str) -> bool {
        let name = format!("dragnet: {subject}");
        self.diagnostics
            .status
            .iter()
            .any(|status| status.name == name && status.level == level && status.message.contains(words))
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_standing_robot_is_localized_and_one_whose_localization_dies_stops() {
    let folder = tempfile::tempdir().unwrap();
    let endpoints = free_endpoints(2).unwrap();
    std::fs::write(folder.path().join("test_site.toml"), YARD.scenario()).unwrap();
    let file = folder.path().join("vehicle.toml");
    let localized = "localization = \"pose\"\nlocalization_timeout_seconds = 1.0";
    let text = settings(&endpoints[0], &endpoints[1]).replace("localization = \"odometry\"", localized);
    std::fs::write(&file, text.replace("[ros]", "safety = { recovery_seconds = 0.5 }\n[ros]")).unwrap();
    let mut site = Site::new(&endpoints[1]).await;
    // Published once, before the robot starts.
    site.locate(|_| ()).await;
    let log = folder.path().join("log");
    let robot = Process::start_logged(Command::new(DRAGNET).args(["agent", "--config"]).arg(&file), &log);
    site.go_on(Said::has_path).await;
    // It drives, and its localization has failed.
    let missing = "no pose arrives: /amcl_pose: no valid message has arrived for ";
    site.go_on(|said| said.reports("pose", 2, missing)).await;
    site.go_on(|said| said.path.as_ref().is_some_and(|_| !said.has_path())).await;
    // Invalid poses count as missing, with their own message.
    site.locate(|pose| "odom".clone_into(&mut pose.header.frame_id)).await;
    site.go_on(|said| said.reports("/amcl_pose", 1, "frame_id is \"odom\"; allowed is \"map\"")).await;
    site.locate(|pose| pose.pose.pose.position.x = f64::NAN).await;
    site.go_on(|said| said.reports("/amcl_pose", 1, "position.x is NaN")).await;
    site.locate(|pose| pose.header.stamp.sec -= 20).await;
    site.go_on(|said| said.reports("/amcl_pose", 1, "stamped 20.")).await;
    let counted = |said: &Said| {
        let counted = |status: &dragnet_ros2::wire::robot::DiagnosticStatus| {
            status.values.iter().any(|value| value.key == "refused" && value.value == "3")
        };
        said.diagnostics.status.iter().any(|status| status.name.ends_with("/amcl_pose") && counted(status))
    };
    site.go_on(counted).await;
    // It comes back.
    site.locate(|_| ()).await;
    site.go_on(|said| said.reports("pose", 0, "well again") && said.has_path()).await;
    robot.terminate();
    let log = std::fs::read_to_string(log).unwrap();
    assert_eq!(log.matches(missing).count(), 1, "one fault, however often it is shown: {log}");
}
