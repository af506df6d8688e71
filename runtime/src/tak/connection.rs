//! The socket to TAK.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpStream, UdpSocket, lookup_host};
use tokio_rustls::TlsConnector;

use super::settings::{Checked, Transport};

/// Routers between two networks that a multicast may cross: as ATAK's own.
const MULTICAST_HOPS: u32 = 64;

/// Bytes of a stream.
pub(super) trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

/// A connection over which events are sent.
pub(super) enum Connection {
    /// Each event is a datagram.
    Datagrams(UdpSocket, SocketAddr),
    /// Events follow one another.
    Stream(Box<dyn Stream>),
}

impl Connection {
    /// Opens a connection to a target.
    pub(super) async fn open(target: &Checked) -> io::Result<Self> {
        match target.transport() {
            Transport::Udp { local } => {
                let address = lookup(target.host()).await?;
                let local = local.unwrap_or(match address {
                    SocketAddr::V4(_) => IpAddr::V4(Ipv4Addr::UNSPECIFIED),
                    SocketAddr::V6(_) => IpAddr::V6(Ipv6Addr::UNSPECIFIED),
                });
                // On Linux a multicast leaves by the network of the local address.
                let socket = UdpSocket::bind((local, 0)).await?;
                if address.is_ipv4() {
                    socket.set_multicast_ttl_v4(MULTICAST_HOPS)?;
                }
                Ok(Self::Datagrams(socket, address))
            }
            Transport::Tcp => Ok(Self::Stream(Box::new(TcpStream::connect(target.host()).await?))),
            Transport::Tls { name, config } => {
                let stream = TcpStream::connect(target.host()).await?;
                let connector = TlsConnector::from(config.clone());
                let stream = connector.connect(name.clone(), stream).await?;
                Ok(Self::Stream(Box::new(stream)))
            }
        }
    }

    /// Sends the texts of events.
    pub(super) async fn send(&mut self, texts: &[String]) -> io::Result<()> {
        match self {
            Self::Datagrams(socket, address) => {
                for text in texts {
                    socket.send_to(text.as_bytes(), *address).await?;
                }
                Ok(())
            }
            Self::Stream(stream) => {
                for text in texts {
                    stream.write_all(text.as_bytes()).await?;
                }
                stream.flush().await
            }
        }
    }

    /// Why the connection ends, when it does. What a server sends is read and dropped: one that cannot get rid of it would
    /// end the connection. Cancel safe.
    pub(super) async fn ends(&mut self) -> io::Error {
        let Self::Stream(stream) = self else { return std::future::pending().await };
        let mut buffer = [0; 4096];
        loop {
            match stream.read(&mut buffer).await {
                Ok(0) => return io::ErrorKind::UnexpectedEof.into(),
                Ok(_) => {}
                Err(error) => return error,
            }
        }
    }
}

async fn lookup(host: &str) -> io::Result<SocketAddr> {
    let address = lookup_host(host).await?.next();
    address.ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "the name has no address"))
}
