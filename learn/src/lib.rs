//! The learned policy: a graph attention network that imitates an expensive expert.
//!
//! Reading order:
//!
//! 1. [`graph`]: what the network sees of a situation;
//! 2. [`network`]: from a graph to a logit for each cell, in plain Rust; [`shape`], [`weights`]: its sizes and its
//!    parameters as a file;
//! 3. [`policy`]: the network as a policy, the shipped ones among them; names of all policies;
//! 4. [`demonstration`]: what an expert decided, and from what, as files; [`mod@file`]: what all files here have in common;
//!
//! Learning itself is a crate of its own above this one, for it needs libtorch.

pub mod demonstration;
pub mod file;
pub mod graph;
pub mod network;
pub mod policy;
pub mod shape;
pub mod weights;
