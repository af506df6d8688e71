//! Logs connections and messages that Zenoh rejects, with their meaning.
//!
//! Zenoh reports rejections in its own log only: some as misleading warnings, some at levels that are not shown. This
//! layer of the log listens to those, and logs the meaning of each rejection once a minute.

use std::cell::Cell;
use std::fmt::{self, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Instant;

use tracing::field::{Field, Visit};
use tracing::subscriber::Interest;
use tracing::{Event, Level, Metadata, Subscriber};
use tracing_subscriber::layer::{Context, Filter, Layer};
use tracing_subscriber::registry::LookupSpan;

use crate::log_limit::{LogLimit, PERIOD};

/// The maximum number of pending rejections.
const MOST: usize = 1000;

const TLS: &str = "zenoh_link_tls";
const CALLS: &str = "zenoh::net::runtime::orchestrator";
const ACCESS: &str = "zenoh::net::routing::interceptor::access_control";

/// A layer that receives Zenoh's log events, and logs rejections as warnings of this module. It must be part of the
/// program's global subscriber.
#[must_use]
pub fn layer<S: Subscriber + for<'a> LookupSpan<'a>>() -> impl Layer<S> {
    let (sender, receiver) = sync_channel(MOST);
    // On a separate thread: an event must not cause another during its handling.
    std::thread::spawn(move || tell(&receiver));
    Listener { sender }.with_filter(Listened)
}

/// Events that can be rejections.
struct Listened;

impl Listened {
    fn includes(metadata: &Metadata<'_>) -> bool {
        let most = match metadata.target() {
            target if target.starts_with(TLS) => Level::WARN,
            CALLS => Level::DEBUG,
            ACCESS => Level::TRACE,
            _ => return false,
        };
        metadata.is_event() && *metadata.level() <= most
    }
}

impl<S> Filter<S> for Listened {
    fn enabled(&self, metadata: &Metadata<'_>, _: &Context<'_, S>) -> bool {
        Self::includes(metadata)
    }

    /// Asked once for each place that logs: Zenoh has many that trace each message.
    fn callsite_enabled(&self, metadata: &'static Metadata<'static>) -> Interest {
        if Self::includes(metadata) { Interest::always() } else { Interest::never() }
    }
}

struct Listener {
    sender: SyncSender<String>,
}

impl<S: Subscriber> Layer<S> for Listener {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let mut text = Text::default();
        event.record(&mut text);
        if let Some(refusal) = understand(event.metadata().target(), &text.0) {
            // Of too many rejections some are dropped.
            let _ = self.sender.try_send(refusal);
        }
    }
}

/// The text of an event.
#[derive(Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "message" {
            // Writing to a string cannot fail.
            let _ = write!(self.0, "{value:?}");
        }
    }
}

fn tell(refusals: &Receiver<String>) {
    let mut limit: LogLimit<String> = LogLimit::default();
    loop {
        let due = limit.due().map_or(PERIOD, |due| due.saturating_duration_since(Instant::now()));
        let refusal = refusals.recv_timeout(due);
        let now = Instant::now();
        for (refusal, count) in limit.settle(now) {
            let what = refusal.as_deref().unwrap_or("rejections of too many kinds to list");
            tracing::warn!("{count} more in {} s, not logged: {what}", PERIOD.as_secs());
        }
        match refusal {
            Ok(refusal) if limit.admits(now, &refusal) => tracing::warn!("{refusal}"),
            Ok(_) | Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

/// The meaning of one of Zenoh's messages, if it reports a rejection.
fn understand(target: &str, message: &str) -> Option<String> {
    match target {
        target if target.starts_with(TLS) => understand_handshake(message),
        CALLS => understand_call(message),
        ACCESS => understand_access(message),
        _ => None,
    }
}

/// An incoming connection was rejected.
fn understand_handshake(message: &str) -> Option<String> {
    let reason = message.strip_suffix(". Hint: increase the system open file limit.")?;
    if reason.contains("os error 23)") || reason.contains("os error 24)") {
        return Some(format!("cannot take a connection: {reason}; more files must be allowed to be open"));
    }
    if reason.contains("have not agreed on TLS") {
        return Some(format!("rejected a connection: {reason}"));
    }
    let meaning = if reason.contains("InvalidContentType") {
        "the client does not use TLS"
    } else if reason.contains("no certificates") {
        "the client has no certificate"
    } else if reason.contains("UnknownIssuer") || reason.contains("BadSignature") {
        "the caller's certificate is not of this mission's authority"
    } else if reason.contains("xpired") {
        "the caller's certificate has expired"
    } else {
        "the handshake failed"
    };
    Some(format!("rejected a connection: {meaning} ({reason})"))
}

/// An outgoing connection was rejected by either side, or its network is not there.
fn understand_call(message: &str) -> Option<String> {
    if let Some(listener) = message.strip_prefix("Unable to open listener ") {
        return Some(format!("cannot listen yet, and tries again: {listener}"));
    }
    let call = message.strip_prefix("Unable to connect to configured peer ")?;
    let (call, _) = call.rsplit_once(". Retry in")?;
    let (peer, reason) = call.split_once("! ")?;
    if reason.contains("lookup address") {
        return Some(format!("no address of {peer} is known yet, and it is tried again: {reason}"));
    }
    let is_refusal = ["certificate", "alert", "corrupt message"].iter().any(|sign| reason.contains(sign));
    is_refusal.then(|| format!("no connection to {peer}, one side rejects the other: {reason}"))
}

thread_local! {
    /// Whether Zenoh is evaluating all permissions of a key, without any attempt to use it.
    static IS_ASSESSING: Cell<bool> = const { Cell::new(false) };
}

/// The last of the messages when a key is evaluated.
const LAST_ASSESSED: &str = "Declare Liveliness Subscriber (";

/// A connected participant tried something that it may not do.
fn understand_access(message: &str) -> Option<String> {
    if message.contains("did not match any configured ACL subject") {
        let participant = message.split(' ').next().unwrap_or_default();
        return Some(format!(
            "rejected all messages of {participant}: these settings have no such certificate, or it has been revoked"
        ));
    }
    if message.starts_with("ACL (") {
        IS_ASSESSING.set(true);
        return None;
    }
    let cached = message.strip_prefix("Using cached result: ");
    if cached.is_none() && IS_ASSESSING.get() {
        IS_ASSESSING.set(!message.contains(LAST_ASSESSED));
        return None;
    }
    let (participant, what) = cached.unwrap_or(message).split_once(" is unauthorized to ")?;
    let (what, key) = what.split_once(" (ingress) on ")?;
    Some(format!("refused {what} of {} under {key}: not allowed", name(participant)))
}

/// The name of a certificate among the names of a connection, or all of them.
fn name(connection: &str) -> &str {
    let names = connection.rsplit(" on ").next().unwrap_or(connection);
    let name = names.split('+').find(|name| name.contains('#')).unwrap_or(names);
    name.trim_start_matches("CertCommonName(").trim_end_matches(')')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejections_are_logged_in_plain_words_and_nothing_else_is() {
        let check = |target: &str, message: &str, expected: Option<&str>| {
            assert_eq!(understand(target, message).as_deref(), expected);
        };
        let tls = "zenoh_link_tls::unicast";
        check(
            tls,
            "peer sent no certificates. Hint: increase the system open file limit.",
            Some("rejected a connection: the client has no certificate (peer sent no certificates)"),
        );
        check(
            tls,
            "192.0.2.7 calls while 64 of its connections have not agreed on TLS. Hint: increase the system open file limit.",
            Some("rejected a connection: 192.0.2.7 calls while 64 of its connections have not agreed on TLS"),
        );
        check(tls, "Skipping name verification of TLS server", None);
        check(
            CALLS,
            "Unable to connect to configured peer tls/1.2.3.4:5! invalid peer certificate: UnknownIssuer. Retry in 1s.",
            Some(
                "no connection to tls/1.2.3.4:5, one side rejects the other: invalid peer certificate: UnknownIssuer",
            ),
        );
        check(
            CALLS,
            "Unable to connect to configured peer tls/1.2.3.4:5! Connection refused (os error 111). Retry in 1s.",
            None,
        );
        check(
            CALLS,
            "Unable to connect to configured peer tcp/nobody:5! failed to lookup address information: Name or service not known. Retry in 1s.",
            Some(
                "no address of tcp/nobody:5 is known yet, and it is tried again: failed to lookup address information: Name or service not known",
            ),
        );
        check(
            CALLS,
            "Unable to open listener tcp/192.0.2.7:5: Cannot assign requested address (os error 99)",
            Some(
                "cannot listen yet, and tries again: tcp/192.0.2.7:5: Cannot assign requested address (os error 99)",
            ),
        );
        check(
            ACCESS,
            "7f on lo+CertCommonName(robot-2#4)+tls+7f is unauthorized to Put (ingress) on dragnet/m/robots/1/intent",
            Some("refused Put of robot-2#4 under dragnet/m/robots/1/intent: not allowed"),
        );
        check(
            ACCESS,
            "7f on lo+robot-2#4+tls+7f is authorized to Put (ingress) on dragnet/m/robots/2/intent",
            None,
        );
    }

    #[test]
    fn an_evaluation_of_permissions_is_not_a_rejection() {
        let put = "7f on lo+robot-2#4+tls+7f is unauthorized to Put (ingress) on k";
        let last =
            "7f on lo+robot-2#4+tls+7f is unauthorized to Declare Liveliness Subscriber (ingress) on k";
        assert_eq!(understand(ACCESS, "ACL (ingress): caching permissions for `k` ..."), None);
        assert_eq!(understand(ACCESS, put), None);
        assert_eq!(understand(ACCESS, last), None);
        assert!(understand(ACCESS, put).is_some());
        assert!(
            understand(ACCESS, "Using cached result: 7f is unauthorized to Put (ingress) on k").is_some()
        );
    }
}
