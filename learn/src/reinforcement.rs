//! What a network learns from its own searches: its decisions, and which of them made a search shorter.
//!
//! An [`Explorer`] searches as the network does, but draws its choices. What a decision brings is counted in cells, from
//! two parts: the way that was driven, and what `tour` says that the rest will cost
//! ([`dragnet_search::policy::TourCost`]). Neither depends on where objects really are: both are expectations by the
//! belief, so that luck is not taken for merit.

mod advantage;
mod explorer;

pub use advantage::{advantages, expected_cells};
pub use explorer::{Choice, Explorer, Visit};
