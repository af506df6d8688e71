//! The session on a robot's ROS 2 network.

use zenoh::{Config, Session, Wait};

use super::settings::{Mode, Network};
use crate::RuntimeError;
use crate::session::{json, read, wait_for_network};

/// Opens a session by the settings: it connects until there is an answer. Zenoh's own future would block its thread
/// that long.
///
/// # Errors
/// If the settings are not Zenoh's.
pub(super) async fn open(network: &Network) -> Result<Session, RuntimeError> {
    let listen = network.listen.join(", ");
    let refused =
        |error: zenoh::Error| RuntimeError::Open { listen: listen.clone(), reason: error.to_string() };
    let mut config = match &network.config {
        Some(file) => read(file)?,
        None => Config::default(),
    };
    let mode = match network.mode {
        Mode::Client => "\"client\"",
        Mode::Peer => "\"peer\"",
    };
    let settings = [
        ("mode", mode),
        ("connect/endpoints", &json(&network.connect)),
        ("listen/endpoints", &json(&network.listen)),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
        // Latched messages are stored by time.
        ("timestamping/enabled", "true"),
    ];
    for (key, value) in settings {
        config.insert_json5(key, value).map_err(refused)?;
    }
    // A robot may start before its router and its network.
    wait_for_network(&mut config).map_err(refused)?;
    let opening = tokio::task::spawn_blocking(move || zenoh::open(config).wait());
    opening.await.map_err(|error| refused(error.into()))?.map_err(refused)
}
