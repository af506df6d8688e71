//! A mission's certificates, and who may say what with them.
//!
//! - [`name`]: who can have a certificate;
//! - [`register`]: which certificates were made, and which of them still hold;
//! - [`certificate`]: the authority, and what it signs;
//! - [`access`]: settings of Zenoh that let each participant speak under its own keys, and nobody else at all;
//! - [`folder`]: all of it on disk, private keys for their owner's eyes only.
//!
//! It opens no socket, and takes the time from its caller.

pub mod access;
pub mod certificate;
pub mod folder;
pub mod name;
pub mod register;

mod error;

pub use error::KeysError;
