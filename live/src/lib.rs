//! The live page: a mission, running or recorded, in a browser.
//!
//! - [`view`], [`frame`]: what the page shows, folded from the coordinator's records; the same for a running mission and
//!   for a recorded one;
//! - [`replay`]: a recording, at any time of it;
//! - [`polygon`], [`ask`]: what a person asks for, from the page's words to the mission's;
//! - [`page`]: the server of the page; [`guard`] says who may do what, and `door`, which alone has a socket, who comes in.
//!
//! `page/` holds the page itself, in TypeScript, and as what browsers run in `page/dist/`.

pub mod ask;
mod assets;
mod curve;
mod door;
pub mod frame;
pub mod guard;
pub mod page;
pub mod polygon;
pub mod replay;
mod shared;
mod stream;
pub mod view;
