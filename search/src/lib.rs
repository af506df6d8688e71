//! The algorithms of active search, and nothing else.
//!
//! This crate knows no clock, socket, file, thread or unseeded randomness: what varies is an argument.
//! Reading order:
//!
//! 1. [`cell`], [`terrain`], [`shape`], [`generated`]: where one can be, and what is searched;
//! 2. [`sensor`], [`evidence`], [`belief`], [`observation`]: what is seen, and what it means;
//! 3. [`information`], [`outlook`], [`route`], [`reach`], [`intent`]: what a look, a path and a teammate's plan are worth,
//!    and what nobody can see;
//! 4. [`situation`], [`policy`]: the decision;
//! 5. [`measures`], [`seed`]: how a search is judged and repeated.

pub mod belief;
pub mod cell;
pub mod evidence;
pub mod generated;
pub mod information;
pub mod information_gain;
pub mod intent;
pub mod measures;
pub mod observation;
pub mod policy;
pub mod reach;
pub mod route;
pub mod seed;
pub mod sensor;
pub mod shape;
pub mod situation;
pub mod terrain;
