//! Takes connections and agrees on TLS with each: in the place of the crate of this name, on which Zenoh builds.
//!
//! That one bounds no number of connections whose TLS is not agreed on, looks at none of them while no further file may
//! be open, so that it never closes one then, and tells Zenoh of each failure before the next success, after each of which
//! Zenoh rests for 100 ms. So a thousand silent connections from one address keep all others out for minutes, or for good.
//! Here each connection has a task of its own, the oldest of an address makes room, and who has agreed on TLS comes before
//! who has failed. `Cargo.toml` of the workspace puts this crate in that one's place (`[patch.crates-io]`), with as much of
//! its interface as Zenoh's TLS uses.

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

/// So many that have agreed on TLS, or have failed, wait to be taken.
const WAITING: usize = 16;
/// Before another connection is taken after one could not be, as when too many files are open.
const REST: Duration = Duration::from_millis(100);

/// Begins a listener.
#[must_use]
pub const fn builder(tls: TlsAcceptor) -> Builder {
    Builder { tls, handshake_timeout: Duration::from_secs(10) }
}

/// What a listener goes by.
pub struct Builder {
    tls: TlsAcceptor,
    handshake_timeout: Duration,
}

impl Builder {
    /// How long it may take to agree on TLS.
    #[must_use]
    pub const fn handshake_timeout(mut self, handshake_timeout: Duration) -> Self {
        self.handshake_timeout = handshake_timeout;
        self
    }

    /// Takes connections until it is dropped.
    ///
    /// # Panics
    /// Outside of a runtime of Tokio.
    #[must_use]
    pub fn listen(self, socket: TcpListener) -> TlsListener {
        let (agreed, to_take) = channel(WAITING);
        let (failed, to_tell) = channel(WAITING);
        let mut task = JoinSet::new();
        task.spawn(Door { settings: self, agreed, failed }.attend(socket));
        TlsListener { agreed: to_take, failed: to_tell, _task: task }
    }
}

/// Who has called, and agreed on TLS or failed to.
pub struct TlsListener {
    agreed: Receiver<(TlsStream<TcpStream>, SocketAddr)>,
    failed: Receiver<Error>,
    /// It takes connections as long as this is kept.
    _task: JoinSet<()>,
}

/// Who could not be let in.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No connection could be taken.
    #[error("{0}")]
    Accept(io::Error),
    /// A caller and this side do not agree on TLS.
    #[error("{0}")]
    Handshake(io::Error),
    /// A caller did not agree on TLS in time.
    #[error("Timeout during TLS handshake")]
    Timeout,
    /// A caller had to make room for one that came later.
    #[error(
        "{0} calls while {MOST_FROM_ONE} of its connections, or {MOST} of all, have not agreed on TLS; the oldest ends"
    )]
    CheckedTeam(IpAddr),
    /// The listener has ended.
    #[error("the listener has ended")]
    Ended,
}

impl TlsListener {
    /// The next that has agreed on TLS, or else one that failed; of more failures than can wait some are not told. What
    /// is waited for is not lost if this is dropped.
    ///
    /// # Errors
    /// If somebody could not be let in.
    pub async fn accept(&mut self) -> Result<(TlsStream<TcpStream>, SocketAddr), Error> {
        tokio::select! {
            biased;
            Some(agreed) = self.agreed.recv() => Ok(agreed),
            Some(error) = self.failed.recv() => Err(error),
            else => Err(Error::Ended),
        }
    }
}

/// Where connections come in.
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
                // Without the listener there is nobody to take it.
                Ok(Ok(stream)) => return drop(agreed.send((stream, peer)).await),
                Ok(Err(error)) => Error::Handshake(error),
                Err(_) => Error::Timeout,
            };
            // Of more than can wait some are not told.
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
