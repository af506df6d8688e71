//! `dragnet scenarios`: lists and copies the scenarios that come with the program.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use dragnet_scenario::Scenario;
use dragnet_scenario::shipped::ShippedScenario;

use super::{Failure, output};
use crate::terminal;

/// List the scenarios that come with the program, or copy some.
///
/// `run`, `compare`, `demonstrate`, `check` and `sim` accept these names in place of files, and map files too: --write of
/// a map creates the scenario that they assume.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet scenarios
  dragnet run ice_cream_cone
  dragnet scenarios --write warehouse        # to change it: warehouse.toml, and its map in maps/
  dragnet scenarios --write area.kml         # area.toml, for a map alone")]
pub(crate) struct Arguments {
    /// Copy these scenarios, with the maps that they name, or create one for a map file
    #[arg(long, value_name = "NAME|MAP", num_args = 1..)]
    write: Vec<String>,
    /// Folder to copy to; it is created if it does not exist
    #[arg(long, value_name = "FOLDER", default_value = ".", requires = "write")]
    into: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.write.is_empty() {
        return Ok(terminal::print(&list())?);
    }
    // All are read before the first is written.
    let files = arguments.write.iter().map(|name| files(name, arguments)).collect::<Result<Vec<_>, _>>()?;
    for files in files {
        terminal::print(&write(files)?)?;
    }
    Ok(())
}

/// The files of a scenario, by path.
fn files(name: &str, arguments: &Arguments) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
    let path = Path::new(name);
    if let Some(scenario) = ShippedScenario::named(name) {
        let files = scenario.files();
        return Ok(files.map(|(name, bytes)| (arguments.into.join(name), bytes.to_vec())).collect());
    }
    if !path.exists() {
        let names: Vec<&str> = ShippedScenario::all().map(|it| it.name()).collect();
        return Err(Failure::Input(format!(
            "--write {name}: no such scenario, and no such map; allowed are map files, and {}",
            names.join(", ")
        )));
    }
    let scenario = Scenario::load(path).map_err(Failure::input)?;
    if !scenario.is_of_map() {
        return Err(Failure::Input(format!("--write {name}: a scenario already; allowed are maps")));
    }
    let absolute = |path: &Path| {
        path.canonicalize().map_err(|error| Failure::Input(format!("{}: {error}", path.display())))
    };
    let map = absolute(path)?;
    let is_beside = arguments.into.exists() && map.parent() == Some(&absolute(&arguments.into)?);
    let file = if is_beside { map.file_name().map(Path::new) } else { Some(map.as_path()) };
    let file = file
        .and_then(Path::to_str)
        .ok_or_else(|| Failure::Input(format!("--write {name}: its path is not UTF-8")))?;
    let scenario = path.with_extension("toml");
    let to = arguments.into.join(scenario.file_name().unwrap_or_default());
    Ok(vec![(to, Scenario::text_of_map(path, file).into_bytes())])
}

fn list() -> String {
    let width = ShippedScenario::all().map(|scenario| scenario.name().len()).max().unwrap_or(0);
    ShippedScenario::all().fold(String::new(), |mut text, scenario| {
        let _ = writeln!(text, "{:<width$}  {}", scenario.name(), scenario.summary());
        text
    })
}

/// Writes files, none of which may exist with another content; returns the list of written files as text.
fn write(files: Vec<(PathBuf, Vec<u8>)>) -> Result<String, Failure> {
    for (file, bytes) in &files {
        if file.exists() && fs::read(file).ok().as_ref() != Some(bytes) {
            let file = file.display();
            return Err(Failure::Input(format!("{file}: exists already; nothing is overwritten")));
        }
    }
    let mut written = String::new();
    for (file, bytes) in files {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder {
            let failed = |error| Failure::Input(format!("{}: {error}", folder.display()));
            fs::create_dir_all(folder).map_err(failed)?;
        }
        output::write(&file, &bytes)?;
        let _ = writeln!(written, "{}", file.display());
    }
    Ok(written)
}
