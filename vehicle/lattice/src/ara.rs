//! ARA*: weighted A* that is repeated with decreasing inflation, and reuses earlier results.
//!
//! Likhachev, Gordon and Thrun (2003), "ARA*: Anytime A* with Provable Bounds on Sub-Optimality". OPEN, CLOSED and
//! INCONS are theirs. Departures:
//! - The goal is not a state: it may be several, and none is expanded. Its cost is that of the best path found.
//! - Once a path is known, states from which no cheaper one can lead to the goal are pruned.
//! - OPEN holds entries of states rather than states; outdated ones are skipped.

use dragnet_search::cell::Position;

use super::costmap::CostMap;
use super::goal::GoalStates;
use super::guidance::{Guidance, OUT_OF_REACH};
use super::layers::Layers;
use super::motions::{Motion, Motions};
use super::queue::{Entry, Queue};
use super::states::States;
use super::stopped::Stopped;

/// Expansions between two calls of `go_on`.
pub(super) const EXPANSIONS_PER_QUESTION: u64 = 1 << 10;

/// What a search keeps between plans: memory only.
#[derive(Clone, Debug)]
pub(super) struct Space {
    pub(super) states: States,
    queue: Queue,
    /// Expanded states to which a cheaper path was found since, with its cost.
    inconsistent: Vec<(u32, u32)>,
}

impl Space {
    pub(super) fn new() -> Self {
        Self { states: States::default(), queue: Queue::new(), inconsistent: Vec::new() }
    }

    pub(super) fn bytes(&self) -> usize {
        self.states.bytes() + self.queue.bytes() + self.inconsistent.capacity() * 8
    }
}

/// The best path found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) cost: u32,
    pub(super) state: u32,
}

/// One plan's search.
pub(super) struct Search<'a> {
    pub(super) map: &'a CostMap,
    pub(super) layers: &'a Layers,
    pub(super) motions: &'a Motions,
    pub(super) goal: &'a GoalStates,
    pub(super) space: &'a mut Space,
    pub(super) best: Option<Best>,
    /// No path can cost less.
    pub(super) lower_bound: u64,
    pub(super) expansions: u64,
    /// A path was dropped because its cost exceeds 32 bits.
    pub(super) too_costly: bool,
    /// Number of searches begun: the mark of the states closed in this one.
    iteration: u8,
    /// Inflation in 1024ths.
    inflation: u64,
}

/// When a search is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Until {
    /// At the first path.
    First,
    /// When no state in OPEN can lead to a cheaper path, as far as the inflation guarantees.
    Proven,
    /// Likewise, and at the latest after this total number of expansions.
    Expanded(u64),
}

impl<'a> Search<'a> {
    pub(super) fn new(
        map: &'a CostMap,
        layers: &'a Layers,
        motions: &'a Motions,
        goal: &'a GoalStates,
        space: &'a mut Space,
    ) -> Self {
        space.states.reset(layers.rows(), layers.columns(), motions.heading_count());
        space.inconsistent.clear();
        space.queue.reset(0);
        Self {
            map,
            layers,
            motions,
            goal,
            space,
            best: None,
            lower_bound: 0,
            expansions: 0,
            too_costly: false,
            iteration: 0,
            inflation: 1024,
        }
    }

    /// Adds the start with cost 0.
    pub(super) fn begin(&mut self, at: Position, heading: u8) {
        let state = self.space.states.make(at, heading);
        self.space.states.record_mut(state).cost = 0;
        self.space.inconsistent.push((state, 0));
    }

    /// OPEN and INCONS become the new OPEN, with keys of this guidance and inflation; CLOSED is empty.
    pub(super) fn reopen(&mut self, guidance: &impl Guidance, inflation: f64) {
        self.inflation = fixed(inflation);
        self.iteration = self.iteration.wrapping_add(1);
        let mut entries: Vec<Entry> = self
            .waiting()
            .filter_map(|(state, cost)| {
                let ahead = guidance.at(self.space.states.place(state).0);
                (ahead != OUT_OF_REACH && !self.is_useless(guidance, cost, ahead))
                    .then(|| self.entry(state, cost, ahead))
            })
            .collect();
        // The order of the old queue must not affect the result.
        entries.sort_unstable_by_key(|entry| entry.state);
        let largest = entries.iter().map(|entry| entry.key).max().unwrap_or(0);
        self.space.inconsistent.clear();
        self.space.queue.reset(largest.saturating_mul(2));
        for entry in entries {
            self.space.queue.push(entry);
        }
    }

    /// States in OPEN and INCONS with their costs.
    fn waiting(&self) -> impl Iterator<Item = (u32, u32)> {
        let states = &self.space.states;
        let open = self.space.queue.entries().filter_map(move |entry| {
            let record = states.record(entry.state);
            (record.cost == entry.cost).then_some((entry.state, entry.cost))
        });
        let inconsistent = self.space.inconsistent.iter().copied();
        open.chain(inconsistent.filter(move |&(state, cost)| states.record(state).cost == cost))
    }

    /// Raises the lower bound by this guidance, which must never overestimate, over OPEN and INCONS: the best path
    /// leads through one of them at its minimum cost.
    pub(super) fn raise_lower_bound<G: Guidance>(&mut self, guidance: &G) {
        debug_assert!(G::IS_LOWER_BOUND);
        let least = self
            .waiting()
            .filter_map(|(state, cost)| {
                let ahead = guidance.at(self.space.states.place(state).0);
                (ahead != OUT_OF_REACH).then_some(u64::from(cost) + u64::from(ahead))
            })
            .min()
            .unwrap_or(u64::MAX);
        let best = self.best.map_or(u64::MAX, |best| u64::from(best.cost));
        self.lower_bound = self.lower_bound.max(least.min(best));
    }

    /// Upper bound on the ratio of the best path's cost to the minimum.
    pub(super) fn bound(&self) -> f64 {
        let Some(best) = self.best else { return f64::INFINITY };
        if u64::from(best.cost) <= self.lower_bound {
            return 1.0;
        }
        f64::from(best.cost) / self.lower_bound as f64
    }

    /// Expands states until done. If OPEN becomes empty, the search is complete.
    pub(super) fn improve(
        &mut self,
        guidance: &impl Guidance,
        until: Until,
        go_on: &mut dyn FnMut(u64) -> bool,
    ) -> Result<(), Stopped> {
        while let Some(entry) = self.space.queue.pop() {
            let record = self.space.states.record_mut(entry.state);
            if record.cost != entry.cost {
                continue;
            }
            debug_assert!(record.closed != self.iteration, "a state was expanded twice in one search");
            if self.best.is_some_and(|best| entry.key >= u64::from(best.cost) << 10) {
                // It stays in OPEN, for the next search.
                self.space.queue.push(entry);
                return Ok(());
            }
            record.closed = self.iteration;
            self.expand(entry, guidance);
            self.expansions += 1;
            let is_done = match until {
                Until::First => self.best.is_some(),
                Until::Proven => false,
                Until::Expanded(most) => self.expansions >= most,
            };
            if is_done {
                return Ok(());
            }
            if self.expansions.is_multiple_of(EXPANSIONS_PER_QUESTION) && !go_on(self.expansions) {
                return Err(Stopped);
            }
        }
        Ok(())
    }

    fn expand(&mut self, from: Entry, guidance: &impl Guidance) {
        let (at, heading) = self.space.states.place(from.state);
        let motions = self.motions;
        let is_near_lethal = self.layers.is_near_lethal(at);
        let is_near_change = self.layers.is_near_change(at);
        let own =
            1 + u64::from(self.map.costs()[at.row as usize * self.layers.columns() + at.column as usize]);
        for motion in motions.starting_with(usize::from(heading)) {
            let to = Position {
                row: at.row.wrapping_add_signed(motion.north),
                column: at.column.wrapping_add_signed(motion.east),
            };
            if is_near_lethal
                && (to.row as usize >= self.layers.rows() || to.column as usize >= self.layers.columns())
            {
                continue;
            }
            // Cheap tests first: most motions lead to states that already have a better path.
            let known = self.space.states.cost_at(to, motion.end_heading);
            if from.cost.saturating_add(motion.cost) >= known {
                continue;
            }
            if is_near_lethal && !self.layers.is_free(at, motions.swept(motion)) {
                continue;
            }
            let step = if is_near_change {
                costly(self.map, motions, motion, at)
            } else {
                u64::from(motion.cost) * own
            };
            let Ok(cost) = u32::try_from(u64::from(from.cost) + step) else {
                self.too_costly = true;
                continue;
            };
            if cost < known {
                self.reach(to, motion, cost, guidance);
            }
        }
    }

    fn reach(&mut self, at: Position, motion: &Motion, cost: u32, guidance: &impl Guidance) {
        let ahead = guidance.at(at);
        if ahead == OUT_OF_REACH || self.best.is_some_and(|best| cost >= best.cost) {
            return;
        }
        let is_goal = self.goal.contains(at, motion.end_heading);
        if !is_goal && self.is_useless(guidance, cost, ahead) {
            return;
        }
        let state = self.space.states.make(at, motion.end_heading);
        let record = self.space.states.record_mut(state);
        record.cost = cost;
        record.primitive = motion.primitive;
        if is_goal {
            self.best = Some(Best { cost, state });
        } else if record.closed == self.iteration {
            self.space.inconsistent.push((state, cost));
        } else {
            let entry = self.entry(state, cost, ahead);
            self.space.queue.push(entry);
        }
    }

    /// Whether no path cheaper than the best leads through a state of this cost and distance to the goal.
    fn is_useless<G: Guidance>(&self, _: &G, cost: u32, ahead: u32) -> bool {
        G::IS_LOWER_BOUND
            && self.best.is_some_and(|best| u64::from(cost) + u64::from(ahead) >= u64::from(best.cost))
    }

    const fn entry(&self, state: u32, cost: u32, ahead: u32) -> Entry {
        Entry { key: ((cost as u64) << 10) + self.inflation * ahead as u64, cost, state }
    }

    /// The state before one on the best path to it, and the cost of the motion between them there.
    pub(super) fn before(&self, state: u32) -> (u32, u64) {
        let (at, _) = self.space.states.place(state);
        let motion = self.motions.of_primitive(self.space.states.record(state).primitive);
        let from = Position {
            row: at.row.wrapping_sub(motion.north.cast_unsigned()),
            column: at.column.wrapping_sub(motion.east.cast_unsigned()),
        };
        (self.space.states.name_at(from, motion.start_heading), costly(self.map, self.motions, motion, from))
    }
}

/// The cost of a motion that starts in a cell: one more than the largest cost along it, times its cost over free
/// ground. Departure from SBPL: the cells are those that the reference point crosses, not all that are swept.
fn costly(map: &CostMap, motions: &Motions, motion: &Motion, at: Position) -> u64 {
    let columns = map.grid().columns() as usize;
    let cell = |&(north, east): &(i32, i32)| {
        let row = (at.row as usize).wrapping_add_signed(north as isize);
        map.costs()[row * columns + (at.column as usize).wrapping_add_signed(east as isize)]
    };
    let largest = motions.path(motion).iter().map(cell).max().unwrap_or(0);
    u64::from(motion.cost) * (1 + u64::from(largest))
}

/// In 1024ths, rounded up: never less than 1.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inflations are 1 to 100")]
fn fixed(inflation: f64) -> u64 {
    ((inflation * 1024.0).ceil() as u64).max(1024)
}
