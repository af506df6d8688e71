//! A participant driven by the wall clock: an agent on a vehicle, or a coordinator in the field.

mod pace;

use std::collections::BTreeSet;
use std::future::Future;
use std::num::NonZeroUsize;
use std::time::Duration;

use dragnet_proto::clock::{self, Adjustment};
use dragnet_proto::message::{Audience, Message, SyncReply, SyncRequest};
use dragnet_proto::radio::{Load, Radio};
use dragnet_proto::state_machine::{Effects, Event, StateMachine};
use dragnet_scenario::Places;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;
use tokio::sync::mpsc;

use self::pace::Pace;
use crate::RuntimeError;
use crate::clock::Clock;
use crate::contender::Contender;
use crate::doubles::{Doubles, News};
use crate::journal::Journal;
use crate::link::{Incoming, Link, Sender};
use crate::log_limit::{Kind, Teller};
use crate::narrator::Narrator;
use crate::progress::{Expected, Progress};
use crate::watchdog::Watchdog;

/// Number of observations of each origin that a robot with a journal holds in memory, the last ones: lost messages are
/// repeated from there. Older ones are read from the journal, for late joiners.
const HELD: NonZeroUsize = NonZeroUsize::new(4).expect("above 0");

/// Period in which a listening robot checks whether it has listened for long enough.
const LISTENS: Duration = Duration::from_millis(100);

/// The measurements of a run by the wall clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Computing time of each decision.
    pub decisions: Vec<Duration>,
    /// Mission time at the end.
    pub ended: MissionTime,
}

/// A report of a vehicle: the mission time, if the vehicle has a more exact one than this clock, and an event.
pub type Report = (Option<MissionTime>, Event<Message>);

/// Where reports come from.
#[derive(Debug)]
pub struct Reports {
    arriving: mpsc::Receiver<Report>,
    /// What is to be expected of it, if it moves a robot; then the log says if it does not.
    expected: Option<Expected>,
}

impl Reports {
    /// Reports of what moves a robot.
    #[must_use]
    pub const fn of(arriving: mpsc::Receiver<Report>, expected: Expected) -> Self {
        Self { arriving, expected: Some(expected) }
    }
}

/// Nothing is expected: there may be none.
impl From<mpsc::Receiver<Report>> for Reports {
    fn from(arriving: mpsc::Receiver<Report>) -> Self {
        Self { arriving, expected: None }
    }
}

/// Runs a state machine until `stop` is ready, its mission is over or the network closes. `reports` come from its vehicle: a coordinator has
/// none. `places` are those of its log. Everything to be stored is in the journal, if there is one, before anything is published.
///
/// # Errors
/// If the state machine fails.
pub async fn run(
    link: &mut Link,
    machine: &mut dyn StateMachine,
    places: Places,
    mut clock: Clock,
    journal: Option<Journal>,
    reports: impl Into<Reports>,
    stop: impl Future<Output = ()>,
) -> Result<Log, RuntimeError> {
    let Reports { arriving: mut reports, expected } = reports.into();
    let mut driver = Driver {
        machine,
        journal,
        noted: None,
        published: 0,
        radio: link.codec().bytes_per_second().map(Radio::new),
        wake_at: MissionTime(u64::MAX),
        log: Log::default(),
        narrator: Narrator::new(link.me(), places),
        gone: BTreeSet::new(),
        teller: Teller::default(),
        doubles: Doubles::default(),
        pace: Pace::default(),
        set_forward: Duration::ZERO,
        has_begun: false,
        doubled: BTreeSet::new(),
        contender: Contender::new(link.claim()),
        told_stands: (false, None),
        progress: Progress::new(expected),
        has_stood: false,
    };
    driver.handle(link, clock.now(), Event::Start).await?;
    let mut has_reports = true;
    let mut watchdog = Watchdog::ready();
    tokio::pin!(stop);
    while !driver.machine.is_over() {
        driver.note_time(&clock);
        driver.report_doubles(link, clock.now()).await?;
        driver.contend(link, clock.now()).await?;
        driver.tell_standstill(link);
        let due = driver.due(link).map(|due| due.saturating_sub(link.age()));
        let free_at = driver.free_at();
        tokio::select! {
            () = &mut stop => return Ok(driver.finish(&clock)),
            () = tokio::time::sleep(due.unwrap_or_default()), if due.is_some() => {}
            () = watchdog.feed() => {}
            () = driver.teller.settle() => {}
            received = link.receive() => {
                let Some(received) = received else {
                    tracing::error!("{} ends: its session is closed", link.me());
                    return Ok(driver.finish(&clock));
                };
                if let Incoming::Message { from, message, .. } = &received
                    && let Some(time) = clock::dated(*from, message)
                {
                    let adjustment = clock.receive(time);
                    driver.log_time(&clock, *from, adjustment);
                    driver.set_forward(link, &clock, adjustment.by).await?;
                }
                driver.receive(link, clock.now(), received).await?;
            }
            report = reports.recv(), if has_reports && !clock.listens() => match report {
                Some((time, event)) => {
                    // Exactly the simulator's time: others validate a robot's speed by it.
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
            () = tokio::time::sleep_until(clock.instant(driver.wake_at)), if !driver.contender.stands() => {
                let now = clock.now().max(driver.wake_at);
                driver.handle(link, now, Event::Woke).await?;
            }
            () = tokio::time::sleep_until(clock.instant(free_at)) => {
                driver.transmit(link, clock.now().max(free_at)).await;
            }
        }
    }
    Ok(driver.finish(&clock))
}

/// A journal's answer to a request for released observations.
fn repeat(
    journal: &Journal,
    request: SyncRequest,
    most: usize,
    teller: &mut Teller,
) -> Option<(Audience, Message)> {
    match journal.since(request.of, request.first, most) {
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
    machine: &'a mut dyn StateMachine,
    journal: Option<Journal>,
    /// The clock as stored in the journal.
    noted: Option<Clock>,
    /// Number of published messages.
    published: u64,
    /// Where messages wait for their turn, if the rate is limited.
    radio: Option<Radio<Message>>,
    wake_at: MissionTime,
    log: Log,
    narrator: Narrator,
    /// Participants that have left.
    gone: BTreeSet<Participant>,
    teller: Teller,
    doubles: Doubles,
    pace: Pace,
    /// By how much the clock was set forward since the state machine was last told.
    set_forward: Duration,
    /// Whether the mission has begun, as the state machine was last told.
    has_begun: bool,
    /// Robots with several processes, as the state machine knows them.
    doubled: BTreeSet<RobotId>,
    /// Whether it stops and publishes nothing, because another process of its number goes on.
    contender: Contender,
    /// Whether it stands as last logged, and when it was.
    told_stands: (bool, Option<Duration>),
    progress: Progress,
    /// Whether it has received readings since it started.
    has_stood: bool,
}

/// A process that stands and goes on in turn, as a rival's connection comes and goes, logs the last of it this often.
const STANDS_PERIOD: Duration = Duration::from_secs(1);

/// Smaller adjustments of a clock are not logged.
const LEAST: Duration = Duration::from_secs(1);

impl Driver<'_> {
    fn finish(mut self, clock: &Clock) -> Log {
        if let Some(journal) = &mut self.journal {
            journal.commit();
        }
        Log { ended: clock.now(), ..self.log }
    }

    /// Stores the mission's time when it begins, and when the clock is set.
    fn note_time(&mut self, clock: &Clock) {
        let Some(journal) = &mut self.journal else { return };
        if clock.has_begun() && self.noted.is_none_or(|noted| clock.has_moved_since(&noted)) {
            journal.note_time(clock.kept());
            self.noted = Some(*clock);
        }
    }

    /// Logs an adjustment of the clock, or a rejected time.
    fn log_time(&mut self, clock: &Clock, from: Participant, adjustment: Adjustment) {
        let here = clock.real_time_factor();
        if let Some(times) = self.pace.adjust(clock.local(), adjustment.by, here) {
            let text = format_args!(
                "the mission's time runs {times:.2} times as fast as here, where `real_time_factor` is {here}: set \
                 the same in the settings of all processes"
            );
            self.teller.warn(Kind::Pace, Sender::Known(from), text);
        }
        let [by, left] = [adjustment.by, adjustment.left].map(|it| it.as_secs_f64());
        let sender = Sender::Known(from);
        if adjustment.by >= LEAST {
            let text = format_args!("mission time is set {by:.0} s forward: {from} has counted longer");
            self.teller.inform(Kind::Clock, sender, text);
        }
        if adjustment.left >= LEAST {
            let text = format_args!(
                "the mission time of {from} is {left:.0} s ahead of all others; it is not accepted at once"
            );
            self.teller.warn(Kind::Disbelief, sender, text);
        }
    }

    /// The clock was set forward: what was dated by it is too, once that is more than messages take. The date of mission time
    /// 0 is then another one, as it is when a clock that stood still goes on.
    async fn set_forward(&mut self, link: &Link, clock: &Clock, by: Duration) -> Result<(), RuntimeError> {
        self.set_forward += by;
        let has_moved = self.set_forward >= clock.least_adjustment();
        let begins = clock.has_begun() && !std::mem::replace(&mut self.has_begun, clock.has_begun());
        if begins || has_moved {
            self.handle(link, clock.now(), Event::Began { unix_ns: clock.start_unix_ns() }).await?;
        }
        if !has_moved {
            return Ok(());
        }
        let by = std::mem::take(&mut self.set_forward);
        self.handle(link, clock.now(), Event::ClockSet(by)).await
    }

    async fn receive(
        &mut self,
        link: &Link,
        now: MissionTime,
        received: Incoming,
    ) -> Result<(), RuntimeError> {
        for (from, count) in link.dropped() {
            let text =
                format!("dropped {count} messages of {from}: more wait than can; they are asked for later");
            self.teller.warn(Kind::Dropped, from, text);
        }
        match received {
            Incoming::Message { .. } if self.contender.stands() => {}
            Incoming::Message { from, message, .. } => {
                if let Message::Heartbeat(heartbeat) = &message {
                    self.narrator.receive(self.machine, heartbeat);
                }
                self.handle(link, now, Event::Received { from, message }).await?;
            }
            Incoming::Rejected { from, key, reason } => {
                let text = format_args!("rejected a message under {key}: {reason}");
                self.teller.warn(Kind::NoMessage, from, text);
            }
            Incoming::Came(participant, _) => {
                if let Participant::Robot(robot) = participant {
                    self.narrator.expect(robot);
                }
                let (kind, what) = if self.gone.remove(&participant) {
                    (Kind::Back, "is back")
                } else {
                    (Kind::Came, "is here")
                };
                self.teller.inform(kind, Sender::Known(participant), format_args!("{participant} {what}"));
                if !self.contender.stands() {
                    self.handle(link, now, Event::Came).await?;
                }
            }
            Incoming::OtherScenario(participant, difference) => {
                let text = format_args!(
                    "{participant} has another scenario than {}: {difference}; give all the same",
                    link.me()
                );
                self.teller.warn(Kind::Scenario, Sender::Known(participant), text);
            }
            Incoming::Left(participant, _) => {
                self.gone.insert(participant);
                let lost = match participant {
                    Participant::Robot(robot) => {
                        self.narrator.lose(self.machine, robot, self.machine.cell_of(robot))
                    }
                    Participant::Coordinator => None,
                };
                let sender = Sender::Known(participant);
                match lost {
                    Some(lost) => self.teller.warn(Kind::Left, sender, lost),
                    None => self.teller.inform(Kind::Left, sender, format_args!("{participant} has left")),
                }
                if let Participant::Robot(robot) = participant
                    && participant != link.me()
                    && !self.contender.stands()
                {
                    self.handle(link, now, Event::Lost(robot)).await?;
                }
            }
        }
        Ok(())
    }

    /// Handles a report of its vehicle. A restarted simulator without the mission's time does not know the robot's
    /// cell, either: it receives both in the robot's next heartbeat.
    async fn report(
        &mut self,
        link: &Link,
        now: MissionTime,
        event: Event<Message>,
        is_lost: bool,
    ) -> Result<(), RuntimeError> {
        if self.contender.stands() {
            return Ok(());
        }
        if is_lost && self.has_stood {
            return self.handle(link, now, Event::Came).await;
        }
        if matches!(event, Event::Sensed { .. }) {
            self.has_stood = true;
            self.contender.observe();
            self.progress.sense(link.age());
        }
        self.handle(link, now, event).await
    }

    /// Reports two processes of one number.
    async fn report_doubles(&mut self, link: &Link, now: MissionTime) -> Result<(), RuntimeError> {
        self.report_double_processes(link);
        let doubled = self.doubles.lasting(link.age());
        if doubled != self.doubled {
            self.doubled.clone_from(&doubled);
            self.handle(link, now, Event::Doubled(doubled)).await?;
        }
        Ok(())
    }

    /// When it has to look after anything but messages, reports and its state machine, by the link's age.
    fn due(&self, link: &Link) -> Option<Duration> {
        let standstill = self.progress.due().filter(|_| !self.contender.stands());
        // Only robots contend: a coordinator would wait for the past.
        let rise = self.contender.due().filter(|_| matches!(link.me(), Participant::Robot(_)));
        [self.doubles.due(), rise, standstill, self.due_standing()].into_iter().flatten().min()
    }

    /// Logs that nothing moves the robot.
    fn tell_standstill(&mut self, link: &Link) {
        if !self.contender.stands()
            && let Some(standstill) = self.progress.tell(link.age())
        {
            tracing::warn!("{}: {standstill}", link.me());
        }
    }

    /// Stops a robot while another process of its number goes on.
    async fn contend(&mut self, link: &mut Link, now: MissionTime) -> Result<(), RuntimeError> {
        let (me, stood) = (link.me(), self.contender.stands());
        if !matches!(me, Participant::Robot(_)) {
            return Ok(());
        }
        self.contender.update(link.age(), link.claims(me));
        if let Err(error) = link.rise(self.contender.claim()).await {
            self.teller.warn(Kind::Network, Sender::Known(me), error);
        }
        self.tell_standing(link);
        let stands = self.contender.stands();
        if stands == stood {
            return Ok(());
        }
        if let Some(radio) = self.radio.as_mut().filter(|_| stands) {
            radio.clear();
        }
        self.handle(link, now, if stands { Event::Halted } else { Event::Released }).await
    }

    fn report_double_processes(&mut self, link: &Link) {
        for (participant, news) in self.doubles.tell(link.age(), &link.doubled()) {
            let sender = Sender::Known(participant);
            match news {
                News::Two => {
                    let text = format_args!(
                        "{participant} is here twice: it was started again before its last process was known to be gone, or two \
                         have its number"
                    );
                    self.teller.warn(Kind::Two, sender, text);
                }
                News::Both => {
                    let text = format_args!(
                        "TWO PROCESSES ARE RUNNING AS {participant}: give each robot its own number"
                    );
                    self.teller.error(Kind::Double, sender, text);
                }
                News::One => {
                    self.teller.inform(Kind::One, sender, format_args!("{participant} is here once again"));
                }
            }
        }
    }

    /// When it has to log that it stands or goes on, by the link's age.
    fn due_standing(&self) -> Option<Duration> {
        let (stands, at) = self.told_stands;
        (stands != self.contender.stands()).then(|| at.map_or(Duration::ZERO, |at| at + STANDS_PERIOD))
    }

    fn tell_standing(&mut self, link: &Link) {
        if self.due_standing().is_none_or(|due| link.age() < due) {
            return;
        }
        let (me, stands) = (link.me(), self.contender.stands());
        self.told_stands = (stands, Some(link.age()));
        if stands {
            tracing::error!(
                "{me} stands still, and says nothing, as long as another process of {me} is in the mission that has searched for \
                 longer, or was started together with it; one that is started with --take-over goes on instead of both"
            );
        } else {
            tracing::info!("{me} goes on: no other process of it that went before it is in the mission");
        }
    }

    async fn handle(
        &mut self,
        link: &Link,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<(), RuntimeError> {
        let effects = self.machine.handle(now, event)?;
        self.narrator.tell(self.machine, &effects);
        let Effects { kept, mut published, route, wake_at, decision, repeats, rejected, .. } = effects;
        if let Some(route) = route {
            self.progress.route(link.age(), &route);
        }
        if let Some(journal) = &mut self.journal {
            journal.note(kept);
            for (_, message) in &published {
                journal.note_instructions(message);
            }
            if !published.is_empty() {
                journal.commit();
                if journal.waiting() == 0 {
                    self.machine.release(HELD);
                }
            }
            let (most, teller) = (link.codec().max_observations(), &mut self.teller);
            published
                .extend(repeats.into_iter().filter_map(|request| repeat(journal, request, most, teller)));
        }
        for (audience, message) in published {
            match &mut self.radio {
                Some(radio) => {
                    radio.offer(audience, Load::new(&message, link.codec().encoded_len(&message)), message);
                    self.transmit(link, now).await;
                }
                None => self.publish(link, audience, &message).await,
            }
        }
        for observation in rejected {
            let from = link.sender(observation.from);
            self.teller.warn(Kind::Rejected(observation.why), from, observation);
        }
        self.wake_at = wake_at;
        self.log.decisions.extend(decision);
        Ok(())
    }

    async fn publish(&mut self, link: &Link, audience: Audience, message: &Message) {
        // A robot goes on without its network; missing messages are requested later.
        if let Err(error) = link.publish(self.published, audience, message).await {
            self.teller.warn(Kind::Network, Sender::Known(link.me()), error);
        }
        self.published += 1;
    }

    /// When the radio sends its next message; never if none waits.
    fn free_at(&self) -> MissionTime {
        self.radio.as_ref().and_then(Radio::due).unwrap_or(MissionTime(u64::MAX))
    }

    /// Publishes the next message, if the radio is free.
    async fn transmit(&mut self, link: &Link, now: MissionTime) {
        if let Some(sending) = self.radio.as_mut().and_then(|radio| radio.next(now)) {
            self.publish(link, sending.audience, &sending.message).await;
        }
    }
}

#[cfg(test)]
mod tests;
