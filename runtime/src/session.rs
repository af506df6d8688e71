//! Opening of sessions: explicit endpoints, no discovery.

use std::collections::BTreeSet;
use std::hash::{BuildHasher, RandomState};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

use dragnet_files::{check_plain, open_plain};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tokio::runtime::Runtime;
use zenoh::{Config, Session};

use crate::{RuntimeError, endpoint};

/// A Zenoh session.
#[derive(Clone, Debug, Default, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Endpoints {
    /// Zenoh endpoints to listen on, such as `tcp/192.168.1.7:7140`.
    pub listen: Vec<String>,
    /// Zenoh endpoints to connect to; those that do not answer are tried again.
    pub connect: Vec<String>,
    /// Role of the session: `peer` by default, or as the file under `config` says.
    pub mode: Option<Mode>,
    /// Further settings of Zenoh, a JSON5 file, relative to the file that names it. Certificates and keys that it names
    /// are relative to itself.
    pub config: Option<PathBuf>,
}

/// How a session takes part in the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Exchanges messages with direct connections only.
    Peer,
    /// Also forwards messages between other routers: a participant that reaches one of them reaches all. (A Zenoh client
    /// or peer would lose the network with its router.)
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

impl Endpoints {
    /// The endpoints with paths relative to the file that names them.
    #[must_use]
    pub fn named_in(mut self, file: &Path) -> Self {
        let folder = file.parent().unwrap_or(Path::new(""));
        self.config = self.config.map(|config| folder.join(config));
        self
    }

    /// Checks the endpoints and that there is a file of Zenoh's settings if one is named, in the file of settings under
    /// this key.
    ///
    /// # Errors
    /// The first endpoint that can never work, with its key and the allowed values.
    pub(crate) fn check(&self, key: &str, file: &Path) -> Result<(), String> {
        for (name, endpoints) in [("listen", &self.listen), ("connect", &self.connect)] {
            for endpoint in endpoints {
                endpoint::check_one(endpoint)
                    .map_err(|reason| format!("{key}.{name}: {endpoint:?}: {reason}"))?;
            }
        }
        let Some(config) = self.clone().named_in(file).config else { return Ok(()) };
        open_plain(&config)
            .map(|_| ())
            .map_err(|error| format!("{key}.config: {}: {error}", config.display()))
    }
}

/// Runs a participant to its end. Whatever still waits then, such as a session for a router, is dropped.
pub(crate) fn block_on<T>(
    participant: impl Future<Output = Result<T, RuntimeError>>,
) -> Result<T, RuntimeError> {
    let runtime = runtime()?;
    let ended = runtime.block_on(participant);
    runtime.shutdown_background();
    ended
}

/// The runtime of sessions and their participants.
pub(crate) fn runtime() -> Result<Runtime, RuntimeError> {
    allow_more_files();
    Runtime::new()
        .map_err(|error| RuntimeError::Zenoh { what: "start".to_owned(), reason: error.to_string() })
}

/// Raises the limit of open files to the maximum: each connection is one, and unauthenticated ones count until they are
/// rejected. Many systems start with 1,024, and allow far more.
fn allow_more_files() {
    let limit = getrlimit(Resource::Nofile);
    if limit.current < limit.maximum || limit.maximum.is_none() {
        // If that fails, it continues with the current limit.
        let _ = setrlimit(Resource::Nofile, Rlimit { current: limit.maximum, maximum: limit.maximum });
    }
}

/// Opens a session. Scouting is off unless the Zenoh settings file turns it on.
///
/// # Errors
/// If Zenoh rejects the settings, or cannot listen now.
pub async fn open(endpoints: &Endpoints) -> Result<Session, RuntimeError> {
    zenoh::open(settings(endpoints)?).await.map_err(refused(endpoints))
}

/// Opens a session for a process in the field, whose network may become available later: if it cannot listen yet,
/// because an address does not exist or another process uses the port, it tries again every few seconds without limit;
/// so it does for connections. Once a minute it logs what is missing ([`crate::refusals`]).
///
/// # Errors
/// If Zenoh rejects the settings, or they name an endpoint that can never work (`endpoint.rs`).
pub async fn open_when_there(endpoints: &Endpoints) -> Result<Session, RuntimeError> {
    let mut config = settings(endpoints)?;
    let impossible = |reason: String| match &endpoints.config {
        Some(file) => RuntimeError::Settings { file: file.clone(), reason },
        None => RuntimeError::Open { listen: endpoints.listen.join(", "), reason },
    };
    endpoint::check(&config).map_err(impossible)?;
    for name in TLS_FILES {
        if let Some(path) = tls_file(&config, name) {
            let reported =
                |error| impossible(format!("transport/link/tls/{name}: {}: {error}", path.display()));
            std::fs::File::open(&path).map_err(reported)?;
        }
    }
    wait_for_network(&mut config).map_err(refused(endpoints))?;
    zenoh::open(config).await.map_err(refused(endpoints))
}

/// Leaves the network, with a time limit: a session that cannot listen yet closes only once it can. The rest of it ends
/// with the process.
async fn leave(session: &Session) {
    // The others detect the closed connection anyway.
    let _ = tokio::time::timeout(LEAVING, session.close()).await;
}

/// Runs a participant on a session, and leaves the network afterwards, however it ended.
pub(crate) async fn leaving<T>(session: &Session, participant: impl Future<Output = T>) -> T {
    let ended = participant.await;
    leave(session).await;
    ended
}

/// Time limit for closing a session.
const LEAVING: Duration = Duration::from_millis(500);

/// Makes the session retry listening and connecting until it succeeds.
pub(crate) fn wait_for_network(config: &mut Config) -> Result<(), zenoh::Error> {
    for place in ["listen", "connect"] {
        config.insert_json5(&format!("{place}/timeout_ms"), "-1")?;
        config.insert_json5(&format!("{place}/exit_on_failure"), "false")?;
    }
    Ok(())
}

fn refused(endpoints: &Endpoints) -> impl Fn(zenoh::Error) -> RuntimeError + use<> {
    let listen = endpoints.listen.join(", ");
    move |error| RuntimeError::Open { listen: listen.clone(), reason: error.to_string() }
}

/// That a process with these endpoints can never meet another, and what to do about it, if so. Settings that Zenoh rejects
/// say nothing.
#[must_use]
pub fn alone(endpoints: &Endpoints) -> Option<[&'static str; 2]> {
    let config = merged(endpoints).ok()?;
    let value = |key: &str| config.get_json(key).unwrap_or_default();
    let is_empty = |key: &str| endpoint::listed(&value(key)).is_empty();
    let does_scout = value("scouting/multicast/enabled") != "false";
    let is_alone = is_empty("listen/endpoints") && is_empty("connect/endpoints") && !does_scout;
    is_alone.then_some([
        "it listens nowhere, connects to nobody and does not scout: it can meet no other participant",
        "under zenoh write listen = [\"tcp/ADDRESS:PORT\"] with an address of this computer, or connect = [\"tcp/ADDRESS:PORT\"] \
         with that of another participant, or both",
    ])
}

/// Zenoh's settings for these endpoints, checked.
fn settings(endpoints: &Endpoints) -> Result<Config, RuntimeError> {
    let config = merged(endpoints)?;
    if let Some(endpoint) = beyond_tls(&config) {
        return Err(RuntimeError::Unsupported(format!(
            "connect {endpoint:?}: Zenoh's TLS cannot call a number of IPv6; allowed are a number of IPv4 and a name, as \
             `/etc/hosts` or mDNS may give it to this number"
        )));
    }
    let open_to_all = exposed(&config);
    if !open_to_all.is_empty() {
        tracing::warn!(
            "listening at {} without TLS, not on loopback: anyone who reaches this address can take part and impersonate \
             anybody; `dragnet keys` makes certificates",
            open_to_all.join(", ")
        );
    }
    Ok(config)
}

/// The settings of the file that is named, with these endpoints.
fn merged(endpoints: &Endpoints) -> Result<Config, RuntimeError> {
    let refused = refused(endpoints);
    let mut config = match &endpoints.config {
        Some(file) => read(file)?,
        None => private().map_err(&refused)?,
    };
    if !endpoints.listen.is_empty() || endpoints.config.is_none() {
        config.insert_json5("listen/endpoints", &json(&endpoints.listen)).map_err(&refused)?;
    }
    // One list for a whole team has the process itself in it.
    let is_other = |endpoint: &&String| !endpoints.listen.contains(endpoint);
    let others: Vec<String> = endpoints.connect.iter().filter(is_other).cloned().collect();
    if !others.is_empty() {
        config.insert_json5("connect/endpoints", &json(&others)).map_err(&refused)?;
    }
    if let Some(mode) = endpoints.mode {
        config.insert_json5("mode", &format!("{:?}", mode.name())).map_err(&refused)?;
    }
    Ok(config)
}

/// Endpoints that anybody on the same network can connect to without a certificate.
fn exposed(config: &Config) -> Vec<String> {
    let listen = config.get_json("listen/endpoints").unwrap_or_default();
    let is_private = |endpoint: &str| {
        let (protocol, rest) = endpoint.split_once('/').unwrap_or(("", endpoint));
        let address = rest.split(['?', '#']).next().unwrap_or(rest);
        let host = address.rsplit_once(':').map_or(address, |(host, _)| host).trim_matches(['[', ']']);
        let is_loopback = host == "localhost"
            || host.parse::<std::net::IpAddr>().is_ok_and(|address| address.is_loopback());
        is_loopback || matches!(protocol, "tls" | "quic") && is_mutual(config)
    };
    endpoint::listed(&listen).into_iter().filter(|endpoint| !is_private(endpoint)).collect()
}

/// An endpoint that a session cannot connect to: Zenoh takes the brackets of the address for a part of the host's name,
/// finds that no certificate can be for such a name, and reports this only at a hidden log level.
fn beyond_tls(config: &Config) -> Option<String> {
    let called = config.get_json("connect/endpoints").unwrap_or_default();
    endpoint::listed(&called).into_iter().find(|endpoint| endpoint.starts_with("tls/["))
}

fn is_mutual(config: &Config) -> bool {
    config.get_json("transport/link/tls/enable_mtls").is_ok_and(|value| value == "true")
}

/// A peer that connects to its configured endpoints only.
fn private() -> Result<Config, zenoh::Error> {
    let mut config = Config::default();
    config.insert_json5("mode", "\"peer\"")?;
    config.insert_json5("scouting/multicast/enabled", "false")?;
    config.insert_json5("scouting/gossip/enabled", "false")?;
    config.insert_json5("listen/exit_on_failure", "true")?;
    // Participants wait for each other's tokens. Zenoh 1.10 would also wait for half a second, in vain, whenever the declarations
    // of a peer arrive before it has noted that it is connected to this peer.
    config.insert_json5("open/return_conditions/declares", "false")?;
    Ok(config)
}

/// The maximum size of a file that Zenoh reads, bytes.
const MAX_FILE_BYTES: u64 = 1 << 22;

/// Zenoh settings from a file: without endpoints it does not listen, and files that it names are relative to it.
pub(crate) fn read(file: &Path) -> Result<Config, RuntimeError> {
    let failed =
        |error: zenoh::Error| RuntimeError::Settings { file: file.to_owned(), reason: error.to_string() };
    let endless = |path: &Path, error: std::io::Error| RuntimeError::Settings {
        file: file.to_owned(),
        reason: format!("{}: {error}", path.display()),
    };
    check_plain(file, MAX_FILE_BYTES).map_err(|error| endless(file, error))?;
    let mut config = Config::from_file(file).map_err(failed)?;
    let listen = "listen/endpoints";
    let usual = Config::default().get_json(listen).map_err(failed)?;
    if config.get_json(listen).map_err(failed)? == usual {
        // By default Zenoh listens on every interface.
        config.insert_json5(listen, "[]").map_err(failed)?;
    }
    for name in TLS_FILES {
        let key = format!("transport/link/tls/{name}");
        if let Some(path) = tls_file(&config, name) {
            let path = file.parent().unwrap_or(Path::new("")).join(path);
            check_plain(&path, MAX_FILE_BYTES).map_err(|error| endless(&path, error))?;
            config.insert_json5(&key, &format!("{:?}", path.display().to_string())).map_err(failed)?;
        }
    }
    Ok(config)
}

/// The listening endpoints of the settings.
///
/// # Errors
/// If they are not Zenoh's.
pub(crate) fn listened(endpoints: &Endpoints) -> Result<Vec<String>, RuntimeError> {
    match &endpoints.config {
        Some(file) if endpoints.listen.is_empty() => {
            let listen = read(file)?.get_json("listen/endpoints").unwrap_or_default();
            Ok(endpoint::listed(&listen))
        }
        _ => Ok(endpoints.listen.clone()),
    }
}

/// The files of the certificates that a session presents and trusts, as named in its settings.
///
/// # Errors
/// If Zenoh rejects the settings.
pub fn certificates(endpoints: &Endpoints) -> Result<BTreeSet<PathBuf>, RuntimeError> {
    let Some(file) = &endpoints.config else { return Ok(BTreeSet::new()) };
    let config = read(file)?;
    let named = TLS_FILES.iter().filter(|name| name.ends_with("certificate"));
    Ok(named.filter_map(|name| tls_file(&config, name)).collect())
}

/// The file that a setting of TLS names, if any.
fn tls_file(config: &Config, name: &str) -> Option<PathBuf> {
    let value = config.get_json(&format!("transport/link/tls/{name}")).unwrap_or_default();
    serde_json::from_str(&value).ok()
}

/// Settings of Zenoh that name files.
const TLS_FILES: [&str; 5] = [
    "root_ca_certificate",
    "listen_certificate",
    "listen_private_key",
    "connect_certificate",
    "connect_private_key",
];

pub(crate) fn json(endpoints: &[String]) -> String {
    let quoted: Vec<String> = endpoints.iter().map(|endpoint| format!("{endpoint:?}")).collect();
    format!("[{}]", quoted.join(","))
}

/// The range in which free ports are searched: below that of outgoing connections, which the sessions of a mesh open
/// many of before the last one listens.
const PORTS: std::ops::Range<u16> = 20_000..32_000;

/// The next port to try, from the beginning of the range. It begins at random, so that two processes hardly find the
/// same ports, and only increases, so that one process does not find the same port twice before it is used.
static NEXT_PORT: LazyLock<AtomicUsize> = LazyLock::new(|| {
    let random = RandomState::new().hash_one(std::process::id());
    AtomicUsize::new(usize::try_from(random % PORTS.len() as u64).unwrap_or(0))
});

/// Finds `count` free endpoints on this computer's loopback interface.
///
/// # Errors
/// If there are not enough free ports.
pub fn free_endpoints(count: usize) -> Result<Vec<String>, RuntimeError> {
    let port = |next: usize| PORTS.start + u16::try_from(next % PORTS.len()).unwrap_or(0);
    let candidates = (0..PORTS.len()).map(|_| port(NEXT_PORT.fetch_add(1, Relaxed)));
    // All are held until the last is found, so that no two are equal.
    let sockets: Vec<(u16, TcpListener)> = candidates
        .filter_map(|port| Some((port, TcpListener::bind(("127.0.0.1", port)).ok()?)))
        .take(count)
        .collect();
    if sockets.len() < count {
        let reason = format!("{count} free ports are needed, {} are there", sockets.len());
        return Err(RuntimeError::Open { listen: format!("tcp/127.0.0.1:{PORTS:?}"), reason });
    }
    Ok(sockets.iter().map(|(port, _)| format!("tcp/127.0.0.1:{port}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn listening_to_all_without_certificates_is_reported() {
        let check = |listen: &str, is_mutual: bool, expected: bool| {
            let mut config = Config::default();
            config.insert_json5("listen/endpoints", &format!("[{listen:?}]")).unwrap();
            config.insert_json5("transport/link/tls/enable_mtls", &is_mutual.to_string()).unwrap();
            assert_eq!(!exposed(&config).is_empty(), expected, "{listen}");
        };
        check("tcp/127.0.0.1:7447", false, false);
        check("tcp/localhost:7447", false, false);
        check("tcp/[::1]:7447", false, false);
        check("tcp/0.0.0.0:7447", false, true);
        check("tcp/[::]:7447", false, true);
        check("tcp/192.168.1.7:7447#iface=eth0", true, true);
        check("tls/192.168.1.7:7447", true, false);
        check("tls/192.168.1.7:7447", false, true);
    }

    #[tokio::test]
    async fn endpoints_that_tls_cannot_reach_are_rejected_at_once() {
        for (endpoint, is_refused) in
            [("tls/[::1]:7447", true), ("tcp/[::1]:7447", false), ("tls/localhost:7447", false)]
        {
            let endpoints = Endpoints { connect: vec![endpoint.to_owned()], ..Endpoints::default() };
            let mut config = private().unwrap();
            config.insert_json5("connect/endpoints", &json(&endpoints.connect)).unwrap();
            assert_eq!(beyond_tls(&config).is_some(), is_refused, "{endpoint}");
            if is_refused {
                let error = open(&endpoints).await.unwrap_err();
                assert!(error.is_bad_input() && error.to_string().contains(endpoint), "{error}");
            }
        }
    }

    #[test]
    fn settings_that_name_no_endpoint_listen_nowhere_and_their_files_lie_beside_them() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("zenoh.json5");
        let settings = "{ transport: { link: { tls: { listen_private_key: \"a.key\", root_ca_certificate: \"/b.pem\" } } } }";
        std::fs::write(&file, settings).unwrap();
        let config = read(&file).unwrap();
        let value = |key: &str| config.get_json(key).unwrap();
        assert_eq!(value("listen/endpoints"), "[]");
        let key = format!("{:?}", folder.path().join("a.key").display().to_string());
        assert_eq!(value("transport/link/tls/listen_private_key"), key);
        assert_eq!(value("transport/link/tls/root_ca_certificate"), "\"/b.pem\"");
    }

    #[test]
    fn who_neither_listens_nor_connects_nor_scouts_is_alone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("zenoh.json5");
        let check = |listen: &str, connect: &str, settings: Option<&str>, expected: bool| {
            let list = |endpoint: &str| endpoint.split_whitespace().map(str::to_owned).collect();
            let config = settings.map(|text| {
                std::fs::write(&file, text).unwrap();
                file.clone()
            });
            let endpoints = Endpoints { listen: list(listen), connect: list(connect), mode: None, config };
            assert_eq!(alone(&endpoints).is_some(), expected, "{endpoints:?} {settings:?}");
        };
        let (here, quiet) = ("tcp/127.0.0.1:7447", "scouting: { multicast: { enabled: false } }");
        check("", "", None, true);
        check(here, "", None, false);
        check("", here, None, false);
        check("", "", Some(&format!("{{ {quiet} }}")), true);
        check("", "", Some(&format!("{{ {quiet}, connect: {{ endpoints: [{here:?}] }} }}")), false);
        check("", "", Some("{ scouting: { multicast: { enabled: true } } }"), false);
    }

    #[test]
    fn files_without_an_end_are_not_given_to_zenoh() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("zenoh.json5");
        std::fs::write(&file, "{ transport: { link: { tls: { listen_private_key: \"/dev/zero\" } } } }")
            .unwrap();
        let check = |file: &Path| {
            let error = read(file).err().unwrap().to_string();
            assert!(error.contains("/dev/zero: no plain file"), "{error}");
        };
        check(&file);
        check(Path::new("/dev/zero"));
    }
}
