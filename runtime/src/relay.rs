//! A slow link: passes on TCP connections late, and only so fast. Not every kernel can do that to a link itself.

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

/// Bytes that are read at once.
const CHUNK: usize = 4096;
/// So many chunks are on their way at most; then the sender has to wait, as with any full link.
const ON_THEIR_WAY: usize = 1024;

/// From where to where connections are passed on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Forward {
    /// Where it listens.
    pub listen: SocketAddr,
    /// Whom it calls for each connection.
    pub to: SocketAddr,
}

/// What a link is like, in each direction of each connection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// How long everything is on its way.
    pub delay: Duration,
    /// Bytes a second at most, above 0; as many as can be without.
    pub bytes_per_second: Option<f64>,
}

/// Passes on connections until the process ends.
///
/// # Errors
/// If it cannot listen somewhere.
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
                tracing::warn!("a caller was lost: {error}");
                // As when too many files are open: that does not pass at once.
                tokio::time::sleep(Duration::from_secs(1)).await;
            }
        }
    }
}

/// A caller whose call is not answered is hung up on.
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

/// Passes on one direction until either side hangs up.
async fn pass(mut from: OwnedReadHalf, mut to: OwnedWriteHalf, quality: Quality) {
    let (sender, mut chunks) = mpsc::channel::<(Instant, Vec<u8>)>(ON_THEIR_WAY);
    let read = async move {
        // When all that was read before has left.
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
