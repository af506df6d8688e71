//! What a tour costs: the search is imagined along it, observation by observation.

use super::ground::{Ground, LENGTH_UNIT, Step};
use super::hidden::{self, HiddenTable, Row};
use crate::situation::Situation;

/// A shortest path of a tour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Leg {
    /// The number of the waypoint where it ends.
    pub to: u16,
    /// Which of the shortest paths: 0 goes along columns first, 1 along rows and diagonals.
    pub bend: u8,
}

/// Weight of the expected number of objects left beside the probability that any is left.
const NUMBER_WEIGHT: f64 = 0.02;
/// Cost of a cell's length as such.
const MOVE_COST: f64 = 0.02;
/// How long a search goes on after a tour that leaves something, cells, and cells for each cell of the ground. It has
/// to exceed what is left of the search: otherwise giving up looks cheapest.
const TAIL_CELLS: f64 = 40.0;
const TAIL_SHARE: f64 = 0.8;
/// The longest tour, steps: at most this, and twice the cells of the ground and a few. Longer ones look at the same
/// cells again and again.
const MAX_STEPS: u16 = 4000;
const FEW_STEPS: u16 = 100;

const NO_HORIZON: u32 = u32::MAX;

/// How far an imagined search has come.
#[derive(Clone)]
pub(super) struct Progress {
    /// Precision at each place of the frame, in steps of the table.
    pub precision: Vec<u8>,
    /// What is hidden at each place.
    pub hidden: Vec<f32>,
    /// The sum of what is hidden.
    pub left: f64,
    /// Cost so far, cells.
    pub cost: f64,
    /// Number of the cell.
    pub at: u16,
    /// Steps so far.
    pub steps: u16,
    /// Length so far, fifths of a cell.
    pub time: u32,
    /// How many of teammates' planned observations have been made.
    pub by_teammates: usize,
}

/// What a teammate's plan will have observed of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PlannedObservation {
    /// When, fifths of a cell: all robots are taken to be equally fast.
    pub time: u32,
    /// Place in the frame.
    pub place: usize,
    /// Precision, in steps of the table.
    pub precision: u8,
}

impl Progress {
    fn copy(&mut self, other: &Self) {
        self.precision.copy_from_slice(&other.precision);
        self.hidden.copy_from_slice(&other.hidden);
        (self.left, self.cost, self.at, self.steps) = (other.left, other.cost, other.at, other.steps);
        (self.time, self.by_teammates) = (other.time, other.by_teammates);
    }
}

/// One decision's planner.
///
/// A tour costs `J = sum_t l_t [g(M_t) + 0.02] + tail g(M_T)`, cells, with `M_t` the sum of what all cells still hide
/// after step `t` of length `l_t`, and `g(M) = 1 - exp(-b M) + 0.02 b M`, `b = max(1, 1 / M_0)`. Since `exp(-M)` is the
/// probability that nothing is left, the first sum is the expected length of the search.
///
/// What teammates plan to observe lowers `M_t` from when they observe it, and the sum goes on without the robot until
/// the last of them has ended its plan: then `J` is what the search of the whole team costs.
///
/// Where the budget ends before the tour, it ends the sum: steps after the *horizon* see nothing and cost nothing, so
/// that the tail weighs what the budget leaves unseen. For a robot with a base the budget ends where it leaves no more
/// than the way home. That is never undone later on: no step shortens the way home by more than its own length.
pub(super) struct Planner<'a> {
    pub ground: &'a Ground,
    pub table: &'a HiddenTable,
    pub rows: Vec<Row>,
    /// What teammates plan to observe, in order of time.
    by_teammates: Vec<PlannedObservation>,
    /// The search as it stands.
    pub root: Progress,
    pub tail: f64,
    pub most_steps: u16,
    /// When the budget ends, fifths of a cell.
    horizon: u32,
    /// At least one object is left, or there is nothing to plan for.
    boost: f64,
}

impl<'a> Planner<'a> {
    pub(super) fn new(
        ground: &'a Ground,
        table: &'a HiddenTable,
        situation: &Situation<'_>,
        at: u16,
    ) -> Self {
        let mut rows = vec![HiddenTable::NOTHING; ground.frame_len()];
        let mut precision = vec![u8::MAX; ground.frame_len()];
        let mut hidden = vec![0.0; ground.frame_len()];
        let mut left = 0.0;
        let has_plans = !situation.planned_precision.plans().is_empty();
        for cell in situation.terrain.searched_cells() {
            let Some(place) = ground.framed_visible(cell) else { continue };
            let row = table.row(situation.belief.log_odds_nats(cell));
            rows[place] = row;
            // The plans' observations count from when they happen.
            precision[place] =
                if has_plans { 0 } else { hidden::steps(situation.planned_precision.precision(cell)) };
            hidden[place] = table.hidden(row, precision[place]);
            left += f64::from(hidden[place]);
        }
        let root = Progress { precision, hidden, left, cost: 0.0, at, steps: 0, time: 0, by_teammates: 0 };
        let tail = TAIL_CELLS + TAIL_SHARE * f64::from(ground.count());
        let most_steps = ground.count().saturating_mul(2).saturating_add(FEW_STEPS).min(MAX_STEPS);
        Self {
            ground,
            table,
            rows,
            by_teammates: Vec::new(),
            root,
            tail,
            most_steps,
            horizon: NO_HORIZON,
            boost: (1.0 / left.max(1e-12)).max(1.0),
        }
    }

    /// The same planner with sums that end when the budget does, fifths of a cell.
    pub(super) fn ending_at(mut self, horizon: u32) -> Self {
        self.horizon = horizon;
        self.by_teammates.retain(|it| it.time <= horizon);
        self
    }

    /// Whether what follows a change of a tour depends on when it is reached.
    const fn depends_on_time(&self) -> bool {
        self.has_teammates() || self.horizon != NO_HORIZON
    }

    /// Length of a tour, and of the way home from its end for a robot with a base, fifths of a cell.
    pub(super) fn length(&self, tour: &[Leg]) -> u32 {
        self.ends(tour).last().unwrap_or(0)
    }

    /// The legs of a tour that begin before the budget ends.
    pub(super) fn within(&self, tour: &[Leg], horizon: u32) -> usize {
        let ends = self.ends(tour).take_while(|&end| end < horizon).count();
        tour.len().min(ends + 1)
    }

    /// When each leg ends, and the robot could be at its base if it has one, fifths of a cell.
    fn ends(&self, tour: &[Leg]) -> impl Iterator<Item = u32> {
        tour.iter().scan((self.root.at, 0_u32), |(at, time), leg| {
            *time += u32::from(self.ground.length(*at, leg.to));
            *at = leg.to;
            Some(time.saturating_add(self.ground.way_home(*at)))
        })
    }

    /// Whether teammates plan anything.
    pub(super) const fn has_teammates(&self) -> bool {
        !self.by_teammates.is_empty()
    }

    /// The planner of a robot in this cell beside teammates who plan to observe this.
    pub(super) fn beside(&self, at: u16, mut by_teammates: Vec<PlannedObservation>) -> Self {
        by_teammates.retain(|observation| self.rows[observation.place] != HiddenTable::NOTHING);
        by_teammates.sort_unstable_by_key(|it| (it.time, it.place, it.precision));
        let mut root = Progress { at, ..self.root.clone() };
        let planner = Self { rows: self.rows.clone(), by_teammates, root: root.clone(), ..*self };
        planner.observe_planned(&mut root);
        Self { root, ..planner }
    }

    /// The same decision after the search has been imagined along a path, whose cost counts.
    pub(super) fn after(&self, path: &[u16]) -> Self {
        let mut root = self.root.clone();
        for &to in path {
            let step = self.ground.step(0, root.at, to);
            self.enter(&mut root, step);
        }
        root.steps = 0;
        Self { rows: self.rows.clone(), by_teammates: self.by_teammates.clone(), root, ..*self }
    }

    /// What a place of the frame hides at the start.
    pub(super) fn hidden_at(&self, number: u16) -> f64 {
        f64::from(self.root.hidden[self.ground.framed(number)])
    }

    /// Cost of a tour, cells; infinite if it is too long.
    pub(super) fn cost(&self, tour: &[Leg]) -> f64 {
        let mut progress = self.root.clone();
        let is_within = tour.iter().all(|&leg| self.walk(&mut progress, leg, f64::INFINITY));
        if is_within { self.total(&mut progress) } else { f64::INFINITY }
    }

    /// Expected length of the search along a tour, cells: that of each step counts with the probability that an object is
    /// left after it, and the tail with what the tour leaves.
    pub(super) fn expected_length(&self, tour: &[Leg]) -> f64 {
        let mut progress = self.root.clone();
        let mut expected = 0.0;
        for leg in tour {
            while progress.at != leg.to {
                let length = self.advance(&mut progress, *leg);
                expected += length * unfinished(progress.left);
            }
        }
        expected + self.tail * unfinished(progress.left)
    }

    /// Numbers of the cells entered along a tour, and how many have been entered at the end of each leg.
    pub(super) fn cells(&self, tour: &[Leg]) -> (Vec<u16>, Vec<usize>) {
        let (mut cells, mut ends) = (Vec::new(), Vec::new());
        let mut at = self.root.at;
        for leg in tour {
            while at != leg.to {
                at = self.ground.step(leg.bend, at, leg.to).to;
                cells.push(at);
            }
            ends.push(cells.len());
        }
        (cells, ends)
    }

    pub(super) fn rate(&self, left: f64) -> f64 {
        let left = left * self.boost;
        1.0 - libm::exp(-left) + NUMBER_WEIGHT * left
    }

    /// The cost of a tour that ends here, once teammates have ended theirs.
    fn total(&self, progress: &mut Progress) -> f64 {
        while let Some(next) = self.by_teammates.get(progress.by_teammates) {
            let length = f64::from(next.time.saturating_sub(progress.time)) * LENGTH_UNIT;
            progress.time = next.time;
            self.observe_planned(progress);
            progress.cost += length * self.rate(progress.left);
        }
        progress.cost + self.tail * self.rate(progress.left)
    }

    /// Counts what teammates have observed by now.
    fn observe_planned(&self, progress: &mut Progress) {
        let mut gain = 0.0_f32;
        let is_made = |by_teammates: &&PlannedObservation| by_teammates.time <= progress.time;
        for made in self.by_teammates[progress.by_teammates..].iter().take_while(is_made) {
            let precision = progress.precision[made.place].saturating_add(made.precision);
            let after = self.table.hidden(self.rows[made.place], precision);
            gain += progress.hidden[made.place] - after;
            (progress.precision[made.place], progress.hidden[made.place]) = (precision, after);
            progress.by_teammates += 1;
        }
        progress.left = (progress.left - f64::from(gain)).max(0.0);
    }

    fn observe(&self, progress: &mut Progress) {
        let mut gain = 0.0_f32;
        for (start, row) in self.ground.observation(progress.at) {
            let range = start..start + row.len();
            let places =
                progress.precision[range.clone()].iter_mut().zip(&mut progress.hidden[range.clone()]);
            for (((precision, hidden), &cell), &added) in places.zip(&self.rows[range]).zip(row) {
                *precision = precision.saturating_add(added);
                let after = self.table.hidden(cell, *precision);
                gain += *hidden - after;
                *hidden = after;
            }
        }
        progress.left = (progress.left - f64::from(gain)).max(0.0);
    }

    /// Takes the next step of a leg; returns its length, cells.
    fn advance(&self, progress: &mut Progress, leg: Leg) -> f64 {
        let step = self.ground.step(leg.bend, progress.at, leg.to);
        self.enter(progress, step)
    }

    /// Enters a neighbor; returns its distance, cells.
    fn enter(&self, progress: &mut Progress, step: Step) -> f64 {
        progress.at = step.to;
        progress.steps += 1;
        progress.time += u32::from(step.length);
        if self.has_teammates() {
            self.observe_planned(progress);
        }
        if self.horizon != NO_HORIZON
            && progress.time.saturating_add(self.ground.way_home(step.to)) > self.horizon
        {
            return 0.0;
        }
        self.observe(progress);
        let length = f64::from(step.length) * LENGTH_UNIT;
        progress.cost += length * (self.rate(progress.left) + MOVE_COST);
        length
    }

    /// Walks a leg; false once it costs more than it may, or the tour is too long.
    pub(super) fn walk(&self, progress: &mut Progress, leg: Leg, limit: f64) -> bool {
        while progress.at != leg.to {
            self.advance(progress, leg);
            if progress.cost > limit || progress.steps >= self.most_steps {
                return false;
            }
        }
        true
    }
}

/// Probability that an object is left where cells hide this much together.
pub(super) fn unfinished(left: f64) -> f64 {
    -libm::expm1(-left)
}

/// A tour with all that follows from it, so that a change to it is evaluated without walking the rest anew.
pub(super) struct WalkedTour {
    /// Before each leg, and at the end.
    marks: Vec<Progress>,
    /// By place of the frame: the steps that observe it, and with which precision.
    observed: Vec<Vec<(u16, u8)>>,
    /// After each step: what is left, and the step's length.
    left: Vec<(f64, f64)>,
    /// Changes of what is left, by step: scratch of [`WalkedTour::rest`].
    changes: Vec<f32>,
    scratch: Progress,
    end: Progress,
}

impl WalkedTour {
    pub(super) fn new(planner: &Planner<'_>, tour: &[Leg]) -> Self {
        let mut walked = Self {
            marks: vec![planner.root.clone()],
            observed: vec![Vec::new(); planner.ground.frame_len()],
            left: vec![(planner.root.left, 0.0)],
            changes: Vec::new(),
            scratch: planner.root.clone(),
            end: planner.root.clone(),
        };
        walked.walk(planner, tour, 0);
        walked
    }

    /// The search at the end of the tour, and of all teammates' tours.
    pub(super) const fn end(&self) -> &Progress {
        &self.end
    }

    pub(super) fn cost(&mut self, planner: &Planner<'_>, tour: &[Leg]) -> f64 {
        self.end.copy(&self.marks[tour.len()]);
        planner.total(&mut self.end)
    }

    /// Walks a tour that is new from this leg on.
    pub(super) fn walk(&mut self, planner: &Planner<'_>, tour: &[Leg], first: usize) {
        while self.marks.len() < tour.len() + 1 {
            self.marks.push(planner.root.clone());
        }
        let start = self.marks[first].steps;
        for observed in &mut self.observed {
            while observed.last().is_some_and(|&(step, _)| step > start) {
                observed.pop();
            }
        }
        self.left.truncate(usize::from(start) + 1);
        for (i, &leg) in tour.iter().enumerate().skip(first) {
            let (before, after) = self.marks.split_at_mut(i + 1);
            let progress = &mut after[0];
            progress.copy(&before[i]);
            while progress.at != leg.to {
                let length = planner.advance(progress, leg);
                self.left.push((progress.left, length));
                if planner.depends_on_time() {
                    continue;
                }
                for (start, row) in planner.ground.observation(progress.at) {
                    for (observed, &precision) in self.observed[start..].iter_mut().zip(row) {
                        observed.push((progress.steps, precision));
                    }
                }
            }
        }
    }

    /// Cost of a tour that differs from this one from leg `first` on, up to its last `common` legs; infinite if it is
    /// above the limit.
    ///
    /// The legs that differ are walked, and the first common one, which starts elsewhere. What follows is counted from
    /// the observations that places whose precision differs get later on.
    pub(super) fn cost_of_changed(
        &mut self,
        planner: &Planner<'_>,
        (tour, trial): (&[Leg], &[Leg]),
        (first, common): (usize, usize),
        limit: f64,
    ) -> f64 {
        self.scratch.copy(&self.marks[first]);
        // What follows depends on what teammates have observed by then, and on whether the budget lasts.
        let rest = if planner.depends_on_time() { 0 } else { common.saturating_sub(1) };
        let middle = &trial[first..trial.len() - rest];
        if !middle.iter().all(|&leg| planner.walk(&mut self.scratch, leg, limit)) {
            return f64::INFINITY;
        }
        if rest == 0 {
            return planner.total(&mut self.scratch);
        }
        self.rest(planner, tour.len() - rest, tour.len(), limit)
    }

    fn rest(&mut self, planner: &Planner<'_>, from: usize, end: usize, limit: f64) -> f64 {
        let (here, old) = (&self.scratch, &self.marks[from]);
        let (start, stop) = (usize::from(old.steps), usize::from(self.marks[end].steps));
        if usize::from(here.steps) + stop - start >= usize::from(planner.most_steps) {
            return f64::INFINITY;
        }
        self.changes.clear();
        self.changes.resize(stop - start + 1, 0.0);
        let blocks = here.precision.chunks(BLOCK).zip(old.precision.chunks(BLOCK));
        for (block, _) in blocks.enumerate().filter(|(_, (a, b))| a != b) {
            for place in block * BLOCK..(block * BLOCK + BLOCK).min(here.precision.len()) {
                let (mut new, mut was) = (here.precision[place], old.precision[place]);
                if new == was {
                    continue;
                }
                let row = planner.rows[place];
                let mut before = here.hidden[place] - old.hidden[place];
                let observed = &self.observed[place];
                let later = observed.partition_point(|&(step, _)| usize::from(step) <= start);
                for &(step, precision) in &observed[later..] {
                    (new, was) = (new.saturating_add(precision), was.saturating_add(precision));
                    let after = planner.table.hidden(row, new) - planner.table.hidden(row, was);
                    self.changes[usize::from(step) - start] += after - before;
                    before = after;
                    if new == was {
                        break;
                    }
                }
            }
        }
        let mut shift = here.left - old.left;
        let mut cost = here.cost;
        let mut left = here.left;
        for (&(old_left, length), &change) in self.left[start + 1..=stop].iter().zip(&self.changes[1..]) {
            shift += f64::from(change);
            left = (old_left + shift).max(0.0);
            cost += length * (planner.rate(left) + MOVE_COST);
            if cost > limit {
                return f64::INFINITY;
            }
        }
        cost + planner.tail * planner.rate(left)
    }
}

/// Places that are compared at once.
const BLOCK: usize = 16;
