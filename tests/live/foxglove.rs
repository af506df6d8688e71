//! The mission in Foxglove: the real program, and Foxglove's own client library (`live/page/test/foxglove.mjs`).

use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::process::{Command, Stdio};

use tempfile::TempDir;

use super::{LONG, Served, folder, root};

/// Plays one case of the script with a program in a folder; the script waits for it, ready to connect.
fn play(case: &str, folder: TempDir, command: &str) {
    let script = root().join("live/page/test/foxglove.mjs");
    let mut node = Command::new("node");
    node.arg(script).arg(case).arg(folder.path().join("hall.mcap"));
    let pipes = node.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut node = pipes.spawn().unwrap();
    let mut ready = String::new();
    BufReader::new(node.stdout.take().unwrap()).read_line(&mut ready).unwrap();
    let arguments: Vec<&str> = command.split(' ').collect();
    let served = Served::start_until(folder, &arguments, "Foxglove: ");
    // If the script has failed already, that is reported below.
    let _ = writeln!(node.stdin.take().unwrap(), "{}", served.address);
    let output = node.wait_with_output().unwrap();
    let reported = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{case}: {reported}\n{}", served.complaints());
}

/// Prints why nothing was tested, if so; a failure where all requirements must be there.
fn with_client(test: impl FnOnce()) {
    let has_node = Command::new("node").arg("--version").output().is_ok();
    if has_node && root().join("live/page/node_modules/@foxglove/ws-protocol").exists() {
        return test();
    }
    let what = "node or live/page/node_modules is missing: npm ci --prefix live/page";
    assert!(std::env::var_os("CI").is_none(), "{what}");
    eprintln!("not tested with a client of Foxglove: {what}");
}

#[test]
fn clients_of_a_search_get_what_its_recording_holds() {
    with_client(|| {
        let folder = folder();
        std::fs::write(folder.path().join("brief.toml"), LONG.replace("36000.0", "400.0")).unwrap();
        play("search", folder, "run brief.toml --foxglove=0 --real-time-factor 200 --record hall.mcap");
    });
}

#[test]
fn a_coordinator_in_the_field_serves_foxglove_as_its_settings_say() {
    with_client(|| {
        let folder = folder();
        let settings =
            "[foxglove]\nlisten = '127.0.0.1:0'\n[common]\nmission = 'hall'\nscenario = 'hall.toml'\n";
        std::fs::write(folder.path().join("coordinator.toml"), settings).unwrap();
        play("glance", folder, "coordinator --config coordinator.toml");
    });
}

#[test]
fn an_address_that_is_taken_is_reported_before_anything_runs() {
    let folder = folder();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    let settings =
        format!("[foxglove]\nlisten = '{address}'\n[common]\nmission = 'hall'\nscenario = 'hall.toml'\n");
    std::fs::write(folder.path().join("coordinator.toml"), settings).unwrap();
    let refused = |arguments: &[&str], reason: &str| {
        let mut dragnet = Command::new(env!("CARGO_BIN_EXE_dragnet"));
        let output = dragnet.args(arguments).current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains(reason), "{said}");
        assert!(!folder.path().join("hall.mcap").exists());
    };
    let reason = format!("cannot serve Foxglove at {address}: ");
    refused(&["run", "hall.toml", &format!("--foxglove={address}"), "--record", "hall.mcap"], &reason);
    refused(&["coordinator", "--config", "coordinator.toml"], &format!("foxglove: {reason}"));
    refused(
        &["run", "hall.toml", "--foxglove=0", "--over", "memory", "--record", "hall.mcap"],
        "--over memory: --foxglove needs Zenoh",
    );
}
