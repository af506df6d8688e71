//! The learned policy: a graph attention network that imitates an expensive expert.
//!
//! Reading order:
//!
//! 1. [`graph`]: the network's input;
//! 2. [`network`]: inference in plain Rust, from a graph to a logit for each cell; [`shape`], [`weights`]: its sizes,
//!    and its parameters as a file;
//! 3. [`policy`]: the network as a policy, the built-in networks, and the names of all policies;
//! 4. [`demonstration`]: an expert's decisions as files; [`mod@file`]: the common format of files;
//! 5. [`reinforcement`]: a network's own searches, and which of its decisions made them shorter.
//!
//! Training is a separate crate above this one, since it needs libtorch.

pub mod demonstration;
pub mod file;
pub mod graph;
pub mod network;
pub mod policy;
pub mod reinforcement;
pub mod shape;
pub mod weights;
