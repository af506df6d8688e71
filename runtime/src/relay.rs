//! Emulates a slow link: forwards TCP connections with delay and limited rate, also on systems whose kernel cannot do
//! so itself.

use std::net::SocketAddr;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::Instant;

use crate::RuntimeError;
use crate::session::block_on;

/// Maximum number of bytes per read.
const CHUNK: usize = 4096;
/// Maximum number of chunks in transit; then the sender has to wait, as with any full link.
const ON_THEIR_WAY: usize = 1024;

/// The endpoints of a relay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Forward {
    /// The listening address.
    pub listen: SocketAddr,
    /// The address that each connection is forwarded to.
    pub to: SocketAddr,
}

/// The quality of a link, in each direction of each connection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// The delay.
    pub delay: Duration,
    /// Maximum rate, above 0; `None`: unlimited.
    pub bytes_per_second: Option<f64>,
}

/// Forwards connections until the process ends.
///
/// # Errors
/// If it cannot listen at an address.
pub fn run(forwards: &[Forward], quality: Quality) -> Result<(), RuntimeError> {
    block_on(async {
        let mut listeners = JoinSet::new();
        for &forward in forwards {
            let listener = TcpListener::bind(forward.listen).await.map_err(|error| RuntimeError::Open {
                listen: forward.listen.to_string(),
                reason: error.to_string(),
            })?;
            listeners.spawn(accept(listener, forward.to, quality));
        }
        while listeners.join_next().await.is_some() {}
        Ok(())
    })
}

async fn accept(listener: TcpListener, to: SocketAddr, quality: Quality) {
    loop {
        match listener.accept().await {
            Ok((caller, _)) => {
                tokio::spawn(connect(caller, to, quality));
            }
            Err(error) => {
                tracing::warn!("a connection was lost: {error}");
                // For example because too many files are open, which does not pass at once.
                tokio::time::sleep(Duration::from_secs(1)).await;
            }
        }
    }
}

/// Closes an incoming connection if the outgoing one fails.
async fn connect(here: TcpStream, to: SocketAddr, quality: Quality) {
    let there = match TcpStream::connect(to).await {
        Ok(there) => there,
        Err(error) => return tracing::info!("{to} does not answer: {error}"),
    };
    for stream in [&here, &there] {
        if let Err(error) = stream.set_nodelay(true) {
            tracing::warn!("{error}");
        }
    }
    let (asked, replies) = here.into_split();
    let (answered, requests) = there.into_split();
    tokio::join!(pass(asked, requests, quality), pass(answered, replies, quality));
}

/// Forwards one direction until either side closes.
async fn pass(mut from: OwnedReadHalf, mut to: OwnedWriteHalf, quality: Quality) {
    let (sender, mut chunks) = mpsc::channel::<(Instant, Vec<u8>)>(ON_THEIR_WAY);
    let read = async move {
        // When all earlier bytes have been sent.
        let mut free = Instant::now();
        let mut buffer = [0; CHUNK];
        while let Ok(count @ 1..) = from.read(&mut buffer).await {
            let takes = quality.bytes_per_second.map_or(0.0, |rate| count as f64 / rate);
            free = free.max(Instant::now()) + Duration::from_secs_f64(takes);
            if sender.send((free + quality.delay, buffer[..count].to_vec())).await.is_err() {
                break;
            }
        }
    };
    let write = async move {
        while let Some((due, chunk)) = chunks.recv().await {
            tokio::time::sleep_until(due).await;
            if to.write_all(&chunk).await.is_err() {
                break;
            }
        }
    };
    tokio::join!(read, write);
}
