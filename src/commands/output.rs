//! Files that commands write: existing files are not overwritten, and no file is left incomplete.

use std::path::{Path, PathBuf};

use super::Failure;

pub(super) use dragnet_experiments::output::write;

/// Checks that a file does not exist and its folder does. `key` is where the file was named; `none` is the message's
/// beginning, such as "no recording is".
pub(super) fn free(key: &str, path: &Path, none: &str) -> Result<PathBuf, Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let path_display = path.display();
    if path.exists() {
        return Err(Failure::Input(format!("{key} {path_display}: exists already; {none} overwritten")));
    }
    if folder != Path::new("") && !folder.is_dir() {
        let folder = folder.display();
        return Err(Failure::Input(format!("{key} {path_display}: there is no folder {folder}")));
    }
    Ok(path.to_owned())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_failed_write_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        assert!(write(&taken, b"whole").is_err());
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
        let path = folder.path().join("part");
        write(&path, b"old").unwrap();
        write(&path, b"whole").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(folder.path().read_dir().unwrap().count(), 2);
    }
}
