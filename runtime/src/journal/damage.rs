//! What is wrong with a file that cannot be opened as a journal: a damaged journal is set aside, and a file that somebody
//! named by mistake is left alone.

use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use dragnet_files::open_plain;
use redb::{Error, TableHandle};

use super::{FACTS, JournalError, OBSERVATIONS};

/// Of the database, bytes.
const PAGE_BYTES: usize = 4096;
/// What every database begins with.
const MAGIC: &[u8] = b"redb\x1a\n";
/// So much of a file is looked through for what a journal says of itself, bytes.
const SEARCHED_BYTES: u64 = 64 << 20;
/// What Linux says of a disk that cannot read what was written on it.
const INPUT_OUTPUT_ERROR: i32 = 5;

/// What is damaged, if the file is a journal that is.
///
/// # Errors
/// If it is none: with what was wrong, or that it is something else.
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

/// Whether that is the end of the file, or of its copy in memory, or what it begins with.
const fn is_of_content(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::UnexpectedEof | ErrorKind::InvalidInput | ErrorKind::InvalidData)
}

/// Whether a file that cannot be read as a journal was one: its first page is blank, as one that never came to the disk, or
/// begins as it should, or names of a journal's tables stand in what is left.
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

/// Renames a file to the first free of `NAME.damaged`, `NAME.damaged-2` and so on.
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
