//! Sockets to an autopilot. A task owns the socket: it calls again whenever a connection ends, and messages that do not get
//! through are dropped, as by a radio.

use std::io;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpStream, UdpSocket};
use tokio::sync::mpsc;

use super::settings::Connection;

/// Time after which another sender may take the place of one that is silent.
const SILENCE: Duration = Duration::from_secs(5);
/// Time between two calls.
const AGAIN: Duration = Duration::from_secs(1);
/// Maximum number of datagrams, and of pieces of a stream, that wait for the robot.
const WAITING: usize = 1024;
/// The longest datagram.
pub(super) const MAX_DATAGRAM: usize = 65_536;

/// What arrives.
#[derive(Debug)]
pub(crate) enum Arrived {
    /// The bytes of a datagram, or the next ones of a stream.
    Bytes(Vec<u8>),
    /// Something else happened; a sentence.
    Trouble(String),
}

/// A connection to an autopilot.
pub(crate) struct Link {
    arriving: mpsc::Receiver<Arrived>,
    leaving: mpsc::Sender<Vec<u8>>,
}

impl Link {
    /// Opens a connection. An autopilot that is not there yet is waited for.
    ///
    /// # Errors
    /// If the address to be called at is not free.
    pub(crate) async fn open(connection: &Connection) -> io::Result<Self> {
        let (arrived, arriving) = mpsc::channel(WAITING);
        let (leaving, left) = mpsc::channel(WAITING);
        let ends = Ends { arrived, left };
        match connection {
            Connection::UdpIn(address) => {
                let socket = UdpSocket::bind(address).await?;
                tokio::spawn(ends.answer(socket));
            }
            Connection::UdpOut(host) => {
                tokio::spawn(ends.call_udp(host.clone()));
            }
            Connection::Tcp(host) => {
                tokio::spawn(ends.call_tcp(host.clone()));
            }
        }
        Ok(Self { arriving, leaving })
    }

    /// The next that arrives. Cancel safe.
    pub(crate) async fn receive(&mut self) -> Arrived {
        match self.arriving.recv().await {
            Some(arrived) => arrived,
            // The task ends only with this end.
            None => std::future::pending().await,
        }
    }

    /// Sends the bytes of a message, or drops them if too many wait.
    pub(crate) fn send(&self, bytes: Vec<u8>) {
        // A robot that waits for a slow radio would steer by old positions.
        let _ = self.leaving.try_send(bytes);
    }

    /// Waits until all was sent, or the time is over.
    pub(crate) async fn flush(self) {
        drop(self.arriving);
        let Self { leaving, .. } = self;
        let is_empty = async {
            while leaving.capacity() < leaving.max_capacity() {
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
        };
        let _ = tokio::time::timeout(AGAIN, is_empty).await;
    }
}

/// The other ends of a link's queues.
struct Ends {
    arrived: mpsc::Sender<Arrived>,
    left: mpsc::Receiver<Vec<u8>>,
}

impl Ends {
    /// Answers the first caller, until that one is silent.
    async fn answer(mut self, socket: UdpSocket) {
        let mut peer: Option<(SocketAddr, Instant)> = None;
        let mut buffer = vec![0; MAX_DATAGRAM];
        loop {
            tokio::select! {
                received = socket.recv_from(&mut buffer) => {
                    // An error is of a datagram that was sent to nobody.
                    let Ok((length, from)) = received else { continue };
                    let known = peer.filter(|(_, heard)| heard.elapsed() < SILENCE);
                    if let Some((known, _)) = known.filter(|(known, _)| *known != from) {
                        let trouble = format!("{from} sends too; its messages are ignored, as long as {known} does");
                        self.pass(Arrived::Trouble(trouble));
                        continue;
                    }
                    peer = Some((from, Instant::now()));
                    self.pass(Arrived::Bytes(buffer[..length].to_vec()));
                }
                bytes = self.left.recv() => {
                    let Some(bytes) = bytes else { return };
                    if let Some((peer, _)) = peer {
                        let _ = socket.send_to(&bytes, peer).await;
                    }
                }
            }
        }
    }

    async fn call_udp(mut self, host: String) {
        let mut buffer = vec![0; MAX_DATAGRAM];
        loop {
            let socket = match called(&host).await {
                Ok(socket) => socket,
                Err(error) => {
                    if self.wait(&host, &error).await {
                        continue;
                    }
                    return;
                }
            };
            loop {
                tokio::select! {
                    // An error is of a datagram for which nobody was there.
                    received = socket.recv(&mut buffer) => if let Ok(length) = received {
                        self.pass(Arrived::Bytes(buffer[..length].to_vec()));
                    },
                    bytes = self.left.recv() => {
                        let Some(bytes) = bytes else { return };
                        let _ = socket.send(&bytes).await;
                    }
                }
            }
        }
    }

    async fn call_tcp(mut self, host: String) {
        let mut buffer = vec![0; MAX_DATAGRAM];
        loop {
            let mut stream = match TcpStream::connect(&host).await.and_then(|stream| {
                // A target is short, and waits for nothing.
                stream.set_nodelay(true).map(|()| stream)
            }) {
                Ok(stream) => stream,
                Err(error) => {
                    if self.wait(&host, &error).await {
                        continue;
                    }
                    return;
                }
            };
            let error = loop {
                tokio::select! {
                    received = stream.read(&mut buffer) => match received {
                        Ok(0) => break io::ErrorKind::ConnectionReset.into(),
                        Ok(length) => self.pass(Arrived::Bytes(buffer[..length].to_vec())),
                        Err(error) => break error,
                    },
                    bytes = self.left.recv() => {
                        let Some(bytes) = bytes else { return };
                        if let Err(error) = stream.write_all(&bytes).await {
                            break error;
                        }
                    }
                }
            };
            if !self.wait(&host, &error).await {
                return;
            }
        }
    }

    /// Waits before the next call, and drops what was to be sent; false if the robot is gone.
    async fn wait(&mut self, host: &str, error: &io::Error) -> bool {
        self.pass(Arrived::Trouble(format!("{host}: {error}; it is called again")));
        let until = tokio::time::Instant::now() + AGAIN;
        while let Ok(bytes) = tokio::time::timeout_at(until, self.left.recv()).await {
            if bytes.is_none() {
                return false;
            }
        }
        true
    }

    fn pass(&self, arrived: Arrived) {
        // A robot that is behind misses messages, as by a bad radio.
        let _ = self.arrived.try_send(arrived);
    }
}

async fn called(host: &str) -> io::Result<UdpSocket> {
    let address = tokio::net::lookup_host(host)
        .await?
        .next()
        .ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "the name has no address"))?;
    let any: SocketAddr = if address.is_ipv4() { ([0; 4], 0).into() } else { ([0_u16; 8], 0).into() };
    let socket = UdpSocket::bind(any).await?;
    socket.connect(address).await?;
    Ok(socket)
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn bytes(link: &mut Link) -> Vec<u8> {
        loop {
            if let Arrived::Bytes(bytes) = link.receive().await {
                return bytes;
            }
        }
    }

    async fn free() -> SocketAddr {
        UdpSocket::bind("127.0.0.1:0").await.unwrap().local_addr().unwrap()
    }

    #[tokio::test]
    async fn the_first_sender_is_answered_and_a_second_is_named() {
        let address = free().await;
        let mut link = Link::open(&Connection::UdpIn(address)).await.unwrap();
        let [first, second] =
            [UdpSocket::bind("127.0.0.1:0").await.unwrap(), UdpSocket::bind("127.0.0.1:0").await.unwrap()];
        first.send_to(b"one", address).await.unwrap();
        assert_eq!(bytes(&mut link).await, b"one");
        second.send_to(b"two", address).await.unwrap();
        let Arrived::Trouble(trouble) = link.receive().await else { panic!() };
        assert!(trouble.contains(&second.local_addr().unwrap().to_string()), "{trouble}");
        link.send(b"three".to_vec());
        let mut buffer = [0; 9];
        assert_eq!(first.recv(&mut buffer).await.unwrap(), 5);
    }

    #[tokio::test]
    async fn an_autopilot_that_comes_late_or_again_is_called_over_tcp() {
        let address = free().await;
        let mut link = Link::open(&Connection::Tcp(address.to_string())).await.unwrap();
        for word in [b"one", b"two"] {
            let server = tokio::net::TcpListener::bind(address).await.unwrap();
            let (mut stream, _) = server.accept().await.unwrap();
            stream.write_all(word).await.unwrap();
            assert_eq!(bytes(&mut link).await, word);
            link.send(b"four".to_vec());
            let mut buffer = [0; 9];
            assert_eq!(stream.read(&mut buffer).await.unwrap(), 4);
        }
    }

    #[tokio::test]
    async fn udp_is_called_and_answers() {
        let server = UdpSocket::bind("127.0.0.1:0").await.unwrap();
        let host = server.local_addr().unwrap().to_string();
        let mut link = Link::open(&Connection::UdpOut(host)).await.unwrap();
        link.send(b"one".to_vec());
        let mut buffer = [0; 9];
        let (length, from) = server.recv_from(&mut buffer).await.unwrap();
        assert_eq!(&buffer[..length], b"one");
        server.send_to(b"two", from).await.unwrap();
        assert_eq!(bytes(&mut link).await, b"two");
    }
}
