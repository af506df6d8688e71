//! The time to detect a lost robot: one whose connection closes, as when its process ends, and one that only falls
//! silent, as when it drives out of range.

use std::time::{Duration, Instant};

use dragnet_proto::convert::Codec;
use dragnet_runtime::link::{Incoming, Link};
use dragnet_runtime::session::{Endpoints, free_endpoints, open};
use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;
use tokio::io::copy_bidirectional;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;

use crate::{percentiles, scenario};

const ROUNDS: usize = 20;

#[derive(Clone, Copy)]
enum Cut {
    Close,
    FallSilent,
}

pub(crate) async fn run() {
    let mut closed = Vec::new();
    for _ in 0..ROUNDS {
        closed.push(until_lost(Cut::Close).await);
    }
    let (median, p99) = percentiles(&mut closed);
    println!(
        "{ROUNDS} robots whose connection closes are known to be lost after {median:.2} ms (median), p99 {p99:.2} ms"
    );
    let silent = until_lost(Cut::FallSilent).await;
    println!("a robot that falls silent is known to be lost after {:.1} s", silent.as_secs_f64());
}

/// From the moment at which the link between two robots is cut to that at which one detects the loss of the other.
async fn until_lost(cut: Cut) -> Duration {
    let addresses = free_endpoints(2).unwrap();
    let [first, relay] = [0, 1].map(|place: usize| addresses[place].trim_start_matches("tcp/").to_owned());
    let here = Endpoints { listen: vec![addresses[0].clone()], ..Endpoints::default() };
    let there = Endpoints { connect: vec![addresses[1].clone()], ..Endpoints::default() };
    let mut here = join(1, &here).await;
    let listener = TcpListener::bind(relay).await.unwrap();
    let (order, ordered) = oneshot::channel::<()>();
    let path = tokio::spawn(async move {
        let (mut from, _) = listener.accept().await.unwrap();
        let mut to = TcpStream::connect(first).await.unwrap();
        tokio::select! {
            _ = copy_bidirectional(&mut from, &mut to) => {}
            _ = ordered => {}
        }
        if matches!(cut, Cut::FallSilent) {
            std::future::pending::<()>().await;
        }
    });
    let other = Participant::Robot(RobotId::new(2).unwrap());
    let there = join(2, &there).await;
    here.wait_for(&[other], Duration::from_secs(10), |_| ()).await.unwrap();
    order.send(()).unwrap();
    let started = Instant::now();
    while !matches!(here.receive().await, Some(Incoming::Left(participant, _)) if participant == other) {}
    let lasted = started.elapsed();
    path.abort();
    drop(there);
    lasted
}

async fn join(robot: u16, endpoints: &Endpoints) -> Link {
    let codec = Codec::new(scenario(2, 12).terrain().grid());
    crate::join(open(endpoints).await.unwrap(), "lost", RobotId::new(robot).unwrap(), codec).await
}
