//! Load tests of the network with real sessions on this computer's loopback interface, by the wall clock:
//!
//! ```sh
//! cargo bench -p dragnet-runtime --bench load -- ping            # a robot's observation against a bare ping
//! cargo bench -p dragnet-runtime --bench load -- late            # a robot joins a mission of 10,000 observations
//! cargo bench -p dragnet-runtime --bench load -- lost            # time to detect a lost robot
//! cargo bench -p dragnet-runtime --bench load -- ros             # a robot's own ROS 2 network, to typed input
//! cargo bench -p dragnet-runtime --bench load -- team 100 60 300 # robots, side of the map, seconds
//! ```

#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

mod late;
mod lost;
mod ping;
mod probe;
mod ros;
mod team;

use std::path::Path;
use std::time::Duration;

use dragnet_proto::convert::Codec;
use dragnet_runtime::journal::{Journal, Subject};
use dragnet_runtime::link::Link;
use dragnet_runtime::session::{Endpoints, free_endpoints};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;
use dragnet_search::observation::RobotId;
use zenoh::Session;

fn main() {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let number = |text: &str| text.parse().unwrap();
    let runtime = tokio::runtime::Runtime::new().unwrap();
    match arguments[..] {
        ["ping"] => runtime.block_on(ping::run()),
        ["late"] => runtime.block_on(late::run()),
        ["lost"] => runtime.block_on(lost::run()),
        ["ros"] => runtime.block_on(ros::run()),
        ["team", robots, side, seconds] => {
            runtime.block_on(team::run(number(robots), number(side), u64::from(number(seconds))));
        }
        [] => {
            runtime.block_on(ping::run());
            runtime.block_on(late::run());
            runtime.block_on(lost::run());
            runtime.block_on(ros::run());
        }
        _ => eprintln!("allowed are: ping; late; lost; ros; team ROBOTS SIDE SECONDS"),
    }
}

/// Endpoints of this many sessions; each connects to all before it.
fn mesh(sessions: usize) -> Vec<Endpoints> {
    let listen = free_endpoints(sessions).unwrap();
    let endpoints = listen.iter().enumerate().map(|(place, own)| Endpoints {
        listen: vec![own.clone()],
        connect: listen[..place].to_vec(),
        ..Endpoints::default()
    });
    endpoints.collect()
}

/// A new journal of a robot in a folder.
fn journal(folder: &Path, mission: &str, robot: RobotId, scenario: &Scenario) -> Journal {
    let mission = mission.parse().unwrap();
    let subject = Subject { mission: &mission, robot, terrain: scenario.terrain() };
    Journal::open(&folder.join(format!("{robot}.journal")), subject, 0).unwrap().0
}

/// A robot's link to the network, announced to the others.
async fn join(session: Session, mission: &str, robot: RobotId, codec: Codec) -> Link {
    let me = Participant::Robot(robot);
    let mut link = Link::join(session, mission.parse().unwrap(), me, codec).await.unwrap();
    link.announce().await.unwrap();
    link
}

fn scenario(robots: u32, side: u32) -> Scenario {
    scenario_at_speed(robots, side, 2.0)
}

fn scenario_at_speed(robots: u32, side: u32, meters_per_second: f64) -> Scenario {
    let text = format!(
        "name = 'load'\nmap = {{ shape = 'all_traversable', rows = {side}, columns = {side} }}\n\
         objects.density = 0.01\nrobots = {{ count = {robots}, policy = 'path' }}\n\
         mission = {{ budget_seconds = 1e6, speed_meters_per_second = {meters_per_second:?} }}\n"
    );
    Scenario::from_text(std::path::Path::new("load.toml"), text).unwrap()
}

/// The readings of a scenario's robot in a cell without objects.
fn observe(scenario: &Scenario, from: Cell) -> Vec<Reading> {
    let grid = scenario.terrain().grid();
    let observations = scenario.sensor().footprint().iter();
    let seen = observations.filter_map(|footprint_cell| {
        Some((grid.step(from, footprint_cell.offset)?, footprint_cell.variance))
    });
    seen.map(|(cell, variance)| Reading { cell, value: 0.0, variance }).collect()
}

/// The median and the 99th percentile, in milliseconds; NaN without times.
fn percentiles(times: &mut [Duration]) -> (f64, f64) {
    if times.is_empty() {
        return (f64::NAN, f64::NAN);
    }
    times.sort_unstable();
    let at = |percent: usize| times[(times.len() - 1) * percent / 100].as_secs_f64() * 1e3;
    (at(50), at(99))
}
