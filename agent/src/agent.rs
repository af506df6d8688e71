//! The robot: events go in, effects come out.

use dragnet_learn::policy;
use dragnet_proto::directive::{Directive, added_prior};
use dragnet_proto::message::{Activity, Audience, Heartbeat, Intent, Message, MissionStatus};
use dragnet_proto::replica::Replica;
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_proto::validation::Limits;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Mission, Robot, Scenario};
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::observation::{Entry, Observation, Origin, RobotId, Source};
use dragnet_search::policy::{Decision, Policy};
use dragnet_search::reach::Reach;
use dragnet_search::route::Connectivity;
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::Sensor;
use dragnet_search::situation::{Place, Situation};
use dragnet_search::terrain::Terrain;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use crate::heartbeat::HeartbeatSchedule;
use crate::team::{Patience, Team};

/// All that a robot is told before it starts.
#[derive(Clone, Debug)]
pub struct AgentConfig {
    /// Which robot this is, and how it decides.
    pub robot: Robot,
    /// Its place in the team.
    pub place: Place,
    /// The map.
    pub terrain: Arc<Terrain>,
    /// How it moves.
    pub connectivity: Connectivity,
    /// What it sees with.
    pub sensor: Arc<Sensor>,
    /// What is believed before any reading.
    pub prior: Arc<Belief>,
    /// What of it can be.
    pub limits: Limits,
    /// When an object counts as found, when to stop, and how to keep in touch.
    pub mission: Mission,
    /// Seed of its random choices.
    pub seed: u64,
}

impl AgentConfig {
    /// The orders of every robot of a scenario, by number.
    #[must_use]
    pub fn of_team(scenario: &Scenario, seed: u64) -> Vec<Self> {
        let (terrain, sensor) = (Arc::new(scenario.terrain().clone()), Arc::new(scenario.sensor().clone()));
        let prior = Arc::new(scenario.prior().clone());
        let numbers = scenario.robots().iter().map(|robot| robot.id);
        let limits = Limits::new(Arc::clone(&terrain), Arc::clone(&sensor), numbers, scenario.mission());
        let team = u16::try_from(scenario.robots().len()).unwrap_or(u16::MAX);
        (0..team)
            .zip(scenario.robots())
            .map(|(member, robot)| Self {
                robot: robot.clone(),
                place: Place { member, team },
                terrain: Arc::clone(&terrain),
                connectivity: scenario.connectivity(),
                sensor: Arc::clone(&sensor),
                prior: Arc::clone(&prior),
                limits: limits.clone(),
                mission: scenario.mission().clone(),
                seed,
            })
            .collect()
    }

    fn id(&self) -> RobotId {
        self.robot.id
    }

    /// How long a robot takes over the longest move.
    fn step_time(&self) -> Duration {
        let meters = std::f64::consts::SQRT_2 * self.terrain.cell_meters();
        Duration::from_secs_f64((meters / self.mission.speed_meters_per_second).min(LONGEST_STEP_SECONDS))
    }

    /// A teammate may be slower than it should be, and plan its way around what stands there.
    fn patience(&self) -> Patience {
        let silence = self.mission.lost_after;
        Patience { silence, stillness: silence.saturating_add(self.step_time() * SLOW_STEPS) }
    }

    /// Robots that decide about the same news do so one after the other.
    fn turn(&self) -> Duration {
        self.mission.stagger * u32::from(self.place.member)
    }

    /// Robots decide for the first time one after the other, so that each knows the plans of those before it.
    fn first_decision(&self) -> MissionTime {
        MissionTime::START + self.turn()
    }
}

/// Of how many steps a teammate that goes nowhere may take the time, beside that of one who is silent.
const SLOW_STEPS: u32 = 4;
/// However slow a robot may be, it is waited for no longer than this over one step.
const LONGEST_STEP_SECONDS: f64 = 3600.0;

/// One robot.
pub struct Agent {
    orders: AgentConfig,
    policy: Box<dyn Policy + Send>,
    random: Stream,
    belief: Belief,
    /// What robots can see, from where they were seen to stand.
    reach: Reach,
    replica: Replica,
    team: Team,
    activity: Activity,
    /// Where it stands; unknown before the first event.
    cell: Option<Cell>,
    path_meters: f64,
    /// Cells that it has yet to enter.
    plan: Vec<Cell>,
    /// Cells entered since the last decision.
    entered: u32,
    /// When the plan was made.
    decided: MissionTime,
    /// Whether a teammate's plan has come late: made before this robot's, and unknown to it then.
    is_overtaken: bool,
    /// Whether its last look has left open in which cell something is.
    is_undecided: bool,
    /// Waypoints chosen.
    decisions: u64,
    /// Plans made, those to rest included: the number of the next one.
    plans: u64,
    /// Where it last stood before it started again.
    recalled: Option<Cell>,
    /// Under which its observations and plans are numbered.
    origin: Origin,
    /// The first incarnation that it does not remember to have used.
    unused_incarnation: u64,
    /// Observations made.
    observations: u64,
    /// The date of the last one.
    dated: MissionTime,
    heartbeats: HeartbeatSchedule,
    /// What a person has ordered, as far as it has heard.
    directive: Directive,
    /// Prior probability in cells that a person adds.
    added_prior: f64,
    /// While it waits for teammates.
    waiting: Waiting,
}

/// When a robot that waits thinks again.
#[derive(Clone, Copy, Debug, Default)]
struct Waiting {
    /// When it last thought about it.
    since: MissionTime,
    /// What was known then: observations, and changes of plans.
    known: (u64, u64),
    /// When it will think again, if anything has changed.
    until: Option<MissionTime>,
}

impl Agent {
    /// A robot with its orders, before it knows where it is.
    #[must_use]
    pub fn new(orders: AgentConfig) -> Self {
        let dragnet_scenario::Policy { name, parameters, ref network, .. } = orders.robot.policy;
        let policy = policy::build(name, parameters, network.as_ref());
        Self::with_policy(orders, policy)
    }

    /// A robot that decides by a policy of its own, whatever its orders say.
    #[must_use]
    pub fn with_policy(orders: AgentConfig, policy: Box<dyn Policy + Send>) -> Self {
        let participant = Participant::Robot(orders.id());
        Self {
            policy,
            random: stream(orders.seed, Purpose::Decision, orders.id().number()),
            belief: Belief::clone(&orders.prior),
            reach: Reach::unknown(orders.terrain.grid(), orders.sensor.radius()),
            replica: Replica::new(participant, orders.mission.heartbeat / 2, orders.limits.clone()),
            team: Team::default(),
            activity: Activity::Searching,
            cell: None,
            path_meters: 0.0,
            plan: Vec::new(),
            entered: 0,
            decided: MissionTime::START,
            is_overtaken: false,
            is_undecided: false,
            decisions: 0,
            plans: 0,
            recalled: None,
            origin: Origin::first(orders.id()),
            unused_incarnation: 0,
            observations: 0,
            dated: MissionTime::START,
            heartbeats: HeartbeatSchedule::new(orders.place, orders.mission.heartbeat),
            directive: Directive::default(),
            added_prior: added_prior(&orders.prior, &orders.terrain),
            waiting: Waiting::default(),
            orders,
        }
    }

    /// Takes in what a robot of this number kept before it started again: its evidence, and the way that it had covered.
    /// To be called before anything else, with each observation in the order of [`Effects::kept`].
    ///
    /// What it sees from now on is numbered anew, under another incarnation: what it kept last may not be the last that
    /// it told the others.
    pub fn recall(&mut self, observation: &Arc<Observation>) {
        if observation.origin.source == self.orders.id().into() {
            if let Some(before) = self.recalled {
                self.path_meters += self.meters(before, observation.from);
            }
            self.recalled = Some(observation.from);
            let used = observation.origin.incarnation;
            self.unused_incarnation = self.unused_incarnation.max(used.saturating_add(1));
        }
        if self.replica.record(Arc::clone(observation)) == Ok(Entry::New) {
            self.count(observation);
        }
    }

    /// All that was to be kept is kept: no more than the last so many observations of each origin are held in memory.
    /// What it believes stays as it is.
    pub fn release(&mut self, held: NonZeroUsize) {
        self.replica.release(held);
    }

    /// The only way the robot's state changes; `now` comes from the caller. Robots ignore events that are the coordinator's.
    pub fn react(&mut self, now: MissionTime, event: Event<Message>) -> Effects<Message> {
        let mut effects = Effects::default();
        match event {
            Event::Sensed { cell, readings } => self.sense(now, cell, readings, &mut effects),
            Event::Received { from, message } => self.receive(now, from, &message, &mut effects),
            Event::Woke => self.wake(now, &mut effects),
            Event::Came => self.heartbeats.request_sync(now),
            Event::Lost(robot) => self.team.lost(robot),
            Event::Halted => {
                self.plan.clear();
                effects.route = Some(Vec::new());
            }
            Event::Released if !self.activity.is_rest() => self.decide(now, &mut effects),
            Event::Released | Event::Start | Event::Commanded(_) | Event::Doubled(_) => {}
        }
        self.plan_to_think_again(now);
        Effects { wake_at: self.wake_at(), activity: self.activity, ..effects }
    }

    /// When to be woken, if nothing else happens before.
    #[must_use]
    pub fn wake_at(&self) -> MissionTime {
        let due = self.heartbeats.due().min(self.waiting.until.unwrap_or(MissionTime(u64::MAX)));
        if self.plans == 0 && self.cell.is_some() { due.min(self.orders.first_decision()) } else { due }
    }

    /// What the robot believes.
    #[must_use]
    pub const fn belief(&self) -> &Belief {
        &self.belief
    }

    /// Whether an object is found in a cell, as sure as the mission asks.
    #[must_use]
    pub fn is_found(&self, cell: Cell) -> bool {
        self.belief.is_found(cell, self.orders.mission.detection_threshold)
    }

    /// What the robot does.
    #[must_use]
    pub const fn activity(&self) -> Activity {
        self.activity
    }

    /// Waypoints chosen so far.
    #[must_use]
    pub const fn decisions(&self) -> u64 {
        self.decisions
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
            // The numbers that it used before it started again, if it did, are taken.
            self.origin.incarnation = now.0.max(self.unused_incarnation);
            // The vehicle's clock may be set only now, and back.
            self.heartbeats.restart(now);
        }
        self.move_to(cell);
        self.look(now, cell, readings, effects);
        let is_due =
            self.orders.robot.policy.replan_after_cells.is_some_and(|cells| self.entered >= cells.get());
        let is_to_decide = match self.activity {
            // A search ends where it may, not only at a waypoint.
            Activity::Searching => {
                self.plan.is_empty() || self.is_overtaken || is_due || self.is_spent(now) || self.is_cleared()
            }
            // What it sees while it rests may have withdrawn what was found.
            Activity::Cleared => true,
            _ => false,
        };
        if is_to_decide {
            self.decide(now, effects);
        }
    }

    /// Counts and tells what the robot sees, unless nobody would believe it: then its sensor, or where it says that it
    /// is, is wrong.
    fn look(&mut self, now: MissionTime, cell: Cell, readings: Vec<Reading>, effects: &mut Effects<Message>) {
        // Its clock may be set back meanwhile.
        self.dated = self.dated.max(now);
        let observation = Arc::new(Observation {
            origin: self.origin,
            sequence: self.observations,
            time_ns: self.dated.0,
            from: cell,
            readings,
        });
        if let Err(refused) = self.replica.record(Arc::clone(&observation)) {
            effects.refused.push(refused);
            return;
        }
        self.observations += 1;
        self.is_undecided = observation.readings.iter().any(Reading::is_undecided);
        self.count(&observation);
        effects.kept.push(Arc::clone(&observation));
        effects.published.push((Audience::All, Message::Observation(observation)));
    }

    /// The robot may be off its plan: then the plan is void.
    fn move_to(&mut self, cell: Cell) {
        if let Some(before) = self.cell
            && before != cell
        {
            self.path_meters += self.meters(before, cell);
            self.entered += 1;
        }
        self.cell = Some(cell);
        match self.plan.iter().position(|&planned| planned == cell) {
            Some(place) => {
                self.plan.drain(..=place);
            }
            None => self.plan.clear(),
        }
    }

    fn count(&mut self, observation: &Observation) {
        if observation.origin.source != Source::Operator {
            self.reach.add_robot(&self.orders.terrain, observation.from);
        }
        for reading in &observation.readings {
            self.belief.add(reading);
        }
    }

    fn meters(&self, from: Cell, to: Cell) -> f64 {
        self.orders.terrain.grid().offset(from, to).euclidean() * self.orders.terrain.cell_meters()
    }

    fn receive(
        &mut self,
        now: MissionTime,
        from: Participant,
        message: &Message,
        effects: &mut Effects<Message>,
    ) {
        let received = self.replica.receive(now, from, message);
        effects.refused.extend(received.refused);
        if !self.orders.limits.knows(from) {
            return;
        }
        if matches!(from, Participant::Robot(robot) if !self.team.is_alive(robot)) {
            self.heartbeats.request_sync(now);
        }
        match message {
            Message::Observation(observation) => {
                if let Source::Robot(robot) = observation.origin.source {
                    self.team.walked(now, robot, observation.from);
                }
            }
            Message::Intent(intent) => self.learn_plan(now, intent),
            Message::Heartbeat(heartbeat) => self.learn_plan(now, &heartbeat.intent),
            Message::SyncRequest(_) | Message::SyncReply(_) | Message::MissionStatus(_) => {
                if let Participant::Robot(robot) = from {
                    self.team.heard(now, robot);
                }
            }
        }
        for observation in received.new {
            self.count(&observation);
            effects.kept.push(observation);
        }
        effects.repeats.extend(received.repeats);
        let replies = received.replies.into_iter().map(|(whom, reply)| (Audience::One(whom), reply));
        effects.published.extend(replies);
        match message {
            Message::Heartbeat(Heartbeat { directive, versions, .. })
            | Message::MissionStatus(MissionStatus { directive, versions, .. }) => {
                self.heartbeats.suppress(|| self.replica.log().is_known_to(versions));
                self.obey(now, directive, effects);
            }
            _ => {}
        }
    }

    /// Does what a person has ordered, if it is news: pauses, goes on, or counts cells as searched.
    fn obey(&mut self, now: MissionTime, directive: &Directive, effects: &mut Effects<Message>) {
        if !self.directive.merge(now, directive) {
            return;
        }
        let terrain = Arc::make_mut(&mut self.orders.terrain);
        self.belief.search_also(terrain, self.directive.added.iter().copied(), self.added_prior);
        let is_paused = self.activity == Activity::Paused;
        if is_paused != self.directive.is_paused
            || self.activity.is_rest()
            || self.activity == Activity::Waiting
        {
            self.decide(now, effects);
        }
    }

    /// Of two robots that did not know each other's plans the one that decided later, or has the higher number, gives
    /// way: it decides anew in its next cell.
    fn learn_plan(&mut self, now: MissionTime, intent: &Intent) {
        let is_news = self.team.plans(now, intent);
        let made = (MissionTime(intent.time_ns), intent.robot);
        let is_earlier = made < (self.decided, self.orders.id());
        if is_news && is_earlier && !intent.path.is_empty() {
            self.is_overtaken = true;
        }
    }

    fn wake(&mut self, now: MissionTime, effects: &mut Effects<Message>) {
        self.team.review(now, self.orders.patience());
        let is_first = self.plans == 0;
        let is_running_out = !self.activity.is_rest() && self.is_spent(now);
        // What teammates saw may have withdrawn what was found.
        let is_cleared = self.activity == Activity::Cleared;
        let is_to_think_again = self.waiting.until.is_some_and(|until| now >= until);
        if is_first || is_running_out || is_cleared || is_to_think_again {
            self.decide(now, effects);
        }
        if self.heartbeats.beats(now) {
            self.beat(now, effects);
        }
    }

    fn is_spent(&self, now: MissionTime) -> bool {
        self.orders.mission.budget.is_spent(self.path_meters, now.since(MissionTime::START))
    }

    /// Whether so few objects are expected beyond those found that nothing is left that is worth a search. Who sees
    /// something and does not know yet in which cell is not done.
    fn is_cleared(&self) -> bool {
        !self.is_undecided
            && self.orders.mission.stop_when_expected_remaining.is_some_and(|threshold| {
                let AgentConfig { terrain, mission, .. } = &self.orders;
                self.belief.expected_remaining(terrain, &self.reach, mission.detection_threshold) <= threshold
            })
    }

    /// A robot that waits thinks again when a plan or an observation has changed what it knew: in its turn, so that of
    /// several that wait each knows what those before it do now, and no sooner than it could have been in another cell.
    fn plan_to_think_again(&mut self, now: MissionTime) {
        if self.activity != Activity::Waiting {
            self.waiting.until = None;
        } else if self.waiting.until.is_none() && self.waiting.known != self.known() {
            let soonest = self.waiting.since + self.orders.step_time();
            self.waiting.until = Some(soonest.max(now) + self.orders.turn());
        }
    }

    fn known(&self) -> (u64, u64) {
        (self.replica.log().len(), self.team.changes())
    }

    /// Chooses a waypoint, or rests.
    fn decide(&mut self, now: MissionTime, effects: &mut Effects<Message>) {
        let Some(cell) = self.cell.filter(|_| now >= self.orders.first_decision()) else { return };
        let resting = if self.is_spent(now) {
            Some(Activity::Spent)
        } else if self.directive.is_paused {
            Some(Activity::Paused)
        } else if self.is_cleared() {
            Some(Activity::Cleared)
        } else {
            None
        };
        let (activity, path) = match resting {
            Some(activity) => (activity, Vec::new()),
            None => self.choose(cell),
        };
        self.waiting = Waiting { since: now, known: self.known(), until: None };
        if activity != Activity::Searching && activity == self.activity {
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

    /// Where to go from this cell, or why nowhere.
    ///
    /// A robot first leaves to its teammates what they plan to see and what is nearer to them. If nothing else is worth a
    /// look it helps them: it goes where they do not plan to look, nearer to them as it may be, but no farther than it
    /// sees before it thinks again: where they go next may leave something to it. If they plan to see all of that too it
    /// waits, and if they plan nothing then nothing is left.
    fn choose(&mut self, robot: Cell) -> (Activity, Vec<Cell>) {
        let promised = self.team.promised(&self.orders.terrain, &self.orders.sensor, robot);
        let mut decision = self.decide_with(&promised, robot);
        if decision.is_rest() && decision.had_candidates() && self.team.is_anything_promised() {
            let planned = self.team.planned(&self.orders.terrain, &self.orders.sensor);
            decision = self.decide_with(&planned, robot);
            decision.path.truncate(self.orders.sensor.radius() as usize);
        }
        if !decision.is_rest() {
            self.decisions += 1;
            return (Activity::Searching, decision.path);
        }
        let activity = if !decision.had_candidates() {
            Activity::Stuck
        } else if self.team.is_anything_promised() {
            Activity::Waiting
        } else {
            Activity::Cleared
        };
        (activity, Vec::new())
    }

    fn decide_with(&mut self, promised: &PlannedPrecision, robot: Cell) -> Decision {
        let situation = Situation {
            terrain: &self.orders.terrain,
            connectivity: self.orders.connectivity,
            sensor: &self.orders.sensor,
            belief: &self.belief,
            promised,
            robot,
            place: self.orders.place,
        };
        self.policy.decide(&situation, &mut self.random)
    }

    fn intent(&self) -> Intent {
        Intent {
            robot: self.orders.id(),
            incarnation: self.origin.incarnation,
            decision: self.plans,
            time_ns: self.decided.0,
            path: self.plan.clone(),
        }
    }

    fn beat(&self, now: MissionTime, effects: &mut Effects<Message>) {
        let Some(cell) = self.cell else { return };
        let heartbeat = Heartbeat {
            robot: self.orders.id(),
            time_ns: now.0,
            activity: self.activity,
            cell,
            path_meters: self.path_meters,
            intent: self.intent(),
            versions: self.replica.log().versions().collect(),
            digest: self.belief.digest(),
            directive: self.directive.clone(),
        };
        effects.published.push((Audience::All, Message::Heartbeat(heartbeat)));
    }
}
