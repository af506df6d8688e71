//! An environment with a team: the caller decides for every robot, move by move.
//!
//! Everything else is simulated as in an episode: agents exchange observations and repair lost ones over the scenario's
//! network with its faults, robots crash, and each robot has its own belief.

use std::collections::BTreeMap;
use std::sync::Arc;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::measures::{Score, Truth};
use dragnet_search::observation::RobotId;
use dragnet_search::policy::{Decision, Policy};
use dragnet_search::seed::Stream;
use dragnet_search::situation::Situation;

use crate::faults::{Crash, Faults};
use crate::participants::{LocalParticipants, Participants};
use crate::simulation::{End, Membership, Rules, Simulation, StepContext};
use crate::single_robot_env::{Field, Reward};

/// One move of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Move {
    /// Go to a cell that can be reached in one move.
    To(Cell),
    /// Wait without an observation; this costs as much of each budget as entering one cell.
    Wait,
}

/// The state of a robot, and why its search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TerminationReason {
    /// It is searching.
    Searching,
    /// All robots together have found every object.
    Found,
    /// Its budget of path length or time is spent.
    Spent,
    /// It has crashed.
    Crashed,
}

/// A team's search in progress.
pub struct TeamEnv {
    field: Arc<Field>,
    reward: Reward,
    simulation: Simulation<IdleRobots, fn(MissionTime, StepContext)>,
    now: MissionTime,
    /// Path length that each robot has waited for, cells.
    waited_cells: Vec<f64>,
    termination_reasons: Vec<TerminationReason>,
    /// The rewards of the moves so far, from an arbitrary start.
    worth: f64,
}

impl TeamEnv {
    /// The search of a seed, after the first observations. Robots of `crashes` stop permanently at those times.
    ///
    /// # Errors
    /// Never, since robots of this process cannot fail.
    pub fn new(
        field: Arc<Field>,
        reward: Reward,
        crashes: &BTreeMap<RobotId, MissionTime>,
        seed: u64,
    ) -> Result<Self, ParticipantError> {
        let scenario = field.scenario();
        let config = AgentConfig::of_team(scenario, seed).into_iter();
        let puppets =
            IdleRobots { robots: config.map(|it| Agent::with_policy(it, Box::new(Still))).collect() };
        let rules = Rules { end: End::AllFound, coordinator: Membership::Absent };
        let crash = |(&robot, &at)| (Participant::Robot(robot), Crash { at, back: None });
        let faults = Faults { crashes: crashes.iter().map(crash).collect(), ..Faults::default() };
        let nobody: fn(MissionTime, StepContext) = |_, _| ();
        let mut simulation = Simulation::new(scenario, seed, rules, puppets, nobody).with_faults(faults);
        simulation.begin()?;
        let now = simulation.run_on(MissionTime::START)?;
        let robots = scenario.robots().len();
        let mut env = Self {
            reward,
            simulation,
            now,
            waited_cells: vec![0.0; robots],
            termination_reasons: vec![TerminationReason::Searching; robots],
            worth: 0.0,
            field,
        };
        env.judge();
        env.worth = env.measure();
        Ok(env)
    }

    /// Every robot that searches makes its move, by number; those of others are ignored. It lasts until the last of
    /// them has arrived, and at least as long as one cell takes. Returns the team's reward.
    ///
    /// # Errors
    /// Never, since robots of this process cannot fail.
    pub fn step(&mut self, moves: &[Move]) -> Result<f64, ParticipantError> {
        debug_assert_eq!(moves.len(), self.termination_reasons.len());
        let speed = self.field.scenario().mission().speed_meters_per_second;
        for (place, &wanted) in moves.iter().enumerate() {
            match wanted {
                _ if self.termination_reasons[place] != TerminationReason::Searching => {}
                Move::To(cell) => self.simulation.send_off(self.now, self.robot(place), cell),
                Move::Wait => self.waited_cells[place] += 1.0,
            }
        }
        let until = self.now + self.simulation.world().time_over(1.0, speed);
        self.now = self.simulation.run_on(until)?;
        self.judge();
        let worth = self.measure();
        Ok(worth - std::mem::replace(&mut self.worth, worth))
    }

    fn judge(&mut self) {
        let is_all_found = self.score().false_negatives == 0;
        let mission = self.field.scenario().mission();
        let elapsed = self.now.since(MissionTime::START);
        for place in 0..self.termination_reasons.len() {
            if self.termination_reasons[place] != TerminationReason::Searching {
                continue;
            }
            let spent_meters = self.spent_meters(place);
            self.termination_reasons[place] = if !self.simulation.is_up(self.robot(place)) {
                TerminationReason::Crashed
            } else if is_all_found {
                TerminationReason::Found
            } else if mission.budget.is_spent(spent_meters, elapsed) {
                TerminationReason::Spent
            } else {
                TerminationReason::Searching
            };
        }
    }

    fn measure(&self) -> f64 {
        let score = self.score();
        match self.reward {
            Reward::Entropy => {
                -self.simulation.world().merged().entropy_nats(self.field.scenario().terrain())
            }
            Reward::Found => f64::from(score.true_positives),
            Reward::F1 => score.f1(),
        }
    }

    fn robot(&self, place: usize) -> RobotId {
        self.field.scenario().robots()[place].id
    }

    /// The data that all searches of the scenario share.
    #[must_use]
    pub const fn field(&self) -> &Arc<Field> {
        &self.field
    }

    /// The state of each robot, by number.
    #[must_use]
    pub fn termination_reasons(&self) -> &[TerminationReason] {
        &self.termination_reasons
    }

    /// The cell of a robot, by its index in the team.
    #[must_use]
    pub fn cell(&self, place: usize) -> Cell {
        self.simulation.world().body(self.robot(place)).cell
    }

    /// Path length of a robot, cells.
    #[must_use]
    pub fn path_cells(&self, place: usize) -> f64 {
        self.simulation.world().body(self.robot(place)).path_cells
    }

    /// Path length and waiting of a robot, meters: what the budget counts.
    fn spent_meters(&self, place: usize) -> f64 {
        (self.path_cells(place) + self.waited_cells[place]) * self.field.scenario().terrain().cell_meters()
    }

    /// Path length that the budget leaves to a robot, meters.
    #[must_use]
    pub fn remaining_meters(&self, place: usize) -> f64 {
        let elapsed = self.now.since(MissionTime::START);
        self.field.scenario().mission().remaining_meters(self.spent_meters(place), elapsed)
    }

    /// The belief of a robot: from its own readings, and those received so far.
    #[must_use]
    pub fn belief(&self, place: usize) -> &Belief {
        self.simulation.participants().robots[place].belief()
    }

    /// The last cell that a robot, by its index in the team, has received from another, if any; for itself, its own
    /// cell.
    #[must_use]
    pub fn received(&self, place: usize, other: usize) -> Option<Cell> {
        if place == other {
            return Some(self.cell(place));
        }
        let log = self.simulation.participants().robots[place].replica().log();
        log.latest(self.robot(other)).map(|observation| observation.from)
    }

    /// The belief from all readings of the team together.
    #[must_use]
    pub fn merged(&self) -> &Belief {
        self.simulation.world().merged()
    }

    /// The merged belief compared with the truth.
    #[must_use]
    pub fn score(&self) -> Score {
        self.simulation.world().score()
    }

    /// The objects.
    #[must_use]
    pub fn truth(&self) -> &Truth {
        self.simulation.world().truth()
    }

    /// Mission time.
    #[must_use]
    pub const fn now(&self) -> MissionTime {
        self.now
    }
}

/// Robots that do not move by themselves.
struct IdleRobots {
    robots: Vec<Agent>,
}

impl Participants for IdleRobots {
    type MessageRef = Message;
    type Error = ParticipantError;

    fn step(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let effects = LocalParticipants::new(&mut self.robots, None).step(participant, now, event)?;
        Ok(Effects { route: None, ..effects })
    }

    fn digest(&mut self, participant: Participant, now: MissionTime) -> Result<Digest, ParticipantError> {
        LocalParticipants::new(&mut self.robots, None).digest(participant, now)
    }
}

/// A policy that does not move.
struct Still;

impl Policy for Still {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        Decision { chosen: situation.robot, path: Vec::new(), scores: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::time::Duration;

    use dragnet_scenario::Scenario;

    use super::*;
    use crate::single_robot_env::{SingleRobotEnv, Terms};

    fn field(robots: u32, rest: &str) -> Arc<Field> {
        let text = format!(
            "name = 'a'\nmap = {{ shape = 'all_traversable', rows = 24, columns = 24, cell_meters = 20.0 }}\n\
             sensor.radius = 2\nobjects.count = 9\nrobots = {{ count = {robots}, start = 'scattered' }}\n{rest}"
        );
        Arc::new(Field::new(Scenario::from_text(Path::new("a.toml"), text).unwrap()))
    }

    /// The first available step of each robot, counting from a different one each time.
    fn moves(env: &TeamEnv, turn: usize) -> Vec<Move> {
        let step = |place| {
            let open = |step| env.field().neighbor(env.cell(place), (step + turn / 3) % 4);
            Move::To((0..4).find_map(open).unwrap())
        };
        (0..env.termination_reasons().len()).map(step).collect()
    }

    fn run(field: &Arc<Field>, crashes: &BTreeMap<RobotId, MissionTime>) -> (TeamEnv, u32) {
        let mut env = TeamEnv::new(Arc::clone(field), Reward::Entropy, crashes, 3).unwrap();
        let (mut turn, mut differing) = (0, 0);
        while env.termination_reasons().contains(&TerminationReason::Searching) {
            env.step(&moves(&env, turn)).unwrap();
            turn += 1;
            differing += u32::from(env.belief(0).digest() != env.belief(1).digest());
        }
        (env, differing)
    }

    const BUDGET: &str = "mission.budget_meters = 900.0\n";

    #[test]
    fn without_faults_all_beliefs_are_equal_after_each_move() {
        let (env, differing) = run(&field(3, BUDGET), &BTreeMap::new());
        assert_eq!(differing, 0);
        assert_eq!(env.belief(2).digest(), env.merged().digest());
        assert_eq!(env.received(0, 1), Some(env.cell(1)));
    }

    #[test]
    fn lost_and_late_observations_count_later() {
        let network = format!("{BUDGET}network = {{ loss = 0.5, delay_seconds = 15.0 }}\n");
        let (_, differing) = run(&field(3, &network), &BTreeMap::new());
        assert!(differing > 10, "{differing}");
    }

    #[test]
    fn a_crashed_robot_is_out_and_the_others_go_on() {
        let at = MissionTime::START + Duration::from_secs(95);
        let (env, _) = run(&field(3, BUDGET), &BTreeMap::from([(RobotId::new(2).unwrap(), at)]));
        assert_eq!(env.termination_reasons()[1], TerminationReason::Crashed);
        // Ten seconds per cell: it had entered nine.
        assert!((env.path_cells(1) - 9.0).abs() < 1e-9);
        assert!(env.path_cells(0) > 10.0);
    }

    #[test]
    fn a_team_of_one_sees_what_one_robot_sees() {
        let field = field(1, BUDGET);
        let terms = Terms { end: End::AllFound, reward: Reward::Entropy };
        let mut single = SingleRobotEnv::new(Arc::clone(&field), terms, 8);
        let mut env = TeamEnv::new(Arc::clone(&field), Reward::Entropy, &BTreeMap::new(), 8).unwrap();
        let mut turn = 0;
        while single.ended().is_none() {
            let moves = moves(&env, turn);
            let Move::To(cell) = moves[0] else { unreachable!() };
            let (one, team) = (single.step(cell), env.step(&moves).unwrap());
            assert!((one - team).abs() < 1e-9);
            assert_eq!(single.belief().digest(), env.belief(0).digest());
            assert_eq!(single.now(), env.now());
            turn += 1;
        }
        assert_ne!(env.termination_reasons()[0], TerminationReason::Searching);
        assert!(turn > 10);
    }
}
