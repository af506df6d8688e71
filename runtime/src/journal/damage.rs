//! Analyzes a file that cannot be opened as a journal: a damaged journal is moved aside, and any other file is left
//! alone.

use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use dragnet_files::open_plain;
use redb::{Error, TableHandle};

use super::{FACTS, JournalError, OBSERVATIONS};

/// Of the database, bytes.
const PAGE_BYTES: usize = 4096;
/// The first bytes of every database.
const MAGIC: &[u8] = b"redb\x1a\n";
/// Number of bytes of a file that are searched for the names of a journal's tables.
const SEARCHED_BYTES: u64 = 64 << 20;
/// Linux's error for a disk that cannot read its data.
const INPUT_OUTPUT_ERROR: i32 = 5;

/// The damage, if the file is a damaged journal.
///
/// # Errors
/// If it is not a journal: the original error, or that it is something else.
pub(super) fn of(path: &Path, error: JournalError) -> Result<String, JournalError> {
    let JournalError::Storage { source, .. } = &error else { return Err(error) };
    match &**source {
        Error::Corrupted(damage) => Ok(damage.clone()),
        Error::UpgradeRequired(version) => Ok(format!("version {version}, in which none was ever written")),
        Error::Io(failed) if failed.raw_os_error() == Some(INPUT_OUTPUT_ERROR) => Ok(failed.to_string()),
        Error::Io(failed) if is_of_content(failed.kind()) => {
            if was_journal(path).unwrap_or(false) {
                return Ok(failed.to_string());
            }
            Err(JournalError::NotAJournal { path: path.to_owned() })
        }
        _ => Err(error),
    }
}

/// Whether the error comes from the file's content: a truncated or invalid file.
const fn is_of_content(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::UnexpectedEof | ErrorKind::InvalidInput | ErrorKind::InvalidData)
}

/// Whether a file that cannot be read was a journal: its first page is blank, as if it had never been written, or
/// begins correctly, or names of a journal's tables remain.
fn was_journal(path: &Path) -> io::Result<bool> {
    let mut file = open_plain(path)?;
    let mut page = Vec::new();
    file.by_ref().take(PAGE_BYTES as u64).read_to_end(&mut page)?;
    if page.iter().all(|&byte| byte == 0) || page.starts_with(MAGIC) {
        return Ok(true);
    }
    let mut bytes = page;
    file.take(SEARCHED_BYTES).read_to_end(&mut bytes)?;
    let has = |name: &str| bytes.windows(name.len()).any(|window| window == name.as_bytes());
    Ok(has(FACTS.name()) && has(OBSERVATIONS.name()) && has(super::fact::STARTED))
}

/// Renames a file to the first unused of `NAME.damaged`, `NAME.damaged-2` and so on.
pub(super) fn set_aside(path: &Path, damage: &str) -> Result<(), JournalError> {
    let name = |suffix: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".damaged{suffix}"));
        PathBuf::from(name)
    };
    let numbered = (2_u32..).map(|number| name(&format!("-{number}")));
    let mut names = std::iter::once(name("")).chain(numbered);
    let aside = names.find(|name| !name.exists()).unwrap_or_else(|| name(""));
    std::fs::rename(path, &aside).map_err(|source| JournalError::of(path, Error::Io(source)))?;
    let (path, aside) = (path.display(), aside.display());
    tracing::warn!(
        "{path}: damaged ({damage}); it is kept as {aside}, a new journal is begun, and what the robot knew is lost to it"
    );
    Ok(())
}
