//! A participant driven by the wall clock: what an agent on a vehicle and a coordinator in the field are.

use std::collections::BTreeSet;
use std::future::Future;
use std::num::NonZeroUsize;
use std::time::Duration;

use dragnet_proto::message::{Audience, LogReply, LogRequest, Message, Participant};
use dragnet_proto::participant::{Mind, Reaction, Stimulus};
use dragnet_proto::time::MissionTime;
use tokio::sync::mpsc;
use tokio::time::Instant;

use crate::LinkError;
use crate::journal::Journal;
use crate::link::{Heard, Link, Sender};
use crate::log_limit::{Kind, Teller};
use crate::narrator::Narrator;
use crate::watchdog::Watchdog;

/// A robot with a journal holds so many observations of each origin in memory, the last ones: what was lost on its way to
/// others is repeated from there. Older ones are in the journal, for those who come late.
const HELD: NonZeroUsize = NonZeroUsize::new(4).expect("above 0");

/// Mission time by the wall clock.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
    /// Mission seconds a second: 1 in the field.
    pace: f64,
}

impl Clock {
    /// A clock that is at the mission's start now and runs at this pace, above 0.
    #[must_use]
    pub fn new(pace: f64) -> Self {
        Self { start: Instant::now(), pace }
    }

    /// The time now.
    #[must_use]
    pub fn now(&self) -> MissionTime {
        MissionTime::START + self.start.elapsed().mul_f64(self.pace)
    }

    /// Sets the clock: it is this time now.
    pub fn set(&mut self, now: MissionTime) {
        let since_start = now.since(MissionTime::START).div_f64(self.pace);
        self.start = Instant::now().checked_sub(since_start).unwrap_or(self.start);
    }

    /// Sets the clock forward to the time of a robot's sign of life; whether it was one.
    fn follow(&mut self, heard: &Heard) -> bool {
        let Heard::Message { message: Message::Heartbeat(heartbeat), .. } = heard else { return false };
        self.set(self.now().max(MissionTime(heartbeat.time_ns)));
        true
    }

    /// When it will be this time, on the wall; within a day.
    #[must_use]
    pub fn instant(&self, time: MissionTime) -> Instant {
        let since_start = time.since(MissionTime::START).as_secs_f64() / self.pace;
        let from_now = (since_start - self.start.elapsed().as_secs_f64()).clamp(0.0, 86_400.0);
        Instant::now() + Duration::from_secs_f64(from_now)
    }
}

/// What a run by the wall clock measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Computing time of each decision.
    pub decisions: Vec<Duration>,
}

/// What a vehicle reports besides messages: its time, if it knows better than this clock, and what happened.
pub type Report = (Option<MissionTime>, Stimulus<Message>);

/// Runs a mind until `stop` is ready or the network closes. `reports` is what its vehicle says: a coordinator has none.
/// Whatever the mind is to remember is in the journal, if there is one, before it says anything.
///
/// # Errors
/// If the mind cannot go on.
pub async fn run(
    link: &mut Link,
    mind: &mut dyn Mind,
    mut clock: Clock,
    journal: Option<Journal>,
    mut reports: mpsc::Receiver<Report>,
    stop: impl Future<Output = ()>,
) -> Result<Log, LinkError> {
    let mut driver = Driver {
        mind,
        journal,
        published: 0,
        wake_at: MissionTime(u64::MAX),
        log: Log::default(),
        narrator: Narrator::new(link.me(), link.grid()),
        gone: BTreeSet::new(),
        teller: Teller::default(),
    };
    driver.experience(link, clock.now(), Stimulus::Start).await?;
    let mut has_reports = true;
    // Nobody tells a coordinator the time, but the first sign of life that it hears.
    let mut has_time = link.me() != Participant::Coordinator;
    let mut watchdog = Watchdog::ready();
    tokio::pin!(stop);
    loop {
        tokio::select! {
            () = &mut stop => return Ok(driver.finish()),
            () = watchdog.feed() => {}
            () = driver.teller.settle() => {}
            heard = link.hear() => match heard {
                Some(heard) => {
                    has_time = has_time || clock.follow(&heard);
                    driver.hear(link, clock.now(), heard).await?;
                }
                None => return Ok(driver.finish()),
            },
            report = reports.recv(), if has_reports => match report {
                Some((time, stimulus)) => {
                    // To the nanosecond as the vehicle says: others hold where it was against when.
                    let now = time.unwrap_or_else(|| clock.now());
                    clock.set(now);
                    driver.experience(link, now, stimulus).await?;
                }
                None => has_reports = false,
            },
            () = tokio::time::sleep_until(clock.instant(driver.wake_at)) => {
                let now = clock.now().max(driver.wake_at);
                driver.experience(link, now, Stimulus::Woke).await?;
            }
        }
    }
}

/// What a journal answers to a question for what its robot has released.
fn repeat(journal: &Journal, request: LogRequest, teller: &mut Teller) -> Option<(Audience, Message)> {
    match journal.since(request.of, request.first, LogReply::MAX_OBSERVATIONS) {
        Ok(observations) if observations.is_empty() => None,
        Ok(observations) => Some((Audience::One(request.from), Message::LogReply(LogReply { observations }))),
        Err(error) => {
            teller.warn(Kind::Journal, Sender::Known(request.from), error);
            None
        }
    }
}

struct Driver<'a> {
    mind: &'a mut dyn Mind,
    journal: Option<Journal>,
    /// Messages published.
    published: u64,
    wake_at: MissionTime,
    log: Log,
    narrator: Narrator,
    /// Those who left, and have not come back.
    gone: BTreeSet<Participant>,
    teller: Teller,
}

impl Driver<'_> {
    fn finish(mut self) -> Log {
        if let Some(journal) = &mut self.journal {
            journal.commit();
        }
        self.log
    }

    async fn hear(&mut self, link: &Link, now: MissionTime, heard: Heard) -> Result<(), LinkError> {
        for (from, count) in link.dropped() {
            let text =
                format!("dropped {count} messages of {from}: more wait than can; they are asked for later");
            self.teller.warn(Kind::Dropped, from, text);
        }
        match heard {
            Heard::Message { from, message, .. } => {
                self.experience(link, now, Stimulus::Delivered { from, parcel: message }).await?;
            }
            Heard::Refused { from, key, reason } => {
                let text = format_args!("refused what came under {key}: {reason}");
                self.teller.warn(Kind::NoMessage, from, text);
            }
            Heard::Came(who) => {
                let what = if self.gone.remove(&who) { "is back" } else { "is here" };
                self.teller.inform(Kind::Came, Sender::Known(who), format_args!("{who} {what}"));
                self.experience(link, now, Stimulus::Came).await?;
            }
            Heard::Left(who) => {
                self.gone.insert(who);
                self.teller.inform(Kind::Left, Sender::Known(who), format_args!("{who} has left"));
                if let Participant::Robot(robot) = who {
                    self.experience(link, now, Stimulus::Lost(robot)).await?;
                }
            }
        }
        Ok(())
    }

    async fn experience(
        &mut self,
        link: &Link,
        now: MissionTime,
        stimulus: Stimulus<Message>,
    ) -> Result<(), LinkError> {
        let reaction = self.mind.experience(now, stimulus);
        let reaction =
            reaction.map_err(|error| LinkError::Participant { who: link.me(), reason: error.reason })?;
        self.narrator.tell(self.mind, &reaction);
        let Reaction { kept, mut published, wake_at, decision, repeats, refused, .. } = reaction;
        if let Some(journal) = &mut self.journal {
            journal.note(kept);
            if !published.is_empty() {
                journal.commit();
                if journal.waiting() == 0 {
                    self.mind.release(HELD);
                }
            }
            let teller = &mut self.teller;
            published.extend(repeats.into_iter().filter_map(|request| repeat(journal, request, teller)));
        }
        for (audience, message) in published {
            // A robot goes on without its network; what is not heard is asked for later.
            if let Err(error) = link.publish(self.published, audience, &message).await {
                self.teller.warn(Kind::Network, Sender::Known(link.me()), error);
            }
            self.published += 1;
        }
        for refused in refused {
            let from = link.sender(refused.from);
            self.teller.warn(Kind::Refused(refused.why), from, refused);
        }
        self.wake_at = wake_at;
        self.log.decisions.extend(decision);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
