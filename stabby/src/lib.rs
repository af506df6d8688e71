//! Text as Zenoh's plugins name their versions: a replacement of the crate of this name, which Zenoh uses.
//!
//! The original lays types out alike for every compiler, so that a program can load plugins that another compiler built.
//! Zenoh is built without plugins here, and of that crate it needs only [`str::Str`], for which it would compile 19,000
//! lines. `Cargo.toml` of the workspace replaces the original (`[patch.crates-io]`).

/// Text.
pub mod str {
    use std::fmt::{self, Display, Formatter};
    use std::ops::Deref;

    /// A borrowed text. Its layout is that of `&str`, and so not for plugins.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Str<'text>(&'text str);

    impl<'text> From<&'text str> for Str<'text> {
        fn from(text: &'text str) -> Self {
            Self(text)
        }
    }

    impl Deref for Str<'_> {
        type Target = str;

        fn deref(&self) -> &str {
            self.0
        }
    }

    impl Display for Str<'_> {
        fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
            self.0.fmt(formatter)
        }
    }
}
