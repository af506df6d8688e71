//! Output files.

use std::fs;
use std::path::Path;

use crate::ExperimentError;

/// Creates the folder of `--out` before the work begins.
///
/// # Errors
/// If it cannot be created.
pub fn make_folder(folder: &Path) -> Result<(), ExperimentError> {
    fs::create_dir_all(folder).map_err(|error| {
        ExperimentError::Input(format!("--out {}: cannot make the folder: {error}", folder.display()))
    })
}

/// Writes a file atomically.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), ExperimentError> {
    dragnet_files::write(path, bytes).map_err(ExperimentError::run)
}
