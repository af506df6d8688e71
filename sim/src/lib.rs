//! The world that stands in for the real one.
//!
//! A simulation ([`simulation`]) is a queue of events over a world, a network with faults, and a participants ([`participants`]) that is
//! told what happens and says what it does. [`soak`] runs teams through faults and checks what must hold at every step.
//! [`episode`] runs one in this process; over the network it is the same simulation with another participants. [`solo`] and
//! [`expedition`] let somebody else decide, move by move. [`comparison`] is what many episodes come to. [`field`] has
//! vehicles with cameras in continuous space instead of the grid.

pub mod comparison;
pub mod demonstration;
pub mod episode;
pub mod faults;
pub mod field;
pub mod mixture;
pub mod network;
pub mod participants;
mod queue;
pub mod simulation;
pub mod single_robot_env;
pub mod soak;
pub mod team_env;
pub mod world;
