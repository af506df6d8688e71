//! The robot's state machine: handles events and returns effects.

mod apart;
mod operator;
mod zones;

use dragnet_learn::policy;
use dragnet_proto::directive::{Directive, added_prior};
use dragnet_proto::knowledge::{Knowledge, SharedKnowledge};
use dragnet_proto::message::{Activity, Audience, Heartbeat, Intent, Message, MissionStatus};
use dragnet_proto::orders::{RobotOrder, RobotOrders};
use dragnet_proto::radio::max_observations_of;
use dragnet_proto::replica::Replica;
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_proto::validation::Limits;
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Mission, Robot, Scenario};
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Entry, Observation, Origin, RobotId, Source};
use dragnet_search::policy::{Decision, Policy};
use dragnet_search::route::{Connectivity, ShortestPathTree};
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::Sensor;
use dragnet_search::separation::Separation;
use dragnet_search::situation::{Place, Situation, is_way_home_within, leading_cells_with_way_home};
use dragnet_search::subjects::Subjects;
use dragnet_search::terrain::Terrain;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::barred::Barred;
use crate::blind_spots::{self, BlindSpots};
use crate::heartbeat::HeartbeatSchedule;
use crate::home::{self, Home};
use crate::sightings::Sightings;
use crate::team::{Team, View};

/// The configuration of a robot.
#[derive(Clone, Debug)]
pub struct AgentConfig {
    /// The robot, its class and its policy.
    pub robot: Robot,
    /// Its place in the team.
    pub place: Place,
    /// The map as the robot can cross it.
    pub terrain: Arc<Terrain>,
    /// The robot's moves.
    pub connectivity: Connectivity,
    /// What it knows at first: the prior.
    pub knowledge: Knowledge,
    /// That the number of objects is known, if so.
    pub subjects: Option<Subjects>,
    /// Prior probability in cells that the operator adds.
    pub added_prior: f64,
    /// How far it keeps from its teammates.
    pub separation: Separation,
    /// Limits by which observations are validated.
    pub limits: Limits,
    /// Detection threshold, stopping conditions, communication periods, and the robot's own speed and budget.
    pub mission: Mission,
    /// The maximum number of observations in one reply: the team's.
    pub max_observations: usize,
    /// Rate of the team's radios, bytes per second, if it is limited.
    pub bytes_per_second: Option<f64>,
    /// Seed of the robot's random choices.
    pub seed: u64,
}

impl AgentConfig {
    /// The configuration of every robot of a scenario, by number.
    #[must_use]
    pub fn of_team(scenario: &Scenario, seed: u64) -> Vec<Self> {
        let terrain = Arc::new(scenario.terrain().clone());
        let knowledge = Knowledge::new(&terrain, scenario.prior().clone());
        let added_prior = added_prior(scenario.prior(), &terrain);
        let limits = Limits::of(scenario);
        let above = scenario.robots().iter().any(|robot| robot.class.flies);
        let above = above.then(|| Arc::new(terrain.from_above()));
        let max_observations = max_observations_of(scenario);
        let team = u16::try_from(scenario.robots().len()).unwrap_or(u16::MAX);
        (0..team)
            .zip(scenario.robots())
            .map(|(member, robot)| Self {
                robot: robot.clone(),
                place: Place { member, team },
                terrain: Arc::clone(above.as_ref().filter(|_| robot.class.flies).unwrap_or(&terrain)),
                connectivity: scenario.connectivity(),
                knowledge: knowledge.clone(),
                subjects: scenario.subjects(),
                added_prior,
                separation: scenario.separation(),
                limits: limits.clone(),
                mission: scenario.mission().of(&robot.class),
                max_observations,
                bytes_per_second: scenario.network().bytes_per_second,
                seed,
            })
            .collect()
    }

    fn id(&self) -> RobotId {
        self.robot.id
    }

    fn step_time(&self) -> Duration {
        self.robot.class.step_time(self.terrain.cell_meters())
    }

    /// How long a robot may make no progress: it may be slower than planned, and route around obstacles.
    fn stillness(&self, robot: RobotId) -> Duration {
        let class = self.limits.class(robot.into()).unwrap_or(&self.robot.class);
        let slowness = class.step_time(self.terrain.cell_meters()) * SLOW_STEPS;
        self.mission.lost_after.saturating_add(slowness)
    }

    fn sensor(&self) -> &Sensor {
        &self.robot.class.sensor
    }

    /// Robots that decide on the same news take turns.
    fn turn(&self) -> Duration {
        self.mission.stagger * u32::from(self.place.member)
    }

    /// Robots make their first decisions in turn, so that each knows the plans of those before it.
    fn first_decision(&self) -> MissionTime {
        MissionTime::START + self.turn()
    }
}

/// Steps for which a teammate may make no progress, in addition to its liveness timeout.
const SLOW_STEPS: u32 = 4;

/// A robot.
pub struct Agent {
    config: AgentConfig,
    policy: Box<dyn Policy + Send>,
    random: Stream,
    replica: Replica,
    team: Team,
    activity: Activity,
    /// The robot's cell; unknown before the first event.
    cell: Option<Cell>,
    path_meters: f64,
    /// Cells still to be entered.
    plan: Vec<Cell>,
    /// Cells entered since the last decision.
    entered: u32,
    /// When the plan was made.
    decided: MissionTime,
    /// When it came to its cell.
    arrived: MissionTime,
    /// Whether its plan is overtaken by a teammate's that arrived late, made before this robot's and unknown when it
    /// decided, or by a verdict of the operator.
    is_overtaken: bool,
    /// Where vehicles have detected objects that they could not assign to a cell yet.
    sightings: Sightings,
    /// Positions of objects that its next observation carries.
    located: Vec<ObjectPosition>,
    /// Cells that its vehicle does not see.
    blind_spots: BlindSpots,
    /// Cells that its vehicle could not enter.
    barred: Barred,
    /// Waypoints chosen.
    decisions: u64,
    /// Plans made, including decisions to rest: the number of the next one.
    plans: u64,
    /// Its first and its last cell before a restart.
    recalled: Option<(Cell, Cell)>,
    /// Its base; unknown before the first event.
    base: Option<Cell>,
    /// The ways to its base, if its budget is to leave them.
    home: Option<Home>,
    /// The origin of its observations and plans.
    origin: Origin,
    /// The first incarnation that it has not stored as used.
    unused_incarnation: u64,
    /// Observations made.
    observations: u64,
    /// The time of the last one.
    dated: MissionTime,
    heartbeats: HeartbeatSchedule,
    /// The operator's directive, as far as known.
    directive: Directive,
    /// The operator's orders to single robots, as far as known.
    orders: RobotOrders,
    /// The operator's zones, as far as known.
    zones: Zones,
    /// What is hidden by its vehicle's map too, if that has told it.
    line_of_sight: Option<LineOfSight>,
    /// The map with these zones, without the barred cells, and with what its vehicle knows to be hidden.
    open_ground: Arc<Terrain>,
    /// Cells that teammates who stand keep it out of.
    occupied: BTreeSet<Cell>,
    /// The map as it plans: without these.
    ground: Arc<Terrain>,
    /// Whether its vehicle must return to its base.
    must_return: bool,
    /// The state of waiting for teammates.
    waiting: Waiting,
    /// Whether its heartbeats tell the digest of its belief.
    tells_digest: bool,
}

/// When a waiting robot decides again.
#[derive(Clone, Copy, Debug, Default)]
struct Waiting {
    /// When it last decided.
    since: MissionTime,
    /// What was known then: observations, and changes of plans.
    known: (u64, u64),
    /// When it will decide again, if anything has changed.
    until: Option<MissionTime>,
}

impl Agent {
    /// A robot with this configuration; its cell is unknown until its first event.
    #[must_use]
    pub fn new(config: AgentConfig) -> Self {
        let dragnet_scenario::Policy { name, parameters, ref network, .. } = config.robot.policy;
        let policy = policy::build(name, parameters, network.as_ref());
        Self::with_policy(config, policy)
    }

    /// A robot with a given policy, instead of that of its configuration.
    #[must_use]
    pub fn with_policy(config: AgentConfig, policy: Box<dyn Policy + Send>) -> Self {
        let participant = Participant::Robot(config.id());
        Self {
            policy,
            random: stream(config.seed, Purpose::Decision, config.id().number()),
            replica: Replica::new(
                participant,
                config.mission.heartbeat / 2,
                config.limits.clone(),
                config.knowledge.clone(),
            )
            .with_max_observations(config.max_observations),
            team: Team::default(),
            activity: Activity::Searching,
            cell: None,
            path_meters: 0.0,
            plan: Vec::new(),
            entered: 0,
            decided: MissionTime::START,
            arrived: MissionTime::START,
            is_overtaken: false,
            sightings: Sightings::default(),
            located: Vec::new(),
            blind_spots: BlindSpots::default(),
            barred: Barred::default(),
            decisions: 0,
            plans: 0,
            recalled: None,
            base: None,
            home: None,
            origin: Origin::first(config.id()),
            unused_incarnation: 0,
            observations: 0,
            dated: MissionTime::START,
            heartbeats: HeartbeatSchedule::new(config.place, config.mission.heartbeat),
            directive: Directive::default(),
            orders: RobotOrders::default(),
            zones: Zones::default(),
            line_of_sight: None,
            open_ground: Arc::clone(&config.terrain),
            occupied: BTreeSet::new(),
            ground: Arc::clone(&config.terrain),
            must_return: false,
            waiting: Waiting::default(),
            tells_digest: true,
            config,
        }
    }

    /// The same, but heartbeats have an empty digest: no robot reads it, and in an environment that is stepped move by move
    /// hashing the belief for each heartbeat takes a sixth of the time.
    #[must_use]
    pub fn without_digests(self) -> Self {
        Self { tells_digest: false, ..self }
    }

    /// Restores an observation that a robot of this number stored before a restart: its evidence, and the distance
    /// driven. To be called before anything else, with each observation in the order of [`Effects::kept`].
    ///
    /// New observations are numbered under another incarnation: the last stored one may not be the last that was
    /// published.
    pub fn recall(&mut self, observation: &Arc<Observation>) {
        if observation.origin.source == self.config.id().into() {
            if let Some((_, before)) = self.recalled {
                self.path_meters += self.meters(before, observation.from);
            }
            let first = self.recalled.map_or(observation.from, |(first, _)| first);
            self.recalled = Some((first, observation.from));
            let used = observation.origin.incarnation;
            self.unused_incarnation = self.unused_incarnation.max(used.saturating_add(1));
        }
        if self.replica.record(observation) == Ok(Entry::New) {
            self.sightings.add(&observation.readings);
        }
    }

    /// Shares what it knows with other robots of the process.
    pub fn share(&mut self, shared: &SharedKnowledge) {
        self.replica.knowledge_mut().share(shared);
    }

    /// Releases observations from memory: at most the last `held` of each origin are kept. To be called once all are
    /// stored. The belief does not change.
    pub fn release(&mut self, held: NonZeroUsize) {
        self.replica.release(held);
    }

    /// Handles an event. Together with [`Agent::receive`] it is the only function that changes the robot's state while
    /// it runs; the caller passes the time. Events of the coordinator are ignored.
    pub fn react(&mut self, now: MissionTime, event: Event<Message>) -> Effects<Message> {
        let mut effects = Effects::default();
        match event {
            Event::Sensed { cell, readings } => self.sense(now, cell, readings, &mut effects),
            Event::RouteFailed { blocked } => self.bar(now, blocked),
            Event::Doubted { cells } => self.sightings.doubt(&cells),
            Event::LineOfSight(seen) => {
                self.line_of_sight = Some(seen);
                self.survey();
            }
            Event::Located(positions) => self.located = positions,
            Event::Received { from, message } => return self.receive(now, from, &message),
            Event::Woke => self.wake(now, &mut effects),
            Event::Came => self.heartbeats.request_sync(now),
            Event::Lost(robot) => self.team.lost(robot),
            Event::Halted => {
                self.plan.clear();
                effects.route = Some(Vec::new());
            }
            Event::MustReturn(must) => {
                let before = self.order();
                self.must_return = must;
                if self.order() != before {
                    self.decide(now, &mut effects);
                }
            }
            Event::Released if !self.activity.is_rest() => self.decide(now, &mut effects),
            Event::Released
            | Event::Start
            | Event::Commanded(_)
            | Event::Doubled(_)
            | Event::Pictured(_)
            | Event::ClockSet(_)
            | Event::Began { .. } => {}
        }
        self.plan_to_think_again(now);
        Effects { wake_at: self.wake_at(), activity: self.activity, ..effects }
    }

    /// Handles a message like [`Event::Received`], by reference: a message need not be copied for each of its
    /// receivers.
    pub fn receive(&mut self, now: MissionTime, from: Participant, message: &Message) -> Effects<Message> {
        let mut effects = Effects::default();
        self.process(now, from, message, &mut effects);
        self.plan_to_think_again(now);
        Effects { wake_at: self.wake_at(), activity: self.activity, ..effects }
    }

    /// When to wake the robot if no event happens before.
    #[must_use]
    pub fn wake_at(&self) -> MissionTime {
        let due = self.heartbeats.due().min(self.waiting.until.unwrap_or(MissionTime(u64::MAX)));
        let due = due.min(self.held_until().unwrap_or(MissionTime(u64::MAX)));
        if self.plans == 0 && self.cell.is_some() { due.min(self.config.first_decision()) } else { due }
    }

    /// The robot's belief.
    #[must_use]
    pub fn belief(&self) -> &Belief {
        self.replica.knowledge().belief()
    }

    /// Whether a cell's probability reaches the mission's detection threshold.
    #[must_use]
    pub fn is_found(&self, cell: Cell) -> bool {
        self.belief().is_found(cell, self.config.mission.detection_threshold)
    }

    /// The robot's activity.
    #[must_use]
    pub const fn activity(&self) -> Activity {
        self.activity
    }

    /// Waypoints chosen so far.
    #[must_use]
    pub const fn decisions(&self) -> u64 {
        self.decisions
    }

    /// The robot.
    #[must_use]
    pub fn id(&self) -> RobotId {
        self.config.id()
    }

    /// When a message of a teammate that is not lost arrived last.
    #[must_use]
    pub fn heard(&self, teammate: RobotId) -> Option<MissionTime> {
        self.team.heard(teammate)
    }

    /// All observations known.
    #[must_use]
    pub const fn replica(&self) -> &Replica {
        &self.replica
    }

    fn sense(
        &mut self,
        now: MissionTime,
        cell: Cell,
        readings: Vec<Reading>,
        effects: &mut Effects<Message>,
    ) {
        if self.cell.is_none() {
            // The incarnations that it used before a restart are taken.
            self.origin.incarnation = now.0.max(self.unused_incarnation);
            // The vehicle's clock may be set only now, even backwards.
            self.heartbeats.restart(now);
            self.cell = Some(cell);
            self.settle(cell);
        }
        self.move_to(now, cell);
        self.observe(now, cell, readings, effects);
        let is_due =
            self.config.robot.policy.replan_after_cells.is_some_and(|cells| self.entered >= cells.get());
        let is_to_decide = match self.activity {
            // A search may end in any cell, not only at a waypoint.
            Activity::Searching => {
                self.plan.is_empty()
                    || self.is_overtaken
                    || is_due
                    || self.is_spent(now)
                    || self.is_due_home(now)
                    || self.is_cleared()
                    || self.is_way_blocked(now)
            }
            Activity::Returning => self.plan.is_empty() || self.is_overtaken || self.is_way_blocked(now),
            Activity::Sent | Activity::Leaving | Activity::GivingWay => {
                self.plan.is_empty() || self.is_overtaken || self.is_spent(now) || self.is_way_blocked(now)
            }
            // Observations while it rests may have withdrawn a find.
            Activity::Cleared => true,
            _ => false,
        };
        if is_to_decide {
            self.decide(now, effects);
        }
    }

    /// Counts and publishes an observation, unless validation rejects it: then the robot's sensor or its position is
    /// wrong.
    fn observe(
        &mut self,
        now: MissionTime,
        cell: Cell,
        readings: Vec<Reading>,
        effects: &mut Effects<Message>,
    ) {
        let round = |reading: Reading| {
            if self.config.bytes_per_second.is_some() { reading.rounded() } else { reading }
        };
        let readings: Vec<Reading> = readings.into_iter().map(round).collect();
        // Its clock may have been set back.
        self.dated = self.dated.max(now);
        let observation = Arc::new(Observation {
            origin: self.origin,
            sequence: self.observations,
            time_ns: self.dated.0,
            from: cell,
            readings,
            positions: std::mem::take(&mut self.located).into(),
        });
        if let Err(rejected) = self.replica.record(&observation) {
            effects.rejected.push(rejected);
            return;
        }
        self.observations += 1;
        self.blind_spots.add(&self.ground, self.config.sensor(), cell, &observation.readings);
        self.sightings.add(&observation.readings);
        effects.kept.push(Arc::clone(&observation));
        effects.published.push((Audience::All, Message::Observation(observation)));
    }

    /// The robot may be off its plan, which is then discarded.
    fn move_to(&mut self, now: MissionTime, cell: Cell) {
        if self.cell == Some(cell) && !self.plan.is_empty() {
            // A vehicle reports what it has found in the cell that it leaves.
            return;
        }
        if let Some(before) = self.cell
            && before != cell
        {
            self.path_meters += self.meters(before, cell);
            self.entered += 1;
            self.arrived = now;
        }
        self.cell = Some(cell);
        match self.plan.iter().position(|&planned| planned == cell) {
            Some(place) => {
                self.plan.drain(..=place);
            }
            None => self.plan.clear(),
        }
    }

    fn meters(&self, from: Cell, to: Cell) -> f64 {
        self.config.terrain.grid().offset(from, to).euclidean() * self.config.terrain.cell_meters()
    }

    fn process(
        &mut self,
        now: MissionTime,
        from: Participant,
        message: &Message,
        effects: &mut Effects<Message>,
    ) {
        let received = self.replica.receive(now, from, message);
        effects.rejected.extend(received.rejected);
        if !self.config.limits.knows(from) {
            return;
        }
        if matches!(from, Participant::Robot(robot) if !self.team.is_alive(robot)) {
            self.heartbeats.request_sync(now);
        }
        match message {
            Message::Observation(observation) => {
                if let Source::Robot(robot) = observation.origin.source {
                    self.team.walked(now, robot, observation.from);
                    self.team.is_at(now, robot, observation.time_ns, observation.from);
                }
            }
            Message::Intent(intent) => self.learn_plan(now, intent),
            Message::Heartbeat(heartbeat) => {
                self.learn_plan(now, &heartbeat.intent);
                self.team.is_at(now, heartbeat.robot, heartbeat.time_ns, heartbeat.cell);
            }
            Message::SyncRequest(_)
            | Message::SyncReply(_)
            | Message::MissionStatus(_)
            | Message::Verdicts(_)
            | Message::Orders(_)
            | Message::Zones(_)
            | Message::Marks(_) => {
                if let Participant::Robot(robot) = from {
                    self.team.received(now, robot);
                }
            }
        }
        for observation in received.new {
            self.sightings.add(&observation.readings);
            effects.kept.push(observation);
        }
        effects.repeats.extend(received.repeats);
        let replies = received.replies.into_iter().map(|(whom, reply)| (Audience::One(whom), reply));
        effects.published.extend(replies);
        if let Message::Heartbeat(Heartbeat { versions, .. })
        | Message::MissionStatus(MissionStatus { versions, .. }) = message
        {
            self.heartbeats.suppress(|| self.replica.log().is_known_to(versions));
        }
        self.heed(now, message, &received.judged, received.marked.is_some(), effects);
    }

    /// Of two robots that did not know each other's plans, the one that decided later, or has the higher number,
    /// yields: it decides again in its next cell.
    fn learn_plan(&mut self, now: MissionTime, intent: &Intent) {
        let is_news = self.team.plans(now, intent);
        let made = (MissionTime(intent.time_ns), intent.robot);
        let is_earlier = made < (self.decided, self.config.id());
        if is_news && is_earlier && !intent.path.is_empty() {
            self.is_overtaken = true;
        }
    }

    fn wake(&mut self, now: MissionTime, effects: &mut Effects<Message>) {
        self.team.review(now, self.config.mission.lost_after, |robot| self.config.stillness(robot));
        let is_first = self.plans == 0;
        // Between cells it is not known how far a robot has come on its way home.
        let is_running_out = match self.activity {
            Activity::Searching
            | Activity::Paused
            | Activity::Sent
            | Activity::Leaving
            | Activity::GivingWay => self.is_spent(now),
            Activity::Waiting | Activity::Holding => self.is_spent(now) || self.is_due_home(now),
            Activity::Returning
            | Activity::Cleared
            | Activity::Spent
            | Activity::Stuck
            | Activity::Recalled => false,
        };
        // Teammates' observations may have withdrawn a find, and a teammate that was in the way may have left.
        let may_go_on = self.activity == Activity::Cleared
            || self.activity == Activity::Stuck && self.config.separation.is_kept();
        let is_to_think_again = self.waiting.until.is_some_and(|until| now >= until);
        let is_held = self.give_up_if_held(now);
        if is_first || is_running_out || may_go_on || is_to_think_again || is_held {
            self.decide(now, effects);
        }
        if self.heartbeats.beats(now) {
            self.beat(now, effects);
        }
    }

    fn is_spent(&self, now: MissionTime) -> bool {
        self.config.mission.budget.is_spent(self.path_meters, now.since(MissionTime::START))
    }

    /// It is in its first cell, and may have a base.
    fn settle(&mut self, cell: Cell) {
        let was_first_in = self.recalled.map(|(first, _)| first);
        let base = home::base(&self.config.robot, was_first_in, cell);
        self.base = Some(base);
        if self.config.mission.return_reserve.is_some() {
            let home = self.home_to(base);
            // Where no path leads to its base, its first cell is the next best.
            if !home.is_in_reach(cell) {
                self.base = Some(cell);
            }
            self.home = self.base.map(|base| self.home_to(base));
        }
    }

    /// The ways to a base, or to the cell nearest to it that no-go zones leave in reach.
    fn home_to(&self, base: Cell) -> Home {
        let base = self.haven(base);
        Home::new(&self.open_ground, self.config.connectivity, base)
    }

    /// Whether the budget leaves no more than the way home.
    fn is_due_home(&self, now: MissionTime) -> bool {
        self.home
            .as_ref()
            .zip(self.cell)
            .is_some_and(|(home, cell)| !is_way_home_within(home.ways(), cell, self.remaining_cells(now)))
    }

    /// Whether its budget keeps it from some cell, since it is to come home.
    fn is_held_back(&self, now: MissionTime, cell: Cell) -> bool {
        let (ground, connectivity) = (&self.ground, self.config.connectivity);
        let home = self.home.as_ref();
        home.is_some_and(|home| home.is_any_too_far(ground, connectivity, cell, self.remaining_cells(now)))
    }

    /// Path length that the budget leaves, cells.
    fn remaining_cells(&self, now: MissionTime) -> f64 {
        let elapsed = now.since(MissionTime::START);
        self.config.mission.remaining_meters(self.path_meters, elapsed) / self.config.terrain.cell_meters()
    }

    /// Whether the expected number of remaining objects is low enough to end the search.
    fn is_cleared(&self) -> bool {
        self.config.mission.stop_when_expected_remaining.is_some_and(|threshold| {
            let (terrain, mission) = (&self.ground, &self.config.mission);
            let reach = self.replica.knowledge().reach();
            let belief = planning_belief(
                self.replica.knowledge().belief(),
                &self.sightings,
                &self.blind_spots,
                self.config.sensor(),
                &self.zones,
            );
            let tau = mission.detection_threshold;
            match self.config.subjects {
                Some(it) => {
                    let is_found = |cell| belief.is_found(cell, tau);
                    it.expected_remaining(&belief, terrain, reach, is_found) <= threshold
                }
                None => belief.expects_at_most(terrain, reach, tau, threshold),
            }
        })
    }

    /// A waiting robot decides again when a plan or an observation has changed: in its turn, so that it knows the new
    /// plans of those before it, and no sooner than it could have entered another cell.
    fn plan_to_think_again(&mut self, now: MissionTime) {
        if self.activity != Activity::Waiting {
            self.waiting.until = None;
        } else if self.waiting.known != self.known() {
            let soonest = self.waiting.since + self.config.step_time();
            let due = soonest.max(now) + self.config.turn();
            self.waiting.until = Some(self.waiting.until.map_or(due, |until| until.min(due)));
        }
    }

    fn known(&self) -> (u64, u64) {
        (self.replica.log().len(), self.team.changes())
    }

    /// Chooses a waypoint, or rests.
    fn decide(&mut self, now: MissionTime, effects: &mut Effects<Message>) {
        let Some(cell) = self.cell.filter(|_| now >= self.config.first_decision()) else { return };
        let has_opened = self.barred.open(now);
        if self.learns_who_stands(now) || has_opened {
            self.survey();
        }
        let (activity, path) = match self.order() {
            _ if self.is_spent(now) => (Activity::Spent, Vec::new()),
            RobotOrder::Pause => (Activity::Paused, Vec::new()),
            _ if self.is_closed(cell) => self.leave(cell),
            RobotOrder::Return if self.must_return => (Activity::Spent, Vec::new()),
            RobotOrder::Return => (Activity::Recalled, Vec::new()),
            RobotOrder::Go(there) => self.go(now, cell, there),
            RobotOrder::Search if self.is_cleared() => (Activity::Cleared, Vec::new()),
            RobotOrder::Search if self.is_due_home(now) => (Activity::Spent, Vec::new()),
            RobotOrder::Search => self.choose_measured(now, cell, effects),
        };
        let may_leave = activity.is_rest() && self.order() != RobotOrder::Pause;
        let (activity, path) = if may_leave { self.go_home(cell, activity) } else { (activity, path) };
        let (activity, path) = self.keep_apart(now, cell, (activity, path));
        self.waiting = Waiting { since: now, known: self.known(), until: self.waits_until(now, activity) };
        if activity != Activity::Searching && activity == self.activity && path == self.plan {
            return;
        }
        self.activity = activity;
        self.decided = now;
        self.is_overtaken = false;
        self.entered = 0;
        self.plan.clone_from(&path);
        self.plans += 1;
        effects.route = Some(path);
        effects.published.push((Audience::All, Message::Intent(self.intent())));
    }

    /// What a robot in `cell` does that the operator sends to another. Where no path leads it holds where it is; where its
    /// budget would not leave the way home it turns around.
    fn go(&self, now: MissionTime, cell: Cell, there: Cell) -> (Activity, Vec<Cell>) {
        if self.is_due_home(now) {
            return (Activity::Spent, Vec::new());
        }
        let whole = ShortestPathTree::from(&self.ground, self.config.connectivity, cell).path(there);
        let (grid, remaining_cells) = (self.ground.grid(), self.remaining_cells(now));
        let ways_home = self.home.as_ref().map(Home::ways);
        let path = &whole[..leading_cells_with_way_home(grid, cell, &whole, ways_home, remaining_cells)];
        match (path.is_empty(), whole.is_empty()) {
            (_, true) if there != cell => (self.unless_occupied(Activity::Holding), Vec::new()),
            (_, true) => (Activity::Holding, Vec::new()),
            (true, false) => (Activity::Spent, Vec::new()),
            (false, false) => (Activity::Sent, path.to_vec()),
        }
    }

    /// What a robot does whose search is over for this reason: it rests, or returns to its base first.
    fn go_home(&self, cell: Cell, reason: Activity) -> (Activity, Vec<Cell>) {
        let called = self.base.filter(|_| self.order() == RobotOrder::Return);
        let home = match &self.home {
            Some(home) => Some(Cow::Borrowed(home)),
            None => called.map(|base| Cow::Owned(self.home_to(base))),
        };
        match home {
            Some(home) if home.base() != cell => match home.path_from(cell) {
                path if path.is_empty() => (Activity::Stuck, path),
                path => match self.around_occupied(cell, path) {
                    path if path.is_empty() => (self.unless_occupied(Activity::Stuck), path),
                    path => (Activity::Returning, path),
                },
            },
            _ => (reason, Vec::new()),
        }
    }

    /// The same as [`Agent::choose`], with the computing time if a waypoint was chosen.
    fn choose_measured(
        &mut self,
        now: MissionTime,
        robot: Cell,
        effects: &mut Effects<Message>,
    ) -> (Activity, Vec<Cell>) {
        // Only measured: no decision depends on it.
        let start = Instant::now();
        let chosen = self.choose(now, robot);
        effects.decision = (chosen.0 == Activity::Searching).then(|| start.elapsed());
        chosen
    }

    /// The next path from this cell, or the reason why there is none.
    ///
    /// A robot first leaves to its teammates what they plan to observe and what is nearer to them. If nothing else is
    /// informative it helps them: it goes to cells that they do not plan to observe, even if those are nearer to them,
    /// but no farther than its sensor radius before it decides again, since their next plans may leave it something. So
    /// several helpers may go to the same cells: `docs/results.md` compares this with what else they could do. If
    /// teammates plan to observe all that is left, it waits; if they plan nothing, nothing is left.
    fn choose(&mut self, now: MissionTime, robot: Cell) -> (Activity, Vec<Cell>) {
        let planned = self.team.planned(self.view(now));
        let mut with_shares = planned.clone();
        with_shares.add_shares(&self.ground, self.config.sensor(), robot);
        let mut decision = self.decide_with(now, &with_shares, robot);
        if decision.is_rest() && decision.had_candidates() && self.team.is_anything_planned() {
            decision = self.decide_with(now, &planned, robot);
            decision.path.truncate(self.config.sensor().radius() as usize);
        }
        if !decision.is_rest() {
            self.decisions += 1;
            return (Activity::Searching, decision.path);
        }
        let activity = if decision.had_candidates() && self.team.is_anything_planned() {
            Activity::Waiting
        } else if self.is_held_back(now, robot) {
            Activity::Spent
        } else if decision.had_candidates() {
            Activity::Cleared
        } else {
            self.unless_occupied(Activity::Stuck)
        };
        (activity, Vec::new())
    }

    fn view(&self, now: MissionTime) -> View<'_> {
        let AgentConfig { terrain, robot, limits, .. } = &self.config;
        let line_of_sight = self.line_of_sight.as_ref().unwrap_or(limits.terrain().line_of_sight());
        View { terrain, line_of_sight, class: &robot.class, limits, now }
    }

    fn decide_with(
        &mut self,
        now: MissionTime,
        planned_precision: &PlannedPrecision,
        robot: Cell,
    ) -> Decision {
        let belief = planning_belief(
            self.replica.knowledge().belief(),
            &self.sightings,
            &self.blind_spots,
            self.config.sensor(),
            &self.zones,
        );
        let situation = Situation {
            terrain: &self.ground,
            connectivity: self.config.connectivity,
            sensor: self.config.sensor(),
            belief: &belief,
            planned_precision,
            robot,
            place: self.config.place,
            detection_threshold: self.config.mission.detection_threshold,
            remaining_cells: self.remaining_cells(now),
            ways_home: self.home.as_ref().map(Home::ways),
        };
        let mut decision = self.policy.choose(&situation, &mut self.random);
        decision.path.truncate(situation.leading_cells_with_way_home(&decision.path));
        decision
    }

    fn intent(&self) -> Intent {
        Intent {
            robot: self.config.id(),
            incarnation: self.origin.incarnation,
            decision: self.plans,
            time_ns: self.decided.0,
            path: self.plan.clone().into(),
        }
    }

    fn beat(&self, now: MissionTime, effects: &mut Effects<Message>) {
        // A robot that has restarted knows what the operator wants before its vehicle says where it is.
        let Some(cell) = self.cell else { return self.pass_on(now, effects) };
        let heartbeat = Heartbeat {
            robot: self.config.id(),
            time_ns: now.0,
            activity: self.activity,
            cell,
            path_meters: self.path_meters,
            intent: self.intent(),
            versions: self.replica.knowledge().versions(),
            digest: if self.tells_digest { self.replica.knowledge().digest() } else { Digest(0) },
            directive: self.directive.clone(),
        };
        effects.published.push((Audience::All, Message::Heartbeat(heartbeat)));
        self.pass_on(now, effects);
    }
}

/// The belief by which a robot plans and ends its search: with sightings, and without what it cannot see or is to skip.
fn planning_belief<'a>(
    belief: &'a Belief,
    sightings: &Sightings,
    blind_spots: &BlindSpots,
    sensor: &Sensor,
    zones: &Zones,
) -> Cow<'a, Belief> {
    let mut belief = blind_spots.removed_from(sightings.added_to(belief), sensor);
    for cell in zones.cells(Zone::Skip) {
        blind_spots::clear(&mut belief, cell);
    }
    belief
}
