//! The simulator.
//!
//! A [`simulation`] is a queue of events of a [`world`], a [`network`] with faults, and [`participants`] that handle
//! the events. [`episode`] runs one in this process; over Zenoh it is the same simulation with other participants.
//! [`single_robot_env`] and [`team_env`] are environments that the caller advances move by move. [`soak`] injects
//! faults and checks what must hold after every step. [`comparison`] summarizes many episodes. [`field`] has vehicles
//! with cameras in continuous space instead of the grid.

pub mod comparison;
pub mod demonstration;
pub mod episode;
pub mod faults;
pub mod field;
pub mod mixture;
pub mod network;
pub mod participants;
mod queue;
pub mod reinforcement;
pub mod simulation;
pub mod single_robot_env;
pub mod soak;
pub mod team_env;
pub mod traffic;
pub mod world;
