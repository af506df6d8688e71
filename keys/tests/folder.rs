//! Certificates on disk: never overwritten, readable by their owner only, and revoked for all.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use dragnet_keys::KeysError;
use dragnet_keys::folder::{Folder, SETTINGS};
use dragnet_keys::name::Name;
use dragnet_keys::register::{Standing, Topology};
use time::{Duration, OffsetDateTime};

const NAMES: [Name; 3] = [Name::robot(1).unwrap(), Name::robot(2).unwrap(), Name::COORDINATOR];
const VALID: Standing = Standing::Valid;
const REVOKED: Standing = Standing::Revoked;
const NOW: OffsetDateTime = OffsetDateTime::UNIX_EPOCH;

struct Place {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

fn place() -> Place {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("keys");
    Place { _folder: folder, path }
}

fn made(path: &Path) -> Folder {
    let mut folder = Folder::init(path, "valley".parse().unwrap(), Topology::Mesh, NOW).unwrap();
    folder.add(&NAMES, &[], 30, NOW).unwrap();
    folder
}

fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().permissions().mode() & 0o777
}

#[test]
fn private_keys_are_their_owners_alone_and_a_participants_folder_is_whole() {
    let place = place();
    made(&place.path);
    for name in ["robot-1", "robot-2", "coordinator"] {
        let home = place.path.join(name);
        assert_eq!(mode(&home), 0o700);
        assert_eq!(mode(&home.join(format!("{name}.key"))), 0o600);
        let mut files: Vec<String> = fs::read_dir(&home)
            .unwrap()
            .map(|file| file.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        let mut expected =
            ["authority.pem".to_owned(), format!("{name}.key"), format!("{name}.pem"), SETTINGS.to_owned()];
        expected.sort();
        assert_eq!(files, expected);
        // Nothing that is copied to a participant holds the authority's key, or that of another.
        let settings = fs::read_to_string(home.join(SETTINGS)).unwrap();
        assert!(!settings.contains("PRIVATE KEY"));
    }
    assert_eq!(mode(&place.path.join("authority.key")), 0o600);
}

#[test]
fn nothing_is_overwritten() {
    let place = place();
    let mut folder = made(&place.path);
    let key = fs::read(place.path.join("robot-1/robot-1.key")).unwrap();
    let again = Folder::init(&place.path, "valley".parse().unwrap(), Topology::Mesh, NOW);
    assert!(matches!(again, Err(KeysError::Exists { .. })));
    let again = folder.add(&[Name::robot(1).unwrap()], &[], 30, NOW).unwrap_err().to_string();
    assert!(again.contains("robot-1 has a certificate that holds until 1970-01-31"), "{again}");
    assert_eq!(fs::read(place.path.join("robot-1/robot-1.key")).unwrap(), key);
}

#[test]
fn a_revoked_certificate_is_put_away_and_its_successor_has_another_name() {
    let place = place();
    let mut folder = made(&place.path);
    let revoked = folder.revoke(Name::robot(2).unwrap()).unwrap();
    assert_eq!(revoked.common_name(), "robot-2#3");
    assert!(place.path.join("revoked/robot-2#3/robot-2.key").exists());
    let settings = |name: &str| fs::read_to_string(place.path.join(name).join(SETTINGS)).unwrap();
    assert!(!settings("robot-1").contains("said by robot-2#3"));
    let error = folder.revoke(Name::robot(2).unwrap()).unwrap_err().to_string();
    assert!(error.contains("robot-2 has no valid certificate"), "{error}");
    let mut folder = Folder::open(&place.path).unwrap();
    folder.add(&[Name::robot(2).unwrap()], &["127.0.0.1".to_owned()], 1, NOW).unwrap();
    assert!(settings("robot-1").contains("said by robot-2#5"));
    let standings = |now| -> Vec<Standing> {
        folder.register().certificates.iter().map(|entry| entry.standing(now)).collect()
    };
    assert_eq!(standings(NOW), [VALID, REVOKED, VALID, VALID]);
    assert_eq!(standings(NOW + Duration::days(2)), [VALID, REVOKED, VALID, Standing::Expired]);
}

#[test]
fn invalid_values_are_rejected_by_name() {
    let place = place();
    let mut folder = made(&place.path);
    let mut add = |hosts: &[&str], days| {
        let hosts: Vec<String> = hosts.iter().map(|host| (*host).to_owned()).collect();
        folder.add(&[Name::robot(3).unwrap()], &hosts, days, NOW).unwrap_err().to_string()
    };
    assert!(add(&["a b"], 3).contains("host \"a b\""));
    assert!(add(&[], 0).contains("0 days: allowed are 1 to 3650"));
    assert!(!place.path.join("robot-3").exists());
    fs::write(place.path.join("register.toml"), "mission = 3").unwrap();
    let error = Folder::open(&place.path).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("register.toml"), "{error}");
}
