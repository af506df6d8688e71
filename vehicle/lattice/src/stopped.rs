//! The end of a search that its caller has stopped.

/// The caller has no more time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stopped;
