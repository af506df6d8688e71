//! Scenario files as damaged by mistakes, broken editors and attackers.

use dragnet_search::seed::Stream;
use rand::RngExt;
use rand::seq::IndexedRandom;

/// Extreme numbers, allowed and not.
const NUMBERS: [&str; 30] = [
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "100",
    "1000",
    "1001",
    "4096",
    "65536",
    "16777216",
    "16777217",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "9223372036854775808",
    "0.0",
    "-0.0",
    "0.5",
    "1.0",
    "1e-9",
    "1e-300",
    "5e-324",
    "1e9",
    "1e308",
    "1e999",
    "inf",
    "-inf",
    "nan",
];

/// Values of every type of TOML, and names that some key allows.
const VALUES: [&str; 40] = [
    "true",
    "\"\"",
    "\"x\"",
    "'''x\n'''",
    "[]",
    "[[]]",
    "[0]",
    "[1, 2]",
    "[[0, 0]]",
    "[[1, 2], [1, 2]]",
    "[-1, 0]",
    "{}",
    "{ name = 'path' }",
    "{ name = 'coverage', lane_spacing_cells = 2 }",
    "{ name = 'gnn', weights = 'team.toml' }",
    "{ name = 'gnn', weights = '/dev/zero' }",
    "1979-05-27",
    "07:32:00",
    "1979-05-27T07:32:00Z",
    "0x10",
    "'random'",
    "'scattered'",
    "'caves'",
    "'blocks'",
    "'rooms'",
    "'all_traversable'",
    "'open_asterisk'",
    "'gnn'",
    "'nats'",
    "'guts'",
    "'greedy'",
    "'clipped'",
    "'maps/warehouse.yaml'",
    "'maps/jersey.geojson'",
    "'maps/warehouse.pgm'",
    "'.'",
    "'/dev/zero'",
    "'team.toml'",
    "[[1], ['coordinator']]",
    "'\u{0}'",
];

/// Characters that may get into a text by mistake.
const CHARACTERS: [char; 24] = [
    '\0', '\u{1}', '\t', '\n', '\r', ' ', '"', '\'', '#', '=', '.', ',', '[', ']', '{', '}', '\\', '_', '0',
    'a', '\u{7f}', 'é', '\u{feff}', '🛰',
];

/// A scenario file with one to three faults; lines may come from others.
pub(crate) fn spoil(random: &mut Stream, text: &str, others: &[&str]) -> String {
    let mut text = text.to_owned();
    for _ in 0..*[1, 1, 2, 3].choose(random).unwrap() {
        text = match random.random_range(0..20) {
            0..=4 => lines(random, &text, others),
            5..=12 => number(random, &text),
            13..=14 => value(random, &text),
            15..=16 => key(random, &text),
            17 => character(random, &text),
            18 => cut(random, &text),
            _ => nested(random, &text),
        };
    }
    text
}

/// A line is lost, doubled or moved, or one of another file is inserted.
fn lines(random: &mut Stream, text: &str, others: &[&str]) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    if lines.is_empty() {
        return String::new();
    }
    let (line, place) = (random.random_range(0..lines.len()), random.random_range(0..lines.len()));
    match random.random_range(0..5) {
        0 => {
            lines.remove(line);
        }
        1 => lines.insert(place, lines[line]),
        2 => lines.swap(line, place),
        choice => {
            let other: Vec<&str> = others.choose(random).unwrap().lines().collect();
            let foreign = *other.choose(random).unwrap();
            if choice == 3 { lines[line] = foreign } else { lines.insert(line, foreign) }
        }
    }
    lines.join("\n") + "\n"
}

/// One of the numbers becomes another.
fn number(random: &mut Stream, text: &str) -> String {
    let mut text = text.to_owned();
    let (mut places, mut from) = (Vec::new(), 0);
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e');
    while let Some(start) = text[from..].find(|c: char| c.is_ascii_digit()).map(|at| from + at) {
        let end = text[start..].find(|c| !is_part(c)).map_or(text.len(), |at| start + at);
        places.push(start..end);
        from = end;
    }
    if let Some(place) = places.choose(random) {
        text.replace_range(place.clone(), NUMBERS.choose(random).unwrap());
    }
    text
}

/// The value of a key becomes another.
fn value(random: &mut Stream, text: &str) -> String {
    let value = *VALUES.choose(random).unwrap();
    change_line(random, text, |_, key, _| format!("{key}= {value}"))
}

/// A key is misspelt.
fn key(random: &mut Stream, text: &str) -> String {
    change_line(random, text, |random, key, value| {
        let mut letters: Vec<char> = key.chars().collect();
        let place = random.random_range(0..=letters.len());
        if random.random() {
            letters.insert(place, *CHARACTERS.choose(random).unwrap());
        } else {
            letters.truncate(place);
        }
        format!("{}={value}", letters.into_iter().collect::<String>())
    })
}

/// A value or a key is nested too deeply.
fn nested(random: &mut Stream, text: &str) -> String {
    let depth = *[1, 10, 79, 81, 1000, 20_000].choose(random).unwrap();
    let shape = random.random_range(0..4);
    change_line(random, text, |_, key, value| match shape {
        0 => format!("{key}={}{value}{}", "[".repeat(depth), "]".repeat(depth)),
        1 => format!("{key}={}{value}{}", "{ a = ".repeat(depth), " }".repeat(depth)),
        2 => format!("{}{key}={value}", "a.".repeat(depth)),
        _ => format!("[{}{}]\n{key}={value}", "a.".repeat(depth), key.trim()),
    })
}

/// Changes one of the lines that hold a key, given the text before and after its `=`.
fn change_line(
    random: &mut Stream,
    text: &str,
    change: impl FnOnce(&mut Stream, &str, &str) -> String,
) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let with_key: Vec<usize> = (0..lines.len()).filter(|&line| lines[line].contains('=')).collect();
    let Some(&line) = with_key.choose(random) else { return text.to_owned() };
    let (key, value) = lines[line].split_once('=').unwrap_or_default();
    let changed = change(random, key, value);
    [&lines[..line], &[changed.as_str()], &lines[line + 1..]].concat().join("\n") + "\n"
}

fn character(random: &mut Stream, text: &str) -> String {
    let mut characters: Vec<char> = text.chars().collect();
    let character = *CHARACTERS.choose(random).unwrap();
    let place = random.random_range(0..=characters.len());
    if place < characters.len() && random.random() {
        characters[place] = character;
    } else {
        characters.insert(place, character);
    }
    characters.into_iter().collect()
}

fn cut(random: &mut Stream, text: &str) -> String {
    let kept = random.random_range(0..=text.chars().count());
    text.chars().take(kept).collect()
}
