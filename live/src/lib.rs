//! The live page: a mission, running or recorded, in a browser.
//!
//! - [`view`], [`frame`]: the contents of the page, folded from the coordinator's records; the same for a running
//!   mission and for a recorded one;
//! - [`place`]: the map on the earth, and the areas drawn on it;
//! - [`replay`]: the view of a recording at any time;
//! - [`polygon`], [`ask`], `asked`: the operator's commands, from the page's messages to the mission's events;
//! - [`planning`]: the page on which a mission is planned, and its requests;
//! - [`page`]: the server of the page; [`guard`] is its access control, and `door`, the only module with a socket,
//!   limits its connections;
//! - [`foxglove`]: the same mission for Foxglove and other clients of its protocol.
//!
//! `page/` contains the page itself in TypeScript, and compiled for browsers in `page/dist/`.

pub mod ask;
mod asked;
mod assets;
mod basemap;
mod curve;
mod door;
pub mod foxglove;
pub mod frame;
pub mod guard;
#[cfg(test)]
#[path = "../../tests/mentions/mod.rs"]
mod mentions;
pub mod orders;
pub mod page;
pub mod picture;
pub mod place;
pub mod planning;
pub mod polygon;
pub mod replay;
mod searched;
mod shared;
mod socket;
mod stream;
pub mod view;
