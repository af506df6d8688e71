//! From publishing to merging between two robots, compared with a bare Zenoh ping of the same size between the same
//! sessions.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::convert::{self, Codec};
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::Event;
use dragnet_runtime::clock::Clock;
use dragnet_runtime::session::open;
use dragnet_runtime::wall_clock::{self, Report};
use dragnet_search::observation::{Observation, Origin, RobotId};
use tokio::sync::mpsc;
use zenoh::bytes::ZBytes;
use zenoh::qos::CongestionControl;
use zenoh::sample::Sample;
use zenoh::session::SessionPutBuilder;
use zenoh::{Session, Wait};

use crate::probe::{Measured, Probe};
use crate::{join, mesh, observe, percentiles, scenario_at_speed};

const ROUNDS: u32 = 2000;
const PING: &str = "ping";
const PONG: &str = "pong";

pub(crate) async fn run() {
    // So fast that it may observe this often.
    let scenario = scenario_at_speed(2, 60, 1e6);
    let codec = Codec::new(scenario.terrain().grid());
    let cell = scenario.terrain().grid().cells().nth(30 * 60 + 30).unwrap();
    let readings = observe(&scenario, cell);
    let measured = Arc::new(Mutex::new(Measured::default()));
    let (mut sessions, mut senders) = (Vec::new(), Vec::new());
    for (agent_config, endpoints) in AgentConfig::of_team(&scenario, 1).into_iter().zip(mesh(2)) {
        let session = open(&endpoints).await.unwrap();
        sessions.push(session.clone());
        let robot = agent_config.robot.id;
        let mut link = join(session, "ping", robot, codec.clone()).await;
        let mut probe = Probe { robot, agent: Agent::new(agent_config), measured: Arc::clone(&measured) };
        let (sender, reports) = mpsc::channel::<Report>(1);
        senders.push(sender);
        let places = scenario.places();
        tokio::spawn(async move {
            let never = std::future::pending::<()>();
            wall_clock::run(&mut link, &mut probe, places, Clock::new(1.0), None, reports, never)
                .await
                .unwrap();
        });
    }
    let (arrived, mut arrivals) = mpsc::channel::<Instant>(1);
    let received = move |_| {
        let _ = arrived.try_send(Instant::now());
    };
    sessions[0].declare_subscriber(PONG).callback(received).background().await.unwrap();
    let echo = sessions[1].clone();
    let answer = move |ping: Sample| bare(&echo, PONG, ping.payload().clone()).wait().unwrap();
    sessions[1].declare_subscriber(PING).callback(answer).background().await.unwrap();
    let origin = Origin::first(RobotId::FIRST);
    let size = Observation {
        origin,
        sequence: 0,
        time_ns: 0,
        from: cell,
        readings: readings.clone(),
        positions: Box::default(),
    };
    let bytes = convert::encode(&Message::Observation(size.into()));
    tokio::time::sleep(Duration::from_secs(1)).await;
    let mut pings = Vec::new();
    for _ in 0..ROUNDS {
        let sent = Instant::now();
        bare(&sessions[0], PING, bytes.clone()).await.unwrap();
        pings.push(arrivals.recv().await.unwrap() - sent);
        let known = measured.lock().unwrap().merges.len();
        let report = (None, Event::Sensed { cell, readings: readings.clone() });
        senders[0].send(report).await.unwrap();
        while measured.lock().unwrap().merges.len() == known {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    }
    let mut merges = measured.lock().unwrap().merges.clone();
    let ((ping, ping_p99), (merge, merge_p99)) = (percentiles(&mut pings), percentiles(&mut merges));
    println!(
        "{} bytes, {ROUNDS} rounds: bare ping, there and back, median {ping:.3} ms, p99 {ping_p99:.3} ms; publish to \
         merge median {merge:.3} ms, p99 {merge_p99:.3} ms; ratio of the medians {:.2}",
        bytes.len(),
        merge / ping,
    );
}

/// A message with the publisher settings of robots.
fn bare<'a>(session: &'a Session, key: &'a str, bytes: impl Into<ZBytes>) -> SessionPutBuilder<'a, 'a> {
    session.put(key, bytes).congestion_control(CongestionControl::Block).express(true)
}
