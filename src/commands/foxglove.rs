//! `--foxglove`: a running mission for Foxglove and other clients of its protocol.

use std::io::{self, Write};
use std::net::{IpAddr, SocketAddr};

use dragnet_coordinator::record::encoder::MessageListener;
use dragnet_live::foxglove::{PORT, Server, ServerError, Settings};

use super::{Failure, live};

/// The default address: this computer, and the port that Foxglove suggests.
pub(super) const HERE: &str = "127.0.0.1:8765";

impl From<ServerError> for Failure {
    fn from(error: ServerError) -> Self {
        Self::input(error)
    }
}

/// An address and a port, or one of the two.
pub(super) fn parse_address(text: &str) -> Result<SocketAddr, String> {
    match text.parse::<IpAddr>() {
        Ok(ip) => Ok(SocketAddr::from((ip, PORT))),
        Err(_) => live::parse_address(text),
    }
}

/// A server whose address has been printed.
pub(super) struct Announced(Server);

/// Serves a mission at an address, and prints it.
pub(super) fn serve(listen: SocketAddr) -> Result<(Announced, MessageListener), Failure> {
    let (server, messages) = Server::start(&Settings { listen, ..Settings::default() })?;
    // If stderr is closed the address is not printed.
    let _ = writeln!(io::stderr(), "Foxglove: {}", server.address());
    Ok((Announced(server), messages))
}

impl Announced {
    /// Serves the mission until Ctrl-C, or until nothing reads what this program prints.
    pub(super) fn stay(self) {
        let _ = writeln!(io::stderr(), "the search stays at {} until Ctrl-C", self.0.address());
        self.0.serve_until(live::until_asked);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_without_a_port_has_foxgloves() {
        let check = |text: &str, expected: &str| {
            assert_eq!(parse_address(text).unwrap().to_string(), expected);
        };
        check(HERE, "127.0.0.1:8765");
        check("0.0.0.0", "0.0.0.0:8765");
        check("9000", "127.0.0.1:9000");
        check("[::1]:0", "[::1]:0");
        assert!(parse_address("ws://here").unwrap_err().contains("allowed are such as"));
    }
}
