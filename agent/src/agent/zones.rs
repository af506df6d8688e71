//! A robot and ground that the map does not know to be closed: the operator's zones, which it leaves if it is there, and
//! cells that its vehicle could not enter. It plans around both.

use std::sync::Arc;

use dragnet_proto::message::{Activity, Message};
use dragnet_proto::state_machine::Effects;
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::route::ShortestPathTree;
use dragnet_search::terrain::Terrain;

use super::Agent;

impl Agent {
    /// The cells that the operator has closed, as far as known.
    pub fn closed(&self) -> impl Iterator<Item = Cell> + '_ {
        self.zones.cells(Zone::NoGo)
    }

    /// Applies new zones of the operator. A plan into a no-go zone ends here, any other in the next cell.
    pub(super) fn keep_out(&mut self, now: MissionTime, zones: &Zones, effects: &mut Effects<Message>) {
        if !self.zones.merge(now, zones) {
            return;
        }
        self.survey();
        self.is_overtaken = true;
        let is_cut_off = self.cell.iter().chain(&self.plan).any(|&cell| self.is_closed(cell));
        // One that holds may now have a way to where it is sent.
        if is_cut_off || self.activity == Activity::Holding || self.has_nothing_to_do() {
            self.decide(now, effects);
        }
    }

    /// Its vehicle has given up its route, since it could not enter these cells: it decides anew where it stands. Its own
    /// cell it has entered.
    pub(super) fn bar(&mut self, now: MissionTime, cells: impl IntoIterator<Item = Cell>) {
        for cell in cells {
            if self.cell != Some(cell) {
                self.barred.add(now, cell);
            }
        }
        self.survey();
        self.plan.clear();
    }

    /// Whether a cell is in a no-go zone.
    pub(super) fn is_closed(&self, cell: Cell) -> bool {
        self.zones.of(cell) == Some(Zone::NoGo)
    }

    /// The map, the zones, the barred cells, the cells in which teammates stand or what is hidden have changed.
    pub(super) fn survey(&mut self) {
        let mut ground = Arc::clone(&self.config.terrain);
        if let Some(line_of_sight) = &self.line_of_sight {
            let terrain = Terrain::clone(&ground);
            ground = Arc::new(terrain.with_line_of_sight(line_of_sight.clone()));
        }
        if !self.zones.is_empty() {
            ground = Arc::new(self.zones.on(&ground));
        }
        if !self.barred.is_empty() {
            ground = Arc::new(self.barred.on(&ground));
        }
        self.ground = self.without_occupied(&ground);
        self.open_ground = ground;
        self.home = self.base.filter(|_| self.home.is_some()).map(|base| self.home_to(base));
    }

    /// What a robot in a no-go zone does: it takes the shortest way out, as if the zone were open.
    pub(super) fn leave(&self, cell: Cell) -> (Activity, Vec<Cell>) {
        let path = self.way_out(cell);
        (if path.is_empty() { Activity::Stuck } else { Activity::Leaving }, path)
    }

    /// A base, or of the cells in reach the nearest to it, as if no-go zones and barred cells were open.
    pub(super) fn haven(&self, base: Cell) -> Cell {
        let Some(cell) = self.cell.filter(|_| !Arc::ptr_eq(&self.open_ground, &self.config.terrain)) else {
            return base;
        };
        let here = self.way_out(cell).last().copied().unwrap_or(cell);
        let reached = ShortestPathTree::from(&self.open_ground, self.config.connectivity, here);
        if here == base || reached.length(base).is_finite() {
            return base;
        }
        let near = reached.candidates().iter().copied().chain([here]);
        nearest(&self.ways_if_open(base), near).unwrap_or(here)
    }

    /// The shortest way from a cell out of no-go zones; empty if it is in none, or no way leads out.
    fn way_out(&self, cell: Cell) -> Vec<Cell> {
        if !self.is_closed(cell) {
            return Vec::new();
        }
        let ways = self.ways_if_open(cell);
        let outside = ways.candidates().iter().copied().filter(|&to| !self.is_closed(to));
        nearest(&ways, outside).map_or_else(Vec::new, |to| ways.path(to))
    }

    fn ways_if_open(&self, from: Cell) -> ShortestPathTree {
        ShortestPathTree::from(&self.config.terrain, self.config.connectivity, from)
    }
}

/// Of the cells in reach the one with the shortest way; of equally near ones the smallest.
fn nearest(ways: &ShortestPathTree, cells: impl Iterator<Item = Cell>) -> Option<Cell> {
    let in_reach = cells.filter(|&cell| ways.length(cell).is_finite());
    in_reach.min_by(|&a, &b| ways.length(a).total_cmp(&ways.length(b)).then(a.cmp(&b)))
}
