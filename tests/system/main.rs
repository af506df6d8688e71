//! The whole system: what no crate can show alone.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod architecture;
mod clocks;
mod decisions;
mod deploy;
mod doctor;
mod dry_run;
mod durability;
mod endings;
mod faults;
mod field;
mod hosts;
#[path = "../python/interpreter.rs"]
mod interpreter;
mod late_network;
mod localization;
mod logs;
mod networks;
mod one_number;
mod policies;
mod processes;
mod rehearsal;
mod security;
mod team;
mod vehicle;
mod witness;
mod yard;

use std::path::Path;

use dragnet_proto::scenario::Scenario;

/// A scenario from its text.
fn scenario(text: &str) -> Scenario {
    Scenario::from_text(Path::new("test.toml"), text.to_owned()).unwrap()
}

/// A scenario of the repository.
fn committed(name: &str) -> Scenario {
    Scenario::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name)).unwrap()
}
