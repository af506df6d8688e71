//! The benchmark: frozen tracks on which policies are measured, and results that others can run again.
//!
//! A [`Track`] names searches and seeds, and has a digest of all of them. The episodes of a policy on a track, run by the
//! functions of [`comparison`](crate::comparison), become a [`BenchmarkResult`], which is a file; [`verify`] says which
//! episodes of such a file another run gives differently.

mod entry;
mod result;
mod summary;
mod track;
pub mod verify;

pub use entry::{Decider, Entry, Interface};
pub use result::{BenchmarkResult, EpisodeResult, PolicyResult, Program};
pub use summary::{ALL_GROUPS, Summary};
pub use track::{Search, Track};
