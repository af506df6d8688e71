//! What teams know together, for critics: features of cells, and where the robots are.

use dragnet_sim::single_robot_env::features::Layout;
use dragnet_sim::team_env::TerminationReason;
use numpy::PyArray2;
use pyo3::prelude::*;

use super::Lane;
use crate::{arrays, pool};

/// What the whole team of each search knows.
pub(super) struct Known {
    layout: Layout,
    /// Features of the layout, then a plane for each robot, 1 in its cell while it searches: shape
    /// `[searches, (features + robots) * cells]`.
    pub(super) numbers: Py<PyArray2<f32>>,
}

impl Known {
    pub(super) fn new(py: Python<'_>, searches: usize, robots: usize, layout: Layout) -> PyResult<Self> {
        let cells = layout.len() / layout.features().len();
        let numbers = arrays::zeros(py, (searches, layout.len() + robots * cells))?;
        Ok(Self { layout, numbers })
    }

    /// Writes it, in parallel.
    pub(super) fn write(&self, py: Python<'_>, lanes: Vec<&mut Lane>) -> PyResult<()> {
        let mut numbers = arrays::borrow(self.numbers.bind(py))?;
        let numbers = arrays::slice(&mut numbers)?;
        let part = numbers.len() / lanes.len();
        let work = lanes.into_iter().zip(numbers.chunks_exact_mut(part)).collect();
        pool::map(py, work, super::LEAST_TOGETHER, |(lane, numbers)| self.draw(lane, numbers));
        Ok(())
    }

    fn draw(&self, lane: &mut Lane, numbers: &mut [f32]) {
        let (known, robots) = numbers.split_at_mut(self.layout.len());
        if std::mem::replace(&mut lane.is_known_drawn, true) {
            lane.env.redraw_known(&self.layout, known);
        } else {
            lane.env.draw_known(&self.layout, known);
        }
        robots.fill(0.0);
        let cells = known.len() / self.layout.features().len();
        for (robot, plane) in robots.chunks_exact_mut(cells).enumerate() {
            if lane.env.termination_reasons()[robot] == TerminationReason::Searching {
                plane[lane.env.cell(robot).index()] = 1.0;
            }
        }
    }
}
