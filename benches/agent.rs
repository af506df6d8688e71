//! Resource usage of a robot on its vehicle: `dragnet agent` as a process, with odometry and three cameras' detections
//! at 20 Hz, a decision per second, by the wall clock.
//!
//! ```sh
//! cargo bench --bench agent -- 60 30      # seconds, cells along each side of the test site
//! ```
//!
//! Measures the process: processor time as a share of one core, and peak memory.

#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

#[path = "../tests/system/test_site.rs"]
mod test_site;

use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use dragnet_runtime::session::{Endpoints, Mode, free_endpoints, open};
use test_site::{SPEED_METERS_PER_SECOND, TestSite, Vehicle, cameras, settings};

/// Period of odometry and detections.
const TICK: Duration = Duration::from_millis(50);
/// The start, which is not measured.
const WARM_UP: Duration = Duration::from_secs(5);

fn main() {
    // Cargo adds `--bench`.
    let numbers: Vec<u32> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    let (seconds, side) = match numbers[..] {
        [] => (60, 30),
        [seconds, side] => (seconds, side),
        _ => return eprintln!("allowed are: SECONDS SIDE, or nothing"),
    };
    let runtime = tokio::runtime::Runtime::new().unwrap();
    // A cell is crossed in a second, and in each the robot decides anew.
    let policy = "{ name = 'path', replan_after_cells = 1 }";
    let test_site = TestSite { side, cell_meters: SPEED_METERS_PER_SECOND, policy };
    runtime.block_on(run(test_site, Duration::from_secs(seconds.into())));
}

async fn run(test_site: TestSite, duration: Duration) {
    let folder = tempfile::tempdir().unwrap();
    let endpoints = free_endpoints(2).unwrap();
    std::fs::write(folder.path().join("test_site.toml"), test_site.scenario()).unwrap();
    let file = folder.path().join("vehicle.toml");
    std::fs::write(&file, settings(&endpoints[0], &endpoints[1])).unwrap();
    let bridge =
        Endpoints { listen: vec![endpoints[1].clone()], mode: Some(Mode::Router), ..Endpoints::default() };
    let session = open(&bridge).await.unwrap();
    let (paths, received) = mpsc::channel();
    session
        .declare_subscriber("dragnet/path")
        .callback(move |sample| drop(paths.send(sample.payload().to_bytes().into_owned())))
        .background()
        .await
        .unwrap();
    let mut agent = Command::new(env!("CARGO_BIN_EXE_dragnet"))
        .args(["agent", "--config"])
        .arg(&file)
        .stdin(Stdio::null())
        .spawn()
        .unwrap();
    let cameras = cameras();
    let mut vehicle = Vehicle::new(test_site);
    let mut ticks = tokio::time::interval(TICK);
    let (start, mut begun, mut entered) = (Instant::now(), None, 0);
    while start.elapsed() < WARM_UP + duration {
        ticks.tick().await;
        if let Some(path) = received.try_iter().last() {
            vehicle.follow(&path);
        }
        let before = cell(&vehicle);
        vehicle.drive(SPEED_METERS_PER_SECOND * TICK.as_secs_f64());
        entered += u32::from(cell(&vehicle) != before);
        for (key, bytes) in vehicle.messages(&cameras) {
            session.put(key, bytes).await.unwrap();
        }
        if begun.is_none() && start.elapsed() > WARM_UP {
            begun = Some((Instant::now(), processor_seconds(agent.id()), entered));
        }
    }
    let (since, before, entered_before) = begun.unwrap();
    let used = (processor_seconds(agent.id()) - before) / since.elapsed().as_secs_f64();
    let side = test_site.side;
    println!(
        "{side} x {side} cells, {:.0} s, {} cells entered: {:.1} % of a core; at most {:.0} MB",
        since.elapsed().as_secs_f64(),
        entered - entered_before,
        used * 100.0,
        max_megabytes(agent.id()),
    );
    agent.kill().unwrap();
    agent.wait().unwrap();
}

/// The vehicle's cell, to the east and to the north.
#[expect(clippy::cast_possible_truncation, reason = "meters of a small map")]
fn cell(vehicle: &Vehicle) -> [i64; 2] {
    let edge = vehicle.test_site.cell_meters;
    [vehicle.here.x_meters, vehicle.here.y_meters].map(|meters| (meters / edge).floor() as i64)
}

/// CPU time of all its threads, from `proc(5)`: fields 14 and 15, hundredths of a second.
fn processor_seconds(process: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
    let fields: Vec<&str> = stat.rsplit_once(')').unwrap().1.split_whitespace().collect();
    fields[11..13].iter().map(|field| field.parse::<f64>().unwrap()).sum::<f64>() / 100.0
}

fn max_megabytes(process: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() / 1024.0
}
