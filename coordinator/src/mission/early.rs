//! Orders and zones that the operator gave before any robot was heard.
//!
//! The clock of a coordinator that has just started may be far behind that of the robots, so that an order of now has a
//! smaller number than one that they have known for long. The operator gave it later than whatever they bring, so it is
//! dated anew when they bring something newer. Messages set the clock forward: orders that are given once a robot was
//! heard are dated rightly by themselves.

use std::collections::{BTreeMap, BTreeSet};

use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::orders::{RobotOrder, RobotOrders};
use dragnet_proto::zones::{Zone, Zones};
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

use super::own::Own;

/// The operator's orders of this process that may have to be dated anew: each as long as it is the last for its target.
#[derive(Debug, Default)]
pub(super) struct Early {
    has_heard: bool,
    to_all: Option<TeamOrder>,
    to_robots: BTreeMap<RobotId, RobotOrder>,
    zones: BTreeMap<Cell, Zone>,
    /// Robots with an order of their own since that to all, early or not.
    ordered: BTreeSet<RobotId>,
}

impl Early {
    /// A robot was heard.
    pub(super) const fn hear(&mut self) {
        self.has_heard = true;
    }

    /// Whether an order to all that is in effect here is so for the robots too, as far as can be known: before any was
    /// heard only the operator's own is.
    pub(super) fn is_known_to_all(&self, order: TeamOrder) -> bool {
        self.has_heard || self.to_all == Some(order)
    }

    /// The same of an order that is in effect for one robot.
    pub(super) fn is_known(&self, robot: RobotId, order: RobotOrder) -> bool {
        let given = self.to_robots.get(&robot).copied().or(self.to_all.map(Into::into));
        self.has_heard || given == Some(order)
    }

    /// The operator gives all robots an order.
    pub(super) fn gave_all(&mut self, order: TeamOrder) {
        self.to_all = (!self.has_heard).then_some(order);
        self.to_robots.clear();
        self.ordered.clear();
    }

    /// The operator gives a robot an order.
    pub(super) fn gave(&mut self, robot: RobotId, order: RobotOrder) {
        self.ordered.insert(robot);
        if self.has_heard {
            self.to_robots.remove(&robot);
        } else {
            self.to_robots.insert(robot, order);
        }
    }

    /// The operator makes a cell part of a zone.
    pub(super) fn gave_zone(&mut self, cell: Cell, zone: Zone) {
        if self.has_heard {
            self.zones.remove(&cell);
        } else {
            self.zones.insert(cell, zone);
        }
    }

    /// Makes early zones newer than different ones that were merged.
    pub(super) fn rezone(&self, zones: &mut Zones, own: &mut Own) {
        for (&cell, &zone) in &self.zones {
            if zones.of(cell) != Some(zone) {
                zones.give(0, cell, zone);
                own.gave_zone(cell, zones);
            }
        }
    }

    /// Makes early orders newer than different ones that were merged; returns whether one to a single robot was.
    pub(super) fn redate(&self, directive: &mut Directive, orders: &mut RobotOrders, own: &mut Own) -> bool {
        if let Some(order) = self.to_all {
            let rivals = orders.iter().filter(|(robot, rival)| {
                rival.value != order.into()
                    && rival.number > directive.number
                    && !self.ordered.contains(robot)
            });
            let newest = rivals.map(|(_, rival)| rival.number).max();
            if newest.is_some() || directive.order != order {
                directive.give(newest.unwrap_or(0).saturating_add(1), order);
                own.gave_all(directive);
            }
        }
        let mut is_redated = false;
        for (&robot, &order) in &self.to_robots {
            if orders.current(robot, directive) != order {
                // One more than what was newer: what the operator has ordered since is dated by the clock.
                orders.order(0, robot, order, directive);
                own.gave(robot, orders);
                is_redated = true;
            }
        }
        is_redated
    }
}
