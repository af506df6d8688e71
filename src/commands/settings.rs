//! Settings of the processes of a mission as text: a reference, and a complete file with comments. Both are generated
//! from the JSON Schema of the types that read the settings.

use std::fmt::Write;

use clap::ValueEnum;
use dragnet_runtime::config::{AgentSettings, CoordinatorSettings, SimSettings};
use dragnet_scenario::{schema_json, schema_of};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

/// A kind of TOML file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// A scenario
    Scenario,
    /// Settings of `dragnet agent`
    Agent,
    /// Settings of `dragnet coordinator`
    Coordinator,
    /// Settings of `dragnet sim`
    Sim,
}

impl Kind {
    /// The JSON Schema of such a file.
    pub(crate) fn schema(self) -> String {
        match self {
            Self::Scenario => schema_json(),
            Self::Agent => schema_of::<AgentSettings>(),
            Self::Coordinator => schema_of::<CoordinatorSettings>(),
            Self::Sim => schema_of::<SimSettings>(),
        }
    }

    /// The kind of a file, by the keys that only that kind has.
    pub(crate) fn of(text: &str) -> Self {
        let keys = toml::from_str::<Keys>(text).unwrap_or_else(|_| Keys::seen(text));
        match (keys.common.is_some(), keys.robot.is_some()) {
            (true, true) => Self::Agent,
            (true, false) => Self::Coordinator,
            (false, _) if keys.mission.is_some_and(|mission| mission.is_str()) => Self::Sim,
            (false, _) => Self::Scenario,
        }
    }

    /// A complete file with comments: required keys have example values; optional keys have their defaults or are
    /// commented out.
    pub(crate) fn template(self) -> String {
        let sections = sections(&self.schema());
        let mut text = String::new();
        for section in &sections {
            section.write_template(&mut text);
        }
        text
    }

    /// All keys as Markdown tables.
    pub(crate) fn reference(self) -> String {
        let sections = sections(&self.schema());
        let mut text = String::new();
        for section in sections.iter().filter(|section| !section.keys.is_empty()) {
            section.write_reference(&mut text);
        }
        text
    }
}

/// The keys that distinguish the kinds.
#[derive(Default, Deserialize)]
struct Keys {
    common: Option<IgnoredAny>,
    robot: Option<IgnoredAny>,
    /// A name in settings of a simulator, and a table in a scenario.
    mission: Option<toml::Value>,
}

impl Keys {
    /// The keys at the beginning of lines, for a file that is not valid TOML: the reader of its kind reports the error.
    fn seen(text: &str) -> Self {
        let mut keys = Self::default();
        for line in text.lines().map(str::trim_start) {
            match line.split_once(['=', '.', ']']).map(|(key, value)| (key.trim(), value.trim_start())) {
                Some(("[common" | "common", _)) => keys.common = Some(IgnoredAny),
                Some(("robot", _)) => keys.robot = Some(IgnoredAny),
                Some(("mission", value)) if value.starts_with(['"', '\'']) && keys.common.is_none() => {
                    keys.mission = Some(toml::Value::String(String::new()));
                }
                _ => {}
            }
        }
        keys
    }
}

/// A table of a file.
struct Section {
    /// Such as `[vehicle.tracker]`; empty for the top level.
    header: String,
    /// For one of several alternatives of a table: its tag, such as `kind = "goal"`.
    tag: Option<String>,
    description: String,
    /// Whether the table, or a table around it, may be left out.
    is_optional: bool,
    keys: Vec<Key>,
}

struct Key {
    name: String,
    kind: String,
    description: String,
    default: Option<Value>,
    example: Option<Value>,
    is_required: bool,
}

fn sections(schema: &str) -> Vec<Section> {
    let root: Value = serde_json::from_str(schema).unwrap_or_default();
    let mut sections = Vec::new();
    Walk { root: &root, sections: &mut sections }.table(&root, "", String::new(), None, false);
    sections
}

struct Walk<'a> {
    root: &'a Value,
    sections: &'a mut Vec<Section>,
}

impl<'a> Walk<'a> {
    /// Resolves the references of a schema.
    fn resolved(&self, mut schema: &'a Value) -> &'a Value {
        loop {
            let single =
                ["allOf", "anyOf"].iter().find_map(|list| match schema.get(list)?.as_array()?.as_slice() {
                    [one] => Some(one),
                    _ => None,
                });
            let target = schema.get("$ref").and_then(Value::as_str);
            let named = target.and_then(|target| self.root.pointer(target.trim_start_matches('#')));
            match named.or(single) {
                Some(next) => schema = next,
                None => return schema,
            }
        }
    }

    /// Adds a table and its subtables.
    fn table(
        &mut self,
        schema: &'a Value,
        path: &str,
        header: String,
        tag: Option<String>,
        is_optional: bool,
    ) {
        let body = self.resolved(schema);
        let Some(properties) = body.get("properties").and_then(Value::as_object) else { return };
        let (mut keys, mut inner) = (Vec::new(), Vec::new());
        for (name, property) in properties {
            let value = self.resolved(property);
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            let is_required = requires(body, name);
            let items = value.get("items").filter(|items| self.resolved(items).get("properties").is_some());
            if value.get("properties").is_some() {
                inner.push((property, path.clone(), format!("[{path}]"), None, is_optional || !is_required));
            } else if let Some(items) = items {
                inner.push((items, path.clone(), format!("[[{path}]]"), None, true));
            } else if let Some(variants) = tagged(value) {
                for variant in variants {
                    inner.push((variant, path.clone(), format!("[{path}]"), self::tag(variant), true));
                }
            } else if let Some(key) = self.key(name, property, value, is_required) {
                keys.push(key);
            }
        }
        let description = description(schema, body);
        self.sections.push(Section { header, tag, description, is_optional, keys });
        for (schema, path, header, tag, is_optional) in inner {
            self.table(schema, &path, header, tag, is_optional);
        }
    }

    fn key(&self, name: &str, property: &Value, value: &'a Value, is_required: bool) -> Option<Key> {
        // The tag of a variant is part of the header.
        if value.get("const").is_some() {
            return None;
        }
        let first = |list: &Value| list.as_array().and_then(|list| list.first().cloned());
        Some(Key {
            name: name.to_owned(),
            kind: self.kind(value),
            description: description(property, value),
            default: property.get("default").filter(|default| !default.is_null()).cloned(),
            example: property.get("examples").and_then(first),
            is_required,
        })
    }

    /// The type of a value, in words.
    fn kind(&self, value: &'a Value) -> String {
        let choices = |key: &str| value.get(key).and_then(Value::as_array);
        if let Some(values) = choices("enum") {
            return list(values.iter());
        }
        if let Some(variants) = choices("oneOf") {
            return list(variants.iter().filter_map(|variant| variant.get("const")));
        }
        match value.get("type").and_then(Value::as_str) {
            Some("array") => {
                let items = value.get("items").map(|items| self.resolved(items));
                format!("list of {}s", items.map_or_else(|| "value".to_owned(), |items| self.kind(items)))
            }
            Some("boolean") => "true or false".to_owned(),
            Some(kind) => kind.to_owned(),
            None => "value".to_owned(),
        }
    }
}

fn requires(body: &Value, name: &str) -> bool {
    let required = body.get("required").and_then(Value::as_array);
    required.is_some_and(|names| names.iter().any(|known| known == name))
}

/// The variants of a tagged table.
fn tagged(value: &Value) -> Option<&Vec<Value>> {
    value.get("oneOf")?.as_array().filter(|variants| variants.iter().all(|it| it.get("properties").is_some()))
}

/// The tag of a variant, such as `kind = "goal"`.
fn tag(variant: &Value) -> Option<String> {
    let properties = variant.get("properties")?.as_object()?;
    properties.iter().find_map(|(name, value)| Some(format!("{name} = {}", value.get("const")?)))
}

fn list<'a>(values: impl Iterator<Item = &'a Value>) -> String {
    values.map(Value::to_string).collect::<Vec<_>>().join(", ")
}

/// The description of a key or, without one, that of its type.
fn description(near: &Value, far: &Value) -> String {
    let text = near.get("description").or_else(|| far.get("description")).and_then(Value::as_str);
    text.unwrap_or_default().to_owned()
}

impl Section {
    fn write_template(&self, text: &mut String) {
        let hidden = if self.is_optional { "# " } else { "" };
        if !text.is_empty() {
            text.push('\n');
        }
        for line in wrapped(&self.description) {
            let _ = writeln!(text, "# {line}");
        }
        if !self.header.is_empty() {
            let _ = writeln!(text, "{hidden}{}", self.header);
        }
        if let Some(tag) = &self.tag {
            let _ = writeln!(text, "# {tag}");
        }
        for key in &self.keys {
            for line in wrapped(&key.description) {
                let _ = writeln!(text, "{hidden}# {line}");
            }
            let value = key.default.as_ref().or(key.example.as_ref().filter(|_| key.is_required));
            match value {
                Some(value) => {
                    let _ = writeln!(text, "{hidden}{} = {}", key.name, toml_value(value));
                }
                None => {
                    let _ = writeln!(text, "{hidden}# {} = {}", key.name, key.kind);
                }
            }
        }
    }

    fn write_reference(&self, text: &mut String) {
        if !self.header.is_empty() {
            let tag = self.tag.as_ref().map(|tag| format!(", `{tag}`")).unwrap_or_default();
            let _ = writeln!(text, "### `{}`{tag}\n", self.header);
        }
        if !self.description.is_empty() {
            let _ = writeln!(text, "{}\n", self.description);
        }
        let _ = writeln!(text, "| key | value | default | meaning |\n|---|---|---|---|");
        for key in &self.keys {
            let default = match (&key.default, key.is_required) {
                (Some(value), _) => format!("`{}`", toml_value(value)),
                (None, true) => "required".to_owned(),
                (None, false) => String::new(),
            };
            let meaning = key.description.replace('|', "\\|");
            let _ = writeln!(text, "| `{}` | {} | {default} | {meaning} |", key.name, key.kind);
        }
        text.push('\n');
    }
}

fn toml_value(value: &Value) -> String {
    match value {
        Value::Array(values) => format!("[{}]", values.iter().map(toml_value).collect::<Vec<_>>().join(", ")),
        Value::Number(number) if number.is_f64() => fraction(number.as_f64().unwrap_or_default()),
        other => other.to_string(),
    }
}

/// A floating-point number as TOML writes it; single precision keeps its short form.
#[expect(clippy::cast_possible_truncation, reason = "only if nothing is lost")]
fn fraction(number: f64) -> String {
    let short = number as f32;
    if f64::from(short).to_bits() == number.to_bits() { format!("{short:?}") } else { format!("{number:?}") }
}

/// Wraps the text of a comment.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.len() + word.len() < 100 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use dragnet_runtime::config;

    use super::*;

    #[test]
    fn a_template_is_a_file_that_can_be_read() {
        let agent: AgentSettings = toml::from_str(&Kind::Agent.template()).unwrap();
        assert_eq!((agent.robot, agent.common.mission.as_str()), (1, "valley"));
        let coordinator: CoordinatorSettings = toml::from_str(&Kind::Coordinator.template()).unwrap();
        assert_eq!(coordinator.common.real_time_factor.to_bits(), 1.0_f64.to_bits());
        let sim: SimSettings = toml::from_str(&Kind::Sim.template()).unwrap();
        assert!(config::check_real_time_factor(sim.real_time_factor).is_ok());
    }

    /// The template with all comments removed from keys, except the alternatives of a table.
    #[test]
    fn commented_out_keys_are_valid_too() {
        let text = Kind::Agent.template();
        let mut whole = String::new();
        let mut skips = false;
        for line in text.lines() {
            let line = line.strip_prefix("# ").unwrap_or(line);
            if line.starts_with('[') {
                // One kind of motion, one shape, and no detector, which needs a file.
                skips = whole.lines().any(|known| known == line) || line.starts_with("[detector]");
            }
            let is_key = line.starts_with('[')
                || line.split_once(" = ").is_some_and(|(name, value)| {
                    let is_name = name.chars().all(|it| it.is_ascii_lowercase() || it == '_');
                    is_name && value.parse::<toml::Value>().is_ok()
                });
            if is_key && !skips {
                whole.push_str(line);
                whole.push('\n');
            }
        }
        let read: Result<AgentSettings, _> = toml::from_str(&whole);
        assert!(read.is_ok(), "{}\n{whole}", read.unwrap_err());
    }

    #[test]
    fn a_file_is_known_by_its_keys() {
        assert_eq!(Kind::of(&Kind::Agent.template()), Kind::Agent);
        assert_eq!(Kind::of(&Kind::Coordinator.template()), Kind::Coordinator);
        assert_eq!(Kind::of(&Kind::Sim.template()), Kind::Sim);
        assert_eq!(Kind::of("name = 'a'\nmission.budget_seconds = 1.0"), Kind::Scenario);
    }
}
