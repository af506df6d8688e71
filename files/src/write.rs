//! Atomic writing.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use tempfile::Builder;

use crate::FileError;

/// Writes a file atomically: afterwards the path contains either the complete new content or the old file, even after a
/// power failure.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    // With the permissions of an ordinary file, not the private ones of temporary files.
    let unfinished = Builder::new().prefix(".unfinished-").make_in(folder, |path| File::create_new(path));
    let written = unfinished.and_then(|mut file| {
        file.write_all(bytes)?;
        // Otherwise the name may survive a power failure that the content does not.
        file.as_file().sync_all()?;
        Ok(file.persist(path)?)
    });
    written.map(drop).map_err(|source| FileError::Write { path: path.to_owned(), source })
}
