//! A folder of trajectories.

use std::fs;
use std::path::{Path, PathBuf};

use dragnet_files::FileError;

use super::file::KIND;
use super::{Source, Trajectory, read};

/// The file name of a trajectory.
#[must_use]
pub fn file_name(scenario: &str, seed: u64) -> String {
    format!("{scenario}-{seed}.{EXTENSION}")
}

const EXTENSION: &str = "demo.safetensors";

/// The trajectories of a folder, all of one expert, ordered by file name.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    files: Vec<PathBuf>,
}

impl Folder {
    /// Opens the demonstrations of a folder; other files are ignored.
    ///
    /// # Errors
    /// If it cannot be read or holds no demonstration.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let unreadable = |source| FileError::Read { path: path.to_owned(), kind: KIND.name, source };
        let mut files = Vec::new();
        for entry in fs::read_dir(path).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            if entry.file_name().to_string_lossy().ends_with(EXTENSION) {
                files.push(entry.path());
            }
        }
        if files.is_empty() {
            let reason = format!("no demonstrations here: no file ends with .{EXTENSION}");
            return Err(FileError::content(path, reason));
        }
        files.sort_unstable();
        Ok(Self { path: path.to_owned(), files })
    }

    /// The folder's path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of trajectories.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.files.len()
    }

    /// Always false.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Reads one trajectory after the other, so that they need not fit into memory together.
    ///
    /// # Errors
    /// For each: if it cannot be read, or is of another expert than the first.
    pub fn trajectories(&self) -> impl Iterator<Item = Result<Trajectory, FileError>> + '_ {
        let mut first: Option<Source> = None;
        self.files.iter().map(move |path| {
            let trajectory = read(path)?;
            let expected = first.get_or_insert_with(|| trajectory.source.clone());
            if !expected.is_same_expert(&trajectory.source) {
                let (found, expected) = (&trajectory.source, &*expected);
                let reason = format!("demonstrations of {found}; those before it are of {expected}");
                return Err(FileError::content(path, reason));
            }
            Ok(trajectory)
        })
    }
}
