//! The connections of the server: bounded in number, in total and by address, and in the duration of a request.
//!
//! Otherwise idle connections, or clients that do not read, could block all others.

use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, Ipv6Addr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Runtime;
use tokio::time::{sleep, timeout};

/// Maximum number of connections, without those of viewers.
const MOST: usize = 256;
/// Maximum number of them from one address, or from one network of IPv6.
const MOST_FROM_ONE: usize = 64;
/// Time limit for the head of a request.
const HEAD: Duration = Duration::from_secs(10);
/// Time limit of a connection that does not become a stream: browsers open another one.
const LIFE: Duration = Duration::from_mins(1);
/// Pause after a connection could not be accepted, for example because too many files are open.
const REST: Duration = Duration::from_millis(100);

/// A runtime with this number of threads, a socket that listens, and its address: port 0 becomes a free one.
pub(crate) fn listen(at: SocketAddr, threads: usize) -> io::Result<(Runtime, TcpListener, SocketAddr)> {
    let listener = std::net::TcpListener::bind(at)?;
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(threads).enable_all().build()?;
    let listener = runtime.block_on(async { TcpListener::from_std(listener) })?;
    Ok((runtime, listener, address))
}

/// Serves until the runtime ends.
pub(crate) async fn serve(listener: TcpListener, router: Router) {
    let doors = Doors::default();
    let mut is_failing = false;
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => {
                is_failing = false;
                // Connections above the limit are closed.
                if let Some(place) = doors.enter(peer.ip()) {
                    tokio::spawn(attend(stream, router.clone(), place));
                }
            }
            Err(error) => {
                if !std::mem::replace(&mut is_failing, true) {
                    tracing::warn!("a connection to the page or of Foxglove cannot be accepted: {error}");
                }
                sleep(REST).await;
            }
        }
    }
}

async fn attend(stream: TcpStream, router: Router, place: Place) {
    let service = TowerToHyperService::new(router);
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    // The result of a connection is not needed.
    let _ended = timeout(LIFE, connection).await;
    drop(place);
}

/// Number of connections by their origin.
#[derive(Clone, Default)]
struct Doors(Arc<Mutex<BTreeMap<IpAddr, usize>>>);

/// One connection; counted until it is dropped.
struct Place {
    doors: Doors,
    from: IpAddr,
}

impl Doors {
    /// Counts a connection, if the limit allows it.
    fn enter(&self, from: IpAddr) -> Option<Place> {
        let from = network(from);
        let mut counts = self.counts();
        let count = counts.get(&from).copied().unwrap_or_default();
        if count >= MOST_FROM_ONE || counts.values().sum::<usize>() >= MOST {
            return None;
        }
        counts.insert(from, count + 1);
        Some(Place { doors: self.clone(), from })
    }

    fn counts(&self) -> MutexGuard<'_, BTreeMap<IpAddr, usize>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut counts = self.doors.counts();
        let count = counts.remove(&self.from).unwrap_or_default();
        if count > 1 {
            counts.insert(self.from, count - 1);
        }
    }
}

/// The origin of a connection: for IPv6 the network, which has more addresses than the limit.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            IpAddr::V6(Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0))
        }
        address @ IpAddr::V4(_) => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_address_does_not_take_all_connections_and_closed_ones_make_room() {
        let doors = Doors::default();
        let from = |last: u8| IpAddr::from([10, 0, 0, last]);
        let mut places: Vec<Place> = (0..100).filter_map(|_| doors.enter(from(1))).collect();
        assert_eq!(places.len(), MOST_FROM_ONE);
        assert!(doors.enter(from(2)).is_some(), "others have theirs");
        places.pop();
        assert!(doors.enter(from(1)).is_some());
        places.extend((2..=255).cycle().take(500).filter_map(|last| doors.enter(from(last))));
        assert_eq!(places.len(), MOST);
        assert!(doors.enter(from(9)).is_none());
        drop(places);
        assert!(doors.counts().is_empty());
    }

    #[test]
    fn a_network_of_ipv6_is_one() {
        let of = |text: &str| network(text.parse().unwrap());
        assert_eq!(of("2001:db8::1"), of("2001:db8::ffff:1"));
        assert_ne!(of("2001:db8::1"), of("2001:db8:0:1::1"));
        assert_eq!(of("::ffff:10.0.0.1"), of("10.0.0.1"));
    }
}
