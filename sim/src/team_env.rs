//! A team's search, a move of every robot at a time: whoever calls decides for each of them.
//!
//! Everything else is the simulation itself: agents that tell each other what they see and repair what was lost, the
//! scenario's network with its faults, crashes, and a belief of each robot's own.

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

/// What a robot does in one move of the team.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Move {
    /// It goes to a cell that can be reached in one move.
    To(Cell),
    /// It stays where it is, without a look; that costs as much of each budget as one cell.
    Wait,
}

/// How a robot stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TerminationReason {
    /// It searches.
    Searching,
    /// All robots together have found every object.
    Found,
    /// Its way or its time is spent.
    Spent,
    /// It has crashed.
    Crashed,
}

/// A team's search under way.
pub struct TeamEnv {
    field: Arc<Field>,
    reward: Reward,
    simulation: Simulation<Puppets, fn(MissionTime, StepContext)>,
    now: MissionTime,
    /// Way waited for by each robot, cells.
    waited_cells: Vec<f64>,
    fates: Vec<TerminationReason>,
    /// What the moves were worth so far, from an arbitrary start.
    worth: f64,
}

impl TeamEnv {
    /// The search of a seed, after the first looks. Robots of `crashes` stop for good at those times.
    ///
    /// # Errors
    /// Never, as long as robots of this process cannot fail.
    pub fn new(
        field: Arc<Field>,
        reward: Reward,
        crashes: &BTreeMap<RobotId, MissionTime>,
        seed: u64,
    ) -> Result<Self, ParticipantError> {
        let scenario = field.scenario();
        let orders = AgentConfig::of_team(scenario, seed).into_iter();
        let puppets = Puppets { robots: orders.map(|it| Agent::with_policy(it, Box::new(Still))).collect() };
        let rules = Rules { end: End::AllFound, coordinator: Membership::Absent };
        let crash = |(&robot, &at)| (Participant::Robot(robot), Crash { at, back: None });
        let faults = Faults { crashes: crashes.iter().map(crash).collect(), ..Faults::default() };
        let nobody: fn(MissionTime, StepContext) = |_, _| ();
        let mut simulation = Simulation::new(scenario, seed, rules, puppets, nobody).with_faults(faults);
        simulation.begin()?;
        let now = simulation.run_on(MissionTime::START)?;
        let robots = scenario.robots().len();
        let mut expedition = Self {
            reward,
            simulation,
            now,
            waited_cells: vec![0.0; robots],
            fates: vec![TerminationReason::Searching; robots],
            worth: 0.0,
            field,
        };
        expedition.judge();
        expedition.worth = expedition.measure();
        Ok(expedition)
    }

    /// Every robot that searches makes its move, by number; those of others do not matter. It lasts until the last of them
    /// has arrived, and at least as long as one cell takes. Returns what the team gained.
    ///
    /// # Errors
    /// Never, as long as robots of this process cannot fail.
    pub fn step(&mut self, moves: &[Move]) -> Result<f64, ParticipantError> {
        debug_assert_eq!(moves.len(), self.fates.len());
        let speed = self.field.scenario().mission().speed_meters_per_second;
        for (place, &wanted) in moves.iter().enumerate() {
            match wanted {
                _ if self.fates[place] != TerminationReason::Searching => {}
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
        let (mission, cell_meters) =
            (self.field.scenario().mission(), self.field.scenario().terrain().cell_meters());
        let elapsed = self.now.since(MissionTime::START);
        for place in 0..self.fates.len() {
            if self.fates[place] != TerminationReason::Searching {
                continue;
            }
            let spent_meters = (self.path_cells(place) + self.waited_cells[place]) * cell_meters;
            self.fates[place] = if !self.simulation.is_up(self.robot(place)) {
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

    /// What all searches of the scenario share.
    #[must_use]
    pub const fn field(&self) -> &Arc<Field> {
        &self.field
    }

    /// How each robot stands, by number.
    #[must_use]
    pub fn fates(&self) -> &[TerminationReason] {
        &self.fates
    }

    /// Where a robot stands, by its place in the team.
    #[must_use]
    pub fn cell(&self, place: usize) -> Cell {
        self.simulation.world().body(self.robot(place)).cell
    }

    /// Way covered by a robot, cells.
    #[must_use]
    pub fn path_cells(&self, place: usize) -> f64 {
        self.simulation.world().body(self.robot(place)).path_cells
    }

    /// What a robot believes: what it saw, and what it has heard so far.
    #[must_use]
    pub fn belief(&self, place: usize) -> &Belief {
        self.simulation.participants().robots[place].belief()
    }

    /// Where a robot, by its place in the team, has last heard another to be, if it has; of itself, where it stands.
    #[must_use]
    pub fn heard(&self, place: usize, other: usize) -> Option<Cell> {
        if place == other {
            return Some(self.cell(place));
        }
        let log = self.simulation.participants().robots[place].replica().log();
        let version =
            log.versions().filter(|version| version.origin.source == self.robot(other).into()).last()?;
        log.ends(version.origin).map(|known| known.last.from)
    }

    /// What all readings of the team together support.
    #[must_use]
    pub fn merged(&self) -> &Belief {
        self.simulation.world().merged()
    }

    /// How that compares with the truth.
    #[must_use]
    pub fn score(&self) -> Score {
        self.simulation.world().score()
    }

    /// Where the objects are.
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

/// Robots that go nowhere by themselves.
struct Puppets {
    robots: Vec<Agent>,
}

impl Participants for Puppets {
    type MessageRef = Message;
    type Error = ParticipantError;

    fn step(
        &mut self,
        who: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let effects = LocalParticipants::new(&mut self.robots, None).step(who, now, event)?;
        Ok(Effects { route: None, ..effects })
    }

    fn digest(&mut self, who: Participant, now: MissionTime) -> Result<Digest, ParticipantError> {
        LocalParticipants::new(&mut self.robots, None).digest(who, now)
    }
}

/// Goes nowhere.
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

    /// The first open step of each robot, from another one on each time.
    fn moves(expedition: &TeamEnv, turn: usize) -> Vec<Move> {
        let step = |place| {
            let open = |step| expedition.field().neighbor(expedition.cell(place), (step + turn / 3) % 4);
            Move::To((0..4).find_map(open).unwrap())
        };
        (0..expedition.fates().len()).map(step).collect()
    }

    fn run(field: &Arc<Field>, crashes: &BTreeMap<RobotId, MissionTime>) -> (TeamEnv, u32) {
        let mut expedition = TeamEnv::new(Arc::clone(field), Reward::Entropy, crashes, 3).unwrap();
        let (mut turn, mut differing) = (0, 0);
        while expedition.fates().contains(&TerminationReason::Searching) {
            expedition.step(&moves(&expedition, turn)).unwrap();
            turn += 1;
            differing += u32::from(expedition.belief(0).digest() != expedition.belief(1).digest());
        }
        (expedition, differing)
    }

    const BUDGET: &str = "mission.budget_meters = 900.0\n";

    #[test]
    fn without_faults_all_robots_believe_the_same_after_each_move() {
        let (expedition, differing) = run(&field(3, BUDGET), &BTreeMap::new());
        assert_eq!(differing, 0);
        assert_eq!(expedition.belief(2).digest(), expedition.merged().digest());
        assert_eq!(expedition.heard(0, 1), Some(expedition.cell(1)));
    }

    #[test]
    fn what_is_lost_or_late_is_believed_later() {
        let network = format!("{BUDGET}network = {{ loss = 0.5, delay_seconds = 15.0 }}\n");
        let (_, differing) = run(&field(3, &network), &BTreeMap::new());
        assert!(differing > 10, "{differing}");
    }

    #[test]
    fn who_crashes_is_out_and_the_others_go_on() {
        let at = MissionTime::START + Duration::from_secs(95);
        let (expedition, _) = run(&field(3, BUDGET), &BTreeMap::from([(RobotId::new(2).unwrap(), at)]));
        assert_eq!(expedition.fates()[1], TerminationReason::Crashed);
        // Ten seconds a cell: it had entered nine.
        assert!((expedition.path_cells(1) - 9.0).abs() < 1e-9);
        assert!(expedition.path_cells(0) > 10.0);
    }

    #[test]
    fn a_team_of_one_sees_what_one_robot_sees() {
        let field = field(1, BUDGET);
        let terms = Terms { end: End::AllFound, reward: Reward::Entropy };
        let mut solo = SingleRobotEnv::new(Arc::clone(&field), terms, 8);
        let mut expedition = TeamEnv::new(Arc::clone(&field), Reward::Entropy, &BTreeMap::new(), 8).unwrap();
        let mut turn = 0;
        while solo.ended().is_none() {
            let moves = moves(&expedition, turn);
            let Move::To(cell) = moves[0] else { unreachable!() };
            let (one, team) = (solo.step(cell), expedition.step(&moves).unwrap());
            assert!((one - team).abs() < 1e-9);
            assert_eq!(solo.belief().digest(), expedition.belief(0).digest());
            assert_eq!(solo.now(), expedition.now());
            turn += 1;
        }
        assert_ne!(expedition.fates()[0], TerminationReason::Searching);
        assert!(turn > 10);
    }
}
