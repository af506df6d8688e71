//! Who hears how far work has come.

/// Hears of work that takes a while.
pub trait Progress: Sync {
    /// Work of so many steps begins; `unit` says what a step is, such as "episodes". The work ends when what is returned is
    /// dropped.
    fn begin(&self, steps: u64, unit: &str) -> Box<dyn Work>;
}

/// Work that has begun.
pub trait Work: Sync {
    /// So many more steps are done.
    fn advance(&self, steps: u64);
}
