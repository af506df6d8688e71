//! Tests of the whole system.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod architecture;
mod autopilot;
mod clocks;
mod decisions;
mod deploy;
mod doctor;
mod dry_run;
mod durability;
mod endings;
mod faults;
mod field;
mod floods;
mod glossary;
mod hosts;
#[path = "../python/interpreter.rs"]
mod interpreter;
mod ir_sim;
mod late_network;
mod localization;
mod logs;
#[path = "../mentions/mod.rs"]
mod mentions;
mod nav2;
mod networks;
mod one_number;
mod operator;
mod pictures;
mod policies;
mod processes;
mod rehearsal;
mod security;
mod strangers;
mod tak;
mod team;
mod test_site;
mod vehicle;
mod witness;

use std::path::Path;
use std::time::{Duration, Instant};

use dragnet_scenario::Scenario;

/// A scenario from its text.
fn scenario(text: &str) -> Scenario {
    Scenario::from_text(Path::new("test.toml"), text.to_owned()).unwrap()
}

/// Waits for a condition, with a time limit.
fn eventually(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < Duration::from_mins(2), "in vain until {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Prints a requirement that this system lacks, without which a test is skipped. Where all requirements must be there,
/// it fails.
fn skip(what: &str) {
    assert!(std::env::var_os("CI").is_none(), "{what}");
    eprintln!("skipped: {what}");
}

/// A scenario of the repository.
fn committed(name: &str) -> Scenario {
    Scenario::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name)).unwrap()
}
