//! Whom Zenoh turns away, told in plain words.
//!
//! Zenoh tells refused connections and messages in its own log only: some as warnings that hint at something else, some
//! where nobody looks. This layer of the log listens there, and says of each refusal once a minute what it means.

use std::cell::Cell;
use std::fmt::{self, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Instant;

use tracing::field::{Field, Visit};
use tracing::{Event, Level, Metadata, Subscriber};
use tracing_subscriber::layer::{Context, Filter, Layer};
use tracing_subscriber::registry::LookupSpan;

use crate::log_limit::{LogLimit, PERIOD};

/// So many may wait to be told.
const MOST: usize = 1000;

const TLS: &str = "zenoh_link_tls";
const CALLS: &str = "zenoh::net::runtime::orchestrator";
const ACCESS: &str = "zenoh::net::routing::interceptor::access_control";

/// A layer that listens to Zenoh, and tells what is refused as warnings of this module. It hears nothing unless it is
/// part of the subscriber of the whole program.
#[must_use]
pub fn layer<S: Subscriber + for<'a> LookupSpan<'a>>() -> impl Layer<S> {
    let (sender, receiver) = sync_channel(MOST);
    // A thread of its own: an event must not cause another while it is being told.
    std::thread::spawn(move || tell(&receiver));
    Listener { sender }.with_filter(Listened)
}

/// What can be a refusal.
struct Listened;

impl<S> Filter<S> for Listened {
    fn enabled(&self, metadata: &Metadata<'_>, _: &Context<'_, S>) -> bool {
        let most = match metadata.target() {
            target if target.starts_with(TLS) => Level::WARN,
            CALLS => Level::DEBUG,
            ACCESS => Level::TRACE,
            _ => return false,
        };
        *metadata.level() <= most
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
            // Of more than can be told some are not.
            let _ = self.sender.try_send(refusal);
        }
    }
}

/// What an event says.
#[derive(Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "message" {
            // A string takes all that is written to it.
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
            let what = refusal.as_deref().unwrap_or("refusals of too many kinds to be told apart");
            tracing::warn!("{count} more in {} s, not told: {what}", PERIOD.as_secs());
        }
        match refusal {
            Ok(refusal) if limit.admits(now, &refusal) => tracing::warn!("{refusal}"),
            Ok(_) | Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

/// What one of Zenoh's messages means, if it tells of a refusal.
fn understand(target: &str, message: &str) -> Option<String> {
    match target {
        target if target.starts_with(TLS) => understand_handshake(message),
        CALLS => understand_call(message),
        ACCESS => understand_access(message),
        _ => None,
    }
}

/// Somebody called, and was not what it should be.
fn understand_handshake(message: &str) -> Option<String> {
    let reason = message.strip_suffix(". Hint: increase the system open file limit.")?;
    if reason.contains("os error 23)") || reason.contains("os error 24)") {
        return Some(format!("cannot take a connection: {reason}; more files must be allowed to be open"));
    }
    if reason.contains("have not agreed on TLS") {
        return Some(format!("refused a connection: {reason}"));
    }
    let meaning = if reason.contains("InvalidContentType") {
        "the caller does not speak TLS"
    } else if reason.contains("no certificates") {
        "the caller has no certificate"
    } else if reason.contains("UnknownIssuer") || reason.contains("BadSignature") {
        "the caller's certificate is not of this mission's authority"
    } else if reason.contains("xpired") {
        "the caller's certificate has expired"
    } else {
        "the handshake failed"
    };
    Some(format!("refused a connection: {meaning} ({reason})"))
}

/// Somebody was called, and one of the two refused the other; or the network for it is not there.
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
    is_refusal.then(|| format!("no connection to {peer}, one side refuses the other: {reason}"))
}

thread_local! {
    /// Whether Zenoh is working out all that is allowed under a key, though nobody has tried it.
    static IS_ASSESSING: Cell<bool> = const { Cell::new(false) };
}

/// The last of the messages that are assessed for a key.
const LAST_ASSESSED: &str = "Declare Liveliness Subscriber (";

/// Somebody is connected, and tried what it may not.
fn understand_access(message: &str) -> Option<String> {
    if message.contains("did not match any configured ACL subject") {
        let who = message.split(' ').next().unwrap_or_default();
        return Some(format!(
            "refused all that {who} says: these settings know no such certificate, or it has been revoked"
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
    let (who, what) = cached.unwrap_or(message).split_once(" is unauthorized to ")?;
    let (what, key) = what.split_once(" (ingress) on ")?;
    Some(format!("refused {what} of {} under {key}: it may not", name(who)))
}

/// The name of a certificate in the names of a connection, or all of them.
fn name(connection: &str) -> &str {
    let names = connection.rsplit(" on ").next().unwrap_or(connection);
    let name = names.split('+').find(|name| name.contains('#')).unwrap_or(names);
    name.trim_start_matches("CertCommonName(").trim_end_matches(')')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_are_told_in_plain_words_and_nothing_else_is() {
        let check = |target: &str, message: &str, expected: Option<&str>| {
            assert_eq!(understand(target, message).as_deref(), expected);
        };
        let tls = "zenoh_link_tls::unicast";
        check(
            tls,
            "peer sent no certificates. Hint: increase the system open file limit.",
            Some("refused a connection: the caller has no certificate (peer sent no certificates)"),
        );
        check(
            tls,
            "192.0.2.7 calls while 64 of its connections have not agreed on TLS. Hint: increase the system open file limit.",
            Some("refused a connection: 192.0.2.7 calls while 64 of its connections have not agreed on TLS"),
        );
        check(tls, "Skipping name verification of TLS server", None);
        check(
            CALLS,
            "Unable to connect to configured peer tls/1.2.3.4:5! invalid peer certificate: UnknownIssuer. Retry in 1s.",
            Some(
                "no connection to tls/1.2.3.4:5, one side refuses the other: invalid peer certificate: UnknownIssuer",
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
            Some("refused Put of robot-2#4 under dragnet/m/robots/1/intent: it may not"),
        );
        check(
            ACCESS,
            "7f on lo+robot-2#4+tls+7f is authorized to Put (ingress) on dragnet/m/robots/2/intent",
            None,
        );
    }

    #[test]
    fn what_nobody_has_tried_is_no_refusal() {
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
