//! Validation of stamps: data from long ago, or from the future, say nothing about the vehicle's current position.

use super::diagnostic::Fault;
use super::seconds;

/// Advice about a clock that is not this computer's.
const ADVICE: &str = "set `stamps = \"arrival\"` if this computer's clock should count";

/// Checks that a stamp, after one of the same source at `before_ns`, differs from now by at most `max_ns`.
///
/// # Errors
/// What is wrong with the stamp.
pub(super) fn check(now_ns: u64, time_ns: u64, before_ns: Option<u64>, max_ns: u64) -> Result<(), Fault> {
    if now_ns.abs_diff(time_ns) <= max_ns {
        return Ok(());
    }
    // Times before the mission's start are all equal here.
    if time_ns > 0 && before_ns == Some(time_ns) {
        return Err(Fault::new("frozen", &format!("stamps stand still; {ADVICE}"), &[]));
    }
    let apart_seconds = seconds(now_ns.abs_diff(time_ns));
    let (kind, found) = match time_ns {
        0 => ("stale", "stamped before the mission began, or not at all".to_owned()),
        _ if time_ns < now_ns => {
            ("stale", format!("stamped {apart_seconds:.1} s before this computer's clock"))
        }
        _ => ("ahead", format!("stamped {apart_seconds:.1} s ahead of this computer's clock")),
    };
    let numbers = [("apart_seconds", apart_seconds), ("max_seconds", seconds(max_ns))];
    Err(Fault::new(kind, &format!("{found}; {ADVICE}"), &numbers))
}
