//! The log: a line for each event on stderr, separate from a command's own output.

use std::io::{self, Write};

use dragnet_runtime::{source_places, stop};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::{FilterExt, dynamic_filter_fn};
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

use crate::commands::Command;

/// Configures the log as `RUST_LOG` says or, without it, to warnings, and for a process that serves a mission to its
/// activity, connections and rejected participants.
pub(crate) fn keep(command: &Command) {
    // What Zenoh's sessions take for errors is that messages of participants arrive that have left.
    let libraries = "warn,zenoh=error,zenoh::api::session=off";
    let usual =
        if command.serves() { format!("{libraries},dragnet_runtime=info") } else { libraries.to_owned() };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(usual));
    let filter =
        filter.and(dynamic_filter_fn(|line, _| !(stop::is_ending() && line.target().starts_with("zenoh"))));
    let lines = tracing_subscriber::fmt::layer()
        .with_target(false)
        .with_ansi(console::colors_enabled_stderr())
        // A terminal that is closed while a robot searches takes no more lines, which is no reason to stop.
        .log_internal_errors(false)
        .with_writer(|| Lines);
    // No `Option`: without a filter of its own, a layer that is absent takes part in every event and span of all libraries.
    let mut layers = vec![lines.with_filter(filter).boxed()];
    if command.serves() {
        layers.push(dragnet_runtime::refusals::layer().boxed());
    }
    tracing_subscriber::registry().with(layers).init();
}

/// stderr, written in whole lines: libraries add the place in their source that failed.
struct Lines;

impl Write for Lines {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(line);
        io::stderr().write_all(source_places::without(&text).as_bytes())?;
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}
