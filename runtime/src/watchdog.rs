//! Notifications to a service manager: that a participant is ready, alive, or stopping.
//!
//! If a state machine hangs there are no more notifications, and systemd restarts its process (`WatchdogSec`), which
//! continues from its journal. Without a service manager nothing is sent.

use sd_notify::NotifyState;
use tokio::time::{Interval, MissedTickBehavior, interval};

/// Number of notifications in the required period.
const HASTE: u32 = 3;

/// Notifies that a participant stops when it is dropped.
pub(crate) struct Watchdog {
    /// Timer of the next notification, if required.
    beat: Option<Interval>,
}

impl Watchdog {
    /// Notifies that the participant is ready.
    pub(crate) fn ready() -> Self {
        tell(&NotifyState::Ready);
        let beat = sd_notify::watchdog_enabled().map(|limit| {
            let mut beat = interval(limit / HASTE);
            beat.set_missed_tick_behavior(MissedTickBehavior::Delay);
            beat
        });
        Self { beat }
    }

    /// Waits until a notification is due and sends it; never ends if none is required.
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
        tracing::warn!("cannot notify the service manager: {error}");
    }
}
