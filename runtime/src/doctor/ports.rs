//! Checks the robot's listening endpoints: are the addresses this computer's, and the ports free?

use std::io::ErrorKind;
use std::net::{TcpListener, ToSocketAddrs, UdpSocket};
use std::path::Path;

use dragnet_files::open_plain;

use super::Finding;
use crate::RuntimeError;
use crate::session::{self, Endpoints};

/// Checks each endpoint on which the robot is to listen. If the robot itself runs here, it has them.
///
/// # Errors
/// If the settings are not Zenoh's.
pub(super) fn examine(endpoints: &Endpoints, runs_here: bool) -> Result<Vec<Finding>, RuntimeError> {
    let listened = session::listened(endpoints)?;
    Ok(listened.iter().filter_map(|endpoint| examine_one(endpoint, runs_here)).collect())
}

fn examine_one(endpoint: &str, runs_here: bool) -> Option<Finding> {
    let subject = format!("port {endpoint}");
    let (protocol, rest) = endpoint.split_once('/')?;
    let address = rest.split(['?', '#']).next().unwrap_or(rest);
    let is_datagram = matches!(protocol, "udp" | "quic");
    // Other links, such as serial lines and files, are not ports.
    if !is_datagram && !matches!(protocol, "tcp" | "tls" | "ws") {
        return None;
    }
    let bound = address.to_socket_addrs().and_then(|addresses| {
        let addresses: Vec<_> = addresses.collect();
        if is_datagram {
            UdpSocket::bind(&*addresses).map(drop)
        } else {
            TcpListener::bind(&*addresses).map(drop)
        }
    });
    Some(match bound.map_err(|error| (error.kind(), error)) {
        Ok(()) => Finding::pass(subject, "it is free"),
        Err((ErrorKind::AddrInUse, _)) if runs_here => {
            Finding::pass(subject, "it is taken, as by this robot itself, which runs on this computer")
        }
        Err((ErrorKind::AddrInUse, _)) => {
            let advice =
                "stop who has it (`ss -ltnp` names it), or name another port; 7447 is that of rmw_zenohd";
            Finding::fail(subject, "another process listens there already", advice)
        }
        Err((ErrorKind::AddrNotAvailable, _)) => {
            let advice = "name an address that `ip address` lists, and see that its network is up";
            Finding::fail(subject, "that is no address of this computer", advice)
        }
        Err((_, error)) => {
            Finding::fail(subject, error.to_string(), "name an address of this computer, and a port")
        }
    })
}

/// Whether the robot itself runs on this computer: its journal is open then.
pub(super) fn runs_here(journal: &Path) -> bool {
    let Ok(file) = open_plain(journal) else { return false };
    matches!(file.try_lock_shared(), Err(std::fs::TryLockError::WouldBlock))
}
