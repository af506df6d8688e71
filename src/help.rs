//! The subcommands in groups for `dragnet --help`, which clap itself lists in one.

use std::fmt::Write;

use clap::Command;

/// What each group is for, and its subcommands.
const GROUPS: [(&str, &[&str]); 5] = [
    (
        "Search",
        &[
            "run",
            "plan",
            "scenarios",
            "forecast",
            "compare",
            "benchmark",
            "paper",
            "merge",
            "check",
            "schema",
            "soak",
        ],
    ),
    ("Learn", &["demonstrate", "train", "reinforce"]),
    ("Field", &["agent", "coordinator", "doctor", "calibrate", "detect", "sim", "relay"]),
    ("Recordings", &["inspect", "replay", "export", "recover"]),
    ("Security and shell", &["keys", "completions", "help"]),
];

/// The command line with its subcommands in groups.
pub(crate) fn grouped(mut command: Command) -> Command {
    // clap adds `help` only on build.
    command.build();
    let groups = groups(&command);
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n{groups}\nOptions:\n{{options}}{{after-help}}"
    ))
}

fn groups(command: &Command) -> String {
    let mut text = String::new();
    for (title, names) in GROUPS {
        let _ = writeln!(text, "\n{title}:");
        for name in names {
            let about = command.find_subcommand(name).and_then(Command::get_about);
            let about = about.map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(text, "  {name:<12} {}", about.lines().next().unwrap_or_default());
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn each_subcommand_is_in_one_group_and_on_a_line_of_its_own() {
        let mut command = crate::CommandLine::command();
        command.build();
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        let mut all: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
        grouped.sort_unstable();
        all.sort_unstable();
        assert_eq!(grouped, all);
        for line in groups(&command).lines() {
            assert!(line.len() <= 100, "{line}");
        }
    }
}
