//! A mission's certificates on disk.
//!
//! ```text
//! FOLDER/authority.key      stays where it is: it can make a certificate for any participant of this mission
//! FOLDER/authority.pem      the authority's certificate; a copy lies in each folder below
//! FOLDER/register.toml      all certificates ever made
//! FOLDER/robot-1/           goes to robot 1 as it is: authority.pem, robot-1.pem, robot-1.key, zenoh.json5
//! FOLDER/revoked/robot-1#2/ what was revoked
//! ```
//!
//! Only their owner can read folders and private keys, from their creation on; no key is ever overwritten.
//! `zenoh.json5` contains no secret: after a certificate was added or revoked it is the only file that the other
//! participants need.

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
/// Name of the Zenoh settings in each participant's folder.
pub const SETTINGS: &str = "zenoh.json5";

/// A folder with the certificates of one mission.
pub struct Folder {
    path: PathBuf,
    mission: Mission,
    register: Register,
}

impl Folder {
    /// Creates a folder with a new certificate authority of a mission, without any participants.
    ///
    /// # Errors
    /// If the folder exists, or cannot be written.
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

    /// Opens a folder made by [`Folder::init`].
    ///
    /// # Errors
    /// If it does not exist, or its contents are invalid.
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

    /// The folder of a participant.
    #[must_use]
    pub fn home(&self, name: Name) -> PathBuf {
        self.path.join(name.to_string())
    }

    /// Creates certificates with these hosts, valid for `days` days, and new settings for all participants.
    ///
    /// # Errors
    /// If one of the participants has a valid certificate, a host is invalid, or something cannot be written.
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

    /// Revokes a participant's certificate: moves its files to `revoked/`, and creates new settings for the others.
    /// Returns the revoked certificate.
    ///
    /// # Errors
    /// If there is no valid one, or something cannot be written.
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
        // The other participants' settings come first: remaining files do no harm.
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

    /// Writes the list, and the settings of all participants.
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

/// The maximum size of a file, bytes: the list of a large team takes a hundredth of it.
const MAX_FILE_BYTES: u64 = 1 << 24;

fn make_folder(path: &Path) -> Result<(), KeysError> {
    DirBuilder::new().mode(0o700).create(path).map_err(KeysError::file(path))
}

fn write_signed(folder: &Path, name: &str, signed: &Signed) -> Result<(), KeysError> {
    write_new(&folder.join(format!("{name}.key")), &signed.private_key, 0o600)?;
    write_new(&folder.join(format!("{name}.pem")), &signed.certificate, 0o644)
}

/// Creates a file with these permissions; it must not exist.
fn write_new(path: &Path, text: &str, permissions: u32) -> Result<(), KeysError> {
    let mut file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(permissions)
        .open(path)
        .map_err(KeysError::file(path))?;
    file.write_all(text.as_bytes()).and_then(|()| file.sync_all()).map_err(KeysError::file(path))
}

/// Replaces a file atomically.
fn replace(path: &Path, text: &str) -> Result<(), KeysError> {
    let new = path.with_extension("new");
    fs::write(&new, text).map_err(KeysError::file(&new))?;
    fs::rename(&new, path).map_err(KeysError::file(path))
}
