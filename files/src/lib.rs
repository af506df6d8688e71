//! Bounded reading of files that users name, and atomic writing.
//!
//! This crate does not interpret the content of files.

mod error;
mod read;
mod words;
mod write;

pub use error::FileError;
pub use read::{check_plain, open_plain, read_at_most, read_text_at_most, text_of};
pub use words::in_words;
pub use write::write;
