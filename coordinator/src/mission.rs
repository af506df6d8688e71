//! The mission's state machine: handles events, and returns messages to publish and records to write.
//!
//! It merges observations, declares objects, detects lost robots and publishes the operator's commands. It has no
//! clock, network or files.

mod command;
mod early;
mod own;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::directive::{Directive, added_prior};
use dragnet_proto::instructions::passed_on;
use dragnet_proto::knowledge::Knowledge;
use dragnet_proto::message::{
    Audience, Detection, Heartbeat, Intent, MarkReport, Message, MissionStatus, OrderReport, VerdictReport,
    ZoneReport,
};
use dragnet_proto::orders::RobotOrders;
use dragnet_proto::picture::Picture;
use dragnet_proto::radio::max_observations_of;
use dragnet_proto::replica::Replica;
use dragnet_proto::state_machine::{Effects, Event, Left, Standstill};
use dragnet_proto::validation::Limits;
use dragnet_proto::zones::Zones;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::observation::{Observation, RobotId, Source};
use dragnet_search::subjects::{Standing, SubjectPosterior, Subjects};
use dragnet_search::terrain::Terrain;

use self::early::Early;
use self::own::Own;
use crate::declaration::{Dated, Declarations};
use crate::ending::Resting;
use crate::finds::{Find, finds};
use crate::liveness::{Liveness, Presence};
use crate::standstill::Standstills;
use crate::track::{Track, Tracks};

/// The configuration of the coordinator.
#[derive(Clone, Debug)]
pub struct CoordinatorConfig {
    /// The map.
    pub terrain: Arc<Terrain>,
    /// The belief before any reading.
    pub prior: Belief,
    /// That the number of objects is known, if so.
    pub subjects: Option<Subjects>,
    /// Probability from which an object is declared, above 0.
    pub detection_threshold: f64,
    /// Limits by which observations are validated.
    pub limits: Limits,
    /// The team.
    pub robots: Vec<RobotId>,
    /// The speed of each robot, by [`RobotId::index`]; it is not known of robots beyond these.
    pub speeds_meters_per_second: Vec<f64>,
    /// Period of the mission's status, above 0; an unanswered request to a robot is repeated after half of it.
    pub heartbeat: Duration,
    /// A robot that is silent for longer is lost.
    pub lost_after: Duration,
    /// Time between two records of the belief, above 0.
    pub belief_period: Duration,
    /// The maximum number of observations in one reply: the team's.
    pub max_observations: usize,
}

impl CoordinatorConfig {
    /// The configuration of a scenario's coordinator.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let mission = scenario.mission();
        let robots: Vec<RobotId> = scenario.robots().iter().map(|robot| robot.id).collect();
        Self {
            max_observations: max_observations_of(scenario),
            limits: Limits::of(scenario),
            terrain: Arc::new(scenario.terrain().clone()),
            prior: scenario.prior().clone(),
            subjects: scenario.subjects(),
            detection_threshold: mission.detection_threshold,
            robots,
            speeds_meters_per_second: scenario
                .robots()
                .iter()
                .map(|robot| robot.class.speed_meters_per_second)
                .collect(),
            heartbeat: mission.heartbeat,
            lost_after: mission.lost_after,
            belief_period: scenario.recording().belief_period,
        }
    }
}

/// The result of an event.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Messages to publish, and rejected messages and observations.
    pub effects: Effects<Message>,
    /// Records for the recording, in order.
    pub records: Vec<Record>,
}

/// A record of the mission.
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// An observation that counts from now on; each is recorded once, independently of which participants sent it.
    Observation(Arc<Observation>),
    /// A received plan of a robot.
    Intent(Intent),
    /// A received heartbeat of a robot.
    Heartbeat(Heartbeat),
    /// A robot has moved.
    Pose {
        /// The robot.
        robot: RobotId,
        /// Its cell.
        cell: Cell,
        /// When it entered the cell, by the robot's clock.
        time: MissionTime,
    },
    /// A robot's plan has changed.
    Plan {
        /// The robot.
        robot: RobotId,
        /// Cells still to be entered, in order, and when it is expected in each; empty when it rests or is lost.
        path: Vec<(Cell, MissionTime)>,
    },
    /// A published status of the mission.
    Status(MissionStatus),
    /// The operator's verdicts: the coordinator's when they change, and those of a robot when they are received.
    Verdicts(VerdictReport),
    /// The operator's orders to single robots: the coordinator's when they change, and those of a robot when they are received.
    Orders(OrderReport),
    /// The operator's zones: the coordinator's when they change, and those of a robot when they are received.
    Zones(ZoneReport),
    /// The operator's marks: the coordinator's when they change, and those of a robot when they are received.
    Marks(MarkReport),
    /// A robot's picture of a find, better than the one before.
    Picture(Arc<Picture>),
    /// The belief as it is shown, recorded periodically and at the end.
    Belief(Arc<Belief>),
    /// The date of mission time 0, which the coordinator's clock knows better from now on.
    Began {
        /// Unix time, nanoseconds.
        unix_ns: i64,
    },
}

/// One mission.
pub struct Mission {
    config: CoordinatorConfig,
    replica: Replica,
    declarations: Declarations,
    liveness: Liveness,
    tracks: Tracks,
    standstills: Standstills,
    resting: Resting,
    /// Whether the operator ends the mission without waiting for robots.
    ends_now: bool,
    /// Whether a robot was on its way back since the order to end.
    saw_return: bool,
    next_status: MissionTime,
    next_belief: MissionTime,
    /// The operator's directive.
    directive: Directive,
    /// The operator's orders to single robots.
    orders: RobotOrders,
    /// Of these, orders that are older than they should be.
    early: Early,
    /// Of these, and of the zones, those that this operator has given.
    own: Own,
    /// The operator's zones.
    zones: Zones,
    /// Prior probability in cells that the operator adds.
    added_prior: f64,
    /// Robots whose number is used by several processes.
    doubled: BTreeSet<RobotId>,
    /// The best picture of each find.
    pictures: BTreeMap<Cell, Arc<Picture>>,
}

impl Mission {
    /// A mission that starts now. Objects that are certain by the prior are declared from the start.
    #[must_use]
    pub fn new(config: CoordinatorConfig) -> Self {
        let mut declarations = Declarations::new(config.detection_threshold);
        declarations.review(MissionTime::START, &config.prior, config.terrain.searched_cells());
        Self {
            replica: Replica::new(
                Participant::Coordinator,
                config.heartbeat / 2,
                config.limits.clone(),
                Knowledge::new(&config.terrain, config.prior.clone()),
            )
            .with_max_observations(config.max_observations),
            declarations,
            liveness: Liveness::new(config.robots.iter().copied(), config.lost_after),
            tracks: Tracks::default(),
            standstills: Standstills::new(config.terrain.cell_meters(), &config.speeds_meters_per_second),
            resting: Resting::default(),
            ends_now: false,
            saw_return: false,
            next_status: MissionTime::START + config.heartbeat,
            next_belief: MissionTime::START + config.belief_period,
            directive: Directive::default(),
            orders: RobotOrders::default(),
            early: Early::default(),
            own: Own::default(),
            zones: Zones::default(),
            added_prior: added_prior(&config.prior, &config.terrain),
            doubled: BTreeSet::new(),
            pictures: BTreeMap::new(),
            config,
        }
    }

    /// Handles an event. Together with [`Mission::receive`] and [`Mission::finish`] it is the only function that
    /// changes the state; the caller passes the time. Events of a vehicle are ignored.
    pub fn react(&mut self, now: MissionTime, event: Event<Message>) -> Outcome {
        let mut outcome = Outcome::default();
        match event {
            Event::Received { from, message } => return self.receive(now, from, &message),
            Event::Woke => self.wake(now, &mut outcome),
            Event::Lost(robot) => {
                if self.liveness.left(now, robot) {
                    self.lose(robot, &mut outcome);
                    self.report(now, &mut outcome);
                }
            }
            Event::Commanded(command) => self.command(now, command, &mut outcome),
            Event::ClockSet(by) => self.set_forward(now, by, &mut outcome),
            Event::Began { unix_ns } => outcome.records.push(Record::Began { unix_ns }),
            Event::Doubled(robots) => {
                self.doubled = robots;
                self.report(now, &mut outcome);
            }
            Event::Pictured(picture) => {
                let is_better = |known: &Arc<Picture>| picture.facts.quality > known.facts.quality;
                if self.pictures.get(&picture.facts.cell).is_none_or(is_better) {
                    self.pictures.insert(picture.facts.cell, Arc::clone(&picture));
                    outcome.records.push(Record::Picture(picture));
                }
            }
            Event::Start
            | Event::Sensed { .. }
            | Event::RouteFailed { .. }
            | Event::Doubted { .. }
            | Event::LineOfSight(_)
            | Event::Located(_)
            | Event::Came
            | Event::Halted
            | Event::Released
            | Event::MustReturn(_) => {}
        }
        outcome.effects.wake_at = self.wake_at();
        outcome
    }

    /// Handles a message like [`Event::Received`], by reference: a message need not be copied for each of its
    /// receivers.
    pub fn receive(&mut self, now: MissionTime, from: Participant, message: &Message) -> Outcome {
        let mut outcome = Outcome::default();
        self.process(now, from, message, &mut outcome);
        outcome.effects.wake_at = self.wake_at();
        outcome
    }

    /// Ends the mission; returns the last messages and records.
    pub fn finish(&mut self, now: MissionTime) -> Outcome {
        let mut outcome = Outcome::default();
        self.report(now, &mut outcome);
        self.snapshot(now, &mut outcome);
        outcome
    }

    /// When to wake the coordinator if no event happens before.
    #[must_use]
    pub fn wake_at(&self) -> MissionTime {
        self.next_status.min(self.next_belief)
    }

    /// The merged belief.
    #[must_use]
    pub fn belief(&self) -> &Belief {
        self.replica.knowledge().belief()
    }

    /// All observations known.
    #[must_use]
    pub const fn replica(&self) -> &Replica {
        &self.replica
    }

    /// Where the subjects are, if their number is known.
    #[must_use]
    pub fn subject(&self) -> Option<SubjectPosterior> {
        self.config.subjects.map(|it| it.posterior(self.belief()))
    }

    /// The posterior of the subjects by which cells are declared, if their number is known.
    #[must_use]
    pub fn standing(&self) -> Option<Standing> {
        let (terrain, reach) = (&self.config.terrain, self.replica.knowledge().reach());
        Some(self.subject()?.standing(terrain, reach, |cell| self.declarations.contains(cell)))
    }

    /// The belief as it is shown: that of subjects is their posterior.
    pub(crate) fn shown_belief(&self) -> Belief {
        let posterior = self.subject().and_then(|subject| subject.shown(&self.config.terrain));
        posterior.unwrap_or_else(|| self.belief().clone())
    }

    /// Currently declared objects, by cell.
    pub fn declared(&self) -> impl Iterator<Item = Detection> + '_ {
        self.declared_and_remaining().0.into_iter()
    }

    /// Currently declared objects, by cell, and how many are expected in cells in reach without a declaration.
    fn declared_and_remaining(&self) -> (Vec<Detection>, f64) {
        let (terrain, reach, belief) =
            (&self.config.terrain, self.replica.knowledge().reach(), self.belief());
        let cells: Vec<Cell> = self.declarations.cells().collect();
        let (probabilities, remaining) = if let Some(it) = self.config.subjects {
            it.of_declared(belief, terrain, reach, &cells)
        } else {
            let probabilities = cells.iter().map(|&cell| belief.probability(cell)).collect();
            (probabilities, self.declarations.expected_remaining(terrain, reach, belief))
        };
        (self.declarations.detections(probabilities), remaining)
    }

    /// Declared and dismissed objects.
    #[must_use]
    pub fn finds(&self) -> Vec<Find> {
        finds(&self.declared().collect::<Vec<_>>(), self.verdicts())
    }

    /// The best picture of each find that robots have sent.
    pub fn pictures(&self) -> impl Iterator<Item = &Arc<Picture>> {
        self.pictures.values()
    }

    /// Robots that are alive, by number.
    pub fn alive(&self) -> impl Iterator<Item = RobotId> + '_ {
        self.liveness.alive()
    }

    /// Every robot of the team, and others that messages have arrived from, by number.
    pub fn robots(&self) -> impl Iterator<Item = (RobotId, Presence)> + '_ {
        self.liveness.robots()
    }

    /// Position and plan of each robot that messages have arrived from, by number.
    pub fn tracks(&self) -> impl Iterator<Item = (RobotId, &Track)> + '_ {
        self.tracks.robots()
    }

    /// Robots that have been under way for long without entering a cell, by number.
    pub fn standstills(&self) -> impl Iterator<Item = Standstill> + '_ {
        self.standstills.iter()
    }

    /// What may not have been found.
    #[must_use]
    pub fn left(&self) -> Left {
        let (terrain, reach) = (&self.config.terrain, self.replica.knowledge().reach());
        let subjects = self.standing();
        let out_of_reach = reach.out_of_reach(terrain).filter(|&cell| !self.declarations.contains(cell));
        let by_cells = || out_of_reach.map(|cell| self.belief().probability(cell)).sum::<f64>() + 0.0;
        Left {
            in_reach: self.declared_and_remaining().1,
            out_of_reach: subjects.map_or_else(by_cells, |standing| standing.out_of_reach),
            cells_out_of_reach: reach.out_of_reach(terrain).count(),
            subjects,
        }
    }

    /// The mission's status.
    #[must_use]
    pub fn status(&self, now: MissionTime) -> MissionStatus {
        let (declared, expected_remaining) = self.declared_and_remaining();
        MissionStatus {
            time_ns: now.0,
            expected_remaining,
            declared,
            alive: self.alive().collect(),
            observations: self.replica.log().len(),
            versions: self.replica.knowledge().versions(),
            digest: self.replica.knowledge().digest(),
            directive: self.directive.clone(),
            doubled: self.doubled.iter().copied().collect(),
        }
    }

    fn process(&mut self, now: MissionTime, from: Participant, message: &Message, outcome: &mut Outcome) {
        let received = self.replica.receive(now, from, message);
        outcome.effects.rejected.extend(received.rejected);
        if !self.config.limits.knows(from) {
            return;
        }
        let has_appeared = matches!(from, Participant::Robot(robot) if self.liveness.received(now, robot));
        if from != Participant::Coordinator {
            self.early.hear();
        }
        match message {
            Message::Intent(intent) => {
                outcome.records.push(Record::Intent(intent.clone()));
                self.plan(now, intent, outcome);
            }
            Message::Heartbeat(heartbeat) => {
                outcome.records.push(Record::Heartbeat(heartbeat.clone()));
                self.locate(heartbeat.robot, heartbeat.cell, MissionTime(heartbeat.time_ns), outcome);
                self.plan(now, &heartbeat.intent, outcome);
                self.learn(now, &heartbeat.directive, outcome);
                self.watch_return(heartbeat);
                self.standstills.beat(now, heartbeat);
            }
            Message::Verdicts(report) => outcome.records.push(Record::Verdicts(report.clone())),
            Message::Marks(report) => outcome.records.push(Record::Marks(report.clone())),
            Message::Orders(report) => {
                outcome.records.push(Record::Orders(report.clone()));
                self.learn_orders(now, &report.orders, outcome);
            }
            Message::Zones(report) => {
                outcome.records.push(Record::Zones(report.clone()));
                self.learn_zones(now, &report.zones, outcome);
            }
            Message::Observation(_)
            | Message::SyncRequest(_)
            | Message::SyncReply(_)
            | Message::MissionStatus(_) => {}
        }
        let replies = received.replies.into_iter().map(|(whom, reply)| (Audience::One(whom), reply));
        outcome.effects.published.extend(replies);
        self.judged(now, &received.judged, outcome);
        if let Some(cells) = received.marked {
            self.marked(now, cells, outcome);
        }
        let has_declared = self.merge(now, &received.new, outcome);
        if has_appeared || has_declared {
            self.report(now, outcome);
        }
    }

    /// Merges new observations; returns whether anything was declared or withdrawn.
    fn merge(&mut self, now: MissionTime, observations: &[Arc<Observation>], outcome: &mut Outcome) -> bool {
        for observation in observations {
            outcome.effects.kept.push(Arc::clone(observation));
            outcome.records.push(Record::Observation(Arc::clone(observation)));
            let Observation { origin, from, time_ns, .. } = **observation;
            if let Source::Robot(robot) = origin.source {
                self.locate(robot, from, MissionTime(time_ns), outcome);
            }
        }
        let readings = observations.iter().flat_map(|observation| &observation.readings);
        let belief = self.replica.knowledge().belief();
        let has_changed = self.declarations.review(now, belief, readings.map(|reading| reading.cell));
        self.date(now, observations);
        has_changed
    }

    /// Dates declarations of cells of which new observations are older than a heartbeat, by all that is known of these cells.
    fn date(&mut self, now: MissionTime, observations: &[Arc<Observation>]) {
        let heartbeat = self.config.heartbeat;
        // Mostly none: then nothing is looked up.
        let old = observations.iter().filter(|it| MissionTime(it.time_ns) + heartbeat < now);
        let is_later = |dated: &Dated| self.declarations.is_later(dated.reading.cell, dated.time + heartbeat);
        let later = old.flat_map(dated).filter(is_later);
        let cells: BTreeSet<Cell> = later.map(|dated| dated.reading.cell).collect();
        if cells.is_empty() {
            return;
        }
        let knowledge = self.replica.knowledge();
        let versions = knowledge.versions();
        let known = versions.iter().flat_map(|version| knowledge.log().since(version.origin, 0));
        self.declarations.date(knowledge.belief(), known.flat_map(dated), &cells);
    }

    fn locate(&mut self, robot: RobotId, cell: Cell, time: MissionTime, outcome: &mut Outcome) {
        if self.tracks.at(robot, cell, time) {
            outcome.records.push(Record::Pose { robot, cell, time });
        }
    }

    fn plan(&mut self, now: MissionTime, intent: &Intent, outcome: &mut Outcome) {
        let robot = intent.robot;
        if !self.tracks.plans(intent) {
            return;
        }
        let (terrain, class) = (&self.config.terrain, self.config.limits.class(robot.into()));
        if let (Some(track), Some(class)) = (self.tracks.of(robot), class) {
            let cells_per_second = class.speed_meters_per_second / terrain.cell_meters();
            let path = track.expected(now, terrain.grid(), cells_per_second);
            outcome.records.push(Record::Plan { robot, path });
        }
    }

    fn lose(&mut self, robot: RobotId, outcome: &mut Outcome) {
        if self.tracks.lapses(robot) {
            outcome.records.push(Record::Plan { robot, path: Vec::new() });
        }
    }

    fn wake(&mut self, now: MissionTime, outcome: &mut Outcome) {
        let lost = self.liveness.lose_silent(now);
        for &robot in &lost {
            self.lose(robot, outcome);
        }
        if now >= self.next_status || !lost.is_empty() {
            self.report(now, outcome);
        }
        if now >= self.next_belief {
            self.snapshot(now, outcome);
        }
    }

    fn report(&mut self, now: MissionTime, outcome: &mut Outcome) {
        self.next_status = now + self.config.heartbeat;
        let status = self.status(now);
        outcome.records.push(Record::Status(status.clone()));
        outcome.effects.published.push((Audience::All, Message::MissionStatus(status)));
        let (told, marked) = ((self.verdicts(), &self.orders), (&self.zones, self.marks()));
        let messages = passed_on(Participant::Coordinator, now, told, marked);
        outcome.effects.published.extend(messages.map(|message| (Audience::All, message)));
    }

    fn snapshot(&mut self, now: MissionTime, outcome: &mut Outcome) {
        self.next_belief = now + self.config.belief_period;
        outcome.records.push(Record::Belief(Arc::new(self.shown_belief())));
    }
}

/// An observation's readings with its time.
fn dated(observation: &Arc<Observation>) -> impl Iterator<Item = Dated> + '_ {
    let time = MissionTime(observation.time_ns);
    observation.readings.iter().map(move |&reading| Dated { time, reading })
}

#[cfg(test)]
mod tests;
