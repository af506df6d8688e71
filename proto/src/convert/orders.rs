//! The operator's orders to single robots to the wire and back.

use dragnet_search::observation::{RobotId, Source};

use super::check::{self, Check};
use super::error::ConvertError;
use crate::dragnet_msgs as wire;
use crate::message::OrderReport;
use crate::orders::{NumberedOrder, RobotOrder, RobotOrders};

impl From<&OrderReport> for wire::Orders {
    fn from(report: &OrderReport) -> Self {
        let OrderReport { from, time_ns, orders } = report;
        let (mut codes, mut cells) = (Vec::new(), Vec::new());
        for (_, NumberedOrder { value: order, .. }) in orders.iter() {
            let (code, cell) = match order {
                RobotOrder::Search => (0, 0),
                RobotOrder::Go(cell) => (1, cell.number()),
                RobotOrder::Return => (2, 0),
                RobotOrder::Pause => (3, 0),
            };
            codes.push(code);
            cells.push(cell);
        }
        Self {
            version: wire::VERSION,
            robot: Source::from(*from).number(),
            time_ns: *time_ns,
            robots: orders.iter().map(|(robot, _)| robot.number()).collect(),
            numbers: orders.iter().map(|(_, it)| it.number).collect(),
            orders: codes,
            cells,
        }
    }
}

impl Check {
    pub(super) fn orders(self, wire: &wire::Orders) -> Result<OrderReport, ConvertError> {
        self.version(wire.version)?;
        let expected = wire.robots.len();
        self.at_most(usize::from(self.robots), "robots", expected)?;
        self.same_length("numbers", wire.numbers.len(), "robots", expected)?;
        self.same_length("orders", wire.orders.len(), "robots", expected)?;
        self.same_length("cells", wire.cells.len(), "robots", expected)?;
        self.ascending("robots", &wire.robots)?;
        let orders =
            (0..expected).map(|index| self.robot_order(index, wire)).collect::<Result<RobotOrders, _>>()?;
        Ok(OrderReport { from: Source::numbered(wire.robot).into(), time_ns: wire.time_ns, orders })
    }

    fn robot_order(
        self,
        index: usize,
        wire: &wire::Orders,
    ) -> Result<(RobotId, NumberedOrder), ConvertError> {
        let robot = check::robot(self.at_entry("robots", index), wire.robots[index])?;
        let order = match wire.orders[index] {
            0 => RobotOrder::Search,
            1 => RobotOrder::Go(self.cell(self.at_entry("cells", index), wire.cells[index])?),
            2 => RobotOrder::Return,
            3 => RobotOrder::Pause,
            found => {
                let allowed = "0 search, 1 go, 2 return, 3 pause";
                return Err(ConvertError::Alternative { at: self.at_entry("orders", index), found, allowed });
            }
        };
        Ok((robot, NumberedOrder { number: wire.numbers[index], value: order }))
    }
}
