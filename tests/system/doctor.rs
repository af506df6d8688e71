//! `dragnet doctor`: what it finds where something is missing, and where all is there.

use std::path::Path;
use std::process::Command;

use dragnet_link::session::{Endpoints, Mode, free_endpoints, open};
use dragnet_proto::cdr;
use dragnet_proto::wire::robot::Odometry;
use dragnet_proto::wire::standard::Header;

use crate::field::{DRAGNET, Field};

const TEAM: &str = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 8\ncolumns = 8\n[objects]\ncount = 1\n\
                    [robots]\ncount = 2\npolicy = \"path\"\n[mission]\nbudget_seconds = 3600.0\n";

/// What it prints, a line a finding, and whether all will do.
fn examine(file: &Path, seconds: u32) -> (String, bool) {
    let output = Command::new(DRAGNET)
        .args(["doctor", "--listen", &seconds.to_string(), "--config"])
        .arg(file)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.code().is_some_and(|code| code < 2), "{}", String::from_utf8_lossy(&output.stderr));
    (said, output.status.success())
}

fn check(said: &str, expected: &[&str]) {
    for line in expected {
        assert!(said.contains(line), "{line} is not in\n{said}");
    }
}

#[test]
fn a_robot_whose_team_is_there_may_go() {
    let field = Field::new(TEAM, 2, 1);
    let settings = field.robot_settings(1, None);
    let (said, will_do) = examine(&settings, 1);
    assert!(!will_do);
    check(
        &said,
        &[
            "pass  settings: robot 1 of 2",
            "pass  journal: ",
            "pass  decisions: path",
            "FAIL  team: nobody is there",
        ],
    );
    let _mate = field.robot(2);
    let _coordinator = field.coordinator();
    // They come once they have started.
    let (said, _) = std::iter::repeat_with(|| examine(&settings, 3)).find(|(_, will_do)| *will_do).unwrap();
    check(&said, &["pass  team: 2 of the mission are there: robot 2, the coordinator"]);
}

#[test]
fn settings_that_cannot_be_are_all_that_is_told() {
    let field = Field::new(TEAM, 2, 1);
    let settings = field.robot_settings(2, None);
    let text = std::fs::read_to_string(&settings).unwrap();
    std::fs::write(&settings, text.replace("robot = 2", "robot = 7")).unwrap();
    let (said, will_do) = examine(&settings, 1);
    assert!(!will_do && said.lines().count() == 2, "{said}");
    check(&said, &["FAIL  settings: robot is 7, of a team of 2"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn each_topic_of_a_vehicle_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let endpoint = free_endpoints(1).unwrap().remove(0);
    std::fs::write(folder.path().join("yard.toml"), TEAM.replace("count = 2", "count = 1")).unwrap();
    let file = folder.path().join("robot.toml");
    let settings = format!(
        "robot = 1\n[common]\nmission = \"yard\"\nscenario = \"yard.toml\"\n[vehicle]\n[ros]\ntransport = \"bridge\"\n\
         localization = \"odometry\"\nzenoh.connect = [{endpoint:?}]\nhear = {{ pose = \"\", fix = \"\", map = \"\", goals = \"\" }}\n\
         cameras = [{{ name = \"wide\", detections = \"seen\" }}]\n"
    );
    std::fs::write(&file, settings).unwrap();
    let (said, _) = examine(&file, 1);
    check(&said, &["pass  team: it searches alone", "FAIL  vehicle: no router and no bridge answers"]);
    let bridge = Endpoints { listen: vec![endpoint], mode: Some(Mode::Router), ..Endpoints::default() };
    let session = open(&bridge).await.unwrap();
    let _follower = session.declare_subscriber("dragnet/path").await.unwrap();
    let publishing = tokio::spawn(async move {
        // As of a clock that was never set.
        let header = Header { frame_id: "odom".to_owned(), ..Header::default() };
        let mut odometry = Odometry { header, child_frame_id: "base_link".to_owned(), ..Odometry::default() };
        odometry.pose.pose.orientation.w = 1.0;
        loop {
            session.put("odom", cdr::encode(&odometry)).await.unwrap();
            session.put("seen", b"nothing".as_slice()).await.unwrap();
            tokio::time::sleep(std::time::Duration::from_millis(20)).await;
        }
    });
    let (said, will_do) = tokio::task::spawn_blocking(move || examine(&file, 2)).await.unwrap();
    publishing.abort();
    assert!(!will_do);
    check(
        &said,
        &[
            "FAIL  /odom: ",
            "before this computer's clock",
            "FAIL  /seen: ",
            "not the bytes",
            "pass  path: somebody",
        ],
    );
}
