//! The simulated world, driven by the wall clock: moves robots along their published plans, and sends them readings.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use dragnet_proto::clock;
use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::{Mission, Topic};
use dragnet_proto::message::{Heartbeat, Intent, Message};
use dragnet_proto::state_machine::Event;
use dragnet_proto::step::Sensed;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::RobotId;
use dragnet_sim::episode::Episode;
use dragnet_sim::simulation::{Outcome, StepContext, StepObserver};
use dragnet_sim::world::World;
use tokio::sync::mpsc;
use zenoh::Session;
use zenoh::sample::Sample;

use crate::RuntimeError;
use crate::clock::Clock;
use crate::link::{Incoming, Link, ReceiveOnly, Sender};
use crate::log_limit::{Kind, Teller};
use crate::wall_clock::Report;

/// Time limit for robots: at the start to join, at the end to agree.
const PATIENCE: Duration = Duration::from_mins(1);
/// Time for which robots at rest that agree on other readings than were sent are given the rest of these: what comes no
/// more was lost on its way.
const LOST_AFTER: Duration = Duration::from_secs(10);
/// Time between two reports of the robots that are waited for.
const REMINDER: Duration = Duration::from_secs(10);

/// Number of heartbeat periods after which a silent robot is sent its readings again.
const SHOWN_AGAIN: u32 = 3;
/// Wall-clock time by which a world is behind its robots after which it counts as restarted.
const BEHIND: Duration = Duration::from_secs(1);
/// The mission time at which a mission begins here: 0 means unknown.
const BEGINNING: MissionTime = MissionTime(1);

/// A world for real participants.
pub struct WorldServer<'a> {
    link: Link<ReceiveOnly>,
    world: World,
    clock: Clock,
    real_time_factor: f64,
    /// Time between the first observations of two robots.
    stagger: Duration,
    team: BTreeSet<RobotId>,
    /// The robots that are present.
    robots: BTreeSet<RobotId>,
    /// Robots whose cell is known: a restarted world learns the cells from its robots.
    placed: BTreeSet<RobotId>,
    /// The last plan of each, and its process.
    plans: BTreeMap<RobotId, (u64, Intent)>,
    /// When each was last sent its readings.
    observed: BTreeMap<RobotId, MissionTime>,
    heartbeat: Duration,
    /// Whether a robot was away, or readings were lost: what is found and missed here is by what was sent.
    has_missed: bool,
    arrivals: BTreeMap<RobotId, MissionTime>,
    heartbeats: BTreeMap<RobotId, Heartbeat>,
    /// Robots that have stopped: their next heartbeats say why.
    stopped: BTreeSet<RobotId>,
    outcome: Outcome,
    spectator: StepObserver<'a>,
    teller: Teller,
}

/// Waits for robots that may be late, and logs each that is not present. Returns the messages that were received
/// meanwhile.
async fn wait_for_some(
    link: &mut Link<ReceiveOnly>,
    team: &[Participant],
) -> Result<Vec<Incoming>, RuntimeError> {
    let (mut received, mut waited) = (Vec::new(), Duration::ZERO);
    loop {
        match link.wait_for(team, REMINDER, |other| received.push(other)).await {
            Ok(()) => return Ok(received),
            Err(RuntimeError::Absent { .. }) => waited += REMINDER,
            Err(error) => return Err(error),
        }
        let absent: Vec<String> =
            team.iter().filter(|&&robot| !link.is_present(robot)).map(ToString::to_string).collect();
        let absent_names = absent.join(", ");
        let is_running = received.iter().any(|it| match it {
            Incoming::Message { from, message, .. } => {
                clock::dated(*from, message).is_some_and(|time| time > MissionTime::START)
            }
            _ => false,
        });
        if absent.len() < team.len() && (is_running || waited >= PATIENCE) {
            tracing::warn!("begins without {absent_names}: what is late starts when it comes");
            return Ok(received);
        }
        tracing::info!("waits for {absent_names}");
    }
}

impl<'a> WorldServer<'a> {
    /// Opens a world for the robots of a scenario on a session, and waits until they are present. It does not wait for
    /// robots that `may_be_late` once the mission runs, or for longer than a minute if another robot is present: those
    /// start when they join.
    ///
    /// # Errors
    /// If Zenoh fails, or a robot does not join that may not be late.
    pub async fn open(
        session: Session,
        mission: Mission,
        scenario: &Scenario,
        seed: u64,
        real_time_factor: f64,
        may_be_late: bool,
        spectator: StepObserver<'a>,
    ) -> Result<Self, RuntimeError> {
        let world = World::new(scenario, seed);
        let team: BTreeSet<RobotId> = scenario.robots().iter().map(|robot| robot.id).collect();
        // It subscribes like another participant without publishing.
        let codec = Codec::of(scenario);
        let mut link = Link::join(session, mission, ReceiveOnly, codec).await?;
        let participants: Vec<Participant> = team.iter().map(|&robot| Participant::Robot(robot)).collect();
        let received = if may_be_late {
            wait_for_some(&mut link, &participants).await?
        } else {
            let mut received = Vec::new();
            link.wait_for(&participants, PATIENCE, |other| received.push(other)).await?;
            received
        };
        let is_here = |&robot: &RobotId| link.is_present(Participant::Robot(robot));
        let robots = team.iter().copied().filter(is_here).collect();
        let outcome = Outcome::new(&world);
        let mut server = Self {
            link,
            world,
            clock: Clock::new(real_time_factor),
            real_time_factor,
            stagger: scenario.mission().stagger,
            team,
            robots,
            placed: BTreeSet::new(),
            plans: BTreeMap::new(),
            observed: BTreeMap::new(),
            heartbeat: scenario.mission().heartbeat,
            has_missed: false,
            arrivals: BTreeMap::new(),
            heartbeats: BTreeMap::new(),
            stopped: BTreeSet::new(),
            outcome,
            spectator,
            teller: Teller::default(),
        };
        for received in received {
            server.receive(received).await?;
        }
        Ok(server)
    }

    /// Runs until every robot rests and all beliefs are equal, or the time limit has passed; robots that have left may
    /// return in that time.
    ///
    /// # Errors
    /// If Zenoh fails, or the network closes.
    pub async fn run(mut self) -> Result<Episode, RuntimeError> {
        // A running mission has its time already, and this world joins it like any participant.
        if self.clock.has_begun() {
            self.has_missed = true;
        } else {
            self.clock = self.clock.at(BEGINNING);
            self.placed.clone_from(&self.team);
        }
        let start = self.clock.now();
        // Each stays in its start cell until it may decide: a large team does not observe all at the same moment.
        for (turn, &robot) in (0..).zip(&self.team).filter(|(_, robot)| self.robots.contains(robot)) {
            self.arrivals.entry(robot).or_insert(start + self.stagger * turn);
        }
        let mut resting_since = None;
        loop {
            let now = self.clock.now();
            if self.heartbeats.len() == self.robots.len() && self.are_all_resting() {
                let since = *resting_since.get_or_insert(now);
                self.outcome.ended = since;
                self.outcome.digest = self.expected_digest();
                self.outcome.beliefs_equal = self.are_all_equal(self.outcome.digest);
                let [patience, lost_after] =
                    [PATIENCE, LOST_AFTER].map(|time| time.mul_f64(self.real_time_factor));
                if self.outcome.beliefs_equal && !self.robots.is_empty() || now.since(since) >= patience {
                    return Ok(Episode::new(self.world, self.outcome));
                }
                let is_waiting_for_readings = !self.has_missed && self.do_robots_agree();
                if is_waiting_for_readings && now.since(since) >= lost_after {
                    self.has_missed = true;
                    continue;
                }
                self.next(since + if is_waiting_for_readings { lost_after } else { patience }).await?;
            } else {
                resting_since = None;
                self.next(MissionTime(u64::MAX)).await?;
            }
        }
    }

    /// Waits for the next message, at most until a time.
    async fn next(&mut self, until: MissionTime) -> Result<(), RuntimeError> {
        let next =
            self.arrivals.iter().map(|(&robot, &due)| (due, robot)).min().filter(|&(due, _)| due < until);
        let due = next.map_or(until, |(due, _)| due);
        tokio::select! {
            () = self.teller.settle() => {}
            received = self.link.receive() => match received {
                Some(received) => self.receive(received).await?,
                None => {
                    return Err(RuntimeError::Zenoh { what: "go on".to_owned(), reason: "the session is closed".to_owned() });
                }
            },
            () = tokio::time::sleep_until(self.clock.instant(due)) => {
                if let Some((due, robot)) = next {
                    self.arrivals.remove(&robot);
                    self.has_missed |= !self.world.body(robot).is_moving() && self.observed.contains_key(&robot);
                    self.world.advance(robot);
                    self.let_held_go(due);
                    // Readings are dated as if the clock were exact.
                    self.depart(due, robot);
                    self.observe(due, robot).await?;
                }
            }
        }
        Ok(())
    }

    /// Adopts the mission's time; delayed messages arrive accordingly later.
    fn keep_time(&mut self, received: &Incoming) {
        let Incoming::Message { from, message, .. } = received else { return };
        let Some(time) = clock::dated(*from, message) else { return };
        let by = self.clock.receive(time).by;
        if by > BEHIND.mul_f64(self.real_time_factor.max(1.0)) {
            // The mission has continued without this world.
            self.placed.clear();
            self.has_missed = true;
        }
        for arrival in self.arrivals.values_mut() {
            *arrival = *arrival + by;
        }
    }

    async fn receive(&mut self, received: Incoming) -> Result<(), RuntimeError> {
        self.keep_time(&received);
        match received {
            Incoming::Message { from, identity, message: Message::Intent(intent), .. } => {
                if self.is_moved_by(from, identity) {
                    self.follow(identity, &intent);
                }
            }
            Incoming::Message { from, identity, message: Message::Heartbeat(heartbeat), .. } => {
                if self.is_moved_by(from, identity) {
                    self.keep_up(identity, &heartbeat).await?;
                    self.stay(&heartbeat);
                }
                if self.robots.contains(&heartbeat.robot) {
                    self.heartbeats.insert(heartbeat.robot, heartbeat);
                }
            }
            Incoming::Message { message: Message::Marks(report), .. } => {
                self.world.mark(self.clock.now(), &report.marks);
            }
            Incoming::Message { message: Message::Verdicts(report), .. } => {
                self.world.judge(self.clock.now(), &report.verdicts);
            }
            Incoming::Message { message: Message::Zones(report), .. } => {
                self.world.close(self.clock.now(), &report.zones);
            }
            Incoming::Left(Participant::Robot(gone), _) => {
                self.has_missed = true;
                self.robots.remove(&gone);
                self.arrivals.remove(&gone);
                self.heartbeats.remove(&gone);
            }
            // A robot has restarted, in an unknown cell; an additional process of its number has no vehicle.
            Incoming::Came(participant @ Participant::Robot(robot), identity)
                if self.is_moved_by(participant, identity) =>
            {
                self.robots.insert(robot);
                self.world.set_route(robot, Vec::new());
                self.let_held_go(self.clock.now());
                self.observe(self.clock.now(), robot).await?;
            }
            Incoming::Message { .. }
            | Incoming::Came(..)
            | Incoming::Left(Participant::Coordinator, _)
            | Incoming::OtherScenario(..) => {}
            Incoming::Rejected { from, key, reason } => {
                let text = format_args!("rejected a message under {key}: {reason}");
                self.teller.warn(Kind::NoMessage, from, text);
            }
        }
        Ok(())
    }

    /// Whether a process's messages move a robot: of two processes of one number the one that goes on does.
    fn is_moved_by(&self, participant: Participant, identity: u64) -> bool {
        matches!(participant, Participant::Robot(robot) if self.team.contains(&robot))
            && self.link.foremost(participant).is_none_or(|first| first == identity)
    }

    /// A robot's new plan: a repeated one moves no robot.
    fn follow(&mut self, identity: u64, intent: &Intent) {
        let robot = intent.robot;
        let known = self.plans.get(&robot);
        if known.is_none_or(|(by, known)| *by != identity || intent.is_newer_than(known)) {
            self.plans.insert(robot, (identity, intent.clone()));
            self.send(robot, intent.path.to_vec());
        }
    }

    /// Handles a robot's heartbeat: if messages to or from the robot were lost, it shows what the robot is waiting for.
    async fn keep_up(&mut self, identity: u64, heartbeat: &Heartbeat) -> Result<(), RuntimeError> {
        let (now, robot) = (self.clock.now(), heartbeat.robot);
        if self.placed.insert(robot) && self.world.body(robot).cell != heartbeat.cell {
            self.world.enter(robot, heartbeat.cell);
            self.plans.remove(&robot);
        }
        self.follow(identity, &heartbeat.intent);
        if self.world.body(robot).is_moving() {
            return Ok(());
        }
        // It is received: its readings need not be sent again.
        self.arrivals.remove(&robot);
        let (here, path) = (self.world.body(robot).cell, &heartbeat.intent.path);
        let entered = path.iter().position(|&cell| cell == here).map_or(0, |place| place + 1);
        let was_shown_long_ago = self.observed.get(&robot).is_none_or(|&at| now >= at + self.heartbeat);
        if entered < path.len() {
            self.send(robot, path[entered..].to_vec());
        } else if was_shown_long_ago && (entered > 0 || heartbeat.activity.is_under_way()) {
            // It does not know its cell, or waits for readings.
            self.has_missed = true;
            self.observe(now, robot).await?;
        }
        Ok(())
    }

    fn send(&mut self, robot: RobotId, route: Vec<Cell>) {
        let now = self.clock.now();
        if route.is_empty() {
            self.stopped.insert(robot);
        } else {
            self.stopped.remove(&robot);
            (self.spectator)(now, StepContext::Departs { robot, route: route.clone(), activity: None });
        }
        self.world.set_route(robot, route);
        self.let_held_go(now);
        self.depart(now, robot);
    }

    /// Robots that others kept from moving set off where their way is clear.
    fn let_held_go(&mut self, now: MissionTime) {
        for (robot, time) in self.world.set_off_held() {
            self.arrivals.insert(robot, now + time);
        }
    }

    /// Tells why a robot has stopped, once: of its plan alone only that it has.
    fn stay(&mut self, heartbeat: &Heartbeat) {
        if heartbeat.intent.path.is_empty() && self.stopped.remove(&heartbeat.robot) {
            let (robot, activity) = (heartbeat.robot, Some(heartbeat.activity));
            (self.spectator)(self.clock.now(), StepContext::Departs { robot, route: Vec::new(), activity });
        }
    }

    fn depart(&mut self, now: MissionTime, robot: RobotId) {
        match self.world.set_off(robot) {
            Some(time) => self.arrivals.insert(robot, now + time),
            None => self.arrivals.remove(&robot),
        };
    }

    async fn observe(&mut self, now: MissionTime, robot: RobotId) -> Result<(), RuntimeError> {
        let (readings, found) = self.world.sense(robot);
        let (cell, farthest_cells) = (self.world.body(robot).cell, self.world.farthest_cells());
        (self.spectator)(now, StepContext::Arrives { robot, cell, farthest_cells });
        for &cell in &found {
            let probability = self.world.probability(cell);
            (self.spectator)(now, StepContext::Finds { robot, cell, probability });
        }
        self.outcome.measure(now, farthest_cells, self.world.score(), &found);
        self.observed.insert(robot, now);
        if !self.world.body(robot).is_moving() {
            // Unless it is received before: the readings may be lost.
            self.arrivals.insert(robot, now + self.heartbeat * SHOWN_AGAIN);
        }
        let sensed = Sensed { robot, time_ns: now.0, from: cell, readings };
        let key = self.link.mission().key(Topic::SimSensed(robot)).to_string();
        let shown = self.link.session().put(key, convert::encode_sensed(&sensed)).express(true);
        // Of two processes of one number only one gets readings: otherwise they would count twice.
        let shown = match self.link.foremost(Participant::Robot(robot)) {
            Some(first) => shown.attachment(first.to_le_bytes()),
            None => shown,
        };
        shown.await.map_err(RuntimeError::zenoh("let a robot see"))
    }

    fn are_all_resting(&self) -> bool {
        self.heartbeats.values().all(|heartbeat| heartbeat.activity.is_rest())
    }

    /// The evidence of all sent readings, or of those that one robot has received.
    fn expected_digest(&self) -> Digest {
        let seen = self.heartbeats.values().next().filter(|_| self.has_missed);
        seen.map_or_else(|| self.world.merged().digest(), |heartbeat| heartbeat.digest)
    }

    fn do_robots_agree(&self) -> bool {
        self.heartbeats.values().next().is_some_and(|first| self.are_all_equal(first.digest))
    }

    fn are_all_equal(&self, digest: Digest) -> bool {
        self.heartbeats.values().all(|heartbeat| heartbeat.digest == digest)
    }
}

/// Subscribes to the readings of a robot's simulated sensor.
///
/// # Errors
/// If Zenoh fails.
pub async fn sensor(
    link: &Link,
    robot: RobotId,
    codec: Codec,
) -> Result<mpsc::Receiver<Report>, RuntimeError> {
    let (sender, reports) = mpsc::channel(1024);
    let (teller, participant) = (Mutex::new(Teller::default()), Sender::Known(Participant::Robot(robot)));
    let warn = move |text: std::fmt::Arguments<'_>| {
        teller.lock().unwrap_or_else(PoisonError::into_inner).warn(Kind::Sensor, participant, text);
    };
    let own = link.claim().identity.to_le_bytes();
    let is_another =
        move |sample: &Sample| sample.attachment().is_some_and(|bytes| bytes.to_bytes().as_ref() != own);
    link.session()
        .declare_subscriber(link.mission().key(Topic::SimSensed(robot)).to_string())
        .callback(move |sample| match codec.decode_sensed(&sample.payload().to_bytes()) {
            Ok(_) if is_another(&sample) => {}
            Ok(Sensed { time_ns, from, readings, .. }) => {
                let time = Some(MissionTime(time_ns)).filter(|&time| time > MissionTime::START);
                let report = (time, Event::Sensed { cell: from, readings });
                if sender.try_send(report).is_err() {
                    warn(format_args!("robot {robot} does not keep up with its sensor"));
                }
            }
            Err(error) => warn(format_args!("rejected readings of the sensor of robot {robot}: {error}")),
        })
        .background()
        .await
        .map_err(RuntimeError::zenoh("listen to a sensor"))?;
    Ok(reports)
}
