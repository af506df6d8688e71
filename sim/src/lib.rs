//! The world that stands in for the real one.
//!
//! A simulation ([`simulation`]) is a queue of events over a world, a network with faults, and a crew ([`crew`]) that is
//! told what happens and says what it does. [`soak`] runs teams through faults and checks what must hold at every step.
//! [`episode`] runs one in this process; over the network it is the same simulation with another crew. [`solo`] and
//! [`expedition`] let somebody else decide, move by move. [`comparison`] is what many episodes come to. [`field`] has
//! vehicles with cameras in continuous space instead of the grid.

pub mod comparison;
pub mod crew;
pub mod demonstration;
pub mod episode;
pub mod expedition;
pub mod faults;
pub mod field;
pub mod mixture;
pub mod network;
mod queue;
pub mod simulation;
pub mod soak;
pub mod solo;
pub mod world;
