//! A large team in one mission by the wall clock.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::convert::Codec;
use dragnet_proto::key::Mission;
use dragnet_runtime::clock::Clock;
use dragnet_runtime::journal::Journal;
use dragnet_runtime::session::{Endpoints, open};
use dragnet_runtime::wall_clock;
use dragnet_runtime::world::{self, WorldServer};
use dragnet_scenario::Places;
use tokio::sync::watch;
use tokio::task::JoinSet;

use crate::probe::{Measured, Probe};
use crate::{journal, mesh, percentiles, scenario};

const MISSION: &str = "load";

pub(crate) async fn run(robots: u32, side: u32, seconds: u64) {
    let scenario = scenario(robots, side);
    let mission: Mission = MISSION.parse().unwrap();
    let endpoints = mesh(robots as usize + 1);
    let session = open(&endpoints[0]).await.unwrap();
    let measured = Arc::new(Mutex::new(Measured::default()));
    let (stop, stopped) = watch::channel(());
    let journals = tempfile::tempdir().unwrap();
    let mut team = JoinSet::new();
    for (agent_config, endpoints) in AgentConfig::of_team(&scenario, 1).into_iter().zip(&endpoints[1..]) {
        let journal = journal(journals.path(), MISSION, agent_config.robot.id, &scenario);
        join(&mut team, agent_config, endpoints, journal, &measured, stopped.clone()).await;
    }
    eprintln!("{robots} robots in a mesh, {:.0} MB", resident_megabytes());
    let mut spectator = |_, _: dragnet_sim::simulation::StepContext| ();
    let server = WorldServer::open(session, mission, &scenario, 1, 1.0, false, &mut spectator).await.unwrap();
    let started = Instant::now();
    let reported = async {
        let mut each = tokio::time::interval(Duration::from_secs(seconds.div_ceil(5).max(1)));
        each.tick().await;
        let mut before = 0;
        loop {
            each.tick().await;
            before = tell(&measured, started.elapsed(), before);
        }
    };
    // The search is not over in this time.
    let _ =
        tokio::time::timeout(Duration::from_secs(seconds), async { tokio::join!(server.run(), reported) })
            .await;
    let reported = measured.lock().unwrap().published();
    let settled = Instant::now();
    while !measured.lock().unwrap().agree(robots as usize, reported) {
        assert!(settled.elapsed() < Duration::from_mins(1), "the beliefs do not become equal");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    print!("in all ");
    tell(&measured, started.elapsed(), 0);
    println!(
        "all {reported} observations are with all robots, {:.1} s after the last",
        settled.elapsed().as_secs_f64()
    );
    drop(stop);
    while team.join_next().await.is_some() {}
}

async fn join(
    team: &mut JoinSet<()>,
    agent_config: AgentConfig,
    endpoints: &Endpoints,
    journal: Journal,
    measured: &Arc<Mutex<Measured>>,
    mut stopped: watch::Receiver<()>,
) {
    let (robot, codec) = (agent_config.robot.id, Codec::new(agent_config.terrain.grid()));
    let session = open(endpoints).await.unwrap();
    let mut link = crate::join(session, MISSION, robot, codec.clone()).await;
    let reports = world::sensor(&link, robot, codec.clone()).await.unwrap();
    let places = Places::new(&agent_config.terrain, None);
    let mut probe = Probe { robot, agent: Agent::new(agent_config), measured: Arc::clone(measured) };
    team.spawn(async move {
        let stop = async move { while stopped.changed().await.is_ok() {} };
        wall_clock::run(&mut link, &mut probe, places, Clock::new(1.0), Some(journal), reports, stop)
            .await
            .unwrap();
    });
}

/// Prints the measurements from this merge on; messages since the start. Returns the number of merges.
fn tell(measured: &Mutex<Measured>, elapsed: Duration, first: usize) -> usize {
    let (published, delivered, mut merges) = {
        let measured = &*measured.lock().unwrap();
        (measured.published(), measured.delivered, measured.merges[first..].to_vec())
    };
    let seconds = elapsed.as_secs_f64();
    let (median, p99) = percentiles(&mut merges);
    println!(
        "{seconds:>6.0} s: {published} observations, {:.0} messages heard a second, publish to merge median \
         {median:.1} ms, p99 {p99:.1} ms, {:.0} MB",
        delivered as f64 / seconds,
        resident_megabytes(),
    );
    first + merges.len()
}

/// Resident memory of this process.
fn resident_megabytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes: f64 =
        line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(f64::NAN);
    kilobytes / 1024.0
}
