//! Where results go.

use std::fs;
use std::path::Path;

use crate::ExperimentError;

/// Makes the folder of `--out`, so that it is not missing after hours of work.
///
/// # Errors
/// If it cannot be made.
pub fn make_folder(folder: &Path) -> Result<(), ExperimentError> {
    fs::create_dir_all(folder).map_err(|error| {
        ExperimentError::Input(format!("--out {}: cannot make the folder: {error}", folder.display()))
    })
}

/// Writes a file as a whole or not at all.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), ExperimentError> {
    dragnet_files::write(path, bytes).map_err(ExperimentError::run)
}
