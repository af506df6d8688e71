//! What a service manager is told of a participant: that it takes part, that it is alive, and that it stops.
//!
//! A mind that hangs says nothing more, and systemd starts its process again (`WatchdogSec`); what it knew is in its
//! journal. Where nobody manages the process nothing is told.

use sd_notify::NotifyState;
use tokio::time::{Interval, MissedTickBehavior, interval};

/// Signs of life are given so many times as often as they are asked for.
const HASTE: u32 = 3;

/// Tells that a participant stops when it is dropped.
pub(crate) struct Watchdog {
    /// When the next sign of life is due, if any is asked for.
    beat: Option<Interval>,
}

impl Watchdog {
    /// The participant is ready.
    pub(crate) fn ready() -> Self {
        tell(&NotifyState::Ready);
        let beat = sd_notify::watchdog_enabled().map(|limit| {
            let mut beat = interval(limit / HASTE);
            beat.set_missed_tick_behavior(MissedTickBehavior::Delay);
            beat
        });
        Self { beat }
    }

    /// Waits until a sign of life is due, for ever if none is asked for, and gives it.
    pub(crate) async fn feed(&mut self) {
        match &mut self.beat {
            Some(beat) => {
                beat.tick().await;
                tell(&NotifyState::Watchdog);
            }
            None => std::future::pending().await,
        }
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        tell(&NotifyState::Stopping);
    }
}

fn tell(state: &NotifyState<'_>) {
    if let Err(error) = sd_notify::notify(std::slice::from_ref(state)) {
        tracing::warn!("the service manager is not told: {error}");
    }
}
