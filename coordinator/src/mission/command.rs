//! The operator's commands change the directive, the orders to single robots, the zones, the marks or the verdicts.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::command::Command;
use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::marks::Marks;
use dragnet_proto::message::{Activity, Heartbeat, MarkReport, OrderReport, VerdictReport, ZoneReport};
use dragnet_proto::orders::{RobotOrder, RobotOrders};
use dragnet_proto::verdict::{Decision, Verdicts};
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

use super::own::Redated;
use super::{Mission, Outcome, Record};

impl Mission {
    /// The operator's directive so far.
    #[must_use]
    pub const fn directive(&self) -> &Directive {
        &self.directive
    }

    /// The operator's orders to single robots so far.
    #[must_use]
    pub const fn orders(&self) -> &RobotOrders {
        &self.orders
    }

    pub(super) fn command(&mut self, now: MissionTime, command: Command, outcome: &mut Outcome) {
        let mut directive = self.directive.clone();
        match command {
            Command::Mark(mark, note) => {
                let mut marks = self.marks().clone();
                if marks.has_room(self.config.terrain.grid(), mark.cell_count()) {
                    marks.make(now.0, mark, note);
                    self.mark(now, &marks, outcome);
                }
                return;
            }
            Command::Unmark(id) => {
                let mut marks = self.marks().clone();
                if marks.withdraw(now.0, id) {
                    self.mark(now, &marks, outcome);
                }
                return;
            }
            Command::Judge(decision, cell) => return self.judge(now, decision, cell, outcome),
            Command::Robot(robot, order) => return self.order(now, robot, order, outcome),
            Command::Zone(zone, cells) => return self.zone(now, zone, &cells, outcome),
            Command::EndNow => {
                self.ends_now = true;
                // Robots that have the order need no other one, which none of them could acknowledge any more.
                if self.directive.order == TeamOrder::End && self.own.is_to_all(&self.directive) {
                    return;
                }
                return self.command(now, Command::Team(TeamOrder::End), outcome);
            }
            Command::Team(order) => {
                self.ends_now &= order == TeamOrder::End;
                // An order that all robots have already is not given again. One that is away may have another, newer one.
                let is_in_effect = directive.order == order && self.orders.newest() <= directive.number;
                if !is_in_effect
                    || (order == TeamOrder::End && !self.own.is_to_all(&directive))
                    || !self.early.is_known_to_all(order)
                    || !self.config.robots.iter().all(|&robot| self.is_here(robot))
                {
                    self.early.gave_all(order);
                    directive.give(now.0.max(self.orders.newest().saturating_add(1)), order);
                    self.own.gave_all(&directive);
                }
            }
            Command::Search(cells) => {
                let terrain = &self.config.terrain;
                directive.added.extend(cells.into_iter().filter(|&cell| !terrain.is_searched(cell)));
            }
        }
        self.learn(now, &directive, outcome);
    }

    /// Merges a directive, from here or from a robot; if it is news, it is published to all.
    pub(super) fn learn(&mut self, now: MissionTime, directive: &Directive, outcome: &mut Outcome) {
        if !self.directive.merge(now, directive) {
            return;
        }
        let terrain = Arc::make_mut(&mut self.config.terrain);
        let added = self.directive.added.iter().copied();
        let new = self.replica.knowledge_mut().search_also(terrain, added, self.added_prior);
        self.declarations.review(now, self.replica.knowledge().belief(), new);
        if self.early.redate(&mut self.directive, &mut self.orders, &mut self.own) {
            outcome.records.push(Record::Orders(self.order_report(now)));
        }
        self.report(now, outcome);
    }

    /// Whether the operator has ended the mission, and every robot of the team is back, with all that it has seen, or need not
    /// be. The order may be of an earlier process of this coordinator, if it has seen robots on their way back; one after which
    /// all rest already ended an earlier mission.
    #[must_use]
    pub fn is_over(&self) -> bool {
        let is_own = self.own.is_to_all(&self.directive) || self.saw_return;
        let has_all = || self.resting.are_in(self.replica.log());
        let awaited = self.awaited().filter(|_| is_own);
        awaited.is_some_and(|awaited| self.ends_now || (awaited.is_empty() && has_all()))
    }

    /// The robots that are not known to be back, if the mission is ending.
    #[must_use]
    pub fn awaited(&self) -> Option<Vec<RobotId>> {
        let is_called = |robot| self.orders.current(robot, &self.directive) == RobotOrder::Return;
        self.resting.awaited(self.config.robots.iter().copied(), &self.directive, is_called)
    }

    /// A robot has told what it does: whether it still drives by the order to end.
    pub(super) fn watch_return(&mut self, heartbeat: &Heartbeat) {
        self.resting.beat(heartbeat);
        let is_ending = self.directive.order == TeamOrder::End;
        let follows = heartbeat.directive.numbered_order() == self.directive.numbered_order();
        self.saw_return =
            is_ending && (self.saw_return || (follows && heartbeat.activity == Activity::Returning));
    }

    fn is_here(&self, robot: RobotId) -> bool {
        self.alive().any(|alive| alive == robot)
    }

    /// The clock was set forward: so are the dates of this operator's orders and zones.
    pub(super) fn set_forward(&mut self, now: MissionTime, by: Duration, outcome: &mut Outcome) {
        let redated = self.own.set_forward(by, &mut self.directive, &mut self.orders, &mut self.zones);
        if redated.to_robots {
            outcome.records.push(Record::Orders(self.order_report(now)));
        }
        if redated.zones {
            outcome.records.push(Record::Zones(self.zone_report(now)));
        }
        if redated != Redated::default() {
            self.report(now, outcome);
        }
    }

    fn order(&mut self, now: MissionTime, robot: RobotId, order: RobotOrder, outcome: &mut Outcome) {
        let is_in_effect = self.orders.current(robot, &self.directive) == order;
        if is_in_effect && self.early.is_known(robot, order) && self.is_here(robot) {
            return;
        }
        self.early.gave(robot, order);
        let mut orders = self.orders.clone();
        orders.order(now.0, robot, order, &self.directive);
        self.own.gave(robot, &orders);
        self.learn_orders(now, &orders, outcome);
    }

    /// Merges orders to single robots, from here or from a robot; if any is news, all are recorded and published to all.
    pub(super) fn learn_orders(&mut self, now: MissionTime, orders: &RobotOrders, outcome: &mut Outcome) {
        if self.orders.merge(now, orders) {
            self.early.redate(&mut self.directive, &mut self.orders, &mut self.own);
            outcome.records.push(Record::Orders(self.order_report(now)));
            self.report(now, outcome);
        }
    }

    pub(crate) fn order_report(&self, now: MissionTime) -> OrderReport {
        OrderReport { from: Participant::Coordinator, time_ns: now.0, orders: self.orders.clone() }
    }

    /// The operator's zones so far.
    #[must_use]
    pub const fn zones(&self) -> &Zones {
        &self.zones
    }

    fn zone(&mut self, now: MissionTime, zone: Zone, cells: &[Cell], outcome: &mut Outcome) {
        let mut zones = self.zones.clone();
        for &cell in cells {
            if zones.of(cell).unwrap_or(Zone::Open) != zone {
                self.early.gave_zone(cell, zone);
                zones.give(now.0, cell, zone);
                self.own.gave_zone(cell, &zones);
            }
        }
        self.learn_zones(now, &zones, outcome);
    }

    /// Merges zones, from here or from a robot; if any is news, all are recorded and published to all.
    pub(super) fn learn_zones(&mut self, now: MissionTime, zones: &Zones, outcome: &mut Outcome) {
        if self.zones.merge(now, zones) {
            self.early.rezone(&mut self.zones, &mut self.own);
            outcome.records.push(Record::Zones(self.zone_report(now)));
            self.report(now, outcome);
        }
    }

    pub(crate) fn zone_report(&self, now: MissionTime) -> ZoneReport {
        ZoneReport { from: Participant::Coordinator, time_ns: now.0, zones: self.zones.clone() }
    }

    /// The operator's verdicts so far.
    #[must_use]
    pub fn verdicts(&self) -> &Verdicts {
        self.replica.knowledge().verdicts()
    }

    pub(crate) fn verdict_report(&self, now: MissionTime) -> VerdictReport {
        VerdictReport { from: Participant::Coordinator, time_ns: now.0, verdicts: self.verdicts().clone() }
    }

    /// A find that is declared again can be dismissed again; any other decision is made once.
    fn judge(&mut self, now: MissionTime, decision: Decision, cell: Cell, outcome: &mut Outcome) {
        let is_known = match (decision, self.verdicts().decision(cell)) {
            (Decision::Undone, known) => known.is_none(),
            (Decision::Dismissed, Some(Decision::Dismissed)) => !self.declarations.contains(cell),
            (decision, known) => known == Some(decision),
        };
        if is_known {
            return;
        }
        let verdicts = self.replica.knowledge().verdicts_with(now.0, cell, decision);
        let judged = self.replica.knowledge_mut().judge(now, &verdicts);
        self.judged(now, &judged, outcome);
    }

    /// The verdicts on these cells have changed, by the operator here or by what a robot knows: they are recorded and
    /// published to all.
    pub(super) fn judged(&mut self, now: MissionTime, cells: &[Cell], outcome: &mut Outcome) {
        if cells.is_empty() {
            return;
        }
        self.declarations.review(now, self.replica.knowledge().belief(), cells.iter().copied());
        outcome.records.push(Record::Verdicts(self.verdict_report(now)));
        self.report(now, outcome);
    }

    /// The operator's marks so far.
    #[must_use]
    pub fn marks(&self) -> &Marks {
        self.replica.knowledge().marks()
    }

    pub(crate) fn mark_report(&self, now: MissionTime) -> MarkReport {
        MarkReport { from: Participant::Coordinator, time_ns: now.0, marks: self.marks().clone() }
    }

    /// Marks as the operator has changed them here.
    fn mark(&mut self, now: MissionTime, marks: &Marks, outcome: &mut Outcome) {
        let grid = self.config.terrain.grid();
        if let Some(cells) = self.replica.knowledge_mut().mark(now, marks, grid) {
            self.marked(now, cells, outcome);
        }
    }

    /// Marks have changed that concern these cells, by the operator here or by what a robot knows: they are recorded and
    /// published to all.
    pub(super) fn marked(&mut self, now: MissionTime, cells: BTreeSet<Cell>, outcome: &mut Outcome) {
        self.declarations.review(now, self.replica.knowledge().belief(), cells);
        outcome.records.push(Record::Marks(self.mark_report(now)));
        self.report(now, outcome);
    }
}
