//! Files that people name: read no further than they may be long, written as a whole or not at all.
//!
//! What a file holds is for others to know.

mod error;
mod read;
mod write;

pub use error::FileError;
pub use read::{check_plain, open_plain, read_at_most, read_text_at_most, text_of};
pub use write::write;
