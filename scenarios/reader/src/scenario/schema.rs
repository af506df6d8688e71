//! The JSON Schema of scenario files, for editors that complete and check TOML.

use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema};
use serde_json::Value;

use super::file::ScenarioFile;

/// The JSON Schema (draft 7, which TOML editors know) of a scenario file; committed as
/// `scenarios/scenario.schema.json`.
#[must_use]
pub fn schema_json() -> String {
    schema_of::<ScenarioFile>()
}

/// The JSON Schema (draft 7) of a TOML file.
#[must_use]
pub fn schema_of<T: JsonSchema>() -> String {
    let settings = SchemaSettings::draft07().with_transform(ForToml);
    let schema = settings.into_generator().into_root_schema_for::<T>();
    format!("{:#}\n", schema.as_value())
}

/// TOML has no null: an optional key is left out. Descriptions are one line, which editors wrap.
#[derive(Clone)]
struct ForToml;

impl Transform for ForToml {
    fn transform(&mut self, schema: &mut Schema) {
        for list in ["type", "enum", "anyOf"] {
            let is_null = |value: &Value| {
                value.is_null() || value == "null" || value.get("type").is_some_and(|kind| kind == "null")
            };
            if let Some(Value::Array(values)) = schema.get_mut(list) {
                values.retain(|value| !is_null(value));
            }
        }
        if let Some(Value::Array(kinds)) = schema.get("type")
            && let [kind] = &kinds[..]
        {
            let kind = kind.clone();
            schema.insert("type".to_owned(), kind);
        }
        if let Some(Value::String(description)) = schema.get_mut("description") {
            *description = description.replace('\n', " ");
        }
        transform_subschemas(self, schema);
    }
}
