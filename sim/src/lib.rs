//! The world that stands in for the real one.
//!
//! A simulation ([`simulation`]) is a queue of events over a world, a network with faults, and a crew ([`crew`]) that is
//! told what happens and says what it does. [`soak`] runs teams through faults and checks what must hold at every step. [`episode`] runs one in this process; over the network it is the
//! same simulation with another crew.

pub mod crew;
pub mod demonstration;
pub mod episode;
pub mod faults;
pub mod mixture;
pub mod network;
mod queue;
pub mod simulation;
pub mod soak;
pub mod solo;
pub mod world;
