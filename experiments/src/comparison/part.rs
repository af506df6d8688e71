//! Parts: the trials of one shard in a file with the description of their experiment; and joining of parts.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use dragnet_files::read_at_most;
use dragnet_sim::comparison::{Setting, Trial};
use serde::{Deserialize, Serialize};

use super::design::Design;
use crate::cut_off::is_cut_off;
use crate::shard::{self, Shard};
use crate::{ExperimentError, output};

const FORMAT: &str = "dragnet comparison part";
/// The version of the format; no other is read.
const FORMAT_VERSION: u32 = 4;

/// The trials of one shard.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    format: String,
    format_version: u32,
    origin: Origin,
    shard: Shard,
    /// In the order of [`Design::share`].
    trials: Vec<Trial>,
}

/// The origin of trials: only those of one origin belong in one table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Origin {
    /// Version and commit.
    program: String,
    design: Design,
}

/// The beginning of a part, of whatever version.
#[derive(Deserialize)]
struct Stamp {
    format: String,
    format_version: u32,
}

/// All shards of an experiment.
pub struct Joined {
    /// Its description.
    pub design: Design,
    /// The trials of all episodes, in their order.
    pub trials: Vec<Trial>,
    /// The number of parts.
    pub parts: usize,
}

impl Part {
    /// The trials that this version of the program has run for a shard.
    #[must_use]
    pub fn new(program: &str, design: Design, shard: Shard, trials: Vec<Trial>) -> Self {
        let origin = Origin::new(program, design);
        Self { format: FORMAT.to_owned(), format_version: FORMAT_VERSION, origin, shard, trials }
    }

    /// The path of a shard's part.
    #[must_use]
    pub fn path(folder: &Path, shard: Shard) -> PathBuf {
        folder.join(shard.file_name("json"))
    }

    /// Writes the part atomically.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ExperimentError> {
        output::write(path, &serde_json::to_vec(self).map_err(ExperimentError::run)?)
    }

    fn read(path: &Path) -> Result<Self, ExperimentError> {
        let wrong = |what: &dyn Display| ExperimentError::Input(format!("{}: {what}", path.display()));
        let bytes = read_at_most(path, shard::MAX_PART_BYTES).map_err(|error| wrong(&error))?;
        Self::parse(&bytes).map_err(|what| wrong(&what))
    }

    fn parse(json: &[u8]) -> Result<Self, String> {
        let stamp: Stamp = serde_json::from_slice(json).map_err(|error| unreadable(json, &error))?;
        if stamp.format != FORMAT {
            return Err(format!("{NO_PART} (its format is {:?})", stamp.format));
        }
        if stamp.format_version != FORMAT_VERSION {
            let version = stamp.format_version;
            return Err(format!(
                "a part of format version {version}; this program reads version {FORMAT_VERSION}"
            ));
        }
        let part: Self = serde_json::from_slice(json).map_err(|error| format!("a damaged part: {error}"))?;
        part.check().map_err(|what| format!("a damaged part: {what}"))?;
        Ok(part)
    }

    /// Checks that the trials are those of the shard, and that scenario names are valid file names.
    fn check(&self) -> Result<(), String> {
        let Design { settings, .. } = &self.origin.design;
        let is_plain = |character: char| character.is_ascii_alphanumeric() || "_-".contains(character);
        if let Some(Setting { scenario, .. }) = settings.iter().find(|it| !it.scenario.chars().all(is_plain))
        {
            return Err(format!("scenario {scenario:?}: allowed are letters, digits, '_' and '-'"));
        }
        let share = self.origin.design.share(self.shard);
        let expected = share.map(|(_, setting, seed)| (seed, settings[setting].lengths().len()));
        if expected.eq(self.trials.iter().map(|trial| (trial.seed, trial.curve.len()))) {
            Ok(())
        } else {
            Err(format!("its trials are not those of shard {}", self.shard))
        }
    }
}

const NO_PART: &str = "no part of a comparison; allowed is what `dragnet compare --shard` writes";

fn unreadable(json: &[u8], error: &serde_json::Error) -> String {
    if is_cut_off(json, error) {
        format!("a part that was cut off ({error}); delete it and run its shard again")
    } else {
        format!("{NO_PART} ({error})")
    }
}

/// Whether the file at this path is the part of this shard, experiment and version of the program.
///
/// # Errors
/// If it is anything else.
pub fn is_done(path: &Path, program: &str, design: &Design, shard: Shard) -> Result<bool, ExperimentError> {
    if !path.exists() {
        return Ok(false);
    }
    let part = Part::read(path)?;
    let wanted = Origin::new(program, design.clone());
    let difference = part
        .origin
        .difference(&wanted)
        .or_else(|| (part.shard != shard).then(|| format!("shard {} and not {shard}", part.shard)));
    match difference {
        None => Ok(true),
        Some(difference) => Err(ExperimentError::Input(format!(
            "{}: there is a part of another experiment already: {difference}; allowed is another folder, or to delete it",
            path.display()
        ))),
    }
}

/// Joins the parts of all shards of an experiment.
///
/// # Errors
/// If one is not a part, they are of different experiments, or a shard is missing or repeated.
pub fn join(paths: &[PathBuf]) -> Result<Joined, ExperimentError> {
    let read = |path: &PathBuf| Ok((path.clone(), Part::read(path)?));
    let parts = paths.iter().map(read).collect::<Result<Vec<_>, ExperimentError>>()?;
    let Some((first_path, first)) = parts.first() else {
        return Err(ExperimentError::Input("no parts to merge".to_owned()));
    };
    for (path, part) in &parts {
        if let Some(difference) = part.origin.difference(&first.origin) {
            let (path, first_path) = (path.display(), first_path.display());
            return Err(ExperimentError::Input(format!(
                "{path}: of another experiment than {first_path}: {difference}"
            )));
        }
    }
    let shards: Vec<_> = parts.iter().map(|(path, part)| (path.as_path(), part.shard)).collect();
    shard::check_complete(&shards)?;
    let (design, count) = (first.origin.design.clone(), parts.len());
    let trials = in_order(&design, parts.into_iter().map(|(_, part)| part));
    Ok(Joined { design, trials, parts: count })
}

/// The trials of all episodes from those of all shards.
fn in_order(design: &Design, parts: impl Iterator<Item = Part>) -> Vec<Trial> {
    let of = |part: Part| design.share(part.shard).map(|(place, ..)| place).zip(part.trials);
    let mut trials: Vec<(u64, Trial)> = parts.flat_map(of).collect();
    trials.sort_unstable_by_key(|&(place, _)| place);
    trials.into_iter().map(|(_, trial)| trial).collect()
}

impl Origin {
    fn new(program: &str, design: Design) -> Self {
        Self { program: program.to_owned(), design }
    }

    /// The first difference to another origin, in words.
    fn difference(&self, other: &Self) -> Option<String> {
        let (ours, theirs) = (&self.design, &other.design);
        if self.program != other.program {
            return Some(format!("of dragnet {} and not {}", self.program, other.program));
        }
        if ours.seeds != theirs.seeds {
            return Some(format!("{} and not {}", ours.seeds, theirs.seeds));
        }
        if ours.settings.len() != theirs.settings.len() {
            let names = |design: &Design| {
                design.settings.iter().map(Setting::to_string).collect::<Vec<_>>().join(", ")
            };
            return Some(format!("{} and not {}", names(ours), names(theirs)));
        }
        let (our, their) = ours.settings.iter().zip(&theirs.settings).find(|(our, their)| our != their)?;
        if our.to_string() == their.to_string() {
            Some(format!("{our} is not the same: its scenario, map or options differ"))
        } else {
            Some(format!("{our} and not {their}"))
        }
    }
}
