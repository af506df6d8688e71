//! Orders and zones of this operator, and when they were given.
//!
//! A coordinator that has restarted, or whose robots have begun without their journals, counts the mission's time anew until
//! it receives a longer one. What the operator ordered before would then be older than what other robots bring that were
//! away. So its date goes forward with the clock.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_proto::directive::Directive;
use dragnet_proto::newest::Newest;
use dragnet_proto::orders::RobotOrders;
use dragnet_proto::zones::Zones;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

/// The numbers of the orders and zones that were given in this process: those of others keep their dates.
#[derive(Debug, Default)]
pub(super) struct Own {
    to_all: Option<u64>,
    to_robots: BTreeMap<RobotId, u64>,
    zones: BTreeMap<Cell, u64>,
}

/// What has another date now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Redated {
    pub(super) to_all: bool,
    pub(super) to_robots: bool,
    pub(super) zones: bool,
}

impl Own {
    /// The directive's order is this operator's.
    pub(super) const fn gave_all(&mut self, directive: &Directive) {
        self.to_all = Some(directive.number);
    }

    /// Whether the directive's order is this operator's.
    pub(super) fn is_to_all(&self, directive: &Directive) -> bool {
        self.to_all == Some(directive.number)
    }

    /// The order to a robot is this operator's.
    pub(super) fn gave(&mut self, robot: RobotId, orders: &RobotOrders) {
        self.to_robots.extend(orders.numbered(robot).map(|order| (robot, order.number)));
    }

    /// The zone of a cell is this operator's.
    pub(super) fn gave_zone(&mut self, cell: Cell, zones: &Zones) {
        self.zones.extend(zones.numbered(cell).map(|zone| (cell, zone.number)));
    }

    /// Dates all that still counts later.
    pub(super) fn set_forward(
        &mut self,
        by: Duration,
        directive: &mut Directive,
        orders: &mut RobotOrders,
        zones: &mut Zones,
    ) -> Redated {
        let by = u64::try_from(by.as_nanos()).unwrap_or(u64::MAX);
        self.to_all =
            self.to_all.filter(|&number| number == directive.number).map(|number| number.saturating_add(by));
        if let Some(number) = self.to_all {
            directive.number = number;
        }
        Redated {
            to_all: self.to_all.is_some(),
            to_robots: set_forward(by, &mut self.to_robots, orders),
            zones: set_forward(by, &mut self.zones, zones),
        }
    }
}

fn set_forward<K: Copy + Ord, V: Clone + Ord>(
    by: u64,
    own: &mut BTreeMap<K, u64>,
    known: &mut Newest<K, V>,
) -> bool {
    own.retain(|&key, number| match known.numbered(key) {
        Some(entry) if entry.number == *number => {
            *number = number.saturating_add(by);
            known.give(*number, key, entry.value);
            true
        }
        _ => false,
    });
    !own.is_empty()
}
