//! The mission on the maps of TAK (ATAK, WinTAK, iTAK): events of Cursor on Target over UDP, TCP or TLS.
//!
//! What is sent follows from [`dragnet_export::cot`]; this module has the clock and the sockets. The coordinator never waits
//! for it: each period everything is computed anew, so what could not be sent is dropped.
//!
//! - [`settings`]: where to send, and with which certificates;
//! - `connection`: the socket;
//! - `trouble`: what is wrong, in words, once.

mod connection;
pub mod settings;
mod trouble;

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use dragnet_coordinator::mission::Record;
use dragnet_coordinator::node::Listener;
use dragnet_export::cot::event::Event;
use dragnet_export::cot::{Mission, NotOnEarth, Picture};
use tokio::sync::Notify;
use tokio::task::JoinHandle;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

use self::connection::Connection;
use self::settings::Checked;
use self::trouble::Trouble;
use crate::unix_time;

/// Time before the second attempt; it doubles with each that fails,
const FIRST_WAIT: Duration = Duration::from_secs(1);
/// up to this.
const LONGEST_WAIT: Duration = Duration::from_mins(1);
/// Time limit for opening a connection, and for sending all events once.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time limit for sending the end of a mission.
const LAST_PATIENCE: Duration = Duration::from_secs(2);
/// A connection works once all events were sent this often: a peer that closes it is noticed with the second one.
const WORKING: u64 = 2;
/// It is steady once they were sent this often: the next attempt after its end comes soon. Until then attempts are rarer and
/// rarer, so that a connection that comes and goes does not fill the log.
const STEADY: u64 = 20;

/// A mission that is sent to TAK.
pub(crate) struct Feed {
    target: Checked,
    picture: Arc<Mutex<Picture>>,
}

/// A mission that is sent to a target, and the listener for the coordinator's records.
///
/// # Errors
/// If its map does not lie on the earth.
pub(crate) fn feed(target: Checked, mission: &Mission<'_>) -> Result<(Feed, Listener), NotOnEarth> {
    let picture = Arc::new(Mutex::new(Picture::new(mission)?));
    let feed = Feed { target, picture: Arc::clone(&picture) };
    let listener = move |now, record: &Record| lock(&picture).take(now, unix_ns(), record);
    Ok((feed, Box::new(listener)))
}

/// The sending of a mission, which ends when this is dropped.
pub(crate) struct Sending {
    task: JoinHandle<()>,
    end: Arc<Notify>,
}

impl Sending {
    /// Sends how the mission has ended, once, if that is possible soon.
    pub(crate) async fn finish(mut self) {
        self.end.notify_one();
        // Trouble has been logged.
        let _ = timeout(LAST_PATIENCE, &mut self.task).await;
    }
}

impl Drop for Sending {
    fn drop(&mut self) {
        self.task.abort();
    }
}

fn lock(picture: &Mutex<Picture>) -> MutexGuard<'_, Picture> {
    // A picture whose update panicked can still be sent.
    picture.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unix_ns() -> u64 {
    unix_time::now_ns().unsigned_abs()
}

impl Feed {
    /// Sends the mission in a task of its own.
    pub(crate) fn start(self) -> Sending {
        let end = Arc::new(Notify::new());
        Sending { task: tokio::spawn(self.send(Arc::clone(&end))), end }
    }

    /// Sends the mission until its end was sent. Trouble is logged and waited for.
    async fn send(self, end: Arc<Notify>) {
        let url = self.target.url();
        tracing::info!("the mission is sent to TAK at {url} every {} s", self.target.period().as_secs_f64());
        let (mut trouble, mut wait) = (Trouble::of(&self.target), FIRST_WAIT);
        loop {
            let sent = match within(Connection::open(&self.target)).await {
                Ok(connection) => {
                    let sent = |times| {
                        if times == WORKING && trouble.is_over() {
                            tracing::info!("TAK at {url} is there again");
                        }
                        if times == STEADY {
                            wait = FIRST_WAIT;
                        }
                    };
                    self.send_over(connection, sent, &end).await
                }
                Err(error) => Err(error),
            };
            let Err(error) = sent else { return };
            if let Some(reason) = trouble.news(&error) {
                tracing::warn!("TAK at {url}: {reason}; it is tried again, and the mission goes on");
            }
            sleep(wait).await;
            wait = (2 * wait).min(LONGEST_WAIT);
        }
    }

    /// Sends all events each period, and once more at the end; calls a function with the number of times that all were sent.
    async fn send_over(
        &self,
        mut connection: Connection,
        mut sent: impl FnMut(u64),
        end: &Notify,
    ) -> io::Result<()> {
        let mut ticks = interval(self.target.period());
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut times = 0;
        loop {
            let is_last = tokio::select! {
                _ = ticks.tick() => false,
                error = connection.ends() => return Err(error),
                () = end.notified() => true,
            };
            within(connection.send(&self.texts())).await?;
            if is_last {
                return Ok(());
            }
            times += 1;
            sent(times);
        }
    }

    fn texts(&self) -> Vec<String> {
        let events = lock(&self.picture).events(unix_ns(), self.target.period());
        events.iter().map(Event::text).collect()
    }
}

async fn within<T>(attempt: impl Future<Output = io::Result<T>>) -> io::Result<T> {
    let patient = timeout(PATIENCE, attempt).await;
    patient.unwrap_or_else(|_| Err(io::Error::new(io::ErrorKind::TimedOut, "it does not answer")))
}
