//! Who is let in: connections are bounded in number, from one address too, and in how long a request may take.
//!
//! Without that, whoever opens connections and says nothing, or asks and does not read, would keep everybody out.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{sleep, timeout};

/// So many connections at a time, those of viewers not counted.
const MOST: usize = 256;
/// So many of them from one address, or from one network of IPv6.
const MOST_FROM_ONE: usize = 64;
/// A request has this long to say what it asks for.
const HEAD: Duration = Duration::from_secs(10);
/// A connection that has not become a stream lives so long: browsers open another one.
const LIFE: Duration = Duration::from_mins(1);
/// Before another connection is taken after one could not be, as when too many files are open.
const REST: Duration = Duration::from_millis(100);

/// Serves until the runtime ends.
pub(crate) async fn serve(listener: TcpListener, router: Router) {
    let doors = Doors::default();
    let mut is_failing = false;
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => {
                is_failing = false;
                // Who finds no place is hung up on.
                if let Some(place) = doors.enter(peer.ip()) {
                    tokio::spawn(attend(stream, router.clone(), place));
                }
            }
            Err(error) => {
                if !std::mem::replace(&mut is_failing, true) {
                    tracing::warn!("the page cannot take a caller: {error}");
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
    // Whatever ends a connection, there is nobody left to tell.
    let _ended = timeout(LIFE, connection).await;
    drop(place);
}

/// Connections by where they come from.
#[derive(Clone, Default)]
struct Doors(Arc<Mutex<BTreeMap<IpAddr, usize>>>);

/// One of them; free again when it is dropped.
struct Place {
    doors: Doors,
    from: IpAddr,
}

impl Doors {
    /// A place, if there is one.
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

/// Where somebody comes from: of IPv6 the network, which gives everybody more addresses than there are places.
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
    fn nobody_takes_all_places_and_who_leaves_makes_room() {
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
