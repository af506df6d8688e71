//! A robot as a service: notifications to its manager, its unit, and the target platforms.

use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::field::{DRAGNET, Field, Process};
use crate::mentions::assert_mentions;

const ALONE: &str = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 5\ncolumns = 5\n\
                     [objects]\ncount = 1\n[mission]\nbudget_seconds = 3600.0\n";

#[test]
fn a_service_manager_is_notified_that_a_robot_is_ready_alive_and_stopping() {
    let field = Field::new(ALONE, 1, 1);
    let path = field.path("manager");
    let manager = UnixDatagram::bind(&path).unwrap();
    manager.set_read_timeout(Some(Duration::from_mins(1))).unwrap();
    let receive = || {
        let mut words = [0; 256];
        let length = manager.recv(&mut words).unwrap();
        String::from_utf8(words[..length].to_vec()).unwrap().trim().to_owned()
    };
    let settings = field.robot_settings(1, None);
    let robot = Process::start(
        Command::new(DRAGNET)
            .args(["agent", "--config"])
            .arg(settings)
            .env("NOTIFY_SOCKET", path)
            .env("WATCHDOG_USEC", "300000"),
    );
    assert_eq!(receive(), "READY=1");
    for _ in 0..3 {
        assert_eq!(receive(), "WATCHDOG=1");
    }
    robot.terminate();
    let last = std::iter::repeat_with(receive).find(|words| words != "WATCHDOG=1");
    assert_eq!(last.as_deref(), Some("STOPPING=1"));
}

#[test]
fn systemd_understands_the_unit() {
    let folder = tempfile::tempdir().unwrap();
    let unit = Path::new(env!("CARGO_MANIFEST_DIR")).join("deploy/dragnet-agent@.service");
    let text = std::fs::read_to_string(unit).unwrap();
    let installed = "/usr/local/bin/dragnet";
    assert!(text.contains(installed));
    let copy = folder.path().join("dragnet-agent@robot.service");
    std::fs::write(&copy, text.replace(installed, DRAGNET)).unwrap();
    let Ok(output) = Command::new("systemd-analyze").arg("verify").arg(copy).output() else {
        eprintln!("not tested: systemd-analyze is not installed");
        return;
    };
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.trim().is_empty(), "{said}");
}

#[test]
fn an_unsupported_target_is_rejected_before_anything_is_built() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/deploy/build.sh");
    let output = Command::new(script).args(["x86_64", "mips"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    assert_mentions(
        &String::from_utf8_lossy(&output.stderr),
        "deploy/build.sh .. \"mips\" .. x86_64 and aarch64",
    );
}
