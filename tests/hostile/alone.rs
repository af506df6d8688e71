//! Runs a test in a separate process: to measure its memory alone, and to name the failing case however it ends.

use std::env;
use std::fmt::Display;
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// Set in a process that runs one test.
const ALONE: &str = "DRAGNET_TEST_ALONE";
/// Begins the line that announces the next case.
const CASE: &str = "case: ";
/// Begins the line with the peak resident memory, bytes.
const PEAK: &str = "peak: ";

/// Runs a test of this binary in a separate process, whose peak resident memory is limited, bytes.
///
/// Memory is checked on Linux only.
pub(crate) fn alone(test: &str, max_bytes: u64, run: impl FnOnce()) {
    if env::var_os(ALONE).is_some() {
        run();
        println!("{PEAK}{}", peak_bytes().unwrap_or_default());
    } else {
        watch(test, max_bytes);
    }
}

/// Announces the next case: the last announced one is the one that failed.
pub(crate) fn begin(case: impl Display) {
    println!("{CASE}{case}");
}

fn watch(test: &str, max_bytes: u64) {
    let mut child = Command::new(env::current_exe().unwrap())
        .args([test, "--exact", "--nocapture"])
        .env(ALONE, "1")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut case, mut peak_bytes) = (String::new(), None);
    for line in BufReader::new(child.stdout.take().unwrap()).lines() {
        let line = line.unwrap();
        match (line.strip_prefix(CASE), line.strip_prefix(PEAK)) {
            (Some(next), _) => next.clone_into(&mut case),
            (_, Some(peak)) => peak_bytes = Some(peak.parse::<u64>().unwrap()),
            _ => println!("{line}"),
        }
    }
    let status = child.wait().unwrap();
    assert!(status.success(), "{status}, case {case}");
    let peak_bytes = peak_bytes.expect("there is a test of this name, and it has run");
    println!("at most {} MB were resident", peak_bytes / 1_000_000);
    assert!(peak_bytes <= max_bytes, "{peak_bytes} bytes were resident; stated are {max_bytes}");
}

fn peak_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let kibibytes = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?;
    kibibytes.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}
