//! Recordings in other formats: their names, and how to convert them to MCAP.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::RecordingError;

/// The first bytes of every `SQLite` database.
const SQLITE: &[u8; 16] = b"SQLite format 3\0";

/// Rejects a recording in another format.
///
/// # Errors
/// If the file is one.
pub(super) fn check(path: &Path, file: &File) -> Result<(), RecordingError> {
    let mut start = [0; SQLITE.len()];
    // Read errors are reported by the following reads.
    match file.read_exact_at(&mut start, 0) {
        Ok(()) if start == *SQLITE => Err(sqlite(path)),
        _ => Ok(()),
    }
}

/// The format of `ros2 bag record --storage sqlite3`, the default up to Humble.
pub(crate) fn sqlite(path: &Path) -> RecordingError {
    let bag = if path.is_dir() { path } else { path.parent().unwrap_or(path) };
    let found = format!(
        "a bag in SQLite (.db3); only MCAP is read. Convert it: `ros2 bag convert -i {} -o mcap.yaml`, where mcap.yaml \
         says `output_bags: [{{uri: converted, storage_id: mcap, all_topics: true}}]`; or record with `--storage mcap`",
        bag.display()
    );
    RecordingError::NotARecording { path: path.to_owned(), found }
}
