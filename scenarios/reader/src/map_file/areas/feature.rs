//! Features of a file of any format: shapes with a name and properties.

use std::collections::BTreeMap;

use super::{Purpose, description};

/// A word by which a feature seems to be meant for a search, in the form of [`words`].
const NO_GO_WORD: &str = "no_go";

/// A position as written, degrees: longitude, latitude, and optional further values.
pub(super) type Position = Vec<f64>;

/// A drawn feature.
#[derive(Debug, Default)]
pub(super) struct Feature {
    /// Its position in its file, for messages: its number or line, and its name.
    pub place: String,
    pub name: Option<String>,
    pub facts: Facts,
    pub shapes: Shapes,
}

/// Properties of a feature, by key.
#[derive(Debug, Default)]
pub(super) struct Facts {
    known: BTreeMap<&'static str, String>,
    /// A text that seems to be meant for a search but is not understood.
    unclear: Option<String>,
    /// A key with two different values.
    conflict: Option<Conflict>,
    /// Whether it is part of an export: then its `poa` is a result.
    is_account: bool,
}

/// A key with two different values.
#[derive(Clone, Debug)]
pub(super) struct Conflict {
    pub key: &'static str,
    pub first: String,
    pub second: String,
}

/// The shapes of a feature, not checked yet.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    /// Each a list of rings, the outer one first.
    pub polygons: Vec<Vec<Vec<Position>>>,
    pub lines: Vec<Vec<Position>>,
    pub points: Vec<Position>,
}

impl Feature {
    /// A feature at a position such as `feature 3`, with its name, if any.
    pub(super) fn at(place: &str, name: Option<String>) -> Self {
        let name = name.map(|name| name.trim().to_owned()).filter(|name| !name.is_empty());
        let shown = name.as_ref().map(|name| name.chars().take(40).collect::<String>());
        let place = shown.map_or_else(|| place.to_owned(), |shown| format!("{place} {shown:?}"));
        let mut feature = Self { place, name, ..Self::default() };
        if let Some(name) =
            feature.name.as_deref().filter(|name| words(name).iter().any(|word| word == NO_GO_WORD))
        {
            feature.facts.unclear = Some(format!("its name, {:?}", shortened(name)));
        }
        feature
    }
}

impl Facts {
    pub(super) const KIND: &str = "kind";
    pub(super) const POA: &str = "poa";
    pub(super) const SPREAD: &str = "spread_meters";
    pub(super) const QUARTILES: &str = "quartiles_meters";
    const POD: &str = "pod";
    const KEYS: [&str; 4] = [Self::KIND, Self::POA, Self::SPREAD, Self::QUARTILES];

    /// Stores a property whose key has a meaning.
    pub(super) fn add_property(&mut self, key: &str, value: &str) {
        let value = value.trim();
        if value.is_empty() {
            // Tables have a column for all of their rows.
            return;
        }
        self.is_account |= key.trim().eq_ignore_ascii_case(Self::POD);
        if let Some(known) = known_key(key) {
            self.learn(known, value);
        } else {
            self.suspect_property(key, value);
        }
    }

    /// Looks for text that seems to be meant for a search in a property that has no meaning.
    pub(super) fn suspect_property(&mut self, key: &str, value: &str) {
        // A column `no_go` tells of most rows that they are none.
        let is_denied = matches!(value.trim().to_lowercase().as_str(), "" | "false" | "no" | "0" | "none");
        let is_about = is_own_key(key)
            || is_kind(value)
            || words(key).iter().any(|word| word == NO_GO_WORD) && !is_denied
            || description::lines(value).iter().any(|line| is_about_searches(line));
        if is_about {
            self.suspect(&format!("{key}: {value}"));
        }
    }

    /// Looks for it in a text.
    pub(super) fn suspect_text(&mut self, whose: &str, text: &str) {
        if let Some(line) = Self::line_about_searches(text) {
            self.suspect_line(whose, &line);
        }
    }

    /// Stores such a line of a text that describes more than this feature.
    pub(super) fn suspect_line(&mut self, whose: &str, line: &str) {
        self.unclear.get_or_insert_with(|| format!("{whose} {:?}", shortened(line)));
    }

    /// The first line of a text that seems to be meant for a search.
    pub(super) fn line_about_searches(text: &str) -> Option<String> {
        description::lines(text).into_iter().find(|line| is_about_searches(line))
    }

    /// Stores the properties in the lines of a description, such as `poa: 25 %`, for tools without properties.
    pub(super) fn describe(&mut self, description: &str) {
        for line in description::lines(description) {
            let property = line.split_once([':', '=']).filter(|(_, value)| !value.trim().is_empty());
            match property.and_then(|(key, value)| Some((known_key(key)?, value))) {
                Some((known, value)) => self.learn(known, value.trim()),
                None if is_about_searches(&line) => self.suspect(&line),
                None => {}
            }
        }
    }

    /// Stores the first value of a key, and whether a later one differs.
    fn learn(&mut self, key: &'static str, value: &str) {
        let first = self.known.entry(key).or_insert_with(|| value.to_owned());
        if !is_same(first, value) {
            let (first, second) = (shortened(first), shortened(value));
            self.conflict.get_or_insert(Conflict { key, first, second });
        }
    }

    /// The key with two different values, if any.
    pub(super) const fn conflict(&self) -> Option<&Conflict> {
        self.conflict.as_ref()
    }

    /// Stores a text that seems to be meant for a search, for a feature without a kind.
    fn suspect(&mut self, found: &str) {
        self.unclear.get_or_insert_with(|| format!("{:?}", shortened(found)));
    }

    /// A text that seems to be meant for a search but is not understood.
    pub(super) fn unclear(&self) -> Option<&str> {
        self.unclear.as_deref()
    }

    /// Whether it is part of an export, with results of a search.
    pub(super) const fn is_account(&self) -> bool {
        self.is_account
    }

    /// Whether there are any properties.
    pub(super) fn are_some(&self) -> bool {
        !self.known.is_empty()
    }

    pub(super) fn get(&self, key: &'static str) -> Option<&str> {
        self.known.get(key).map(String::as_str)
    }
}

/// Whether two values are equal in different spellings: `no go` and `No_go`, 25% and 0.25.
fn is_same(a: &str, b: &str) -> bool {
    match (number(a), number(b)) {
        _ if a == b => true,
        (Some(a), Some(b)) => (a - b).abs() <= 1e-9 * a.abs().max(b.abs()),
        _ => words(a) == words(b),
    }
}

/// A number; a percentage as a share.
pub(super) fn number(text: &str) -> Option<f64> {
    match text.strip_suffix('%') {
        Some(percent) => percent.trim().parse().ok().map(|percent: f64| percent / 100.0),
        None => text.parse().ok(),
    }
}

fn known_key(key: &str) -> Option<&'static str> {
    Facts::KEYS.into_iter().find(|known| known.eq_ignore_ascii_case(key.trim()))
}

/// Whether a text is one of the kinds that do not occur by chance.
fn is_kind(text: &str) -> bool {
    matches!(words(text).join(" ").as_str(), NO_GO_WORD | "last known position" | "linear feature")
}

/// Whether a key is one of Dragnet's, in any spelling: `kind`, `POA (%)`, `spread m`.
fn is_own_key(key: &str) -> bool {
    let words = words(key);
    match words.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["kind" | "poa" | "spread" | "quartiles"] => true,
        [first, second] => {
            [first, second].iter().any(|word| matches!(**word, "poa" | "spread" | "quartiles"))
        }
        _ => false,
    }
}

/// Whether a line is about searches without being a valid property: it has one of Dragnet's keys, or an unmistakable
/// word.
fn is_about_searches(line: &str) -> bool {
    let is_keyed = line.split_once([':', '=']).is_some_and(|(key, _)| is_own_key(key));
    let words = words(line);
    let is_said = match words.as_slice() {
        [key, _] => key == "kind",
        [key, .., number] => key == "spread" && number.parse::<f64>().is_ok(),
        _ => false,
    };
    is_keyed || is_said || words.iter().any(|word| word == NO_GO_WORD || word == "poa")
}

/// The words of a text in small letters; `no go`, `no-go`, `no_go` and `nogo` are one.
fn words(text: &str) -> Vec<String> {
    let text = text.to_lowercase();
    let mut words: Vec<String> = Vec::new();
    for word in text.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty()) {
        match words.last_mut() {
            Some(last) if last == "no" && word == "go" => NO_GO_WORD.clone_into(last),
            _ if word == "nogo" => words.push(NO_GO_WORD.to_owned()),
            _ => words.push(word.to_owned()),
        }
    }
    words
}

fn shortened(text: &str) -> String {
    text.chars().take(60).collect()
}

impl Shapes {
    pub(super) fn corner_count(&self) -> usize {
        let rings: usize = self.polygons.iter().flatten().map(Vec::len).sum();
        rings + self.lines.iter().map(Vec::len).sum::<usize>() + self.points.len()
    }

    pub(super) fn ring_count(&self) -> usize {
        self.polygons.iter().map(Vec::len).sum::<usize>() + self.lines.len()
    }

    /// Its shapes, in words.
    pub(super) fn describe(&self) -> String {
        self.describe_only([true; 3])
    }

    /// Its shapes that an area of this purpose does not use, in words, if any.
    pub(super) fn beside(&self, purpose: &Purpose) -> Option<String> {
        let is_beside = match purpose {
            Purpose::Search(_) | Purpose::Prior { .. } => [false, true, true],
            Purpose::NoGo(..) => [false, false, true],
            Purpose::LinearFeature { .. } => [true, false, true],
            Purpose::LastKnownPosition { .. } | Purpose::Start(_) => [true, true, false],
        };
        let counts = [self.polygons.len(), self.lines.len(), self.points.len()];
        let is_some = is_beside.iter().zip(counts).any(|(is_beside, count)| *is_beside && count > 0);
        is_some.then(|| self.describe_only(is_beside))
    }

    /// The requested shapes of polygons, lines and points, in words.
    fn describe_only(&self, are_asked: [bool; 3]) -> String {
        let counts =
            [(self.polygons.len(), "polygon"), (self.lines.len(), "line"), (self.points.len(), "point")];
        let words: Vec<String> = counts
            .into_iter()
            .zip(are_asked)
            .filter_map(|(counted, is_asked)| is_asked.then_some(counted))
            .filter(|(count, _)| *count > 0)
            .map(|(count, word)| format!("{count} {word}{}", if count == 1 { "" } else { "s" }))
            .collect();
        if words.is_empty() { "nothing".to_owned() } else { words.join(" and ") }
    }
}
