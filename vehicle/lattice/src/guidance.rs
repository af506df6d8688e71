//! Guidance of a search.

use dragnet_search::cell::Position;

use super::metric::Metric;

/// No path leads from there to the goal, or none that is useful.
pub(super) const OUT_OF_REACH: u32 = u32::MAX;

/// An estimate of the cost from a cell to the goal.
pub(super) trait Guidance {
    /// Whether it never overestimates.
    const IS_LOWER_BOUND: bool;

    /// In units; [`OUT_OF_REACH`] where a search need not go.
    fn at(&self, at: Position) -> u32;
}

/// Distance over free ground, to the nearest goal cell. It is consistent, and needs no map: the first lower bound.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeGround {
    pub(super) metric: Metric,
    pub(super) goal: Position,
    /// Distance over free ground between the goal and the farthest goal cell.
    pub(super) tolerance: u64,
}

impl Guidance for FreeGround {
    const IS_LOWER_BOUND: bool = true;

    fn at(&self, at: Position) -> u32 {
        let east = at.column.cast_signed() - self.goal.column.cast_signed();
        let north = at.row.cast_signed() - self.goal.row.cast_signed();
        u32::try_from(self.metric.cost(east, north).saturating_sub(self.tolerance))
            .unwrap_or(OUT_OF_REACH - 1)
    }
}
