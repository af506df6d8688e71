//! A mission's certificates, and the keys that their owners may publish under.
//!
//! - [`name`]: the owners of certificates;
//! - [`register`]: the list of certificates, and which of them are valid;
//! - [`certificate`]: the certificate authority, and the certificates that it signs;
//! - [`access`]: settings of Zenoh that let each participant publish under its own keys only;
//! - [`folder`]: these files on disk; only their owner can read private keys.
//!
//! The crate opens no socket, and takes the time from its caller.

pub mod access;
pub mod certificate;
pub mod folder;
pub mod name;
pub mod register;

mod error;

pub use error::KeysError;
