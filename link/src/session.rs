//! How a session is opened: explicit endpoints, nothing found by chance.

use std::net::TcpListener;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use zenoh::{Config, Session};

use crate::LinkError;

/// Where a session listens and whom it calls.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Endpoints {
    /// Zenoh endpoints to listen on, such as `tcp/192.168.1.7:7447`; without one, only this session calls.
    pub listen: Vec<String>,
    /// Zenoh endpoints to call; who does not answer is called again.
    pub connect: Vec<String>,
    /// Further settings of Zenoh, a JSON5 file.
    pub config: Option<PathBuf>,
}

/// Opens a session as a peer: scouting is off unless the settings file turns it on.
///
/// # Errors
/// If the settings are not Zenoh's, or it cannot listen there.
pub async fn open(endpoints: &Endpoints) -> Result<Session, LinkError> {
    let listen = endpoints.listen.join(", ");
    let refused = |error: zenoh::Error| LinkError::Open { listen: listen.clone(), reason: error.to_string() };
    let mut config = match &endpoints.config {
        Some(file) => read(file)?,
        None => private().map_err(refused)?,
    };
    if !endpoints.listen.is_empty() || endpoints.config.is_none() {
        config.insert_json5("listen/endpoints", &json(&endpoints.listen)).map_err(refused)?;
    }
    if !endpoints.connect.is_empty() {
        config.insert_json5("connect/endpoints", &json(&endpoints.connect)).map_err(refused)?;
    }
    zenoh::open(config).await.map_err(refused)
}

/// A peer that meets only those whom it calls or who call it.
fn private() -> Result<Config, zenoh::Error> {
    let mut config = Config::default();
    config.insert_json5("mode", "\"peer\"")?;
    config.insert_json5("scouting/multicast/enabled", "false")?;
    config.insert_json5("scouting/gossip/enabled", "false")?;
    config.insert_json5("listen/exit_on_failure", "true")?;
    Ok(config)
}

fn read(file: &Path) -> Result<Config, LinkError> {
    Config::from_file(file)
        .map_err(|error| LinkError::Settings { file: file.to_owned(), reason: error.to_string() })
}

fn json(endpoints: &[String]) -> String {
    let quoted: Vec<String> = endpoints.iter().map(|endpoint| format!("{endpoint:?}")).collect();
    format!("[{}]", quoted.join(","))
}

/// So many endpoints on this machine's loopback interface that are free now.
///
/// # Errors
/// If the machine has no port left.
pub fn free_endpoints(count: usize) -> Result<Vec<String>, LinkError> {
    let refused = |error: std::io::Error| LinkError::Open {
        listen: "tcp/127.0.0.1:0".to_owned(),
        reason: error.to_string(),
    };
    // All are held until the last is known, so that no two are equal.
    let sockets: Vec<TcpListener> =
        (0..count).map(|_| TcpListener::bind("127.0.0.1:0")).collect::<Result<_, _>>().map_err(refused)?;
    let endpoint = |socket: &TcpListener| Ok(format!("tcp/{}", socket.local_addr().map_err(refused)?));
    sockets.iter().map(endpoint).collect()
}
