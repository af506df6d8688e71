//! A mission's certificates on disk.
//!
//! ```text
//! FOLDER/authority.key      stays where it is: whoever has it can join any mission of this authority as anybody
//! FOLDER/authority.pem      the authority's certificate; a copy lies in each folder below
//! FOLDER/register.toml      all certificates ever made
//! FOLDER/robot-1/           goes to robot 1 as it is: authority.pem, robot-1.pem, robot-1.key, zenoh.json5
//! FOLDER/revoked/robot-1#2/ what was revoked
//! ```
//!
//! Folders are open to their owner alone, and private keys are from the moment they exist; no key is ever overwritten.
//! `zenoh.json5` holds no secret: after a certificate was added or revoked it is all that the others need.

use std::fs::{self, DirBuilder, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use dragnet_files::read_text_at_most;
use dragnet_proto::key::Mission;
use time::{Duration, OffsetDateTime};

use crate::KeysError;
use crate::access::settings;
use crate::certificate::{self, MAX_DAYS, Signed, check_host};
use crate::name::Name;
use crate::register::{Entry, Register, Topology};

const REGISTER: &str = "register.toml";
const AUTHORITY: &str = "authority";
const REVOKED: &str = "revoked";
/// Name of the settings of Zenoh in each participant's folder.
pub const SETTINGS: &str = "zenoh.json5";

/// A folder with the certificates of one mission.
pub struct Folder {
    path: PathBuf,
    mission: Mission,
    register: Register,
}

impl Folder {
    /// Makes a folder, and in it the authority of a mission, which has signed nothing yet.
    ///
    /// # Errors
    /// If something is there already, or cannot be written.
    pub fn init(
        path: &Path,
        mission: Mission,
        topology: Topology,
        now: OffsetDateTime,
    ) -> Result<Self, KeysError> {
        let authority = certificate::authority(&mission, now)?;
        make_folder(path)?;
        write_signed(path, AUTHORITY, &authority)?;
        let folder = Self { path: path.to_owned(), register: Register::new(&mission, topology), mission };
        folder.save()?;
        Ok(folder)
    }

    /// Reads what [`Folder::init`] has made.
    ///
    /// # Errors
    /// If it is not there, or was changed into something that makes no sense.
    pub fn open(path: &Path) -> Result<Self, KeysError> {
        let file = path.join(REGISTER);
        let text = read_text_at_most(&file, MAX_FILE_BYTES).map_err(KeysError::file(&file))?;
        let register: Register = toml::from_str(&text)
            .map_err(|error| KeysError::Register { path: file, reason: error.to_string() })?;
        let mission = register.mission()?;
        Ok(Self { path: path.to_owned(), mission, register })
    }

    /// All certificates.
    #[must_use]
    pub const fn register(&self) -> &Register {
        &self.register
    }

    /// Where the files of somebody are.
    #[must_use]
    pub fn home(&self, name: Name) -> PathBuf {
        self.path.join(name.to_string())
    }

    /// Makes certificates for so many days, each with these hosts, and new settings for everybody.
    ///
    /// # Errors
    /// If one of them has a certificate that holds, a host cannot be one, or something cannot be written.
    pub fn add(
        &mut self,
        names: &[Name],
        hosts: &[String],
        days: u32,
        now: OffsetDateTime,
    ) -> Result<(), KeysError> {
        if !(1..=MAX_DAYS).contains(&days) {
            return Err(KeysError::Days(days));
        }
        if let Some(entry) = names.iter().find_map(|&name| self.register.holder(name)) {
            return Err(KeysError::Holds { name: entry.name.to_string(), until: entry.last_day() });
        }
        hosts.iter().try_for_each(|host| check_host(host))?;
        let authority = self.authority()?;
        for &name in names {
            let entry = Entry {
                name,
                serial: self.register.next_serial(),
                valid_until: (now + Duration::days(days.into())).unix_timestamp(),
                revoked: false,
                hosts: hosts.to_vec(),
            };
            let signed = certificate::issue(&authority, &self.mission, &entry, now)?;
            let home = self.home(name);
            make_folder(&home)?;
            write_new(&home.join("authority.pem"), &authority.certificate, 0o644)?;
            write_signed(&home, &name.to_string(), &signed)?;
            self.register.certificates.push(entry);
        }
        self.save()
    }

    /// Revokes somebody's certificate: puts its files away and makes new settings for the others. Returns which it was.
    ///
    /// # Errors
    /// If there is none that holds, or something cannot be written.
    pub fn revoke(&mut self, name: Name) -> Result<Entry, KeysError> {
        let Some(place) =
            self.register.certificates.iter().position(|entry| entry.name == name && !entry.revoked)
        else {
            let holders = self.register.holders();
            let holders = holders.iter().map(|entry| entry.name.to_string()).collect::<Vec<_>>().join(", ");
            return Err(KeysError::Unknown { name: name.to_string(), holders });
        };
        self.register.certificates[place].revoked = true;
        let entry = self.register.certificates[place].clone();
        // First of all the others must be told: files that lie about do no harm.
        self.save()?;
        let away = self.path.join(REVOKED);
        if !away.is_dir() {
            make_folder(&away)?;
        }
        let home = self.home(name);
        fs::rename(&home, away.join(entry.common_name())).map_err(KeysError::file(&home))?;
        Ok(entry)
    }

    fn authority(&self) -> Result<Signed, KeysError> {
        let read = |extension: &str| {
            let file = self.path.join(format!("{AUTHORITY}.{extension}"));
            read_text_at_most(&file, MAX_FILE_BYTES).map_err(KeysError::file(&file))
        };
        Ok(Signed { certificate: read("pem")?, private_key: read("key")? })
    }

    /// Writes the list, and everybody's settings by it.
    fn save(&self) -> Result<(), KeysError> {
        let file = self.path.join(REGISTER);
        let text = toml::to_string(&self.register)
            .map_err(|error| KeysError::Register { path: file.clone(), reason: error.to_string() })?;
        replace(&file, &text)?;
        for entry in self.register.holders() {
            let settings = settings(&self.register, &self.mission, entry.name);
            let heading = format!(
                "// Settings of Zenoh for {} of mission {}, made by `dragnet keys`: they are made anew when somebody is\n\
                 // added or revoked. No secret is in here.\n",
                entry.name, self.mission
            );
            replace(&self.home(entry.name).join(SETTINGS), &format!("{heading}{settings:#}\n"))?;
        }
        Ok(())
    }
}

/// The longest file that is read, bytes: a list of all certificates of a large team takes a hundredth.
const MAX_FILE_BYTES: u64 = 1 << 24;

fn make_folder(path: &Path) -> Result<(), KeysError> {
    DirBuilder::new().mode(0o700).create(path).map_err(KeysError::file(path))
}

fn write_signed(folder: &Path, name: &str, signed: &Signed) -> Result<(), KeysError> {
    write_new(&folder.join(format!("{name}.key")), &signed.private_key, 0o600)?;
    write_new(&folder.join(format!("{name}.pem")), &signed.certificate, 0o644)
}

/// A file that did not exist, with these permissions from its first moment on.
fn write_new(path: &Path, text: &str, permissions: u32) -> Result<(), KeysError> {
    let mut file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(permissions)
        .open(path)
        .map_err(KeysError::file(path))?;
    file.write_all(text.as_bytes()).and_then(|()| file.sync_all()).map_err(KeysError::file(path))
}

/// Whole or not at all.
fn replace(path: &Path, text: &str) -> Result<(), KeysError> {
    let new = path.with_extension("new");
    fs::write(&new, text).map_err(KeysError::file(&new))?;
    fs::rename(&new, path).map_err(KeysError::file(path))
}
