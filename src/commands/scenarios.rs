//! `dragnet scenarios`: lists and copies the scenarios that come with the program.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

use dragnet_scenario::shipped::ShippedScenario;

use super::{Failure, output};
use crate::terminal;

/// List the scenarios that come with the program, or copy some.
///
/// `run`, `compare`, `demonstrate` and `check` take these names instead of files.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet scenarios
  dragnet run ice_cream_cone
  dragnet scenarios --write warehouse        # to change it: warehouse.toml, and its map in maps/")]
pub(crate) struct Arguments {
    /// Copy a scenario with the maps that it names
    #[arg(long, value_name = "NAME", num_args = 1..)]
    write: Vec<String>,
    /// Folder to copy to; it is made if it is missing
    #[arg(long, value_name = "FOLDER", default_value = ".", requires = "write")]
    into: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.write.is_empty() {
        return Ok(terminal::print(&list())?);
    }
    let named = |name: &String| {
        ShippedScenario::named(name).ok_or_else(|| {
            let names: Vec<&str> = ShippedScenario::all().map(|it| it.name()).collect();
            Failure::Input(format!("--write {name}: no such scenario; allowed are {}", names.join(", ")))
        })
    };
    let scenarios = arguments.write.iter().map(named).collect::<Result<Vec<_>, _>>()?;
    for scenario in scenarios {
        terminal::print(&copy(scenario, arguments)?)?;
    }
    Ok(())
}

fn list() -> String {
    let width = ShippedScenario::all().map(|scenario| scenario.name().len()).max().unwrap_or(0);
    ShippedScenario::all().fold(String::new(), |mut text, scenario| {
        let _ = writeln!(text, "{:<width$}  {}", scenario.name(), scenario.summary());
        text
    })
}

/// Copies all files of a scenario, none of which may exist with another content, and tells which were written.
fn copy(scenario: ShippedScenario, arguments: &Arguments) -> Result<String, Failure> {
    let files: Vec<_> = scenario.files().map(|(name, bytes)| (arguments.into.join(name), bytes)).collect();
    for (file, bytes) in &files {
        if file.exists() && fs::read(file).ok().as_deref() != Some(bytes) {
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
        output::write(&file, bytes)?;
        let _ = writeln!(written, "{}", file.display());
    }
    Ok(written)
}
