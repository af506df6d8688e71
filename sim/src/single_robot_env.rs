//! An environment with one robot, for which the caller decides move by move.
//!
//! World, seeds, motion, belief and stopping conditions are those of an [`crate::episode`] of one robot, but there are
//! no messages and no queue of events: it makes hundreds of thousands of moves per second. [`field`] holds the data
//! that all searches of a scenario share, [`features`] what a learner observes.

pub(crate) mod changes;
pub mod features;
pub mod field;

use std::sync::Arc;
use std::time::Duration;

use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;
use dragnet_search::measures::{Score, Truth};
use dragnet_search::observation::RobotId;

use crate::simulation::End;
use crate::world::World;
use changes::{ChangedCells, Entropies};
use features::{Layout, View};
pub use field::{Control, Field};

const ROBOT: RobotId = RobotId::FIRST;

/// The reward of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reward {
    /// Entropy of the belief that it removed, nats.
    Entropy,
    /// Change in the number of found objects; negative if finds were withdrawn.
    Found,
    /// Change of F1.
    F1,
}

/// The reward and the end of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// When it ends before the budget does.
    pub end: End,
    /// The reward of an action.
    pub reward: Reward,
}

/// Why a search is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Every object is found.
    Found,
    /// The expected number of remaining objects is low enough for the scenario.
    Cleared,
    /// The budget of path length or time is spent.
    Spent,
}

/// A search of one robot in progress. A copy of it has the same future: the same actions see the same readings.
#[derive(Clone)]
pub struct SingleRobotEnv {
    field: Arc<Field>,
    terms: Terms,
    world: World,
    now: MissionTime,
    /// Path length and waiting, meters: what the budget counts.
    spent_meters: f64,
    /// Whether, of a heartbeat and an arrival at this time, the arrival came first.
    is_before_heartbeat: bool,
    /// Every cell that the robot was in, the start cell first.
    track: Vec<Cell>,
    ended: Option<Ended>,
    /// `None` unless it is the reward.
    entropies: Option<Entropies>,
    /// The reward of the action so far.
    worth: f64,
    /// Cells observed since the last drawing.
    seen: ChangedCells,
    /// The robot's cell at that drawing.
    drawn: Cell,
    readings: Vec<Reading>,
    found: Vec<Cell>,
}

impl SingleRobotEnv {
    /// The search of a seed, after the first observation.
    #[must_use]
    pub fn new(field: Arc<Field>, terms: Terms, seed: u64) -> Self {
        let world = World::new(field.scenario(), seed);
        let grid = field.scenario().terrain().grid();
        let entropies = (terms.reward == Reward::Entropy).then(|| Entropies::of(grid, world.merged()));
        let mut env = Self {
            terms,
            now: MissionTime::START,
            spent_meters: 0.0,
            is_before_heartbeat: false,
            track: vec![world.body(ROBOT).cell],
            ended: None,
            entropies,
            worth: 0.0,
            seen: ChangedCells::new(grid),
            drawn: world.body(ROBOT).cell,
            readings: Vec::new(),
            found: Vec::new(),
            world,
            field,
        };
        env.observe();
        env
    }

    /// Moves to a cell that can be reached in one move, and returns the reward. If the search is over, the robot does
    /// not move and the reward is 0.
    pub fn step(&mut self, to: Cell) -> f64 {
        self.act(|env| env.advance(to))
    }

    /// Moves along the shortest path to a cell, at most as far as the scenario allows between two decisions, and
    /// returns the reward. If the search is over or there is no path, the robot does not move and the reward is 0.
    pub fn go(&mut self, to: Cell) -> f64 {
        self.act(|env| {
            let scenario = env.field.scenario();
            let path = env.field.path(env.cell(), to);
            let replan_after_cells = scenario.robots()[0].policy.replan_after_cells;
            let most = replan_after_cells.map_or(usize::MAX, |cells| cells.get() as usize);
            for cell in path.into_iter().take(most) {
                if env.ended.is_none() {
                    env.advance(cell);
                }
            }
        })
    }

    /// Waits for the time that one cell takes, without an observation; this costs as much of each budget as a move.
    /// Returns 0.
    pub fn wait(&mut self) -> f64 {
        self.act(|env| {
            env.pass(1.0);
            env.rest();
        })
    }

    fn act(&mut self, action: impl FnOnce(&mut Self)) -> f64 {
        self.worth = 0.0;
        if self.ended.is_none() {
            action(self);
        }
        self.worth
    }

    /// Enters a neighboring cell and observes, if the time lasts until then.
    fn advance(&mut self, to: Cell) {
        let distance = self.field.scenario().terrain().grid().offset(self.cell(), to).euclidean();
        self.pass(distance);
        // The time may end on the way; a budget that ends with this move still allows the observation.
        if self.ended.is_none() {
            self.world.enter(ROBOT, to);
            self.track.push(to);
            self.observe();
        }
    }

    /// Advances time and path length by this many cells, as far as the budget of time lasts.
    ///
    /// A robot notices that its time is over when it arrives, or with its next heartbeat. Of an arrival and a heartbeat
    /// at the same time the one that was planned first comes first, as in the queue of the simulation.
    fn pass(&mut self, distance_cells: f64) {
        let scenario = self.field.scenario();
        let (mission, budget) = (scenario.mission(), scenario.robots()[ROBOT.index()].class.budget);
        let start = self.now;
        let arrival = start + self.world.time_over(ROBOT, distance_cells);
        let beat = mission.heartbeat;
        let is_before_heartbeat =
            start + beat < arrival || start + beat == arrival && self.is_before_heartbeat;
        if let Some(last) = budget.time().map(|time| next_heartbeat(time, beat))
            && (arrival > last || arrival == last && !is_before_heartbeat)
        {
            self.now = last;
            self.ended = Some(Ended::Spent);
            return;
        }
        self.now = arrival;
        self.is_before_heartbeat = is_before_heartbeat && arrival.0.is_multiple_of(nanoseconds(beat));
        self.spent_meters += distance_cells * self.field.scenario().terrain().cell_meters();
    }

    fn observe(&mut self) {
        let before = self.world.score();
        self.readings.clear();
        self.found.clear();
        self.world.sense_into(ROBOT, &mut self.readings, &mut self.found);
        let seen = self.readings.iter().map(|reading| reading.cell);
        self.seen.extend(seen.clone());
        let after = self.world.score();
        self.worth += match self.terms.reward {
            Reward::Entropy => {
                self.entropies.as_mut().map_or(0.0, |it| it.removed(self.world.merged(), seen))
            }
            Reward::Found => f64::from(after.true_positives) - f64::from(before.true_positives),
            Reward::F1 => after.f1() - before.f1(),
        };
        if self.terms.end == End::AllFound && after.false_negatives == 0 {
            self.ended = Some(Ended::Found);
        } else {
            self.rest();
        }
    }

    /// Ends a search whose budget is spent, or without informative observations left.
    fn rest(&mut self) {
        if self.ended.is_some() {
            return;
        }
        let mission = self.field.scenario().mission();
        if self.is_spent() {
            self.ended = Some(Ended::Spent);
        } else if self.terms.end == End::Resting
            && let Some(threshold) = mission.stop_when_expected_remaining
            && self.world.expected_remaining() <= threshold
        {
            self.ended = Some(Ended::Cleared);
        }
    }

    /// Writes all features in the map's frame, shape as in [`Layout::drawn_len`].
    pub fn draw(&mut self, layout: &Layout, numbers: &mut [f32]) {
        layout.draw(&self.field, &self.view(), numbers);
        self.seen.clear();
        self.drawn = self.cell();
    }

    /// Writes what changed since the last call.
    pub fn redraw(&mut self, layout: &Layout, numbers: &mut [f32]) {
        layout.redraw(&self.field, &self.view(), self.drawn, self.seen.cells(), numbers);
        self.seen.clear();
        self.drawn = self.cell();
    }

    /// What the robot knows.
    #[must_use]
    pub fn view(&self) -> View<'_> {
        View { belief: self.belief(), robot: self.cell(), budget: self.budget(), teammates: &[] }
    }

    /// Share of the budget that is left, `0..=1`.
    #[must_use]
    pub fn budget(&self) -> f32 {
        let elapsed = self.now.since(MissionTime::START);
        let mission = self.field.scenario().mission();
        self.field.budget(mission.remaining_meters(self.spent_meters, elapsed))
    }

    fn is_spent(&self) -> bool {
        let elapsed = self.now.since(MissionTime::START);
        self.field.scenario().robots()[ROBOT.index()].class.budget.is_spent(self.spent_meters, elapsed)
    }

    /// The data that all searches of the scenario share.
    #[must_use]
    pub const fn field(&self) -> &Arc<Field> {
        &self.field
    }

    /// The robot's cell.
    #[must_use]
    pub fn cell(&self) -> Cell {
        self.world.body(ROBOT).cell
    }

    /// Every cell that the robot was in, in order from its start.
    #[must_use]
    pub fn track(&self) -> &[Cell] {
        &self.track
    }

    /// Path length, cells.
    #[must_use]
    pub fn path_cells(&self) -> f64 {
        self.world.body(ROBOT).path_cells
    }

    /// Mission time.
    #[must_use]
    pub const fn now(&self) -> MissionTime {
        self.now
    }

    /// Why the search is over, if it is.
    #[must_use]
    pub const fn ended(&self) -> Option<Ended> {
        self.ended
    }

    /// The belief from all readings.
    #[must_use]
    pub const fn belief(&self) -> &Belief {
        self.world.merged()
    }

    /// The belief compared with the truth.
    #[must_use]
    pub const fn score(&self) -> Score {
        self.world.score()
    }

    /// The objects.
    #[must_use]
    pub const fn truth(&self) -> &Truth {
        self.world.truth()
    }
}

/// The first heartbeat that is not before a time.
fn next_heartbeat(time: Duration, beat: Duration) -> MissionTime {
    let (time, beat) = (MissionTime::START + time, nanoseconds(beat));
    MissionTime(time.0.div_ceil(beat).max(1).saturating_mul(beat))
}

/// At least 1: a heartbeat period is not zero.
fn nanoseconds(beat: Duration) -> u64 {
    u64::try_from(beat.as_nanos()).unwrap_or(u64::MAX).max(1)
}

#[cfg(test)]
mod tests;
