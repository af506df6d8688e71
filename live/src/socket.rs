//! The socket of one viewer, who may leave, or stop to read, at any time.

use std::time::Duration;

use axum::body::Bytes;
use axum::extract::ws::{Message, WebSocket};
use tokio::time::{Instant, sleep_until, timeout};

/// Time limit for sending a message.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time between two pings to a viewer.
const PING: Duration = Duration::from_secs(3);
/// Silence after which a viewer counts as gone.
const SILENCE: Duration = Duration::from_secs(10);

/// Why a stream ends: the viewer is gone.
pub(crate) struct Gone;

/// A viewer, and when it last answered.
pub(crate) struct Viewer {
    socket: WebSocket,
    received: Instant,
    next_ping: Instant,
}

impl Viewer {
    pub(crate) fn new(socket: WebSocket) -> Self {
        let received = Instant::now();
        Self { socket, received, next_ping: received + PING }
    }

    /// The next message of the viewer. Pings check whether it still reads: buffers in between hold minutes of unread
    /// frames, and would keep the permit of another viewer.
    pub(crate) async fn recv(&mut self) -> Result<Message, Gone> {
        loop {
            tokio::select! {
                // An answer may have come while a long message was sent.
                biased;
                message = self.socket.recv() => {
                    self.received = Instant::now();
                    return message.and_then(Result::ok).ok_or(Gone);
                }
                () = sleep_until(self.next_ping) => {
                    self.next_ping = Instant::now() + PING;
                    if self.received.elapsed() > SILENCE {
                        return Err(Gone);
                    }
                    self.send(Message::Ping(Bytes::new())).await?;
                }
            }
        }
    }

    pub(crate) async fn send(&mut self, message: Message) -> Result<(), Gone> {
        match timeout(PATIENCE, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(Gone),
        }
    }
}
