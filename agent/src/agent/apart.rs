//! A robot that keeps apart from its teammates: it plans around those that stand, does not cross the plans of those that move,
//! and makes way for them. Without a separation none of this has an effect.

use std::collections::BTreeSet;
use std::sync::Arc;

use dragnet_proto::message::Activity;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::route::ShortestPathTree;
use dragnet_search::situation::leading_cells_with_way_home;
use dragnet_search::terrain::{Ground, Terrain};

use super::Agent;
use crate::clearance::{AHEAD, Clearance, Other};
use crate::home::Home;

/// Steps after which a robot that waits looks again whether its way is free: messages may be lost.
const PATIENCE_STEPS: u32 = 4;
/// Steps in which a robot that enters no cell is taken to be held by another: it may only be slow.
const HELD_STEPS: u32 = 3;
/// Later than any plan.
const ALL: MissionTime = MissionTime(u64::MAX);

impl Agent {
    /// Whether the cells have changed that teammates who stand keep this robot out of.
    pub(super) fn learns_who_stands(&mut self, now: MissionTime) -> bool {
        let separation = self.config.separation;
        if !separation.is_kept() {
            return false;
        }
        let grid = self.config.terrain.grid();
        let standing = self.team.standing(self.view(now));
        let mut occupied: BTreeSet<Cell> = standing.flat_map(|cell| separation.around(grid, cell)).collect();
        if let Some(cell) = &self.cell {
            occupied.remove(cell);
        }
        let has_changed = occupied != self.occupied;
        self.occupied = occupied;
        has_changed
    }

    /// A map on which these cells are closed.
    pub(super) fn without_occupied(&self, terrain: &Arc<Terrain>) -> Arc<Terrain> {
        if self.occupied.is_empty() {
            return Arc::clone(terrain);
        }
        let closed = |&cell: &Cell| (cell, Ground { traversable: false, ..terrain.ground(cell) });
        Arc::new(terrain.with_ground(self.occupied.iter().map(closed)))
    }

    /// What a robot does to which no way is open: it waits if teammates may clear one, since some stand in the way and some move.
    pub(super) fn unless_occupied(&self, otherwise: Activity) -> Activity {
        let may_clear = !self.occupied.is_empty() && self.team.is_anything_planned();
        if may_clear { Activity::Waiting } else { otherwise }
    }

    /// A path to the same cell around those who stand in its way; empty if there is none.
    pub(super) fn around_occupied(&self, cell: Cell, path: Vec<Cell>) -> Vec<Cell> {
        if !path.iter().any(|it| self.occupied.contains(it)) {
            return path;
        }
        let ways = ShortestPathTree::from(&self.ground, self.config.connectivity, cell);
        path.last().map_or_else(Vec::new, |&to| ways.path(to))
    }

    /// The part of what it wants to do that keeps it apart from its teammates; all of them have decided before it.
    pub(super) fn keep_apart(
        &self,
        now: MissionTime,
        cell: Cell,
        (activity, mut path): (Activity, Vec<Cell>),
    ) -> (Activity, Vec<Cell>) {
        let may_move = match activity {
            Activity::Searching
            | Activity::Returning
            | Activity::Sent
            | Activity::Leaving
            | Activity::GivingWay
            | Activity::Waiting
            | Activity::Cleared
            | Activity::Stuck => true,
            Activity::Spent | Activity::Paused | Activity::Recalled | Activity::Holding => false,
        };
        let others = if may_move { self.others(now, ALL) } else { Vec::new() };
        if others.is_empty() {
            return (activity, path);
        }
        let clearance = self.clearance(&others);
        if activity.is_under_way() {
            path.truncate(clearance.clear_cells(cell, &path));
            if !path.is_empty() {
                return (activity, path);
            }
        }
        let aside = if clearance.is_in_the_way(cell) {
            let ways = ShortestPathTree::from(&self.ground, self.config.connectivity, cell);
            let mut aside = self.within_budget(now, cell, clearance.way_aside(&ways));
            aside.truncate(clearance.clear_cells(cell, &aside));
            aside
        } else {
            Vec::new()
        };
        match (aside.is_empty(), activity.is_rest()) {
            (false, _) => (Activity::GivingWay, aside),
            (true, true) => (activity, aside),
            (true, false) => (Activity::Waiting, aside),
        }
    }

    /// A path if the budget leaves all of it, and the way home.
    fn within_budget(&self, now: MissionTime, cell: Cell, path: Vec<Cell>) -> Vec<Cell> {
        let (grid, remaining_cells) = (self.ground.grid(), self.remaining_cells(now));
        let ways_home = self.home.as_ref().map(Home::ways);
        let leading = leading_cells_with_way_home(grid, cell, &path, ways_home, remaining_cells);
        if leading == path.len() { path } else { Vec::new() }
    }

    /// When a robot that waits for others looks again.
    pub(super) fn waits_until(&self, now: MissionTime, activity: Activity) -> Option<MissionTime> {
        let is_kept = activity == Activity::Waiting && self.config.separation.is_kept();
        is_kept.then(|| now + self.config.step_time() * PATIENCE_STEPS + self.config.turn())
    }

    /// Whether a teammate is or comes in the way of its next cells that knew nothing of its plan when it decided.
    pub(super) fn is_way_blocked(&self, now: MissionTime) -> bool {
        let Some(cell) = self.cell else { return false };
        let others = self.others(now, self.decided);
        if others.is_empty() {
            return false;
        }
        let next = &self.plan[..self.plan.len().min(AHEAD)];
        let (grid, separation) = (self.config.terrain.grid(), self.config.separation);
        let is_occupied = |other: &Other| {
            other.path.is_empty() && next.iter().any(|&it| !separation.is_apart(grid, it, other.cell))
        };
        others.iter().any(is_occupied) || self.clearance(&others).clear_cells(cell, next) < next.len()
    }

    /// Until when its vehicle may be held by others before it decides anew, if it is under way and robots keep apart.
    pub(super) fn held_until(&self) -> Option<MissionTime> {
        let is_held =
            self.config.separation.is_kept() && self.activity.is_under_way() && !self.plan.is_empty();
        is_held.then(|| self.arrived.max(self.decided) + self.config.step_time() * HELD_STEPS)
    }

    /// Whether its vehicle has been held for that long. Then its next cell is barred; if a lost teammate was near it last, that
    /// one still stands there, and all cells are that are too near to it.
    pub(super) fn give_up_if_held(&mut self, now: MissionTime) -> bool {
        let is_held = self.held_until().is_some_and(|until| now >= until);
        if let Some(&next) = self.plan.first().filter(|_| is_held) {
            let (grid, separation) = (self.config.terrain.grid(), self.config.separation);
            let near =
                self.team.last_places(self.view(now)).filter(|&it| !separation.is_apart(grid, it, next));
            let barred: BTreeSet<Cell> =
                near.flat_map(|it| separation.around(grid, it)).chain([next]).collect();
            self.bar(now, barred);
        }
        is_held
    }

    fn others(&self, now: MissionTime, since: MissionTime) -> Vec<Other> {
        if self.config.separation.is_kept() {
            self.team.others(self.view(now), (since, self.id()))
        } else {
            Vec::new()
        }
    }

    fn clearance<'a>(&self, others: &'a [Other]) -> Clearance<'a> {
        Clearance {
            grid: self.config.terrain.grid(),
            separation: self.config.separation,
            others,
            step: self.config.terrain.cell_meters() / self.config.robot.class.speed_meters_per_second,
        }
    }
}
