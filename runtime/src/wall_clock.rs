//! A participant driven by the wall clock: what an agent on a vehicle and a coordinator in the field are.

use std::collections::BTreeSet;
use std::future::Future;
use std::num::NonZeroUsize;
use std::time::Duration;

use dragnet_proto::clock::{self, Adjustment};
use dragnet_proto::message::{Audience, Message, SyncReply, SyncRequest};
use dragnet_proto::state_machine::{Effects, Event, StateMachine};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;
use tokio::sync::mpsc;

use crate::RuntimeError;
use crate::clock::Clock;
use crate::doubles::{Doubles, News};
use crate::journal::Journal;
use crate::link::{Incoming, Link, Sender};
use crate::log_limit::{Kind, Teller};
use crate::narrator::Narrator;
use crate::watchdog::Watchdog;

/// A robot with a journal holds so many observations of each origin in memory, the last ones: what was lost on its way to
/// others is repeated from there. Older ones are in the journal, for those who come late.
const HELD: NonZeroUsize = NonZeroUsize::new(4).expect("above 0");

/// So often whoever listens looks whether it has listened for long enough.
const LISTENS: Duration = Duration::from_millis(100);

/// What a run by the wall clock measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Computing time of each decision.
    pub decisions: Vec<Duration>,
    /// Mission time at the end.
    pub ended: MissionTime,
}

/// What a vehicle reports besides messages: the mission's time, if it knows that better than this clock, and what happened.
pub type Report = (Option<MissionTime>, Event<Message>);

/// Runs a mind until `stop` is ready or the network closes. `reports` is what its vehicle says: a coordinator has none.
/// Whatever the mind is to remember is in the journal, if there is one, before it says anything.
///
/// # Errors
/// If the mind cannot go on.
pub async fn run(
    link: &mut Link,
    mind: &mut dyn StateMachine,
    mut clock: Clock,
    journal: Option<Journal>,
    mut reports: mpsc::Receiver<Report>,
    stop: impl Future<Output = ()>,
) -> Result<Log, RuntimeError> {
    let mut driver = Driver {
        mind,
        journal,
        noted: None,
        published: 0,
        wake_at: MissionTime(u64::MAX),
        log: Log::default(),
        narrator: Narrator::new(link.me(), link.grid()),
        gone: BTreeSet::new(),
        teller: Teller::default(),
        doubles: Doubles::default(),
        doubled: BTreeSet::new(),
        stands: false,
        has_stood: false,
    };
    driver.handle(link, clock.now(), Event::Start).await?;
    let mut has_reports = true;
    let mut watchdog = Watchdog::ready();
    tokio::pin!(stop);
    loop {
        driver.note_time(&clock);
        driver.look_for_doubles(link, clock.now()).await?;
        let doubles = driver.doubles.due().map(|due| due.saturating_sub(link.age()));
        tokio::select! {
            () = &mut stop => return Ok(driver.finish(&clock)),
            () = tokio::time::sleep(doubles.unwrap_or_default()), if doubles.is_some() => {}
            () = watchdog.feed() => {}
            () = driver.teller.settle() => {}
            heard = link.hear() => match heard {
                Some(heard) => {
                    if let Incoming::Message { from, message, .. } = &heard
                        && let Some(time) = clock::dated(*from, message)
                    {
                        driver.tell_time(*from, clock.hear(time));
                    }
                    driver.hear(link, clock.now(), heard).await?;
                }
                None => return Ok(driver.finish(&clock)),
            },
            report = reports.recv(), if has_reports && !clock.listens() => match report {
                Some((time, event)) => {
                    // To the nanosecond as the simulator says: others hold where a robot was against when.
                    let followed = time.filter(|&time| clock.follow(time));
                    if matches!(event, Event::Sensed { .. }) {
                        clock.begin();
                    }
                    driver.note_time(&clock);
                    let is_lost = time.is_some() && followed.is_none();
                    driver.report(link, followed.unwrap_or_else(|| clock.now()), event, is_lost).await?;
                }
                None => has_reports = false,
            },
            () = tokio::time::sleep(LISTENS), if clock.listens() => {}
            () = tokio::time::sleep_until(clock.instant(driver.wake_at)), if !driver.stands => {
                let now = clock.now().max(driver.wake_at);
                driver.handle(link, now, Event::Woke).await?;
            }
        }
    }
}

/// What a journal answers to a question for what its robot has released.
fn repeat(journal: &Journal, request: SyncRequest, teller: &mut Teller) -> Option<(Audience, Message)> {
    match journal.since(request.of, request.first, SyncReply::MAX_OBSERVATIONS) {
        Ok(observations) if observations.is_empty() => None,
        Ok(observations) => {
            Some((Audience::One(request.from), Message::SyncReply(SyncReply { observations })))
        }
        Err(error) => {
            teller.warn(Kind::Journal, Sender::Known(request.from), error);
            None
        }
    }
}

struct Driver<'a> {
    mind: &'a mut dyn StateMachine,
    journal: Option<Journal>,
    /// The clock as the journal knows it.
    noted: Option<Clock>,
    /// Messages published.
    published: u64,
    wake_at: MissionTime,
    log: Log,
    narrator: Narrator,
    /// Those who left, and have not come back.
    gone: BTreeSet<Participant>,
    teller: Teller,
    doubles: Doubles,
    /// Robots whose number several processes have, as its mind knows it.
    doubled: BTreeSet<RobotId>,
    /// Whether it stands, and says nothing, since an older process of its number is in the mission.
    stands: bool,
    /// Whether it was shown anything since it started.
    has_stood: bool,
}

/// A clock that is set by less than this is not worth a line.
const LEAST: Duration = Duration::from_secs(1);

impl Driver<'_> {
    fn finish(mut self, clock: &Clock) -> Log {
        if let Some(journal) = &mut self.journal {
            journal.commit();
        }
        Log { ended: clock.now(), ..self.log }
    }

    /// A journal knows the mission's time from when it begins, and anew when the clock is set.
    fn note_time(&mut self, clock: &Clock) {
        let Some(journal) = &mut self.journal else { return };
        if clock.has_begun() && self.noted.is_none_or(|noted| clock.has_moved_since(&noted)) {
            journal.note_time(clock.kept());
            self.noted = Some(*clock);
        }
    }

    /// That the clock was set, or that somebody is not believed.
    fn tell_time(&mut self, from: Participant, adjustment: Adjustment) {
        let [by, left] = [adjustment.by, adjustment.left].map(|it| it.as_secs_f64());
        let sender = Sender::Known(from);
        if adjustment.by >= LEAST {
            let text = format_args!("mission time is set {by:.0} s forward: {from} has counted longer");
            self.teller.inform(Kind::Clock, sender, text);
        }
        if adjustment.left >= LEAST {
            let text = format_args!(
                "{from} says that the mission is {left:.0} s older than anybody else has said; it is not believed at once"
            );
            self.teller.warn(Kind::Disbelief, sender, text);
        }
    }

    async fn hear(&mut self, link: &Link, now: MissionTime, heard: Incoming) -> Result<(), RuntimeError> {
        for (from, count) in link.dropped() {
            let text =
                format!("dropped {count} messages of {from}: more wait than can; they are asked for later");
            self.teller.warn(Kind::Dropped, from, text);
        }
        match heard {
            Incoming::Message { .. } if self.stands => {}
            Incoming::Message { from, message, .. } => {
                self.handle(link, now, Event::Received { from, message }).await?;
            }
            Incoming::Rejected { from, key, reason } => {
                let text = format_args!("refused what came under {key}: {reason}");
                self.teller.warn(Kind::NoMessage, from, text);
            }
            Incoming::Rival(process) => self.doubles.hear(link.process(), process),
            Incoming::Came(who, _) => {
                let (kind, what) =
                    if self.gone.remove(&who) { (Kind::Back, "is back") } else { (Kind::Came, "is here") };
                self.teller.inform(kind, Sender::Known(who), format_args!("{who} {what}"));
                if !self.stands {
                    self.handle(link, now, Event::Came).await?;
                }
            }
            Incoming::Left(who, _) => {
                self.gone.insert(who);
                self.teller.inform(Kind::Left, Sender::Known(who), format_args!("{who} has left"));
                if let Participant::Robot(robot) = who
                    && who != link.me()
                    && !self.stands
                {
                    self.handle(link, now, Event::Lost(robot)).await?;
                }
            }
        }
        Ok(())
    }

    /// What its vehicle says. A simulator that has started again and is lost in time does not know where the robot is,
    /// either: it hears both in the robot's next sign of life.
    async fn report(
        &mut self,
        link: &Link,
        now: MissionTime,
        event: Event<Message>,
        is_lost: bool,
    ) -> Result<(), RuntimeError> {
        if self.stands {
            return Ok(());
        }
        if is_lost && self.has_stood {
            return self.handle(link, now, Event::Came).await;
        }
        self.has_stood |= matches!(event, Event::Sensed { .. });
        self.handle(link, now, event).await
    }

    /// Two of one number are told of, and the younger one of this process's own number stands.
    async fn look_for_doubles(&mut self, link: &Link, now: MissionTime) -> Result<(), RuntimeError> {
        self.tell_doubles(link);
        let (me, doubled) = (link.me(), self.doubles.lasting(link.age()));
        if doubled != self.doubled {
            self.doubled.clone_from(&doubled);
            self.handle(link, now, Event::Doubled(doubled)).await?;
        }
        let is_robot = matches!(me, Participant::Robot(_));
        let stands = is_robot && self.doubles.must_stand(link.process(), link.processes(me));
        if stands == self.stands {
            return Ok(());
        }
        self.tell_standing(me, stands);
        if stands {
            self.handle(link, now, Event::Halted).await?;
        }
        self.stands = stands;
        if !stands {
            self.handle(link, now, Event::Released).await?;
        }
        Ok(())
    }

    fn tell_doubles(&mut self, link: &Link) {
        for (who, news) in self.doubles.tell(link.age(), &link.doubled()) {
            let sender = Sender::Known(who);
            match news {
                News::Two => {
                    let text = format_args!(
                        "{who} is here twice: it was started again before its last process was known to be gone, or two \
                         have its number"
                    );
                    self.teller.warn(Kind::Two, sender, text);
                }
                News::Both => {
                    let text =
                        format_args!("TWO PROCESSES SAY THAT THEY ARE {who}: give each robot its own number");
                    self.teller.error(Kind::Double, sender, text);
                }
                News::One => self.teller.inform(Kind::One, sender, format_args!("{who} is here once again")),
            }
        }
    }

    fn tell_standing(&mut self, me: Participant, stands: bool) {
        let sender = Sender::Known(me);
        if stands {
            let text = format_args!(
                "{me} stands still, and says nothing, as long as another process of {me} is in the mission; the one that \
                 is started with --take-over goes on instead"
            );
            self.teller.error(Kind::Stands, sender, text);
        } else {
            let text = format_args!("{me} goes on: no older process of it is in the mission");
            self.teller.inform(Kind::GoesOn, sender, text);
        }
    }

    async fn handle(
        &mut self,
        link: &Link,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<(), RuntimeError> {
        let effects = self.mind.handle(now, event);
        let effects =
            effects.map_err(|error| RuntimeError::Participant { who: link.me(), reason: error.reason })?;
        self.narrator.tell(self.mind, &effects);
        let Effects { kept, mut published, wake_at, decision, repeats, refused, .. } = effects;
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
            self.teller.warn(Kind::Rejected(refused.why), from, refused);
        }
        self.wake_at = wake_at;
        self.log.decisions.extend(decision);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
