//! Orders of the operator to single robots, gossiped by all participants like [`crate::verdict`]s.
//!
//! Of the order to all robots ([`Directive`]) and the order to one robot the newer counts for that robot. Merging is
//! commutative and idempotent: of two orders to one robot the newer one counts, in any order of arrival.

use std::collections::BTreeMap;

use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

use crate::directive::{Directive, MOST_AHEAD, TeamOrder};

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
            TeamOrder::Return => Self::Return,
            TeamOrder::Pause => Self::Pause,
        }
    }
}

/// An order to one robot. The order of its fields is the order in which orders count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct NumberedOrder {
    /// When it was given: nanoseconds of mission time, or one more than the greatest number before if the coordinator's
    /// clock is behind.
    pub number: u64,
    /// The order.
    pub order: RobotOrder,
}

/// The orders to single robots that a participant knows, by robot. The default contains none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RobotOrders(BTreeMap<RobotId, NumberedOrder>);

impl RobotOrders {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All orders, by robot.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (RobotId, NumberedOrder)> + '_ {
        self.0.iter().map(|(&robot, &order)| (robot, order))
    }

    /// Whether this order, or a newer one to its robot, is known.
    #[must_use]
    pub fn includes(&self, robot: RobotId, order: NumberedOrder) -> bool {
        self.0.get(&robot).is_some_and(|known| *known >= order)
    }

    /// The greatest number of these orders; 0 if there are none.
    #[must_use]
    pub fn newest(&self) -> u64 {
        self.0.values().map(|it| it.number).max().unwrap_or(0)
    }

    /// What a robot is to do: the newer one of its own order and that to all; of two with the same number that to all.
    #[must_use]
    pub fn current(&self, robot: RobotId, directive: &Directive) -> RobotOrder {
        match self.0.get(&robot) {
            Some(own) if own.number > directive.number => own.order,
            _ => directive.order.into(),
        }
    }

    /// Gives a robot an order, as of a time in nanoseconds: it is newer than any other order to this robot and to all.
    pub fn give(&mut self, time_ns: u64, robot: RobotId, order: RobotOrder, directive: &Directive) {
        let known = self.0.get(&robot).map_or(0, |known| known.number).max(directive.number);
        let number = time_ns.max(known.saturating_add(1));
        self.0.insert(robot, NumberedOrder { number, order });
    }

    /// Merges the orders that another participant knows; returns whether any is news. One dated too far ahead of its
    /// reception counts as dated earlier, as in [`Directive::merge`].
    pub fn merge(&mut self, now: MissionTime, other: &Self) -> bool {
        let most = (now + MOST_AHEAD).0;
        let mut is_news = false;
        for (robot, order) in other.iter() {
            let order = NumberedOrder { number: order.number.min(most), ..order };
            if !self.includes(robot, order) {
                self.0.insert(robot, order);
                is_news = true;
            }
        }
        is_news
    }
}

impl FromIterator<(RobotId, NumberedOrder)> for RobotOrders {
    fn from_iter<I: IntoIterator<Item = (RobotId, NumberedOrder)>>(orders: I) -> Self {
        Self(orders.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Grid;

    use super::RobotOrder::{Go, Pause, Return, Search};
    use super::*;

    fn robot(number: u16) -> RobotId {
        RobotId::new(number).unwrap()
    }

    fn orders(given: impl IntoIterator<Item = (u16, u64, RobotOrder)>) -> RobotOrders {
        let given = given.into_iter();
        given.map(|(to, number, order)| (robot(to), NumberedOrder { number, order })).collect()
    }

    #[test]
    fn any_order_of_arrival_gives_the_same_orders() {
        let there = Grid::new(2, 2).unwrap().cells().last().unwrap();
        let reported = [
            orders([(1, 5, Pause), (2, 3, Go(there))]),
            orders([(1, 5, Search), (3, 1, Return)]),
            orders([(1, 4, Return), (2, 4, Search)]),
        ];
        let expected = orders([(1, 5, Pause), (2, 4, Search), (3, 1, Return)]);
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut known = RobotOrders::default();
            for index in order {
                known.merge(MissionTime::START, &reported[index]);
            }
            assert_eq!(known, expected, "{order:?}");
            assert!(reported.iter().all(|old| !known.merge(MissionTime(9), old)), "nothing is news twice");
        }
    }

    #[test]
    fn the_newer_one_of_the_order_to_all_and_that_to_a_robot_counts() {
        let [one, two] = [robot(1), robot(2)];
        let (mut directive, mut orders) = (Directive::default(), RobotOrders::default());
        let current =
            |orders: &RobotOrders, directive: &_| [one, two].map(|robot| orders.current(robot, directive));
        directive.give(10, TeamOrder::Pause);
        assert_eq!(current(&orders, &directive), [Pause, Pause]);
        orders.give(20, one, Search, &directive);
        assert_eq!(current(&orders, &directive), [Search, Pause]);
        directive.give(30, TeamOrder::Return);
        assert_eq!(current(&orders, &directive), [Return, Return]);
        // The coordinator's clock is behind.
        orders.give(7, two, Pause, &directive);
        assert_eq!(current(&orders, &directive), [Return, Pause]);
        directive.give(orders.newest() + 1, TeamOrder::Search);
        assert_eq!(current(&orders, &directive), [Search, Search]);
    }

    #[test]
    fn an_order_at_the_end_of_time_can_be_followed_by_another() {
        let mut known = RobotOrders::default();
        assert!(known.merge(MissionTime(3), &orders([(1, u64::MAX, Pause)])));
        known.give(7, robot(1), Search, &Directive::default());
        assert_eq!(known.current(robot(1), &Directive::default()), Search);
    }
}
