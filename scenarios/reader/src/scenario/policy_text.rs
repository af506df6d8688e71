//! A policy as text: `path`, or `path(path_length_weight = 1, replan_after_cells = 3)`.
//!
//! The parameters in parentheses have the names, types and limits of the keys in a scenario's policy table. Strings
//! need no quotation marks: `path(utility=recall)`.

use std::fmt;
use std::str::FromStr;

use dragnet_learn::policy::{PolicyName, UnknownPolicy};
use serde::{Deserialize, Serialize};

use super::file::{PolicyField, PolicyTable};
use crate::toml_text;

/// Why a text is not a policy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PolicyTextError {
    /// The name is not that of a policy.
    #[error(transparent)]
    Unknown(#[from] UnknownPolicy),
    /// The text in parentheses is not a list of parameters.
    #[error("{text:?}: {reason}; allowed is a policy, or one with parameters as in NAME(KEY=VALUE,..)")]
    Parameters {
        /// The text.
        text: String,
        /// The reason.
        reason: String,
    },
}

/// The table of one policy, as TOML has it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    policy: PolicyTable,
}

impl FromStr for PolicyField {
    type Err = PolicyTextError;

    /// Checks the name of the policy and the names and types of its parameters; their values are checked when a
    /// scenario takes them.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        let Some((name, rest)) = text.split_once('(') else {
            return Ok(text.parse::<PolicyName>()?.into());
        };
        let name = name.trim_end().parse::<PolicyName>()?;
        let wrong =
            |reason: &str| PolicyTextError::Parameters { text: text.to_owned(), reason: reason.to_owned() };
        let parameters = rest.strip_suffix(')').ok_or_else(|| wrong("no ')' at its end"))?.trim();
        if parameters.is_empty() {
            return Ok(name.into());
        }
        let document = format!("policy = {{ name = \"{name}\", {} }}", quoted(parameters));
        let document: Document = toml_text::read(&document)
            .map_err(|error| wrong(error.message.strip_prefix("policy.").unwrap_or(&error.message)))?;
        Ok(Self::Table(document.policy))
    }
}

/// Parameters whose words are strings of TOML.
fn quoted(parameters: &str) -> String {
    let is_word = |value: &str| {
        let is_letter = |character: char| character.is_ascii_lowercase() || character == '_';
        !value.is_empty()
            && value.chars().all(is_letter)
            && !matches!(value, "true" | "false" | "inf" | "nan")
    };
    let quote = |part: &str| match part.split_once('=') {
        Some((key, value)) if is_word(value.trim()) => format!("{key}=\"{}\"", value.trim()),
        _ => part.to_owned(),
    };
    parameters.split(',').map(quote).collect::<Vec<_>>().join(",")
}

impl From<PolicyName> for PolicyField {
    fn from(name: PolicyName) -> Self {
        Self::Name(name.as_str().to_owned())
    }
}

impl From<dragnet_search::policy::PolicyName> for PolicyField {
    fn from(name: dragnet_search::policy::PolicyName) -> Self {
        PolicyName::from(name).into()
    }
}

/// In the form that [`PolicyField::from_str`] parses.
impl fmt::Display for PolicyField {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let table = match self {
            Self::Name(name) => return formatter.write_str(name),
            Self::Table(table) => table,
        };
        let PolicyTable {
            name,
            path_length_weight,
            utility,
            pattern,
            after_pattern,
            lane_spacing_cells,
            evaluations,
            replan_after_cells,
            weights,
        } = table;
        let number = |value: &Option<i64>| value.map(|it| it.to_string());
        let values = [
            ("path_length_weight", path_length_weight.map(|it| it.to_string())),
            ("utility", utility.clone()),
            ("pattern", pattern.clone()),
            ("after_pattern", after_pattern.clone()),
            ("lane_spacing_cells", number(lane_spacing_cells)),
            ("evaluations", number(evaluations)),
            ("replan_after_cells", number(replan_after_cells)),
            ("weights", weights.as_ref().map(|file| format!("{file:?}"))),
        ];
        let parameters: Vec<String> =
            values.into_iter().filter_map(|(key, value)| Some(format!("{key}={}", value?))).collect();
        match parameters.as_slice() {
            [] => formatter.write_str(name),
            parameters => write!(formatter, "{name}({})", parameters.join(",")),
        }
    }
}

/// Parses several policies, separated by commas. Commas in parentheses separate parameters.
///
/// # Errors
/// If one is not a policy, or is repeated.
pub fn policies(text: &str) -> Result<Vec<PolicyField>, String> {
    let mut depth = 0_usize;
    let parts = text.split(|character| {
        match character {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        character == ',' && depth == 0
    });
    let mut policies: Vec<PolicyField> = Vec::new();
    for part in parts {
        let policy: PolicyField = part.parse().map_err(|error: PolicyTextError| error.to_string())?;
        if policies.iter().any(|other| other.to_string() == policy.to_string()) {
            return Err(format!("{policy} is there twice"));
        }
        policies.push(policy);
    }
    Ok(policies)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<String, String> {
        text.parse()
            .map(|policy: PolicyField| policy.to_string())
            .map_err(|error: PolicyTextError| error.to_string())
    }

    #[test]
    fn a_policy_with_parameters_is_written_as_it_is_read() {
        for text in ["path", "tour(evaluations=4000)", "path(path_length_weight=0.5,replan_after_cells=3)"] {
            assert_eq!(parse(text).as_deref(), Ok(text));
        }
        assert_eq!(
            parse("coverage(pattern='sector', after_pattern = path)").as_deref(),
            Ok("coverage(pattern=sector,after_pattern=path)")
        );
        assert_eq!(parse(" path ( path_length_weight = 1 ) ").as_deref(), Ok("path(path_length_weight=1)"));
        assert_eq!(parse("greedy()").as_deref(), Ok("greedy"));
        assert_eq!(
            parse("gnn(weights='a,b.safetensors')").as_deref(),
            Ok("gnn(weights=\"a,b.safetensors\")")
        );
    }

    #[test]
    fn what_is_no_policy_is_an_error_that_says_what_is_allowed() {
        let check = |text: &str, parts: &[&str]| {
            let error = parse(text).unwrap_err();
            assert!(parts.iter().all(|part| error.contains(part)), "{text}: {error}");
        };
        check("", &["unknown policy \"\"", "allowed are random"]);
        check("tuor(evaluations=1)", &["unknown policy \"tuor\""]);
        check("tour(evaluations=1", &["no ')'", "NAME(KEY=VALUE,..)"]);
        check("tour(evaluation=1)", &["unknown field `evaluation`", "`evaluations`"]);
        check("tour(evaluations=1.5)", &["invalid type: floating point `1.5`"]);
        check("tour(name='path')", &["name is given twice"]);
        check("tour(evaluations=1 }\nother = { a = 1)", &["unknown field `other`"]);
    }

    #[test]
    fn commas_between_parentheses_separate_parameters() {
        let list =
            |text: &str| policies(text).map(|list| list.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(
            list("path,tour(evaluations=10,replan_after_cells=2),greedy").unwrap(),
            ["path", "tour(evaluations=10,replan_after_cells=2)", "greedy"]
        );
        assert_eq!(list("path,path(path_length_weight=1)").unwrap().len(), 2);
        assert_eq!(list("path,path( )").unwrap_err(), "path is there twice");
        assert!(list("path,").unwrap_err().contains("unknown policy \"\""));
    }
}
