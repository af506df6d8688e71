//! What a participant knows: the observations that it has counted, the operator's verdicts and marks, and what follows from them.
//!
//! Equal sets of observations and equal verdicts and marks give equal knowledge, in any order. So the participants of one process need not hold it
//! once each: those that a simulator lets share their knowledge ([`Knowledge::share`]) hold one copy as long as they
//! have counted the same observations, and the first of them that counts another one computes what all the others
//! take over. In a large team on a good network nearly all of the work of merging is done once, instead of once a robot.

use std::collections::{BTreeSet, HashMap};
use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::evidence::Digest;
use dragnet_search::object_position::ObjectPositions;
use dragnet_search::observation::{Observation, ObservationLog, Versions};
use dragnet_search::reach::{Reach, Sight};
use dragnet_search::terrain::Terrain;

use crate::marks::Marks;
use crate::verdict::{Decision, Verdicts};

/// One participant's knowledge. A copy costs nothing until one of them changes.
#[derive(Clone, Debug)]
pub struct Knowledge {
    state: Arc<State>,
    /// The log-odds before any reading or added cell, shape `[cells]`.
    prior: Arc<[f64]>,
    shared: Option<SharedKnowledge>,
}

/// Where the participants of one process find what others of them know.
#[derive(Clone, Debug, Default)]
pub struct SharedKnowledge {
    states: Arc<Mutex<HashMap<Contents, Weak<State>>>>,
}

/// What decides what a participant knows: the sum of the digests of its observations, its prior by address, and the
/// verdicts and marks. The names of observations would not do: if two robots use one number, different observations have one name.
type Contents = (u128, usize, Arc<Verdicts>, Arc<Marks>);

#[derive(Debug)]
struct State {
    log: ObservationLog,
    belief: Belief,
    /// Cells that robots can observe, from the cells of all observations.
    reach: Arc<Reach>,
    positions: Arc<ObjectPositions>,
    verdicts: Arc<Verdicts>,
    marks: Arc<Marks>,
    /// Sum of the digests of the observations; kept only while the knowledge is shared.
    digests: u128,
    derived: Derived,
}

/// What is computed of a state when somebody first asks.
#[derive(Debug, Default)]
struct Derived {
    /// The first observation that anybody counted next, and what it then knew: mostly all others count it next, too.
    next: OnceLock<(Arc<Observation>, Weak<State>)>,
    versions: OnceLock<Versions>,
    digest: OnceLock<Digest>,
}

/// A copy is made to be changed: nobody has counted anything after it.
impl Clone for State {
    fn clone(&self) -> Self {
        let Self { log, belief, reach, positions, verdicts, marks, digests, .. } = self;
        let (log, belief) = (log.clone(), belief.clone());
        let (reach, positions) = (Arc::clone(reach), Arc::clone(positions));
        let (verdicts, marks) = (Arc::clone(verdicts), Arc::clone(marks));
        let (digests, derived) = (*digests, Derived::default());
        Self { log, belief, reach, positions, verdicts, marks, digests, derived }
    }
}

impl State {
    fn contents(&self) -> Contents {
        self.contents_with(self.digests)
    }

    /// The contents with other observations.
    fn contents_with(&self, digests: u128) -> Contents {
        (digests, self.belief.prior_address(), Arc::clone(&self.verdicts), Arc::clone(&self.marks))
    }

    fn count(&mut self, terrain: &Terrain, sight: Option<Sight>, observation: &Arc<Observation>) {
        if let Some(sight) = sight.filter(|&sight| self.reach.is_news(sight, observation.from)) {
            Arc::make_mut(&mut self.reach).add_robot(terrain, sight, observation.from);
        }
        for reading in &observation.readings {
            self.belief.add(reading);
        }
        if !observation.positions.is_empty() {
            Arc::make_mut(&mut self.positions).add(observation);
        }
        self.log.insert(Arc::clone(observation));
    }
}

impl Knowledge {
    /// No observation yet.
    #[must_use]
    pub fn new(terrain: &Terrain, prior: Belief) -> Self {
        let reach = Arc::new(Reach::unknown(terrain.grid()));
        let (log, positions, verdicts, marks, derived) = Default::default();
        let shared_prior = prior.shared_prior();
        let state = State { log, belief: prior, reach, positions, verdicts, marks, digests: 0, derived };
        Self { state: Arc::new(state), prior: shared_prior, shared: None }
    }

    /// Shares this knowledge with others of the mission that have the same prior, whenever they have counted the same
    /// observations. It does nothing if observations have been released: what they said is not known here.
    pub fn share(&mut self, shared: &SharedKnowledge) {
        let log = self.log();
        let versions = self.versions();
        let (mut count, mut digests) = (0, 0_u128);
        for observation in versions.iter().flat_map(|version| log.since(version.origin, 0)) {
            count += 1;
            digests = digests.wrapping_add(observation.digest().0);
        }
        if count != log.len() {
            return;
        }
        if digests != self.state.digests {
            self.state_mut().digests = digests;
        }
        shared.offer(&mut self.state);
        self.shared = Some(shared.clone());
    }

    /// The observations.
    #[must_use]
    pub fn log(&self) -> &ObservationLog {
        &self.state.log
    }

    /// The belief with the readings of all observations.
    #[must_use]
    pub fn belief(&self) -> &Belief {
        &self.state.belief
    }

    /// The cells that robots can observe, from the cells of all observations.
    #[must_use]
    pub fn reach(&self) -> &Reach {
        &self.state.reach
    }

    /// The positions of declared objects, as far as robots know them.
    #[must_use]
    pub fn positions(&self) -> &Arc<ObjectPositions> {
        &self.state.positions
    }

    /// The operator's verdicts.
    #[must_use]
    pub fn verdicts(&self) -> &Verdicts {
        &self.state.verdicts
    }

    /// The operator's marks.
    #[must_use]
    pub fn marks(&self) -> &Marks {
        &self.state.marks
    }

    /// The operator's verdicts and, as of a time in nanoseconds, a new one.
    #[must_use]
    pub fn verdicts_with(&self, time_ns: u64, cell: Cell, decision: Decision) -> Verdicts {
        self.verdicts().with(time_ns, cell, decision, self.belief())
    }

    /// The version vector of the observations.
    #[must_use]
    pub fn versions(&self) -> Versions {
        self.state.derived.versions.get_or_init(|| self.log().versions()).clone()
    }

    /// Digest of the evidence of the belief.
    #[must_use]
    pub fn digest(&self) -> Digest {
        *self.state.derived.digest.get_or_init(|| self.belief().digest())
    }

    /// The state to be changed: a copy, if others have it too.
    fn state_mut(&mut self) -> &mut State {
        let state = Arc::make_mut(&mut self.state);
        state.derived = Derived::default();
        state
    }

    /// Adds cells to the search area, as [`Belief::search_also`].
    pub fn search_also(
        &mut self,
        terrain: &mut Terrain,
        cells: impl IntoIterator<Item = Cell>,
        prior: f64,
    ) -> Vec<Cell> {
        self.state_mut().belief.search_also(terrain, cells, prior)
    }

    /// Merges verdicts, as [`Verdicts::merge`]; returns the cells with a new one.
    pub fn judge(&mut self, now: MissionTime, verdicts: &Verdicts) -> Vec<Cell> {
        if verdicts.iter().all(|(cell, verdict)| self.verdicts().includes(cell, verdict)) {
            return Vec::new();
        }
        let State { belief, verdicts: known, .. } = self.state_mut();
        let judged = Arc::make_mut(known).merge(now, verdicts, belief);
        if let Some(shared) = &self.shared {
            shared.offer(&mut self.state);
        }
        judged
    }

    /// Merges marks, as [`Marks::merge_into`]; returns the cells that they concern, `None` if nothing is news.
    pub fn mark(&mut self, now: MissionTime, marks: &Marks, grid: Grid) -> Option<BTreeSet<Cell>> {
        if self.marks().includes_all(marks) {
            return None;
        }
        let prior = Arc::clone(&self.prior);
        let State { belief, marks: known, .. } = self.state_mut();
        let marked = Arc::make_mut(known).merge_into(now, marks, grid, &prior, belief);
        if let Some(shared) = &self.shared {
            shared.offer(&mut self.state);
        }
        marked
    }

    /// Keeps at most the last `held` observations of each origin in memory. Others that need them all would miss the rest,
    /// and so this knowledge is shared no longer.
    pub fn release(&mut self, held: NonZeroUsize) {
        self.shared = None;
        self.state_mut().log.release(held);
    }

    /// Counts an observation as another participant did that knew the same and has validated it; false if none has.
    pub(crate) fn follow(&mut self, observation: &Arc<Observation>) -> bool {
        let next = match (&self.shared, self.state.derived.next.get()) {
            (Some(_), Some((counted, next))) if Arc::ptr_eq(counted, observation) => next.upgrade(),
            _ => None,
        };
        let is_followed = next.is_some();
        if let Some(next) = next {
            self.state = next;
        }
        is_followed
    }

    /// Counts an observation that is the next of its origin, by a robot of this sight or by the operator.
    pub(crate) fn count(&mut self, terrain: &Terrain, sight: Option<Sight>, observation: &Arc<Observation>) {
        let Some(shared) = self.shared.clone() else {
            return self.state_mut().count(terrain, sight, observation);
        };
        let digests = self.state.digests.wrapping_add(observation.digest().0);
        // If nobody else knows the same, nobody follows, and nothing is copied.
        let before = (Arc::strong_count(&self.state) > 1).then(|| Arc::clone(&self.state));
        if let Some(known) = shared.find(&self.state.contents_with(digests)) {
            self.state = known;
        } else {
            let state = self.state_mut();
            state.digests = digests;
            state.count(terrain, sight, observation);
            shared.offer(&mut self.state);
        }
        if let Some(before) = before {
            before.derived.next.get_or_init(|| (Arc::clone(observation), Arc::downgrade(&self.state)));
        }
    }
}

impl SharedKnowledge {
    fn find(&self, contents: &Contents) -> Option<Arc<State>> {
        self.states().get(contents)?.upgrade()
    }

    /// Replaces a state by that of another participant with the same contents, or makes it known to others.
    fn offer(&self, state: &mut Arc<State>) {
        let mut states = self.states();
        if let Some(known) = states.get(&state.contents()).and_then(Weak::upgrade) {
            *state = known;
            return;
        }
        if states.len() == states.capacity() {
            states.retain(|_, state| state.strong_count() > 0);
        }
        states.insert(state.contents(), Arc::downgrade(state));
    }

    /// No panic leaves the map half changed.
    fn states(&self) -> MutexGuard<'_, HashMap<Contents, Weak<State>>> {
        self.states.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::evidence::Reading;
    use dragnet_search::object_position::ObjectPosition;
    use dragnet_search::observation::{Origin, RobotId};
    use proptest::prelude::*;

    use super::*;

    fn field() -> (Terrain, Knowledge) {
        let terrain = Terrain::from_ascii(".....,", 1.0).unwrap();
        let prior = Belief::uniform(&terrain, 0.2).unwrap();
        let knowledge = Knowledge::new(&terrain, prior);
        (terrain, knowledge)
    }

    fn observation(terrain: &Terrain, robot: u16, sequence: u64, value: f32) -> Arc<Observation> {
        let cell = terrain.grid().cell_numbered(u32::from(robot)).unwrap();
        let readings = vec![Reading { cell, value, variance: 0.1 }];
        let origin = Origin::first(RobotId::new(robot).unwrap());
        let variance = 1.0 / (1.0 + value.abs());
        let position = ObjectPosition::new(cell, [f64::from(value), 0.5], [variance, 0.0, variance]);
        let positions = position.filter(|_| sequence.is_multiple_of(3)).into_iter().collect();
        Arc::new(Observation { origin, sequence, time_ns: sequence, from: cell, readings, positions })
    }

    /// Whether it only followed.
    fn learn(knowledge: &mut Knowledge, terrain: &Terrain, observation: &Arc<Observation>) -> bool {
        let is_followed = knowledge.follow(observation);
        if !is_followed {
            knowledge.count(terrain, Some(Sight::on_ground(1)), observation);
        }
        is_followed
    }

    fn team(first: &Knowledge) -> Vec<Knowledge> {
        let mut team = vec![first.clone(); 4];
        let shared = SharedKnowledge::default();
        for knowledge in &mut team {
            knowledge.share(&shared);
        }
        team
    }

    #[test]
    fn participants_that_know_the_same_hold_it_once_in_whatever_order_they_learned_it() {
        let (terrain, first) = field();
        let mut team = team(&first);
        let [a, b] = [1, 2].map(|robot| observation(&terrain, robot, 0, 1.0));
        for (knowledge, order) in team.iter_mut().zip([[&a, &b], [&b, &a], [&a, &b], [&b, &a]]) {
            for observation in order {
                learn(knowledge, &terrain, observation);
            }
        }
        assert!(team.iter().all(|knowledge| Arc::ptr_eq(&knowledge.state, &team[0].state)));
    }

    #[test]
    fn only_the_first_to_learn_something_adds_it_up() {
        let (terrain, first) = field();
        let news = observation(&terrain, 1, 0, 1.0);
        let is_followed = team(&first).iter_mut().map(|it| learn(it, &terrain, &news)).collect::<Vec<_>>();
        assert_eq!(is_followed, [false, true, true, true]);
    }

    #[test]
    fn other_observations_of_the_same_name_and_other_priors_are_other_knowledge() {
        let (mut terrain, first) = field();
        let mut team = team(&first);
        let [read, added] = [1, 5].map(|number| terrain.grid().cell_numbered(number).unwrap());
        team[2].search_also(&mut terrain, [added], 0.3);
        for (knowledge, value) in team.iter_mut().zip([1.0, 0.0, 1.0]) {
            learn(knowledge, &terrain, &observation(&terrain, 1, 0, value));
        }
        let is_found = |robot: usize, cell| team[robot].belief().is_found(cell, 0.9);
        assert_eq!([0, 1, 2].map(|robot| is_found(robot, read)), [true, false, true]);
        assert_eq!([0, 2].map(|robot| team[robot].belief().probability(added) > 0.2), [false, true]);
    }

    #[test]
    fn participants_with_the_same_verdicts_hold_them_once_and_others_do_not_share_theirs() {
        let (terrain, first) = field();
        let mut team = team(&first);
        let [a, b] = [1, 2].map(|robot| observation(&terrain, robot, 0, 1.0));
        let judged = terrain.grid().cell_numbered(1).unwrap();
        learn(&mut team[0], &terrain, &a);
        let verdicts = team[0].verdicts_with(1, judged, Decision::Dismissed);
        assert_eq!(team[0].judge(MissionTime(1), &verdicts), [judged]);
        learn(&mut team[0], &terrain, &b);
        assert_eq!(team[1].judge(MissionTime(1), &verdicts), [judged], "before the observations");
        for knowledge in &mut team[1..] {
            learn(knowledge, &terrain, &b);
            learn(knowledge, &terrain, &a);
        }
        assert!(Arc::ptr_eq(&team[0].state, &team[1].state) && Arc::ptr_eq(&team[2].state, &team[3].state));
        assert_eq!([0, 2].map(|robot| team[robot].belief().is_found(judged, 0.5)), [false, true]);
        assert_eq!(team[2].judge(MissionTime(2), &verdicts), [judged]);
        assert!(Arc::ptr_eq(&team[0].state, &team[2].state));
    }

    proptest! {
        #[test]
        fn what_is_shared_is_what_each_would_know_alone(
            steps in prop::collection::vec((0_usize..4, 1_u16..5), 1..80), released in 0_usize..160,
        ) {
            let (terrain, first) = field();
            let (mut alone, mut team) = (vec![first.clone(); 4], team(&first));
            let published: Vec<Vec<Arc<Observation>>> = (1..5)
                .map(|robot| (0..80).map(|it| observation(&terrain, robot, it, it as f32 / 80.0)).collect())
                .collect();
            for (step, (participant, robot)) in steps.into_iter().enumerate() {
                let next = alone[participant].log().next(Origin::first(RobotId::new(robot).unwrap()));
                let news = &published[usize::from(robot) - 1][usize::try_from(next).unwrap()];
                alone[participant].count(&terrain, Some(Sight::on_ground(1)), news);
                learn(&mut team[participant], &terrain, news);
                if step == released {
                    team[participant].release(NonZeroUsize::MIN);
                }
                for (knowledge, alone) in team.iter().zip(&alone) {
                    prop_assert_eq!(knowledge.belief(), alone.belief());
                    prop_assert_eq!(knowledge.reach(), alone.reach());
                    prop_assert_eq!(knowledge.positions(), alone.positions());
                    prop_assert_eq!((knowledge.digest(), knowledge.versions()), (alone.digest(), alone.versions()));
                }
            }
        }
    }
}
