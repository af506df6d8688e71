//! An environment with a team: the caller decides for every robot, move by move.
//!
//! Everything else is simulated as in an episode: agents exchange observations and repair lost ones over the scenario's
//! network with its faults, robots crash, and each robot has its own belief.

mod idle;

use std::collections::BTreeMap;
use std::sync::Arc;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::state_machine::ParticipantError;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::measures::{Score, Truth};
use dragnet_search::observation::RobotId;

use crate::faults::{Crash, Faults};
use crate::simulation::{End, Membership, Rules, Simulation, StepContext};
use crate::single_robot_env::changes::{ChangedCells, Entropies};
use crate::single_robot_env::features::{Layout, View};
use crate::single_robot_env::{Field, Reward};
use idle::{IdleRobots, Still};

/// One move of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Move {
    /// Go to a cell that can be reached in one move. Where robots keep apart and another one is in the way, it is a
    /// [`Move::Wait`].
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
    /// Every cell that each robot was in, its start cell first.
    tracks: Vec<Vec<Cell>>,
    /// `None` unless it is the reward.
    entropies: Option<Entropies>,
    /// What the reward measures, but for the entropy.
    worth: f64,
    /// Cells of the merged belief that have changed since [`TeamEnv::draw_known`] or [`TeamEnv::redraw_known`].
    observed: ChangedCells,
    /// The cell of each robot when it was drawn last.
    drawn: Vec<Cell>,
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
        let (robots, grid) = (scenario.robots().len(), scenario.terrain().grid());
        let config = AgentConfig::of_team(scenario, seed).into_iter();
        let robot = |config| Agent::with_policy(config, Box::new(Still)).without_digests();
        let puppets = IdleRobots {
            robots: config.map(robot).collect(),
            learned: vec![ChangedCells::new(grid); robots],
            sensed: Vec::new(),
        };
        let rules = Rules { end: End::AllFound, coordinator: Membership::Absent };
        let crash = |(&robot, &at)| (Participant::Robot(robot), Crash { at, back: None });
        let faults = Faults { crashes: crashes.iter().map(crash).collect(), ..Faults::default() };
        let nobody: fn(MissionTime, StepContext) = |_, _| ();
        let mut simulation =
            Simulation::new(scenario, seed, rules, puppets, nobody).with_faults(faults).without_traffic();
        simulation.begin()?;
        let now = simulation.run_on(MissionTime::START)?;
        simulation.participants_mut().sensed.clear();
        let world = simulation.world();
        let entropies = (reward == Reward::Entropy).then(|| Entropies::of(grid, world.merged()));
        let starts: Vec<Cell> = scenario.robots().iter().map(|robot| world.body(robot.id).cell).collect();
        let mut env = Self {
            reward,
            now,
            waited_cells: vec![0.0; robots],
            termination_reasons: vec![TerminationReason::Searching; robots],
            tracks: starts.iter().map(|&start| vec![start]).collect(),
            entropies,
            worth: 0.0,
            observed: ChangedCells::new(grid),
            drawn: starts,
            simulation,
            field,
        };
        env.judge();
        env.worth = env.measure();
        Ok(env)
    }

    /// Every robot that searches makes its move, by number; those of others are ignored. It lasts until the last of
    /// them has arrived, and at least as long as one cell takes the slowest of the team. Returns the team's reward.
    ///
    /// # Errors
    /// Never, since robots of this process cannot fail.
    pub fn step(&mut self, moves: &[Move]) -> Result<f64, ParticipantError> {
        debug_assert_eq!(moves.len(), self.termination_reasons.len());
        for (place, &wanted) in moves.iter().enumerate() {
            match wanted {
                _ if self.termination_reasons[place] != TerminationReason::Searching => {}
                Move::To(cell) if self.simulation.send_off(self.now, self.robot(place), cell) => {}
                Move::To(_) | Move::Wait => self.waited_cells[place] += 1.0,
            }
        }
        let world = self.simulation.world();
        let slowest = (0..moves.len()).map(|place| world.time_over(self.robot(place), 1.0)).max();
        let until = self.now + slowest.unwrap_or_default();
        self.now = self.simulation.run_on(until)?;
        for place in 0..self.tracks.len() {
            let cell = self.cell(place);
            if self.tracks[place].last() != Some(&cell) {
                self.tracks[place].push(cell);
            }
        }
        self.judge();
        Ok(self.gain())
    }

    /// The reward of the last move.
    fn gain(&mut self) -> f64 {
        let sensed = std::mem::take(&mut self.simulation.participants_mut().sensed);
        let removed = self.entropies.as_mut().map_or(0.0, |entropies| {
            entropies.removed(self.simulation.world().merged(), sensed.iter().copied())
        });
        self.observed.extend(sensed);
        let worth = self.measure();
        removed + (worth - std::mem::replace(&mut self.worth, worth))
    }

    fn judge(&mut self) {
        let is_all_found = self.score().false_negatives == 0;
        let elapsed = self.now.since(MissionTime::START);
        for place in 0..self.termination_reasons.len() {
            if self.termination_reasons[place] != TerminationReason::Searching {
                continue;
            }
            let spent_meters = self.spent_meters(place);
            let budget = self.field.scenario().robots()[place].class.budget;
            self.termination_reasons[place] = if !self.simulation.is_up(self.robot(place)) {
                TerminationReason::Crashed
            } else if is_all_found {
                TerminationReason::Found
            } else if budget.is_spent(spent_meters, elapsed) {
                TerminationReason::Spent
            } else {
                TerminationReason::Searching
            };
        }
    }

    fn measure(&self) -> f64 {
        let score = self.score();
        match self.reward {
            Reward::Entropy => 0.0,
            Reward::Found => f64::from(score.true_positives),
            Reward::F1 => score.f1(),
        }
    }

    fn robot(&self, place: usize) -> RobotId {
        self.field.scenario().robots()[place].id
    }

    /// Writes all features of what a robot knows, in the map's frame, shape as in [`Layout::drawn_len`].
    pub fn draw(&mut self, place: usize, layout: &Layout, numbers: &mut [f32]) {
        layout.draw(&self.field, &self.view(place, &self.teammates(place)), numbers);
        self.settle(place);
    }

    /// Writes what changed since the last call for this robot.
    pub fn redraw(&mut self, place: usize, layout: &Layout, numbers: &mut [f32]) {
        let cells = self.simulation.participants().learned[place].cells();
        let teammates = self.teammates(place);
        layout.redraw(&self.field, &self.view(place, &teammates), self.drawn[place], cells, numbers);
        self.settle(place);
    }

    fn settle(&mut self, place: usize) {
        self.drawn[place] = self.cell(place);
        self.simulation.participants_mut().learned[place].clear();
    }

    /// Writes all features of what the whole team knows, by a layout [of a team](Layout::of_team).
    pub fn draw_known(&mut self, layout: &Layout, numbers: &mut [f32]) {
        let view = View { belief: self.merged(), ..self.view(0, &[]) };
        layout.draw(&self.field, &view, numbers);
        self.observed.clear();
    }

    /// Writes what of it changed since the last call.
    pub fn redraw_known(&mut self, layout: &Layout, numbers: &mut [f32]) {
        let view = View { belief: self.merged(), ..self.view(0, &[]) };
        layout.redraw(&self.field, &view, view.robot, self.observed.cells(), numbers);
        self.observed.clear();
    }

    /// What a robot knows, but for its [teammates](TeamEnv::teammates).
    #[must_use]
    pub fn view<'a>(&'a self, place: usize, teammates: &'a [Cell]) -> View<'a> {
        View {
            belief: self.belief(place),
            robot: self.cell(place),
            budget: self.field.budget(self.remaining_meters(place)),
            teammates,
        }
    }

    /// The cells in which a robot last heard its teammates to be.
    #[must_use]
    pub fn teammates(&self, place: usize) -> Vec<Cell> {
        let others = (0..self.tracks.len()).filter(|&other| other != place);
        others.filter_map(|other| self.received(place, other)).collect()
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

    /// Every cell that a robot was in after a move, in order from its start.
    #[must_use]
    pub fn track(&self, place: usize) -> &[Cell] {
        &self.tracks[place]
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

#[cfg(test)]
mod tests;
