//! The simulation: one queue of events, in simulated time, over any participants.

mod by_hand;
mod delivery;

use std::time::Duration;

use dragnet_proto::command::Command;
use dragnet_proto::convert::Codec;
use dragnet_proto::message::{Activity, Audience};
use dragnet_proto::radio::Radio;
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::measures::{Curve, Score};
use dragnet_search::observation::RobotId;

use serde::{Deserialize, Serialize};

use crate::faults::Faults;
use crate::network::{Network, Tally};
use crate::participants::Participants;
use crate::queue::Queue;
use crate::traffic::Traffic;
use crate::world::{Body, World};

/// The rules of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rules {
    /// When it ends.
    pub end: End,
    /// Whether a coordinator participates.
    pub coordinator: Membership,
}

/// When an episode ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// When no robot is searching.
    Resting,
    /// When no robot is searching, or as soon as the merged belief has found every object. The paper's trials end so;
    /// only a simulator can determine it.
    AllFound,
}

/// Whether a participant is present.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Membership {
    /// It participates.
    Present,
    /// It does not participate.
    Absent,
}

/// A step of the simulation, for observers.
#[derive(Clone, Debug, PartialEq)]
pub enum StepContext {
    /// A robot has a new route; empty: it stays where it is.
    Departs {
        /// The robot.
        robot: RobotId,
        /// Cells to enter.
        route: Vec<Cell>,
        /// Its activity; `None` where only its plan is known.
        activity: Option<Activity>,
    },
    /// A robot has entered a cell.
    Arrives {
        /// The robot.
        robot: RobotId,
        /// The cell.
        cell: Cell,
        /// Path length of the farthest robot, cells.
        farthest_cells: f64,
    },
    /// With all readings so far, a cell has become found.
    Finds {
        /// The robot of the last reading.
        robot: RobotId,
        /// The cell.
        cell: Cell,
        /// Its probability by all readings: of a subject, if their number is known.
        probability: f64,
    },
}

/// An observer of a simulation's steps.
pub type StepObserver<'a> = &'a mut dyn FnMut(MissionTime, StepContext);

/// The measurements of a simulation.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// When the search ended.
    pub ended: MissionTime,
    /// When the last of the cells that are found at the end was found, whether it holds an object or not; known at the
    /// end.
    pub last_find: Option<MissionTime>,
    /// Of all readings.
    latest: MissionTime,
    /// When cells became found, in order; one that is withdrawn may be found again.
    finds: Vec<(MissionTime, Cell)>,
    /// F1 of the merged belief over the path length of the farthest robot, cells.
    pub f1: Curve,
    /// Recall of the merged belief, likewise.
    pub recall: Curve,
    /// Recall of the merged belief over the mission time, seconds.
    pub recall_over_time: Curve,
    /// Path length of the farthest robot when the merged belief first had found every object, cells.
    pub cells_to_full_recall: Option<f64>,
    /// Computing time of each decision.
    pub decisions: Vec<Duration>,
    /// Observations made by all robots.
    pub observations: u64,
    /// Numbers of messages by their outcome in the network.
    pub network: Tally,
    /// Messages sent until the search ended.
    pub traffic: Traffic,
    /// Whether the evidence of all robots was bit-for-bit equal after the end.
    pub beliefs_equal: bool,
    /// Digest of the evidence of all readings.
    pub digest: Digest,
}

impl Outcome {
    /// No measurements yet.
    #[must_use]
    pub fn new(world: &World) -> Self {
        Self {
            ended: MissionTime::START,
            last_find: None,
            latest: MissionTime::START,
            finds: Vec::new(),
            f1: Curve::default(),
            recall: Curve::default(),
            recall_over_time: Curve::default(),
            cells_to_full_recall: None,
            decisions: Vec::new(),
            observations: 0,
            network: Tally::default(),
            traffic: Traffic::default(),
            beliefs_equal: false,
            digest: world.merged().digest(),
        }
    }

    /// Keeps the last find that has not been withdrawn.
    pub(crate) fn end(&mut self, is_found: impl Fn(Cell) -> bool) {
        self.last_find = self.finds.iter().rev().find(|&&(_, cell)| is_found(cell)).map(|&(time, _)| time);
    }

    /// The time from the last find to the end; from the start if nothing was found.
    #[must_use]
    pub fn tail(&self) -> Duration {
        self.ended.since(self.last_find.unwrap_or(MissionTime::START))
    }

    /// Records the score of the merged belief, and its new finds, after another observation at this path length of the
    /// farthest robot.
    pub fn measure(&mut self, now: MissionTime, farthest_cells: f64, score: Score, found: &[Cell]) {
        self.observations += 1;
        self.finds.extend(found.iter().map(|&cell| (now, cell)));
        self.f1.push(farthest_cells, score.f1());
        self.recall.push(farthest_cells, score.recall());
        // By the wall clock a reading may be dated before the last one of another robot.
        self.latest = self.latest.max(now);
        self.recall_over_time.push(self.latest.as_seconds(), score.recall());
        if score.false_negatives == 0 && self.cells_to_full_recall.is_none() {
            self.cells_to_full_recall = Some(farthest_cells);
        }
    }
}

enum SimEvent<P> {
    /// A participant's radio has sent a message.
    Sent {
        from: Participant,
        audience: Audience,
        message: P,
    },
    Arrival {
        robot: RobotId,
        route_number: u64,
    },
    /// One message reaches these, one after the other.
    Delivery {
        from: Participant,
        to: Vec<Participant>,
        message: P,
    },
    Waking {
        participant: Participant,
        number: u64,
    },
    Crash {
        participant: Participant,
    },
    Return {
        participant: Participant,
    },
    Command(Command),
}

/// One episode in progress.
pub(crate) struct Simulation<C: Participants, S> {
    participants: C,
    rules: Rules,
    faults: Faults,
    /// Number of participants that will restart: the search is not over before.
    returns: usize,
    heartbeat: Duration,
    world: World,
    network: Network,
    codec: Codec,
    /// By [`Simulation::place`]; empty if messages take no time.
    radios: Vec<Radio<C::MessageRef>>,
    /// Whether what is sent is counted by kind.
    is_traffic_counted: bool,
    traffic: Traffic,
    queue: Queue<SimEvent<C::MessageRef>>,
    members: Vec<Member>,
    /// Number of members that do not rest.
    searching: usize,
    spectator: S,
    outcome: Outcome,
}

/// An observation as the simulator measures it.
struct View {
    robot: RobotId,
    cell: Cell,
    route_number: u64,
    /// Cells that have become found.
    found: Vec<Cell>,
    farthest_cells: f64,
    score: Score,
}

struct Member {
    participant: Participant,
    activity: Activity,
    /// Whether it has not crashed, or has restarted.
    is_up: bool,
    wake_at: MissionTime,
    /// Number of planned wake-ups: only the last one takes effect.
    waking: u64,
}

/// Number of heartbeats after the end to wait for equal beliefs.
const SETTLING_HEARTBEATS: u32 = 100;

impl<C: Participants, S: FnMut(MissionTime, StepContext)> Simulation<C, S> {
    pub(crate) fn new(scenario: &Scenario, seed: u64, rules: Rules, participants: C, spectator: S) -> Self {
        let robots = scenario.robots().iter().map(|robot| Participant::Robot(robot.id));
        let coordinator = (rules.coordinator == Membership::Present).then_some(Participant::Coordinator);
        let members = robots.chain(coordinator).map(|participant| Member {
            participant,
            activity: Activity::Searching,
            is_up: true,
            wake_at: MissionTime(u64::MAX),
            waking: 0,
        });
        let members: Vec<Member> = members.collect();
        let radios = scenario.network().bytes_per_second.into_iter();
        let radios = radios.flat_map(|rate| members.iter().map(move |_| Radio::new(rate))).collect();
        let world = World::new(scenario, seed);
        let mission = scenario.mission();
        Self {
            participants,
            rules,
            faults: Faults::default(),
            returns: 0,
            heartbeat: mission.heartbeat,
            network: Network::new(scenario.network().clone(), seed),
            codec: Codec::of(scenario),
            radios,
            is_traffic_counted: true,
            traffic: Traffic::default(),
            queue: Queue::new(),
            searching: members.iter().filter(|member| !member.is_resting()).count(),
            members,
            spectator,
            outcome: Outcome::new(&world),
            world,
        }
    }

    /// The same with faults; those of absent participants are ignored.
    pub(crate) fn with_faults(mut self, mut faults: Faults) -> Self {
        self.network.mute(std::mem::take(&mut faults.mute));
        for (&participant, crash) in &faults.crashes {
            if self.members.iter().all(|member| member.participant != participant) {
                continue;
            }
            self.queue.plan(crash.at, SimEvent::Crash { participant });
            if let Some((time, _)) = crash.back {
                self.queue.plan(time, SimEvent::Return { participant });
                self.returns += 1;
            }
        }
        if self.rules.coordinator == Membership::Present {
            for (time, command) in &faults.commands {
                self.queue.plan(*time, SimEvent::Command(command.clone()));
            }
        }
        self.faults = faults;
        self
    }

    /// Runs the episode to its end.
    pub(crate) fn run(mut self) -> Result<(World, Outcome), C::Error> {
        self.start()?;
        loop {
            let mut now = self.search()?;
            self.outcome.ended = now;
            self.outcome.traffic = self.traffic_so_far();
            self.network.heal();
            if self.settle(&mut now)? {
                break;
            }
        }
        self.outcome.digest = self.world.merged().digest();
        self.outcome.network = self.network.tally();
        Ok((self.world, self.outcome))
    }

    /// The coordinator first, so that it receives everything; then every robot observes from its start cell.
    fn start(&mut self) -> Result<(), C::Error> {
        for index in (0..self.members.len()).rev() {
            let participant = self.members[index].participant;
            self.tell(MissionTime::START, participant, Event::Start)?;
        }
        for index in 0..self.members.len() {
            if let Participant::Robot(robot) = self.members[index].participant {
                self.observe(MissionTime::START, robot)?;
            }
        }
        Ok(())
    }

    /// Runs until the search is over; returns the time.
    fn search(&mut self) -> Result<MissionTime, C::Error> {
        let mut now = self.outcome.ended;
        while !self.is_over() {
            let Some((due, sim_event)) = self.queue.next() else { break };
            now = due;
            match sim_event {
                SimEvent::Arrival { robot, route_number } if self.rules.end == End::Resting => {
                    self.arrive_together(now, robot, route_number)?;
                }
                sim_event => self.happen(now, sim_event)?,
            }
        }
        Ok(now)
    }

    fn is_over(&self) -> bool {
        self.is_all_found() || self.returns == 0 && self.searching == 0
    }

    fn is_all_found(&self) -> bool {
        self.rules.end == End::AllFound && self.outcome.cells_to_full_recall.is_some()
    }

    /// Runs until all beliefs are equal. Returns false if a robot searches again, because its last messages withdrew a
    /// find.
    fn settle(&mut self, now: &mut MissionTime) -> Result<bool, C::Error> {
        for _ in 0..SETTLING_HEARTBEATS {
            self.outcome.beliefs_equal = self.are_beliefs_equal(*now)?;
            if self.outcome.beliefs_equal {
                break;
            }
            let until = *now + self.heartbeat;
            while self.queue.due().is_some_and(|due| due <= until) {
                if let Some((due, sim_event)) = self.queue.next() {
                    // If the search was stopped from outside, no robot moves on.
                    if !(self.is_all_found() && matches!(sim_event, SimEvent::Arrival { .. })) {
                        self.happen(due, sim_event)?;
                    }
                }
                if !self.is_over() {
                    return Ok(false);
                }
            }
            *now = until;
        }
        Ok(true)
    }

    fn are_beliefs_equal(&mut self, now: MissionTime) -> Result<bool, C::Error> {
        // A robot's last readings may be lost in a crash, and the operator's marks are not readings of the world.
        let Faults { crashes, commands, liar, .. } = &self.faults;
        let is_all_seen = crashes.is_empty() && commands.is_empty() && liar.is_none();
        let mut expected = is_all_seen.then(|| self.world.merged().digest());
        let liar = liar.map(Participant::Robot);
        for member in self.members.iter().filter(|member| member.is_up && Some(member.participant) != liar) {
            let digest =
                self.participants.digest(member.participant, now + self.faults.ahead(member.participant))?;
            if *expected.get_or_insert(digest) != digest {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn happen(&mut self, now: MissionTime, sim_event: SimEvent<C::MessageRef>) -> Result<(), C::Error> {
        match sim_event {
            SimEvent::Arrival { robot, route_number } => {
                // A crash ends the route.
                if self.world.body(robot).route_number == route_number {
                    self.arrive(now, robot);
                    self.observe(now, robot)?;
                }
            }
            SimEvent::Sent { from, audience, message } => self.sent(now, from, audience, &message),
            SimEvent::Delivery { from, to, message } => self.deliver(now, from, to, message)?,
            SimEvent::Waking { participant, number } => {
                let place = self.place(participant);
                if self.members[place].waking == number {
                    // It may ask for the same time once more.
                    self.members[place].wake_at = MissionTime(u64::MAX);
                    self.tell(now, participant, Event::Woke)?;
                }
            }
            SimEvent::Crash { participant } => self.crash(now, participant),
            SimEvent::Return { participant } => self.bring_back(now, participant)?,
            SimEvent::Command(command) => self.command(now, command)?,
        }
        Ok(())
    }

    /// Passes an operator's command, once there is a coordinator.
    fn command(&mut self, now: MissionTime, command: Command) -> Result<(), C::Error> {
        let participant = Participant::Coordinator;
        if self.members[self.place(participant)].is_up {
            return self.tell(now, participant, Event::Commanded(command));
        }
        self.queue.plan(now + self.heartbeat, SimEvent::Command(command));
        Ok(())
    }

    /// A participant stops, and so does its robot.
    fn crash(&mut self, now: MissionTime, participant: Participant) {
        let place = self.place(participant);
        self.change(place, |member| member.is_up = false);
        let member = &mut self.members[place];
        member.wake_at = MissionTime(u64::MAX);
        member.waking += 1;
        if let Some(radio) = self.radios.get_mut(place) {
            radio.clear();
        }
        if let Participant::Robot(robot) = participant {
            self.world.set_route(robot, Vec::new());
            self.let_held_go(now);
        }
    }

    /// A robot enters the next cell of its route, and leaves the way to others.
    fn arrive(&mut self, now: MissionTime, robot: RobotId) {
        self.world.advance(robot);
        self.let_held_go(now);
    }

    /// A participant restarts; a robot observes from its cell.
    fn bring_back(&mut self, now: MissionTime, participant: Participant) -> Result<(), C::Error> {
        self.returns -= 1;
        let place = self.place(participant);
        self.change(place, |member| member.is_up = true);
        self.tell(now, participant, Event::Start)?;
        match participant {
            Participant::Robot(robot) => self.observe(now, robot),
            Participant::Coordinator => Ok(()),
        }
    }

    /// All robots that arrive at this time, up to another event, observe and decide: none of them can hear of another, and
    /// none can end the search before the last has decided, since all others drive.
    fn arrive_together(
        &mut self,
        now: MissionTime,
        robot: RobotId,
        route_number: u64,
    ) -> Result<(), C::Error> {
        let mut arrivals = vec![(robot, route_number)];
        while let Some(SimEvent::Arrival { robot, route_number }) =
            self.queue.next_if(now, |event| matches!(event, SimEvent::Arrival { .. }))
        {
            arrivals.push((robot, route_number));
        }
        arrivals.retain(|&(robot, route_number)| self.world.body(robot).route_number == route_number);
        let (mut views, mut steps) = (Vec::new(), Vec::new());
        for (robot, _) in arrivals {
            self.arrive(now, robot);
            let (view, event) = self.look(robot);
            let participant = Participant::Robot(robot);
            steps.push((participant, now + self.faults.ahead(participant), event));
            views.push(view);
        }
        let effects = self.participants.step_together(steps)?;
        for (view, effects) in views.into_iter().zip(effects) {
            self.measure(now, &view);
            self.react(now, Participant::Robot(view.robot), effects);
            self.go_on(now, &view);
        }
        Ok(())
    }

    /// A robot observes, decides, and goes on.
    fn observe(&mut self, now: MissionTime, robot: RobotId) -> Result<(), C::Error> {
        let (view, event) = self.look(robot);
        self.measure(now, &view);
        self.tell(now, Participant::Robot(robot), event)?;
        self.go_on(now, &view);
        Ok(())
    }

    /// A robot takes its readings; with them all are compared with the truth.
    fn look(&mut self, robot: RobotId) -> (View, Event<C::MessageRef>) {
        let (readings, found) = self.world.sense(robot);
        let &Body { cell, route_number, .. } = self.world.body(robot);
        let (farthest_cells, score) = (self.world.farthest_cells(), self.world.score());
        (View { robot, cell, route_number, found, farthest_cells, score }, Event::Sensed { cell, readings })
    }

    fn measure(&mut self, now: MissionTime, view: &View) {
        let &View { robot, cell, farthest_cells, score, .. } = view;
        (self.spectator)(now, StepContext::Arrives { robot, cell, farthest_cells });
        for &cell in &view.found {
            let probability = self.world.probability(cell);
            (self.spectator)(now, StepContext::Finds { robot, cell, probability });
        }
        self.outcome.measure(now, farthest_cells, score, &view.found);
    }

    /// Unless it has decided on a new route, a robot drives on along its route.
    fn go_on(&mut self, now: MissionTime, view: &View) {
        if self.world.body(view.robot).route_number == view.route_number {
            self.depart(now, view.robot);
        }
    }

    /// Schedules a robot's arrival in the next cell of its route.
    fn depart(&mut self, now: MissionTime, robot: RobotId) {
        if let Some(time) = self.world.set_off(robot) {
            self.travel(now, robot, time);
        }
    }

    fn travel(&mut self, now: MissionTime, robot: RobotId, time: Duration) {
        let route_number = self.world.body(robot).route_number;
        let time = time.mul_f64(self.faults.slowness(robot));
        self.queue.plan(now + time, SimEvent::Arrival { robot, route_number });
    }

    /// Robots that others kept from moving set off where their way is clear.
    fn let_held_go(&mut self, now: MissionTime) {
        for (robot, time) in self.world.set_off_held() {
            self.travel(now, robot, time);
        }
    }

    fn tell(
        &mut self,
        now: MissionTime,
        participant: Participant,
        event: Event<C::MessageRef>,
    ) -> Result<(), C::Error> {
        let effects = self.participants.step(participant, now + self.faults.ahead(participant), event)?;
        self.react(now, participant, effects);
        Ok(())
    }

    fn react(&mut self, now: MissionTime, participant: Participant, effects: Effects<C::MessageRef>) {
        self.attend(now, participant, effects.wake_at, effects.activity);
        self.outcome.decisions.extend(effects.decision);
        for (audience, message) in effects.published {
            self.publish(now, participant, audience, message);
        }
        if let (Participant::Robot(robot), Some(route)) = (participant, effects.route) {
            (self.spectator)(
                now,
                StepContext::Departs { robot, route: route.clone(), activity: Some(effects.activity) },
            );
            self.world.set_route(robot, route);
            self.let_held_go(now);
            self.depart(now, robot);
        }
    }

    /// Takes note of a participant's activity, and of when it is to be woken.
    fn attend(
        &mut self,
        now: MissionTime,
        participant: Participant,
        wake_at: MissionTime,
        activity: Activity,
    ) {
        let ahead = self.faults.ahead(participant);
        let is_ahead = !ahead.is_zero() && wake_at < MissionTime(u64::MAX);
        let wake_at = if is_ahead { now + wake_at.since(now + ahead) } else { wake_at };
        let place = self.place(participant);
        self.change(place, |member| member.activity = activity);
        let member = &mut self.members[place];
        // A restarted participant may ask for a past time: it is woken now.
        let wake_at = wake_at.max(now);
        if member.wake_at != wake_at {
            member.wake_at = wake_at;
            member.waking += 1;
            if wake_at < MissionTime(u64::MAX) {
                self.queue.plan(wake_at, SimEvent::Waking { participant, number: member.waking });
            }
        }
    }

    /// Changes a member, and the number of those that search.
    fn change(&mut self, place: usize, change: impl FnOnce(&mut Member)) {
        let member = &mut self.members[place];
        self.searching -= usize::from(!member.is_resting());
        change(member);
        self.searching += usize::from(!member.is_resting());
    }

    /// Robots are ordered by number, followed by the coordinator.
    fn place(&self, participant: Participant) -> usize {
        match participant {
            Participant::Robot(robot) => robot.index(),
            Participant::Coordinator => self.members.len() - 1,
        }
    }
}

impl Member {
    fn is_resting(&self) -> bool {
        !self.is_up || self.participant == Participant::Coordinator || self.activity.is_rest()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn readings_that_are_dated_out_of_order_are_measured() {
        let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 2, columns = 2, cell_meters = 1.0 }\n\
                    sensor.radius = 1\nobjects.count = 1\nmission.budget_seconds = 60.0\n";
        let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
        let world = World::new(&scenario, 1);
        let mut outcome = Outcome::new(&world);
        let found = Score { true_positives: 1, ..Score::default() };
        for (seconds, score) in [(5, world.score()), (3, found), (8, found)] {
            outcome.measure(MissionTime::START + Duration::from_secs(seconds), 1.0, score, &[]);
        }
        let recall = [4.0, 5.0, 9.0].map(|seconds| outcome.recall_over_time.at(seconds) > 0.5);
        assert_eq!((recall, outcome.observations), ([false, true, true], 3));
    }
}
