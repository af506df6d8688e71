//! Stops processes by signals, or when their input or output is closed.

use std::future::Future;
use std::io;
use std::process::Child;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, kill_process};
use tokio::io::AsyncReadExt;
use tokio::signal::unix::{Signal, SignalKind, signal};

use crate::RuntimeError;

/// Time between checks whether standard output is still read.
const CHECK_PERIOD: Duration = Duration::from_millis(500);

/// Time between checks whether a child process has ended.
const END_CHECK_PERIOD: Duration = Duration::from_millis(50);

/// Whether the process was asked to end.
static IS_ENDING: AtomicBool = AtomicBool::new(false);

/// Asks child processes to end as a service manager does, so that they finish their files, and waits until they have
/// ended. What has not ended after `patience` is killed.
pub fn end(children: &mut [Child], patience: Duration) {
    for child in children.iter() {
        // It may have ended already.
        let _ = kill_process(Pid::from_child(child), rustix::process::Signal::TERM);
    }
    let deadline = Instant::now() + patience;
    for child in children {
        while Instant::now() < deadline && matches!(child.try_wait(), Ok(None)) {
            std::thread::sleep(END_CHECK_PERIOD);
        }
        let _ = child.kill();
        let _ = child.wait();
    }
}

/// Whether the process was asked to end. From then on Zenoh's errors mean nothing: it reports each message that still
/// arrives for a subscriber that is gone.
#[must_use]
pub fn is_ending() -> bool {
    IS_ENDING.load(Ordering::Relaxed)
}

/// A stream whose closing ends a process, besides signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bond {
    /// Nothing.
    None,
    /// Its standard input closes, as when its parent process ends.
    Input,
    /// Its standard output closes, as with `head`, or with its terminal.
    Output,
}

/// A future that is ready when the process is asked to end: by Ctrl-C, by a service manager, by the end of its terminal
/// (unless that signal is ignored, as with `nohup`), or by its bond. To be called within a Tokio runtime; from then on
/// none of these signals ends the process by itself.
///
/// # Errors
/// If signal handlers cannot be installed.
pub fn asked(bond: Bond) -> Result<impl Future<Output = ()> + Send, RuntimeError> {
    let failed = |error: io::Error| RuntimeError::Zenoh {
        what: "listen for signals".to_owned(),
        reason: error.to_string(),
    };
    let mut interrupt = signal(SignalKind::interrupt()).map_err(failed)?;
    let mut terminate = signal(SignalKind::terminate()).map_err(failed)?;
    let mut hangup =
        if is_hangup_ignored() { None } else { Some(signal(SignalKind::hangup()).map_err(failed)?) };
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
            () = received(hangup.as_mut()) => {}
            () = severed(bond) => {}
        }
        IS_ENDING.store(true, Ordering::Relaxed);
    })
}

async fn received(signal: Option<&mut Signal>) {
    match signal {
        Some(signal) => {
            signal.recv().await;
        }
        None => std::future::pending().await,
    }
}

async fn severed(bond: Bond) {
    match bond {
        Bond::None => std::future::pending().await,
        Bond::Input => {
            let mut byte = [0];
            while tokio::io::stdin().read(&mut byte).await.is_ok_and(|count| count > 0) {}
        }
        Bond::Output => {
            while is_output_read() {
                tokio::time::sleep(CHECK_PERIOD).await;
            }
        }
    }
}

/// Whether standard output may still be read.
fn is_output_read() -> bool {
    let stdout = io::stdout();
    let mut watched = [PollFd::new(&stdout, PollFlags::empty())];
    let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
    let is_gone = poll(&mut watched, Some(&at_once)).is_ok()
        && watched[0].revents().intersects(PollFlags::ERR | PollFlags::HUP);
    !is_gone
}

/// Whether this process was started so that it survives its terminal.
fn is_hangup_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    is_ignored(&status, SignalKind::hangup())
}

/// Whether a process ignores a signal, by its status file on Linux.
fn is_ignored(status: &str, signal: SignalKind) -> bool {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or_default();
    let bit = u32::try_from(signal.as_raw_value() - 1).unwrap_or_default();
    mask.checked_shr(bit).unwrap_or_default() & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nohup_is_detected() {
        let check = |status: &str, expected: bool| {
            assert_eq!(is_ignored(status, SignalKind::hangup()), expected, "{status}");
        };
        check("Name:\ta\nSigIgn:\t0000000000001000\nSigCgt:\t0000000000000001\n", false);
        check("SigIgn:\t0000000000001001\n", true);
        check("", false);
    }
}
