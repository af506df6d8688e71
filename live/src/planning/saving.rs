//! Writes the files of a plan. Files of others are overwritten only if the viewer has agreed.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use axum::http::StatusCode;
use dragnet_planning::written::PlanFiles;

use super::Refused;

/// The files that were saved here: their contents by their names.
pub(super) type Own = BTreeMap<String, String>;

/// Writes the files of a plan into a folder; `own` are those that were written before. Returns what was done.
pub(super) fn save(
    folder: &Path,
    files: &PlanFiles,
    own: &mut Own,
    overwrite: bool,
) -> Result<String, Refused> {
    let is_own = |name: &str| own.get(name).is_some_and(|text| is_content(folder, name, text));
    let existing: Vec<&str> = parts(files)
        .into_iter()
        .filter(|&(name, text)| {
            folder.join(name).exists() && !is_content(folder, name, text) && !is_own(name)
        })
        .map(|(name, _)| name)
        .collect();
    let names = parts(files).map(|(name, _)| name).join(" and ");
    if !existing.is_empty() && !overwrite {
        let why = format!("{}; choose another name, or overwrite it", about(&existing, own, folder));
        let existing = existing.into_iter().map(str::to_owned).collect();
        return Err(Refused { status: StatusCode::CONFLICT, why, existing });
    }
    // The areas first: a scenario is never there without them.
    for (name, text) in parts(files) {
        dragnet_files::write(&folder.join(name), text.as_bytes()).map_err(Refused::invalid)?;
        own.insert(name.to_owned(), text.to_owned());
    }
    let what = if existing.is_empty() { "Saved" } else { "Overwritten" };
    Ok(format!("{what}: {names} in {}.", folder.display()))
}

/// Why files are not overwritten: others wrote them, or changed them.
fn about(existing: &[&str], own: &Own, folder: &Path) -> String {
    let (changed, foreign): (Vec<&str>, Vec<&str>) =
        existing.iter().partition(|&&name| own.contains_key(name));
    let both = [
        (changed, ["has changed since it was saved here", "have changed since they were saved here"]),
        (foreign, ["exists already and was not saved here", "exist already and were not saved here"]),
    ];
    let of_each = both.into_iter().filter(|(names, _)| !names.is_empty()).map(|(names, [one, several])| {
        let what = if names.len() == 1 { one } else { several };
        format!("{} in {} {what}", names.join(" and "), folder.display())
    });
    of_each.collect::<Vec<_>>().join("; ")
}

/// Whether the files are on disk as they are here.
pub(super) fn is_on_disk(folder: &Path, files: &PlanFiles) -> bool {
    parts(files).into_iter().all(|(name, text)| is_content(folder, name, text))
}

fn is_content(folder: &Path, name: &str, text: &str) -> bool {
    fs::read(folder.join(name)).is_ok_and(|bytes| bytes == text.as_bytes())
}

/// Names and contents.
fn parts(files: &PlanFiles) -> [(&str, &str); 2] {
    [(&files.areas_name, &files.areas_text), (&files.scenario_name, &files.scenario_text)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(text: &str) -> PlanFiles {
        PlanFiles {
            scenario_name: "a.toml".to_owned(),
            scenario_text: text.to_owned(),
            areas_name: "a.geojson".to_owned(),
            areas_text: "areas".to_owned(),
        }
    }

    #[test]
    fn files_of_others_are_overwritten_only_if_that_is_agreed() {
        let folder = tempfile::tempdir().unwrap();
        let (first, second) = (files("first"), files("second"));
        let read = || fs::read_to_string(folder.path().join("a.toml")).unwrap();
        let saved = |files, own: &mut Own, overwrite| {
            save(folder.path(), files, own, overwrite).map_err(|refused| {
                assert_eq!(refused.existing, ["a.toml"]);
                refused.why
            })
        };
        let (mut own, mut nothing) = (Own::new(), Own::new());
        assert!(saved(&first, &mut own, false).unwrap().starts_with("Saved"));
        assert!(is_on_disk(folder.path(), &first) && !is_on_disk(folder.path(), &second));
        assert!(saved(&second, &mut own, false).unwrap().starts_with("Saved"), "its own");
        assert_eq!(read(), "second");
        let why = saved(&first, &mut nothing, false).unwrap_err();
        assert!(why.contains("a.toml in ") && why.contains("was not saved here"), "{why}");
        assert_eq!(read(), "second");
        assert!(saved(&second, &mut nothing, false).is_ok(), "the same content");
        fs::write(folder.path().join("a.toml"), "by somebody else").unwrap();
        let why = saved(&first, &mut own, false).unwrap_err();
        assert!(why.contains("has changed since it was saved here") && !why.contains("not saved"), "{why}");
        assert!(saved(&first, &mut own, true).unwrap().starts_with("Overwritten"));
        assert_eq!(read(), "first");
        let nowhere = folder.path().join("nowhere");
        assert!(
            save(&nowhere, &first, &mut own, false).is_err_and(|refused| refused.why.contains("nowhere"))
        );
    }
}
