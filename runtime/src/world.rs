//! The simulated world by the wall clock: moves robots along the plans that they publish, and lets them see.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use dragnet_proto::clock;
use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::{Mission, Topic};
use dragnet_proto::message::{Activity, Heartbeat, Intent, Message};
use dragnet_proto::state_machine::Event;
use dragnet_proto::step::Sensed;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::observation::{RobotId, Source};
use dragnet_sim::episode::Episode;
use dragnet_sim::simulation::{Outcome, StepContext, StepObserver};
use dragnet_sim::world::World;
use tokio::sync::mpsc;
use zenoh::Session;
use zenoh::sample::Sample;

use crate::RuntimeError;
use crate::clock::Clock;
use crate::link::{Incoming, Link, Nobody, Sender};
use crate::log_limit::{Kind, Teller};
use crate::wall_clock::Report;

/// How long robots are waited for: at the start to come, at the end to agree.
const PATIENCE: Duration = Duration::from_mins(1);

/// Of whom nothing is heard is shown again what it sees after so many times between two of its signs of life.
const SHOWN_AGAIN: u32 = 3;
/// A world that is farther behind its robots, on the wall, has started again.
const BEHIND: Duration = Duration::from_secs(1);
/// When a mission begins here: a time of 0 would say that it is not known.
const BEGINNING: MissionTime = MissionTime(1);

/// A world that real participants move in.
pub struct WorldServer<'a> {
    link: Link<Nobody>,
    world: World,
    clock: Clock,
    real_time_factor: f64,
    speed: f64,
    /// Time between the first looks of two robots.
    stagger: Duration,
    team: BTreeSet<RobotId>,
    /// Those who are there.
    robots: BTreeSet<RobotId>,
    /// Those who are where this world has them: one that has started again in the middle of a mission learns from its
    /// robots where they are.
    placed: BTreeSet<RobotId>,
    /// The last plan of each, and of which process it is.
    plans: BTreeMap<RobotId, (u64, Intent)>,
    /// When each was shown last what it sees.
    looked: BTreeMap<RobotId, MissionTime>,
    heartbeat: Duration,
    /// Whether somebody was away: what it was shown then, nobody may have seen.
    has_missed: bool,
    arrivals: BTreeMap<RobotId, MissionTime>,
    heartbeats: BTreeMap<RobotId, Heartbeat>,
    outcome: Outcome,
    spectator: StepObserver<'a>,
    teller: Teller,
}

impl<'a> WorldServer<'a> {
    /// A world on a session, for the robots of a scenario; waits until they are there.
    ///
    /// # Errors
    /// If Zenoh refuses, or a robot does not come.
    pub async fn open(
        session: Session,
        mission: Mission,
        scenario: &Scenario,
        seed: u64,
        real_time_factor: f64,
        spectator: StepObserver<'a>,
    ) -> Result<Self, RuntimeError> {
        let world = World::new(scenario, seed);
        let robots: BTreeSet<RobotId> = scenario.robots().iter().map(|robot| robot.id).collect();
        // It listens as one more participant would who has nothing to say.
        let codec = Codec::of(scenario);
        let mut link = Link::join(session, mission, Nobody, codec).await?;
        let team: Vec<Participant> = robots.iter().map(|&robot| Participant::Robot(robot)).collect();
        let mut heard = Vec::new();
        link.wait_for(&team, PATIENCE, |other| heard.push(other)).await?;
        let outcome = Outcome::new(&world);
        let mut server = Self {
            link,
            world,
            clock: Clock::new(real_time_factor),
            real_time_factor,
            speed: scenario.mission().speed_meters_per_second,
            stagger: scenario.mission().stagger,
            team: robots.clone(),
            robots,
            placed: BTreeSet::new(),
            plans: BTreeMap::new(),
            looked: BTreeMap::new(),
            heartbeat: scenario.mission().heartbeat,
            has_missed: false,
            arrivals: BTreeMap::new(),
            heartbeats: BTreeMap::new(),
            outcome,
            spectator,
            teller: Teller::default(),
        };
        for heard in heard {
            server.hear(heard).await?;
        }
        Ok(server)
    }

    /// Runs until every robot rests and all believe the same, or have had the time to; robots that are gone may come back
    /// in that time.
    ///
    /// # Errors
    /// If Zenoh refuses, or the network closes.
    pub async fn run(mut self) -> Result<Episode, RuntimeError> {
        // A mission that is under way has its time already, and this world joins it as everybody does.
        if self.clock.has_begun() {
            self.has_missed = true;
        } else {
            self.clock = self.clock.at(BEGINNING);
            self.placed.clone_from(&self.team);
        }
        let start = self.clock.now();
        // Each stands where it starts until it may decide: a large team does not see all at the same moment.
        for (turn, &robot) in (0..).zip(&self.team) {
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
                let patience = PATIENCE.mul_f64(self.real_time_factor);
                if self.outcome.beliefs_equal && !self.robots.is_empty() || now.since(since) >= patience {
                    return Ok(Episode::new(self.world, self.outcome));
                }
                self.next(since + patience).await?;
            } else {
                resting_since = None;
                self.next(MissionTime(u64::MAX)).await?;
            }
        }
    }

    /// Waits for what happens next, but no longer than until then.
    async fn next(&mut self, until: MissionTime) -> Result<(), RuntimeError> {
        let next =
            self.arrivals.iter().map(|(&robot, &due)| (due, robot)).min().filter(|&(due, _)| due < until);
        let due = next.map_or(until, |(due, _)| due);
        tokio::select! {
            () = self.teller.settle() => {}
            heard = self.link.hear() => match heard {
                Some(heard) => self.hear(heard).await?,
                None => {
                    return Err(RuntimeError::Zenoh { what: "go on".to_owned(), reason: "the session is closed".to_owned() });
                }
            },
            () = tokio::time::sleep_until(self.clock.instant(due)) => {
                if let Some((due, robot)) = next {
                    self.arrivals.remove(&robot);
                    self.has_missed |= !self.world.body(robot).is_moving() && self.looked.contains_key(&robot);
                    self.world.advance(robot);
                    // What is seen is dated as if the clock were exact.
                    self.depart(due, robot);
                    self.look(due, robot).await?;
                }
            }
        }
        Ok(())
    }

    /// Takes the mission's time from whoever knows it; what is on its way comes as much later.
    fn keep_time(&mut self, heard: &Incoming) {
        let Incoming::Message { from, message, .. } = heard else { return };
        let Some(time) = clock::dated(*from, message) else { return };
        let by = self.clock.hear(time).by;
        if by > BEHIND.mul_f64(self.real_time_factor.max(1.0)) {
            // The mission has gone on without this world.
            self.placed.clear();
            self.has_missed = true;
        }
        for arrival in self.arrivals.values_mut() {
            *arrival = *arrival + by;
        }
    }

    async fn hear(&mut self, heard: Incoming) -> Result<(), RuntimeError> {
        self.keep_time(&heard);
        match heard {
            Incoming::Message { from, identity, message: Message::Intent(intent), .. } => {
                if self.is_moved_by(from, identity) {
                    self.follow(identity, &intent);
                }
            }
            Incoming::Message { from, identity, message: Message::Heartbeat(heartbeat), .. } => {
                if self.is_moved_by(from, identity) {
                    self.keep_up(identity, &heartbeat).await?;
                }
                if self.robots.contains(&heartbeat.robot) {
                    self.heartbeats.insert(heartbeat.robot, heartbeat);
                }
            }
            Incoming::Message { message: Message::Observation(mark), .. }
                if mark.origin.source == Source::Operator =>
            {
                self.world.take_in(&mark.readings);
            }
            Incoming::Left(Participant::Robot(gone), _) => {
                self.has_missed = true;
                self.robots.remove(&gone);
                self.arrivals.remove(&gone);
                self.heartbeats.remove(&gone);
            }
            // It has started again, wherever it stood; one more process of its number is nobody's body.
            Incoming::Came(who @ Participant::Robot(robot), identity) if self.is_moved_by(who, identity) => {
                self.robots.insert(robot);
                self.world.set_route(robot, Vec::new());
                self.look(self.clock.now(), robot).await?;
            }
            Incoming::Message { .. }
            | Incoming::Rival(_)
            | Incoming::Came(..)
            | Incoming::Left(Participant::Coordinator, _) => {}
            Incoming::Rejected { from, key, reason } => {
                let text = format_args!("refused what came under {key}: {reason}");
                self.teller.warn(Kind::NoMessage, from, text);
            }
        }
        Ok(())
    }

    /// Whether what is said moves a robot: of two processes of one number that which came first does.
    fn is_moved_by(&self, who: Participant, identity: u64) -> bool {
        let first = self.link.processes(who).first();
        matches!(who, Participant::Robot(robot) if self.team.contains(&robot))
            && first.is_none_or(|&first| first == identity)
    }

    /// A robot has a plan: one that was told before, and comes again, moves nobody.
    fn follow(&mut self, identity: u64, intent: &Intent) {
        let robot = intent.robot;
        let known = self.plans.get(&robot);
        if known.is_none_or(|(by, known)| *by != identity || intent.is_newer_than(known)) {
            self.plans.insert(robot, (identity, intent.clone()));
            self.send(robot, intent.path.clone());
        }
    }

    /// A robot's sign of life: if it was not heard, or did not hear, for a while, it says what it waits for.
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
        // It is heard: it need not be shown again where it stands.
        self.arrivals.remove(&robot);
        let (here, path) = (self.world.body(robot).cell, &heartbeat.intent.path);
        let entered = path.iter().position(|&cell| cell == here).map_or(0, |place| place + 1);
        let was_shown_long_ago = self.looked.get(&robot).is_none_or(|&at| now >= at + self.heartbeat);
        if entered < path.len() {
            self.send(robot, path[entered..].to_vec());
        } else if was_shown_long_ago && (entered > 0 || heartbeat.activity == Activity::Searching) {
            // It does not know that it is there, or waits to be shown where it is.
            self.has_missed = true;
            self.look(now, robot).await?;
        }
        Ok(())
    }

    fn send(&mut self, robot: RobotId, route: Vec<Cell>) {
        let now = self.clock.now();
        (self.spectator)(now, StepContext::Departs { robot, route: route.clone(), activity: None });
        self.world.set_route(robot, route);
        self.depart(now, robot);
    }

    fn depart(&mut self, now: MissionTime, robot: RobotId) {
        match self.world.travel_time(robot, self.speed) {
            Some(time) => self.arrivals.insert(robot, now + time),
            None => self.arrivals.remove(&robot),
        };
    }

    async fn look(&mut self, now: MissionTime, robot: RobotId) -> Result<(), RuntimeError> {
        let (readings, found) = self.world.sense(robot);
        let (cell, farthest_cells) = (self.world.body(robot).cell, self.world.farthest_cells());
        (self.spectator)(now, StepContext::Arrives { robot, cell, farthest_cells });
        for &cell in &found {
            (self.spectator)(now, StepContext::Finds { robot, cell });
        }
        self.outcome.measure(now, farthest_cells, self.world.score(), &found);
        self.looked.insert(robot, now);
        if !self.world.body(robot).is_moving() {
            // Unless it is heard before: what it is shown may be lost.
            self.arrivals.insert(robot, now + self.heartbeat * SHOWN_AGAIN);
        }
        let sensed = Sensed { robot, time_ns: now.0, from: cell, readings };
        let key = self.link.mission().key(Topic::SimSensed(robot)).to_string();
        let shown = self.link.session().put(key, convert::encode_sensed(&sensed)).express(true);
        // Of two processes of one number the first alone sees: otherwise what it sees would count twice.
        let shown = match self.link.processes(Participant::Robot(robot)) {
            [first, ..] => shown.attachment(first.to_le_bytes()),
            [] => shown,
        };
        shown.await.map_err(RuntimeError::zenoh("let a robot see"))
    }

    fn are_all_resting(&self) -> bool {
        self.heartbeats.values().all(|heartbeat| heartbeat.activity.is_rest())
    }

    /// Of all that was shown, or of what one robot has seen of it.
    fn expected_digest(&self) -> Digest {
        let seen = self.heartbeats.values().next().filter(|_| self.has_missed);
        seen.map_or_else(|| self.world.merged().digest(), |heartbeat| heartbeat.digest)
    }

    fn are_all_equal(&self, digest: Digest) -> bool {
        self.heartbeats.values().all(|heartbeat| heartbeat.digest == digest)
    }
}

/// What a robot's simulated sensor sees, from now on.
///
/// # Errors
/// If Zenoh refuses.
pub async fn sensor(
    link: &Link,
    robot: RobotId,
    codec: Codec,
) -> Result<mpsc::Receiver<Report>, RuntimeError> {
    let (sender, reports) = mpsc::channel(1024);
    let (teller, who) = (Mutex::new(Teller::default()), Sender::Known(Participant::Robot(robot)));
    let warn = move |text: std::fmt::Arguments<'_>| {
        teller.lock().unwrap_or_else(PoisonError::into_inner).warn(Kind::Sensor, who, text);
    };
    let own = link.process().identity.to_le_bytes();
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
            Err(error) => warn(format_args!("refused what the sensor of robot {robot} said: {error}")),
        })
        .background()
        .await
        .map_err(RuntimeError::zenoh("listen to a sensor"))?;
    Ok(reports)
}
