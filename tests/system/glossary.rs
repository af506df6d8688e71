//! Public names are the field's words: each is in `docs/glossary.md` or an ordinary word, and given-up names and words
//! do not come back.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use dragnet_search::policy::PolicyName;
use serde_json::Value;

use crate::field::DRAGNET;

/// Ordinary words of software and robotics that need no entry.
const ORDINARY: &str = "about acceleration address agent agnostic alarms alive arrays attached batch ca calibrate certificate choice class classes \
    common compare completions compressed confidence connection correlation cpu csv decide demonstrate detect doctor domain doubled dry \
    epochs error every explore export false format frame fusion gate goal goals height help hidden id inspect into json key kind \
    kinds latitude learning live load local longitude markdown merge minutes miss module namespace next node odometry patience \
    period pitch placement plot print priorities processes publish quality rate recover relay replan replay reset resolution reverse \
    ros router run safety save schema sender sequence server soak source speed stamps step stop strength subscribe take text threads token \
    transport uncorrected url velocity wake when width window withdrawn write z";

/// Names that were given up for those of the glossary.
const GIVEN_UP: [&str; 40] = [
    "expected_undeclared",
    "lost_after_seconds",
    "clock_tolerance_seconds",
    "stagger_seconds",
    "sigma2",
    "lane_cells",
    "hold_out_every",
    "most_decisions",
    "on_silence",
    "pose_silence_seconds",
    "camera_silence_seconds",
    "most_deviation_meters",
    "settling_seconds",
    "first_look_seconds",
    "nearest_meters",
    "farthest_meters",
    "column_deviation_pixels",
    "confirming_hits",
    "losing_misses",
    "forgetting_seconds",
    "first_looks",
    "heading_degrees",
    "forward_meters",
    "Stimulus",
    "MindError",
    "MissionOrders",
    "LocalCrew",
    "RemoteCrew",
    "Puppet",
    "Expedition",
    "Outlook",
    "LogRequest",
    "LogReply",
    "PathByDefinition",
    "Attendance",
    "Bites",
    "Errand",
    "Sights",
    "Onlooker",
    "log_request",
];

/// Private words that were given up, as phrases that have no plain meaning in a help text or in documentation.
const GIVEN_UP_PHRASES: [&str; 32] = [
    "a look",
    "one look",
    "last look",
    "first look",
    "looks around",
    "is told",
    "are told",
    "is heard",
    "are heard",
    "hears of",
    "sign of life",
    "signs of life",
    "what it sees",
    "what it says",
    "whoever",
    "whom",
    "somebody",
    "nobody",
    "believes that",
    "not believed",
    "promised",
    "promises",
    "goes on its way",
    "its own way",
    "way covered",
    "this way (",
    "by hand",
    "started anew",
    "what cannot be",
    "as given",
    "so many",
    "taken down",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap()
}

/// Keys of the files that a schema describes.
fn schema_keys(value: &Value, keys: &mut BTreeSet<String>) {
    match value {
        Value::Object(entries) => {
            if let Some(Value::Object(properties)) = entries.get("properties") {
                keys.extend(properties.keys().cloned());
            }
            entries.values().for_each(|value| schema_keys(value, keys));
        }
        Value::Array(values) => values.iter().for_each(|value| schema_keys(value, keys)),
        _ => {}
    }
}

/// Fields of messages.
fn message_fields() -> Vec<String> {
    let entries = fs::read_dir(root().join("proto/msg")).unwrap();
    let texts = entries.map(|entry| fs::read_to_string(entry.unwrap().path()).unwrap());
    let fields = |text: String| -> Vec<String> {
        let definitions = text.lines().map(|line| line.split('#').next().unwrap_or_default());
        let parts = definitions.filter_map(|line| line.trim().split_once(' '));
        parts.map(|(_, name)| name.trim().to_owned()).filter(|name| !name.contains('=')).collect()
    };
    texts.flat_map(fields).collect()
}

fn help(arguments: &[&str]) -> String {
    let output = Command::new(DRAGNET).args(arguments).arg("--help").output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

/// Subcommands and their flags.
fn command_line() -> Vec<String> {
    let top = help(&[]);
    let names = top.lines().filter_map(|line| line.strip_prefix("  ")?.split_once("  "));
    let names =
        names.map(|(name, _)| name.trim()).filter(|name| name.chars().all(|it| it.is_ascii_lowercase()));
    let names: Vec<&str> = names.filter(|name| !name.is_empty() && *name != "help").collect();
    assert!(names.len() > 15, "{top}");
    let flags = |name: &&str| -> Vec<String> {
        let help = help(&[*name]);
        let first = help.lines().map(str::trim).filter(|line| line.starts_with('-'));
        let flags = first
            .filter_map(|line| line.split([' ', ',', '[', '=']).find_map(|word| word.strip_prefix("--")));
        flags.map(str::to_owned).collect()
    };
    names.iter().flat_map(flags).chain(names.iter().map(|&name| name.to_owned())).collect()
}

/// Names of the Python package.
fn python_names() -> Vec<String> {
    let text = read("python/dragnet/_dragnet.pyi");
    let methods = text.lines().filter_map(|line| line.trim().strip_prefix("def ")?.split_once('('));
    methods.map(|(name, _)| name.to_owned()).filter(|name| !name.starts_with('_')).collect()
}

#[test]
fn each_public_name_is_made_of_words_of_the_glossary_or_ordinary_ones() {
    let mut names = BTreeSet::new();
    for file in ["scenarios/scenario", "deploy/agent", "deploy/coordinator", "deploy/sim"] {
        schema_keys(&serde_json::from_str(&read(&format!("{file}.schema.json"))).unwrap(), &mut names);
    }
    assert!(names.len() > 100, "{names:?}");
    names.extend(message_fields().into_iter().chain(command_line()).chain(python_names()));
    assert!(names.len() > 200, "{}", names.len());
    let glossary = read("docs/glossary.md").to_lowercase();
    let known: BTreeSet<&str> = glossary
        .split(|character: char| !character.is_ascii_alphanumeric())
        .chain(ORDINARY.split_whitespace())
        .collect();
    let is_known = |word: &str| known.contains(word) || known.contains(word.trim_end_matches('s'));
    let strange: Vec<&String> = names.iter().filter(|name| !name.split(['_', '-']).all(is_known)).collect();
    assert!(strange.is_empty(), "in neither docs/glossary.md nor ORDINARY: {strange:?}");
}

#[test]
fn each_policy_is_in_the_guide_and_in_the_glossary() {
    let (guide, glossary) = (read("docs/guide.md"), read("docs/glossary.md"));
    for policy in PolicyName::ALL {
        let row = format!("| `{policy}` |");
        assert!(guide.contains(&row), "docs/guide.md: {row}");
        assert!(glossary.contains(&format!("`{policy}`")), "docs/glossary.md: {policy}");
    }
}

/// Files of the repository that people read or write, except for its history.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let skipped =
        ["target", ".git", ".venv", "third_party", "node_modules", "dist", "CHANGELOG.md", "glossary.rs"];
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if skipped.contains(&name) {
            continue;
        }
        if path.is_dir() {
            files(&path, found);
        } else if path
            .extension()
            .is_some_and(|it| ["rs", "md", "msg", "py", "pyi", "toml", "ts"].iter().any(|kind| it == *kind))
        {
            found.push(path);
        }
    }
}

#[test]
fn names_that_were_given_up_do_not_come_back() {
    let mut found = Vec::new();
    files(root(), &mut found);
    assert!(found.len() > 400, "{}", found.len());
    for path in found {
        let text = fs::read_to_string(&path).unwrap();
        let words: BTreeSet<&str> =
            text.split(|it: char| !(it.is_ascii_alphanumeric() || it == '_')).collect();
        for name in GIVEN_UP {
            assert!(!words.contains(name), "{}: {name}", path.display());
        }
    }
}

fn assert_plain(place: &str, text: &str) {
    let text = text.to_lowercase().split_whitespace().collect::<Vec<_>>().join(" ");
    let is_letter = |it: Option<char>| it.is_some_and(char::is_alphanumeric);
    for phrase in GIVEN_UP_PHRASES {
        let is_whole = |(at, _): (usize, &str)| {
            !is_letter(text[..at].chars().next_back()) && !is_letter(text[at + phrase.len()..].chars().next())
        };
        assert!(!text.match_indices(phrase).any(is_whole), "{place}: {phrase:?} in {text:?}");
    }
}

#[test]
fn help_texts_have_no_words_that_were_given_up() {
    assert_plain("dragnet", &help(&[]));
    let commands = fs::read_dir(root().join("src/commands")).unwrap();
    let names = commands.filter_map(|entry| {
        let name = entry.unwrap().file_name().into_string().unwrap();
        Some(name.strip_suffix(".rs")?.replace('_', "-"))
    });
    let top = help(&[]);
    let names: Vec<String> = names.filter(|name| top.contains(&format!("\n  {name} "))).collect();
    assert!(names.len() > 15, "{names:?}");
    for name in names {
        assert_plain(&name, &help(&[&name]));
    }
}

/// The documentation of public items of a source file, and of the file itself; a text for each.
fn public_documentation(source: &str) -> Vec<String> {
    let (mut documentation, mut text) = (Vec::new(), String::new());
    for line in source.lines().map(str::trim_start) {
        if let Some(line) = line.strip_prefix("//!") {
            documentation.push(line.to_owned());
        } else if let Some(line) = line.strip_prefix("///") {
            text.push_str(line);
        } else if !line.starts_with("#[") && !text.is_empty() {
            let documented = std::mem::take(&mut text);
            if line.starts_with("pub ") {
                documentation.push(documented);
            }
        }
    }
    documentation
}

#[test]
fn public_documentation_has_no_words_that_were_given_up() {
    let mut found = Vec::new();
    files(root(), &mut found);
    let sources = found.iter().filter(|path| path.extension().is_some_and(|it| it == "rs"));
    let mut count = 0;
    for path in sources {
        for text in public_documentation(&fs::read_to_string(path).unwrap()) {
            assert_plain(&path.display().to_string(), &text);
            count += 1;
        }
    }
    assert!(count > 2000, "{count}");
}
