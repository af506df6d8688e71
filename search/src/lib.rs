//! The algorithms of active search, and nothing else.
//!
//! This crate has no clock, socket, file, thread or unseeded randomness: all inputs are arguments. Reading order:
//!
//! 1. [`cell`], [`terrain`], [`line_of_sight`], [`shape`], [`generated`]: the map;
//! 2. [`sensor`], [`evidence`], [`belief`], [`subjects`], [`observation`], [`object_position`]: observations and
//!    what follows from them;
//! 3. [`utility`], [`utility_gain`], [`route`], [`reach`], [`intent`]: the value of an observation, a path and
//!    a teammate's plan, and the cells out of reach;
//! 4. [`situation`], [`policy`], [`separation`]: the decision, and how far apart robots keep;
//! 5. [`measures`], [`detection`], [`sweep`], [`seed`]: how a search is measured and reproduced.
//!
//! The sensor is radially symmetric: the variance of a reading depends on the distance of its cell alone. [`sensor`]
//! defines this; [`utility_gain`], [`intent`] and [`reach`] use it, and so do the features of `dragnet-learn`. Where walls hide
//! cells there is no reading of them ([`line_of_sight`]).
//!
//! To add a policy: write its file in `policy/`, implement [`policy::Policy`], add a variant to [`policy::PolicyName`]
//! with its name in [`policy::PolicyName::ALL`], and build it in [`policy::build`]. Scenarios, the command line, their
//! help, the JSON Schema and error messages take their names from there. Then add a row to the tables of policies in
//! `docs/guide.md` and `docs/glossary.md`, which a test asks for.

pub mod belief;
pub mod cell;
pub mod detection;
pub mod evidence;
pub mod generated;
pub mod intent;
pub mod line_of_sight;
pub mod mark;
pub mod measures;
pub mod object_position;
pub mod observation;
pub mod policy;
pub mod reach;
pub mod route;
pub mod seed;
pub mod sensor;
pub mod separation;
pub mod shape;
pub mod situation;
pub mod subjects;
pub mod sweep;
pub mod terrain;
pub mod utility;
pub mod utility_gain;
