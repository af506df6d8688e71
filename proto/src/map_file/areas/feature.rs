//! What a file draws, whatever its format: shapes as they stand there, with a name and what is said of them.

use std::collections::BTreeMap;

/// A position as it is written, degrees: longitude, latitude, and what may follow.
pub(super) type Position = Vec<f64>;

/// Something drawn.
#[derive(Debug, Default)]
pub(super) struct Feature {
    /// Where it stands in its file, for messages: its number or line, and its name.
    pub place: String,
    pub name: Option<String>,
    pub facts: Facts,
    pub shapes: Shapes,
}

/// What its author says of a feature, by key.
#[derive(Debug, Default)]
pub(super) struct Facts(BTreeMap<&'static str, String>);

/// Where a feature lies, not checked yet.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    /// Each a list of rings, the outer one first.
    pub polygons: Vec<Vec<Vec<Position>>>,
    pub lines: Vec<Vec<Position>>,
    pub points: Vec<Position>,
}

impl Feature {
    /// A feature at a place, such as `feature 3`, with what may be its name.
    pub(super) fn at(place: &str, name: Option<String>) -> Self {
        let name = name.map(|name| name.trim().to_owned()).filter(|name| !name.is_empty());
        let shown = name.as_ref().map(|name| name.chars().take(40).collect::<String>());
        let place = shown.map_or_else(|| place.to_owned(), |shown| format!("{place} {shown:?}"));
        Self { place, name, ..Self::default() }
    }
}

impl Facts {
    pub(super) const KIND: &str = "kind";
    pub(super) const POA: &str = "poa";
    pub(super) const SPREAD: &str = "spread_meters";
    const KEYS: [&str; 3] = [Self::KIND, Self::POA, Self::SPREAD];

    /// Keeps what is said under a key that means something; what was said first stays.
    pub(super) fn say(&mut self, key: &str, value: &str) {
        let known = Self::KEYS.into_iter().find(|known| known.eq_ignore_ascii_case(key.trim()));
        if let Some(known) = known.filter(|_| !value.trim().is_empty()) {
            self.0.entry(known).or_insert_with(|| value.trim().to_owned());
        }
    }

    /// Keeps what the lines of a description say, such as `poa: 25 %`: for tools that know no properties.
    pub(super) fn describe(&mut self, description: &str) {
        let breaks = description.replace("<br>", "\n").replace("<br/>", "\n").replace("<br />", "\n");
        for line in breaks.lines() {
            if let Some((key, value)) = line.split_once([':', '=']) {
                self.say(key, value);
            }
        }
    }

    pub(super) fn get(&self, key: &'static str) -> Option<&str> {
        self.0.get(key).map(String::as_str)
    }
}

impl Shapes {
    pub(super) fn corner_count(&self) -> usize {
        let rings: usize = self.polygons.iter().flatten().map(Vec::len).sum();
        rings + self.lines.iter().map(Vec::len).sum::<usize>() + self.points.len()
    }

    pub(super) fn ring_count(&self) -> usize {
        self.polygons.iter().map(Vec::len).sum::<usize>() + self.lines.len()
    }

    /// What is drawn, in words.
    pub(super) fn describe(&self) -> String {
        let counts =
            [(self.polygons.len(), "polygon"), (self.lines.len(), "line"), (self.points.len(), "point")];
        let words: Vec<String> = counts
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, word)| format!("{count} {word}{}", if count == 1 { "" } else { "s" }))
            .collect();
        if words.is_empty() { "nothing".to_owned() } else { words.join(" and ") }
    }
}
