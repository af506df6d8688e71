//! Enumerations of the Python interface: how searches are scored, ended and controlled.

use dragnet_search::cell::Grid;
use dragnet_sim::simulation::End;
use dragnet_sim::single_robot_env::features::{Company, Frame, Layout, Order};
use dragnet_sim::single_robot_env::{Control, Reward};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// What happens when an action is not available.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Masked {
    /// An exception.
    Error,
    /// The robot stays where it is, at the cost of one cell.
    Stay,
}

const CONTROLS: [(&str, Control); 2] = [("waypoint", Control::Waypoint), ("step", Control::Step)];
const REWARDS: [(&str, Reward); 3] =
    [("entropy", Reward::Entropy), ("found", Reward::Found), ("f1", Reward::F1)];
const ENDS: [(&str, End); 2] = [("all_found", End::AllFound), ("resting", End::Resting)];
const MASKED: [(&str, Masked); 2] = [("error", Masked::Error), ("stay", Masked::Stay)];
/// What is observed, and how its features are ordered; a belief has none, and shows none of these.
const OBSERVATIONS: [(&str, Order); 4] =
    [("dict", Order::Named), ("planes", Order::Planes), ("graph", Order::Nodes), ("belief", Order::Named)];
const FRAMES: [(&str, Frame); 2] = [("map", Frame::Map), ("robot", Frame::Robot)];

/// The layout of observations on a map.
pub(crate) fn layout(observation: &str, frame: &str, company: Company, grid: Grid) -> PyResult<Layout> {
    let order = choose("observation", observation, &OBSERVATIONS)?;
    let frame = choose("frame", frame, &FRAMES)?;
    // Beliefs are those of the map.
    let frame = if is_belief(observation) { Frame::Map } else { frame };
    Ok(Layout::new(order, frame, company, grid))
}

/// Whether the exact belief is observed.
pub(crate) fn is_belief(observation: &str) -> bool {
    observation == "belief"
}

pub(crate) fn control(word: &str) -> PyResult<Control> {
    choose("control", word, &CONTROLS)
}

pub(crate) fn reward(word: &str) -> PyResult<Reward> {
    choose("reward", word, &REWARDS)
}

pub(crate) fn end(word: &str) -> PyResult<End> {
    choose("end", word, &ENDS)
}

pub(crate) fn masked(word: &str) -> PyResult<Masked> {
    choose("masked_action", word, &MASKED)
}

fn choose<T: Copy>(name: &str, word: &str, choices: &[(&str, T)]) -> PyResult<T> {
    choices.iter().find(|(choice, _)| *choice == word).map(|&(_, value)| value).ok_or_else(|| {
        let allowed: Vec<String> = choices.iter().map(|(choice, _)| format!("{choice:?}")).collect();
        PyValueError::new_err(format!("{name}={word:?}; allowed are {}", allowed.join(", ")))
    })
}
