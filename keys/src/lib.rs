//! A mission's certificates, and what their owners may publish.
//!
//! - [`name`]: the owners of certificates;
//! - [`register`]: the list of certificates, and which of them are valid;
//! - [`certificate`]: the authority, and what it signs;
//! - [`access`]: settings of Zenoh that let each participant publish under its own keys only;
//! - [`folder`]: all of it on disk, private keys readable by their owner only.
//!
//! The crate opens no socket, and takes the time from its caller.

pub mod access;
pub mod certificate;
pub mod folder;
pub mod name;
pub mod register;

mod error;

pub use error::KeysError;
