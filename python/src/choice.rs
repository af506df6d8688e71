//! Enumerations of the Python interface: how searches are scored, ended and controlled.

use dragnet_sim::simulation::End;
use dragnet_sim::single_robot_env::Reward;
use dragnet_sim::single_robot_env::buffers::Control;
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
