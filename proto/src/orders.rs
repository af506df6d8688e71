//! Orders of the operator to single robots, gossiped by all participants like [`crate::verdict`]s.
//!
//! Of the order to all robots ([`Directive`]) and the order to one robot the newer counts for that robot.

use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

use crate::directive::{Directive, TeamOrder};
use crate::newest::{Newest, Numbered};

/// What the operator wants of a robot. Of two simultaneous orders the later one here wins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RobotOrder {
    /// It searches.
    Search,
    /// It goes to this cell, and stays there.
    Go(Cell),
    /// It returns to its base, and rests there.
    Return,
    /// It stays where it is.
    Pause,
}

impl From<TeamOrder> for RobotOrder {
    fn from(order: TeamOrder) -> Self {
        match order {
            TeamOrder::Search => Self::Search,
            TeamOrder::Return | TeamOrder::End => Self::Return,
            TeamOrder::Pause => Self::Pause,
        }
    }
}

/// An order to one robot, with its number.
pub type NumberedOrder = Numbered<RobotOrder>;

/// The orders to single robots that a participant knows, by robot. The default contains none.
pub type RobotOrders = Newest<RobotId, RobotOrder>;

impl RobotOrders {
    /// The greatest number of these orders; 0 if there are none.
    #[must_use]
    pub fn newest(&self) -> u64 {
        self.iter().map(|(_, order)| order.number).max().unwrap_or(0)
    }

    /// What a robot is to do: the newer one of its own order and that to all; of two with the same number that to all.
    #[must_use]
    pub fn current(&self, robot: RobotId, directive: &Directive) -> RobotOrder {
        match self.numbered(robot) {
            Some(own) if own.number > directive.number => own.value,
            _ => directive.order.into(),
        }
    }

    /// Gives a robot an order, as of a time in nanoseconds: it is newer than any other order to this robot and to all.
    pub fn order(&mut self, time_ns: u64, robot: RobotId, order: RobotOrder, directive: &Directive) {
        self.give(time_ns.max(directive.number.saturating_add(1)), robot, order);
    }
}

#[cfg(test)]
mod tests {
    use super::RobotOrder::{Pause, Return, Search};
    use super::*;

    fn robot(number: u16) -> RobotId {
        RobotId::new(number).unwrap()
    }

    #[test]
    fn the_newer_one_of_the_order_to_all_and_that_to_a_robot_counts() {
        let [one, two] = [robot(1), robot(2)];
        let (mut directive, mut orders) = (Directive::default(), RobotOrders::default());
        let current =
            |orders: &RobotOrders, directive: &_| [one, two].map(|robot| orders.current(robot, directive));
        directive.give(10, TeamOrder::Pause);
        assert_eq!(current(&orders, &directive), [Pause, Pause]);
        orders.order(20, one, Search, &directive);
        assert_eq!(current(&orders, &directive), [Search, Pause]);
        directive.give(30, TeamOrder::Return);
        assert_eq!(current(&orders, &directive), [Return, Return]);
        // The coordinator's clock is behind.
        orders.order(7, two, Pause, &directive);
        assert_eq!(current(&orders, &directive), [Return, Pause]);
        directive.give(orders.newest() + 1, TeamOrder::Search);
        assert_eq!(current(&orders, &directive), [Search, Search]);
    }
}
