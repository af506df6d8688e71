//! How a session is opened: explicit endpoints, nothing found by chance.

use std::hash::{BuildHasher, RandomState};
use std::net::TcpListener;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use tokio::runtime::Runtime;
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
    /// How the session takes part in the network: a peer without, or as the file of further settings says.
    pub mode: Option<Mode>,
    /// Further settings of Zenoh, a JSON5 file.
    pub config: Option<PathBuf>,
}

/// How a session takes part in the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// It talks to those whom it is connected with.
    Peer,
    /// It also passes on what others say to each other, of those that are routers too: who can reach one of them reaches
    /// all. (To a Zenoh client or peer a lost router would be the end of the network, or of those behind it.)
    Router,
}

impl Mode {
    const fn name(self) -> &'static str {
        match self {
            Self::Peer => "peer",
            Self::Router => "router",
        }
    }
}

/// What sessions and their participants run on.
pub(crate) fn runtime() -> Result<Runtime, LinkError> {
    Runtime::new().map_err(|error| LinkError::Zenoh { what: "start".to_owned(), reason: error.to_string() })
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
    if let Some(mode) = endpoints.mode {
        config.insert_json5("mode", &format!("{:?}", mode.name())).map_err(refused)?;
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

/// Where free ports are looked for: below those that systems give to outgoing connections, which the sessions of a
/// mesh open many of before the last one listens.
const PORTS: std::ops::Range<u16> = 20_000..32_000;

/// So many endpoints on this machine's loopback interface that are free now. The search starts anywhere, so that two
/// that run side by side hardly meet.
///
/// # Errors
/// If so many are not free.
pub fn free_endpoints(count: usize) -> Result<Vec<String>, LinkError> {
    let ports = PORTS.len() as u64;
    let start = RandomState::new().hash_one(std::process::id()) % ports;
    let candidates = (0..ports).map(|step| PORTS.start + u16::try_from((start + step) % ports).unwrap_or(0));
    // All are held until the last is known, so that no two are equal.
    let sockets: Vec<(u16, TcpListener)> = candidates
        .filter_map(|port| Some((port, TcpListener::bind(("127.0.0.1", port)).ok()?)))
        .take(count)
        .collect();
    if sockets.len() < count {
        let reason = format!("{count} free ports are needed, {} are there", sockets.len());
        return Err(LinkError::Open { listen: format!("tcp/127.0.0.1:{PORTS:?}"), reason });
    }
    Ok(sockets.iter().map(|(port, _)| format!("tcp/127.0.0.1:{port}")).collect())
}
