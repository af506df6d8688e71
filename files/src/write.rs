//! Writing: all or nothing.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use tempfile::Builder;

use crate::FileError;

/// Writes a file as a whole or not at all: under its name is all of it, or the one before, even after a power cut.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    // Not private, as temporary files are: it becomes a file like any other.
    let unfinished = Builder::new().prefix(".unfinished-").make_in(folder, |path| File::create_new(path));
    let written = unfinished.and_then(|mut file| {
        file.write_all(bytes)?;
        // Otherwise the name may outlive a power cut that the content does not.
        file.as_file().sync_all()?;
        Ok(file.persist(path)?)
    });
    written.map(drop).map_err(|source| FileError::Write { path: path.to_owned(), source })
}
