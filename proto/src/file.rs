//! Files that people name, read no further than they may be long: for all who do not know `learn`, whose code it is.

pub use dragnet_learn::file::{check_plain, open_plain, read_at_most, read_text_at_most, text_of};
