//! Writes the files of a plan. Files of others are overwritten only if the viewer has agreed.

use std::fs;
use std::path::Path;

use axum::http::StatusCode;
use dragnet_planning::written::PlanFiles;

use super::Refused;

/// Writes the files of a plan into a folder; `own` are those that it wrote before. Returns what was done.
pub(super) fn save(
    folder: &Path,
    files: &PlanFiles,
    own: Option<&PlanFiles>,
    overwrite: bool,
) -> Result<String, Refused> {
    let is_own = |name: &str| {
        let text = own.and_then(|own| parts(own).into_iter().find(|part| part.0 == name)).map(|part| part.1);
        text.is_some_and(|text| is_content(folder, name, text))
    };
    let existing: Vec<String> = parts(files)
        .into_iter()
        .filter(|&(name, text)| {
            folder.join(name).exists() && !is_content(folder, name, text) && !is_own(name)
        })
        .map(|(name, _)| name.to_owned())
        .collect();
    let names = parts(files).map(|(name, _)| name).join(" and ");
    if !existing.is_empty() && !overwrite {
        let why = format!(
            "{} in {} exists already and was not saved here; choose another name, or overwrite it",
            existing.join(" and "),
            folder.display()
        );
        return Err(Refused { status: StatusCode::CONFLICT, why, existing });
    }
    // The areas first: a scenario is never there without them.
    for (name, text) in parts(files) {
        dragnet_files::write(&folder.join(name), text.as_bytes()).map_err(Refused::invalid)?;
    }
    let what = if existing.is_empty() { "Saved" } else { "Overwritten" };
    Ok(format!("{what}: {names} in {}.", folder.display()))
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
        let saved =
            |files, own, overwrite| save(folder.path(), files, own, overwrite).map_err(|it| it.existing);
        assert!(saved(&first, None, false).unwrap().starts_with("Saved"));
        assert!(is_on_disk(folder.path(), &first) && !is_on_disk(folder.path(), &second));
        assert!(saved(&second, Some(&first), false).unwrap().starts_with("Saved"), "its own");
        assert_eq!(read(), "second");
        assert_eq!(saved(&first, None, false), Err(vec!["a.toml".to_owned()]));
        assert_eq!(read(), "second");
        assert!(saved(&second, None, false).is_ok(), "the same content");
        fs::write(folder.path().join("a.toml"), "by somebody else").unwrap();
        assert_eq!(saved(&first, Some(&second), false), Err(vec!["a.toml".to_owned()]));
        assert!(saved(&first, Some(&second), true).unwrap().starts_with("Overwritten"));
        assert_eq!(read(), "first");
        let nowhere = folder.path().join("nowhere");
        assert!(save(&nowhere, &first, None, false).is_err_and(|refused| refused.why.contains("nowhere")));
    }
}
