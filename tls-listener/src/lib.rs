//! Accepts connections and performs TLS handshakes: a replacement of the crate of this name, which Zenoh uses.
//!
//! The original does not bound the number of pending handshakes, does not process them while no further file can be
//! opened, so that it never closes one then, and reports each failure before the next success, after each of which
//! Zenoh pauses for 100 ms. So a thousand silent connections from one address block all others for minutes, or for
//! ever. Here each connection has its own task, the oldest of an address makes room, and completed handshakes come
//! before failed ones. `Cargo.toml` of the workspace replaces the original (`[patch.crates-io]`), with the part of its
//! interface that Zenoh's TLS uses.

mod pending;

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::time::Duration;

use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::{sleep, timeout};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::server::TlsStream;

use crate::pending::{MOST, MOST_FROM_ONE, Pending, network};

/// Maximum number of completed and of failed handshakes that wait to be taken.
const WAITING: usize = 16;
/// Pause after a connection could not be accepted, for example because too many files are open.
const REST: Duration = Duration::from_millis(100);

/// Begins a listener.
#[must_use]
pub const fn builder(tls: TlsAcceptor) -> Builder {
    Builder { tls, handshake_timeout: Duration::from_secs(10) }
}

/// Settings of a listener.
pub struct Builder {
    tls: TlsAcceptor,
    handshake_timeout: Duration,
}

impl Builder {
    /// Time limit of a handshake.
    #[must_use]
    pub const fn handshake_timeout(mut self, handshake_timeout: Duration) -> Self {
        self.handshake_timeout = handshake_timeout;
        self
    }

    /// Accepts connections until it is dropped.
    ///
    /// # Panics
    /// Outside of a Tokio runtime.
    #[must_use]
    pub fn listen(self, socket: TcpListener) -> TlsListener {
        let (agreed, to_take) = channel(WAITING);
        let (failed, to_tell) = channel(WAITING);
        let mut task = JoinSet::new();
        task.spawn(Door { settings: self, agreed, failed }.attend(socket));
        TlsListener { agreed: to_take, failed: to_tell, _task: task }
    }
}

/// A listener that returns connections after their handshakes.
pub struct TlsListener {
    agreed: Receiver<(TlsStream<TcpStream>, SocketAddr)>,
    failed: Receiver<Error>,
    /// Accepts connections while this is kept.
    _task: JoinSet<()>,
}

/// Why a connection failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No connection could be accepted.
    #[error("{0}")]
    Accept(io::Error),
    /// The handshake failed.
    #[error("{0}")]
    Handshake(io::Error),
    /// The handshake took too long.
    #[error("Timeout during TLS handshake")]
    Timeout,
    /// The connection had to make room for a later one.
    #[error(
        "{0} calls while {MOST_FROM_ONE} of its connections, or {MOST} of all, have not agreed on TLS; the oldest ends"
    )]
    CheckedTeam(IpAddr),
    /// The listener has ended.
    #[error("the listener has ended")]
    Ended,
}

impl TlsListener {
    /// The next completed handshake, or else a failed one; of too many failures some are not reported. Cancel safe.
    ///
    /// # Errors
    /// If a connection failed.
    pub async fn accept(&mut self) -> Result<(TlsStream<TcpStream>, SocketAddr), Error> {
        tokio::select! {
            biased;
            Some(agreed) = self.agreed.recv() => Ok(agreed),
            Some(error) = self.failed.recv() => Err(error),
            else => Err(Error::Ended),
        }
    }
}

/// The accepting side.
struct Door {
    settings: Builder,
    agreed: Sender<(TlsStream<TcpStream>, SocketAddr)>,
    failed: Sender<Error>,
}

impl Door {
    async fn attend(self, socket: TcpListener) {
        let (mut handshakes, mut pending) = (JoinSet::new(), Pending::<AbortHandle>::default());
        loop {
            tokio::select! {
                call = socket.accept() => match call {
                    Ok((stream, peer)) => {
                        let handshake = handshakes.spawn(self.handshake(stream, peer));
                        if let Some(oldest) = pending.enter(network(peer.ip()), handshake) {
                            oldest.abort();
                            self.tell(Error::CheckedTeam(peer.ip()));
                        }
                    }
                    Err(error) => {
                        self.tell(Error::Accept(error));
                        sleep(REST).await;
                    }
                },
                Some(ended) = handshakes.join_next_with_id() => {
                    let ended = ended.map_or_else(|error| error.id(), |(id, ())| id);
                    pending.leave(|handshake| handshake.id() == ended);
                }
            }
        }
    }

    fn handshake(&self, stream: TcpStream, peer: SocketAddr) -> impl Future<Output = ()> + use<> {
        let handshake = timeout(self.settings.handshake_timeout, self.settings.tls.accept(stream));
        let (agreed, failed) = (self.agreed.clone(), self.failed.clone());
        async move {
            let error = match handshake.await {
                // Without the listener the connection is dropped.
                Ok(Ok(stream)) => return drop(agreed.send((stream, peer)).await),
                Ok(Err(error)) => Error::Handshake(error),
                Err(_) => Error::Timeout,
            };
            // Of too many failures some are not reported.
            let _ = failed.try_send(error);
        }
    }

    fn tell(&self, error: Error) {
        // As above.
        let _ = self.failed.try_send(error);
    }
}

#[cfg(test)]
mod tests;
