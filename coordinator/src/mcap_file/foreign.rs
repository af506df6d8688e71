//! Recordings in another format: what they are, and what makes MCAP of them.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::RecordingError;

/// What every database of `SQLite` begins with.
const SQLITE: &[u8; 16] = b"SQLite format 3\0";

/// Refuses a file that is a recording of another kind.
///
/// # Errors
/// If it is one.
pub(super) fn check(path: &Path, file: &File) -> Result<(), RecordingError> {
    let mut start = [0; SQLITE.len()];
    // What cannot be read is told by whoever reads on.
    match file.read_exact_at(&mut start, 0) {
        Ok(()) if start == *SQLITE => Err(sqlite(path)),
        _ => Ok(()),
    }
}

/// ROS 2 records so by `--storage sqlite3`, and up to Humble without being told.
pub(crate) fn sqlite(path: &Path) -> RecordingError {
    let bag = if path.is_dir() { path } else { path.parent().unwrap_or(path) };
    let found = format!(
        "a bag in SQLite (.db3); only MCAP is read. Convert it: `ros2 bag convert -i {} -o mcap.yaml`, where mcap.yaml \
         says `output_bags: [{{uri: converted, storage_id: mcap, all_topics: true}}]`; or record with `--storage mcap`",
        bag.display()
    );
    RecordingError::NotARecording { path: path.to_owned(), found }
}
