//! A running mission for Foxglove, Lichtblick and other clients of Foxglove's WebSocket protocol.
//!
//! Clients see the topics of a recording, with the same bytes, definitions and times. They can only read: the server
//! accepts no messages and no commands, and answers anybody who reaches its address, as the protocol has no token.
//!
//! - `protocol`: messages of the protocol, after its public specification, `foxglove/ws-protocol`;
//! - `feed`: the mission so far, as far as clients need it;
//! - `client`: what one client gets next.
//!
//! The coordinator never waits for a client: of one that is too slow the feed keeps nothing but what is newest.

mod client;
mod feed;
mod protocol;

use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use axum::Router;
use axum::extract::State;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{Message, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use dragnet_coordinator::record::encoder::MessageListener;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tokio::runtime::Runtime;
use tokio::sync::{Semaphore, watch};

use self::client::Client;
use self::feed::Feed;
use self::protocol::{Outgoing, Request};
use crate::door;
use crate::guard::may_read;
use crate::socket::{Gone, Viewer};

/// The port that Foxglove suggests.
pub const PORT: u16 = 8765;
/// The protocol, under its first name and its current one; the messages used here are the same.
const PROTOCOLS: [&str; 2] = ["foxglove.websocket.v1", "foxglove.sdk.v1"];
/// Maximum number of clients.
const MOST_CLIENTS: usize = 32;
/// The maximum size of a client's message, bytes: subscriptions to all topics of a thousand robots.
const MOST_BYTES: usize = 1 << 20;
/// Number of threads that serve clients.
const THREADS: usize = 1;

/// The running mission for Foxglove and other clients of its WebSocket protocol.
#[derive(Clone, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Address and port; port 0 is any free one. With 127.0.0.1 only this computer can connect. There is no token: all who
    /// can connect see everything that a recording holds, and can change nothing.
    pub listen: SocketAddr,
    /// Websites whose pages may connect from a browser, beside pages of this computer; programs can always connect.
    pub websites: Vec<String>,
}

impl Default for Settings {
    fn default() -> Self {
        let websites = vec!["https://app.foxglove.dev".to_owned()];
        Self { listen: SocketAddr::from(([127, 0, 0, 1], PORT)), websites }
    }
}

/// Why a mission cannot be served.
#[derive(Debug, thiserror::Error)]
#[error("cannot serve Foxglove at {listen}: {source}")]
pub struct ServerError {
    /// The address.
    listen: SocketAddr,
    /// The cause.
    source: io::Error,
}

/// A server, which serves until this value is dropped.
pub struct Server {
    runtime: Runtime,
    address: SocketAddr,
}

/// What all clients share.
struct Shared {
    feed: Mutex<Feed>,
    /// Notified when there is something new in the feed.
    news: watch::Sender<()>,
    /// Permits for clients.
    clients: Arc<Semaphore>,
    address: SocketAddr,
    websites: Vec<String>,
    /// Logs the first website that is refused.
    refused: Once,
    /// The name of this mission to clients.
    session: String,
}

/// Marks the mission as over when the coordinator drops it.
struct Teller(Arc<Shared>);

impl Drop for Teller {
    fn drop(&mut self) {
        self.0.change(Feed::end);
    }
}

impl Server {
    /// Serves a mission before its start; returns the server, and the listener for the mission's messages.
    ///
    /// # Errors
    /// If the address cannot be used.
    pub fn start(settings: &Settings) -> Result<(Self, MessageListener), ServerError> {
        let listen = settings.listen;
        let (runtime, listener, address) =
            door::listen(listen, THREADS).map_err(|source| ServerError { listen, source })?;
        let started = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let shared = Arc::new(Shared {
            feed: Mutex::default(),
            news: watch::Sender::default(),
            clients: Arc::new(Semaphore::new(MOST_CLIENTS)),
            address,
            websites: settings.websites.clone(),
            refused: Once::new(),
            session: started.as_nanos().to_string(),
        });
        let router = Router::new().fallback(open).with_state(Arc::clone(&shared));
        runtime.spawn(door::serve(listener, router));
        let teller = Teller(shared);
        let listener = move |message| teller.0.change(|feed| feed.put(message));
        Ok((Self { runtime, address }, Box::new(listener)))
    }

    /// The address as a client takes it, such as `ws://127.0.0.1:8765`.
    #[must_use]
    pub fn address(&self) -> String {
        format!("ws://{}", self.address)
    }

    /// Serves until the future that `stop` returns is ready. The future runs on the Tokio runtime of the server.
    pub fn serve_until<F: Future<Output = ()>>(self, stop: impl FnOnce() -> F) {
        self.runtime.block_on(async { stop().await });
        self.runtime.shutdown_background();
    }
}

impl Shared {
    fn feed(&self) -> MutexGuard<'_, Feed> {
        // A feed whose update panicked can still be read.
        self.feed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Feed)) {
        change(&mut self.feed());
        self.news.send_replace(());
    }
}

async fn open(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Response {
    let Ok(upgrade) = upgrade else {
        let what =
            format!("open ws://{} in Foxglove: a connection of type Foxglove WebSocket\n", shared.address);
        return (StatusCode::UPGRADE_REQUIRED, what).into_response();
    };
    let origin = headers.get(header::ORIGIN).map(|origin| String::from_utf8_lossy(origin.as_bytes()));
    if !may_read(origin.as_deref(), &shared.websites) {
        let what = format!(
            "pages of {} may not connect; foxglove.websites lists those that may",
            origin.unwrap_or_default()
        );
        shared.refused.call_once(|| tracing::warn!("{what}"));
        return (StatusCode::FORBIDDEN, what).into_response();
    }
    let upgrade = upgrade.max_message_size(MOST_BYTES).max_frame_size(MOST_BYTES).protocols(PROTOCOLS);
    if upgrade.selected_protocol().is_none() {
        let what = format!("a client is to offer one of the protocols {}\n", PROTOCOLS.join(", "));
        return (StatusCode::BAD_REQUEST, what).into_response();
    }
    let Ok(place) = Arc::clone(&shared.clients).try_acquire_owned() else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many are watching; try again later\n").into_response();
    };
    upgrade.on_upgrade(async move |socket| {
        // A client that leaves ends its stream, which is not a failure.
        let _gone = attend(&mut Viewer::new(socket), &shared).await;
        drop(place);
    })
}

/// Serves one client until it leaves.
async fn attend(socket: &mut Viewer, shared: &Shared) -> Result<(), Gone> {
    let mut news = shared.news.subscribe();
    let (mut client, hello) = Client::new(&shared.session, &shared.feed());
    send(socket, hello).await?;
    loop {
        news.mark_unchanged();
        let next = client.next(&shared.feed());
        let has_all = next.is_empty();
        send(socket, next).await?;
        let more = async {
            if has_all {
                // Its sender is shared, so it is there as long as this task is.
                let _changed = news.changed().await;
            }
        };
        tokio::select! {
            // A client that always has something to get is read too.
            biased;
            message = socket.recv() => {
                let answer = match message? {
                    Message::Close(_) => {
                        // The answer has to be sent.
                        let _closed = socket.recv().await;
                        return Err(Gone);
                    }
                    Message::Text(text) => match Request::read(&text) {
                        Some(request) => client.take(request, &shared.feed()),
                        None => vec![Outgoing::refusal()],
                    },
                    Message::Binary(_) => vec![Outgoing::refusal()],
                    Message::Ping(_) | Message::Pong(_) => Vec::new(),
                };
                send(socket, answer).await?;
            }
            () = more => {}
        }
    }
}

async fn send(socket: &mut Viewer, messages: Vec<Outgoing>) -> Result<(), Gone> {
    for message in messages {
        socket.send(message.into()).await?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
