use std::io::ErrorKind;
use std::sync::Arc;

use rcgen::{CertifiedKey, generate_simple_self_signed};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::{PrivateKeyDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, RootCertStore, ServerConfig};

use super::*;

const PATIENCE: Duration = Duration::from_mins(1);

/// A listener, and its clients.
struct Field {
    listener: TlsListener,
    address: SocketAddr,
    connector: TlsConnector,
}

impl Field {
    async fn new(handshake_timeout: Duration) -> Self {
        let CertifiedKey { cert, signing_key } =
            generate_simple_self_signed(["localhost".to_owned()]).unwrap();
        let key = PrivateKeyDer::try_from(signing_key.serialize_der()).unwrap();
        let mut roots = RootCertStore::empty();
        roots.add(cert.der().clone()).unwrap();
        let provider = Arc::new(tokio_rustls::rustls::crypto::ring::default_provider());
        let server = ServerConfig::builder_with_provider(Arc::clone(&provider));
        let server = server.with_safe_default_protocol_versions().unwrap().with_no_client_auth();
        let server = server.with_single_cert(vec![cert.der().clone()], key).unwrap();
        let client = ClientConfig::builder_with_provider(provider);
        let client = client.with_safe_default_protocol_versions().unwrap();
        let client = client.with_root_certificates(roots).with_no_client_auth();
        let socket = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = socket.local_addr().unwrap();
        let listener = builder(TlsAcceptor::from(Arc::new(server))).handshake_timeout(handshake_timeout);
        Self { listener: listener.listen(socket), address, connector: TlsConnector::from(Arc::new(client)) }
    }

    async fn call(&self) -> TcpStream {
        TcpStream::connect(self.address).await.unwrap()
    }

    /// An honest client connects, and is the next to be accepted.
    async fn is_open(&mut self) {
        let stream = self.call().await;
        let own = stream.local_addr().unwrap();
        let agree = self.connector.connect(ServerName::try_from("localhost").unwrap(), stream);
        let agree = tokio::spawn(agree);
        let (_, peer) = loop {
            match timeout(PATIENCE, self.listener.accept()).await.unwrap() {
                Ok(agreed) => break agreed,
                // As Zenoh does after each.
                Err(_) => sleep(Duration::from_millis(100)).await,
            }
        };
        assert_eq!(peer, own);
        drop(timeout(PATIENCE, agree).await.unwrap().unwrap().unwrap());
    }
}

/// Waits until the other side has closed the connection, whatever it sends before.
async fn is_over(stream: &mut TcpStream) {
    // It may also end with an error, as where not all has been read.
    let _ = timeout(PATIENCE, stream.read_to_end(&mut Vec::new())).await.unwrap();
}

#[tokio::test]
async fn a_silent_connection_makes_room_and_blocks_no_other() {
    let mut field = Field::new(PATIENCE * 10).await;
    let mut silent = Vec::new();
    for _ in 0..3 * MOST_FROM_ONE {
        silent.push(field.call().await);
    }
    field.is_open().await;
    // They are closed long before their time limit; the last ones stay.
    for stream in &mut silent[..2 * MOST_FROM_ONE] {
        is_over(stream).await;
    }
    let last = silent.last_mut().unwrap();
    assert_eq!(last.try_read(&mut [0]).unwrap_err().kind(), ErrorKind::WouldBlock);
}

#[tokio::test]
async fn a_silent_connection_is_closed_and_reported() {
    let mut field = Field::new(Duration::from_millis(1)).await;
    let mut silent = field.call().await;
    is_over(&mut silent).await;
    let reported = timeout(PATIENCE, field.listener.accept()).await.unwrap().unwrap_err();
    assert_eq!(reported.to_string(), "Timeout during TLS handshake");
}

#[tokio::test]
async fn successful_handshakes_come_before_failed_ones() {
    let mut field = Field::new(PATIENCE).await;
    for _ in 0..2 * MOST_FROM_ONE {
        let mut stream = field.call().await;
        stream.write_all(b"this is no TLS at all").await.unwrap();
        // It is rejected, before any failure has been taken.
        is_over(&mut stream).await;
    }
    field.is_open().await;
    field.is_open().await;
}

#[tokio::test]
async fn a_dropped_listener_accepts_no_more_connections() {
    let field = Field::new(PATIENCE).await;
    let mut silent = field.call().await;
    drop(field.listener);
    is_over(&mut silent).await;
    while TcpStream::connect(field.address).await.is_ok() {
        tokio::task::yield_now().await;
    }
}
