//! The scenarios that are part of the program, and their maps.
//!
//! They are in a virtual folder, [`FOLDER`], so that the same functions read these files and files on disk.

use std::io;
use std::path::{Component, Path, PathBuf};

/// The virtual folder of the shipped files.
pub const FOLDER: &str = "dragnet:";

/// What a file's name ends with if it is a scenario.
const EXTENSION: &str = "toml";

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_bytes!(concat!("../../", $name)).as_slice())),*]
    };
}

/// Each file with its content, by its path in [`FOLDER`]. Scenarios stand in the order in which they are listed.
const FILES: &[(&str, &[u8])] = files![
    "ice_cream_cone.toml",
    "team.toml",
    "faults.toml",
    "warehouse.toml",
    "jersey.toml",
    "missing_person.toml",
    "drone_and_rovers.toml",
    "field.toml",
    "paper/ice_cream_cone.toml",
    "paper/ice_cream_cone_60.toml",
    "paper/open_asterisk.toml",
    "paper/open_asterisk_60.toml",
    "paper/figure_four.toml",
    "paper/figure_four_60.toml",
    "paper/all_traversable.toml",
    "paper/all_traversable_60.toml",
    "maps/warehouse.yaml",
    "maps/warehouse.pgm",
    "maps/jersey.geojson",
    "maps/missing_person.kml",
    "scenario.schema.json",
];

/// Files that scenarios name, by scenario.
const MAPS: &[(&str, &[&str])] = &[
    ("warehouse", &["maps/warehouse.yaml", "maps/warehouse.pgm"]),
    ("jersey", &["maps/jersey.geojson"]),
    ("missing_person", &["maps/missing_person.kml"]),
    ("drone_and_rovers", &["maps/missing_person.kml"]),
];

/// A shipped scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShippedScenario {
    file: &'static str,
    text: &'static str,
}

impl ShippedScenario {
    /// All shipped scenarios.
    pub fn all() -> impl Iterator<Item = Self> {
        FILES.iter().filter_map(|&(file, bytes)| {
            let is_scenario = Path::new(file).extension().is_some_and(|it| it == EXTENSION);
            Some(Self { file, text: std::str::from_utf8(bytes).ok()? }).filter(|_| is_scenario)
        })
    }

    /// The scenario with this name, if there is one.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|scenario| scenario.name() == name)
    }

    /// Its name, such as `ice_cream_cone` or `paper/figure_four`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.file.strip_suffix(".toml").unwrap_or(self.file)
    }

    /// Its path in [`FOLDER`].
    #[must_use]
    pub fn path(&self) -> PathBuf {
        Path::new(FOLDER).join(self.file)
    }

    /// A summary: the comment before its first key.
    #[must_use]
    pub fn summary(&self) -> String {
        let comments = self.text.lines().map_while(|line| line.strip_prefix('#'));
        let lines: Vec<&str> = comments.filter(|line| !line.starts_with(':')).map(str::trim).collect();
        lines.join(" ")
    }

    /// Its files and their contents, by path in the folder: the scenario first, then the files that it names.
    pub fn files(&self) -> impl Iterator<Item = (&'static str, &'static [u8])> {
        let maps = MAPS.iter().filter(|(name, _)| *name == self.name()).flat_map(|(_, files)| files.iter());
        let names = std::iter::once(self.file).chain(maps.copied()).chain(["scenario.schema.json"]);
        names.filter_map(|name| Some((name, content(name)?)))
    }
}

fn content(name: &str) -> Option<&'static [u8]> {
    FILES.iter().find(|(file, _)| *file == name).map(|&(_, bytes)| bytes)
}

/// The path that a scenario is read from: the given path or, if no file exists there and it is the name of a shipped
/// scenario, the path of that one.
#[must_use]
pub fn resolve(path: &Path) -> PathBuf {
    let shipped = || path.to_str().and_then(ShippedScenario::named).map(|scenario| scenario.path());
    if path.exists() { path.to_owned() } else { shipped().unwrap_or_else(|| path.to_owned()) }
}

/// The bytes of a file of at most this length: a shipped one if its path leads to [`FOLDER`], or else one on disk.
///
/// # Errors
/// If it cannot be read, is not a regular file, or is longer.
pub(crate) fn read_at_most(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    read(path)
        .map_or_else(|| dragnet_files::read_at_most(path, max_bytes), |shipped| shipped.map(<[u8]>::to_vec))
}

/// The content of a path in [`FOLDER`], if it leads there: also from a folder that it was joined to.
fn read(path: &Path) -> Option<io::Result<&'static [u8]>> {
    let mut components = path.components();
    components.find(|component| *component == Component::Normal(FOLDER.as_ref()))?;
    let missing = || io::Error::new(io::ErrorKind::NotFound, "no such file comes with the program");
    Some(components.as_path().to_str().and_then(content).ok_or_else(missing))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::Scenario;

    #[test]
    fn every_scenario_of_the_folder_is_shipped_and_is_the_same() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut found = BTreeSet::new();
        for part in ["", "paper"] {
            for entry in std::fs::read_dir(folder.join(part)).unwrap() {
                let name = Path::new(part).join(entry.unwrap().file_name());
                if name.extension().is_some_and(|it| it == EXTENSION) {
                    found.insert(name.with_extension("").to_str().unwrap().to_owned());
                }
            }
        }
        let shipped: BTreeSet<String> = ShippedScenario::all().map(|it| it.name().to_owned()).collect();
        assert_eq!(shipped, found);
        for name in shipped {
            let here = Scenario::load(Path::new(&name)).unwrap();
            let there = Scenario::load(&folder.join(&name).with_extension(EXTENSION)).unwrap();
            assert_eq!(here.terrain(), there.terrain(), "{name}");
            assert_eq!(here.source().text, there.source().text, "{name}");
        }
    }

    #[test]
    fn a_copy_has_all_that_it_needs() {
        for scenario in ShippedScenario::all() {
            let folder = tempfile::tempdir().unwrap();
            for (name, bytes) in scenario.files() {
                let file = folder.path().join(name);
                std::fs::create_dir_all(file.parent().unwrap()).unwrap();
                std::fs::write(file, bytes).unwrap();
            }
            Scenario::load(&folder.path().join(scenario.file)).unwrap();
            assert!(scenario.summary().ends_with(['.', '?']), "{}", scenario.summary());
        }
    }

    #[test]
    fn paths_lead_there_from_any_folder_and_no_further() {
        let text = |path: &str| read(Path::new(path)).map(|content| content.map(<[u8]>::len).ok());
        let length = Some(Some(ShippedScenario::named("team").unwrap().text.len()));
        assert_eq!(text("dragnet:/team.toml"), length);
        assert_eq!(text("/tmp/a/dragnet:/team.toml"), length);
        assert_eq!(text("dragnet:/teams.toml"), Some(None));
        assert_eq!(text("dragnet:/../team.toml"), Some(None));
        assert_eq!(text("team.toml"), None);
        assert_eq!(resolve(Path::new("nothing")), Path::new("nothing"));
    }
}
