//! A command of the page from its text, and in plain words what is wrong with a text that is none.

use serde_json::{Map, Value};

use dragnet_proto::marks::Marked;

use crate::ask::{Ask, LEAST_POD, LEAST_RATIO, MOST_POD, MOST_RATIO};

/// The most characters of a text that are repeated in an answer to it.
const MOST_SHOWN: usize = 40;

/// What a command looks like.
struct Form {
    name: &'static str,
    fields: &'static [Field],
    example: &'static str,
}

struct Field {
    name: &'static str,
    value: Allowed,
    is_needed: bool,
}

/// Allowed values of a field.
enum Allowed {
    Whole { most: u64 },
    Number { least: f64, most: f64 },
    OneOf(&'static [&'static str]),
    Text { most_bytes: usize },
    Truth,
    Corners,
}

const ONE_ROBOT: Field =
    Field { name: "robot", value: Allowed::Whole { most: u16::MAX as u64 }, is_needed: true };
const ROBOT: Field = Field { is_needed: false, ..ONE_ROBOT };
const NOW: Field = Field { name: "now", value: Allowed::Truth, is_needed: false };
const ROW: Field = Field { name: "row", value: Allowed::Whole { most: u32::MAX as u64 }, is_needed: true };
const COLUMN: Field = Field { name: "column", ..ROW };
const RATIO: Field = Field {
    name: "ratio",
    value: Allowed::Number { least: LEAST_RATIO, most: MOST_RATIO },
    is_needed: false,
};
const RADIUS: Field =
    Field { name: "radius_meters", value: Allowed::Number { least: 0.0, most: 1e6 }, is_needed: false };
const POD: Field =
    Field { name: "pod", value: Allowed::Number { least: LEAST_POD, most: MOST_POD }, is_needed: false };
const NOTE: Field =
    Field { name: "note", value: Allowed::Text { most_bytes: Marked::MAX_NOTE_BYTES }, is_needed: false };
const MARK: Field = Field { name: "mark", value: Allowed::Text { most_bytes: 20 }, is_needed: true };
const DECISION: Field =
    Field { name: "as", value: Allowed::OneOf(&["confirmed", "dismissed", "undone"]), is_needed: true };
const ZONE: Field = Field { name: "as", value: Allowed::OneOf(&["no_go", "skip", "open"]), is_needed: true };
const CORNERS: Field = Field { name: "corners", value: Allowed::Corners, is_needed: true };

/// All commands.
const FORMS: [Form; 11] = [
    Form { name: "pause", fields: &[ROBOT], example: r#"{"command": "pause", "robot": 2}"# },
    Form { name: "resume", fields: &[ROBOT], example: r#"{"command": "resume", "robot": 2}"# },
    Form { name: "return", fields: &[ROBOT], example: r#"{"command": "return", "robot": 2}"# },
    Form { name: "end", fields: &[NOW], example: r#"{"command": "end"}"# },
    Form {
        name: "go",
        fields: &[ONE_ROBOT, ROW, COLUMN],
        example: r#"{"command": "go", "robot": 2, "row": 3, "column": 4}"#,
    },
    Form {
        name: "clue",
        fields: &[ROW, COLUMN, RATIO, RADIUS, NOTE],
        example: r#"{"command": "clue", "row": 3, "column": 4, "ratio": 20, "radius_meters": 50, "note": "a glove"}"#,
    },
    Form {
        name: "searched",
        fields: &[CORNERS, POD, NOTE],
        example: r#"{"command": "searched", "corners": [[0, 0], [9, 0], [9, 5]], "pod": 0.8, "note": "team 2"}"#,
    },
    Form { name: "withdraw", fields: &[MARK], example: r#"{"command": "withdraw", "mark": "61000000000"}"# },
    Form {
        name: "find",
        fields: &[ROW, COLUMN, DECISION],
        example: r#"{"command": "find", "row": 3, "column": 4, "as": "confirmed"}"#,
    },
    Form {
        name: "search",
        fields: &[CORNERS],
        example: r#"{"command": "search", "corners": [[0, 0], [9, 0], [9, 5]]}"#,
    },
    Form {
        name: "zone",
        fields: &[CORNERS, ZONE],
        example: r#"{"command": "zone", "corners": [[0, 0], [9, 0], [9, 5]], "as": "no_go"}"#,
    },
];

impl Allowed {
    fn includes(&self, value: &Value) -> bool {
        match self {
            Self::Whole { most } => value.as_u64().is_some_and(|number| number <= *most),
            Self::Number { least, most } => value.as_f64().is_some_and(|it| (*least..=*most).contains(&it)),
            Self::OneOf(names) => value.as_str().is_some_and(|name| names.contains(&name)),
            Self::Text { most_bytes } => value.as_str().is_some_and(|text| text.len() <= *most_bytes),
            Self::Truth => value.is_boolean(),
            Self::Corners => value.as_array().is_some_and(|corners| corners.iter().all(is_corner)),
        }
    }

    fn words(&self) -> String {
        match self {
            Self::Whole { most } => format!("a whole number from 0 to {most}"),
            Self::Number { least, most } => format!("a number from {least} to {most}"),
            Self::Text { most_bytes } => format!("a text of at most {most_bytes} bytes"),
            Self::OneOf(names) => {
                listed(&names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>(), "or")
            }
            Self::Truth => "true or false".to_owned(),
            Self::Corners => {
                "a list of corners, each [east, north] in cells from the south-western corner".to_owned()
            }
        }
    }
}

fn is_corner(value: &Value) -> bool {
    value.as_array().is_some_and(|corner| corner.len() == 2 && corner.iter().all(Value::is_number))
}

/// The command of a text.
///
/// # Errors
/// What is wrong with it, what is allowed, and an example.
pub(crate) fn read(text: &str) -> Result<Ask, String> {
    let none = |what: &str| {
        let names: Vec<String> = FORMS.iter().map(|form| form.name.to_owned()).collect();
        format!("no command: {what}; allowed are {}, such as {}", listed(&names, "and"), FORMS[0].example)
    };
    let value = serde_json::from_str::<Value>(text).map_err(|_| none("the text is not valid JSON"))?;
    let Value::Object(fields) = value else { return Err(none("the JSON is not an object")) };
    let name = fields.get("command").ok_or_else(|| none("the field \"command\" is missing"))?;
    let is_named = |form: &&Form| name.as_str() == Some(form.name);
    let form = FORMS
        .iter()
        .find(is_named)
        .ok_or_else(|| none(&format!("{} is not known", shown(&name.to_string()))))?;
    form.check(&fields).map_err(|what| format!("no command: {what}, such as {}", form.example))?;
    serde_json::from_str(text)
        .map_err(|_| format!("no command: a field is there twice; allowed is once, such as {}", form.example))
}

impl Form {
    /// What is wrong with the fields of a command of this name, and what is allowed.
    fn check(&self, fields: &Map<String, Value>) -> Result<(), String> {
        let is_unknown = |name: &&String| *name != "command" && self.fields.iter().all(|it| it.name != *name);
        if let Some(unknown) = fields.keys().find(is_unknown) {
            let known = self.fields.iter().map(|field| format!("{:?}", field.name));
            let allowed: Vec<String> = std::iter::once("\"command\"".to_owned()).chain(known).collect();
            let (unknown, allowed) = (shown(&format!("{unknown:?}")), listed(&allowed, "and"));
            return Err(format!("{} has no field {unknown}; allowed are {allowed}", self.name));
        }
        for Field { name, value, is_needed } in self.fields {
            let allowed = value.words();
            match fields.get(*name) {
                None if *is_needed => {
                    return Err(format!("{} needs the field {name:?}: allowed is {allowed}", self.name));
                }
                Some(given) if !value.includes(given) => {
                    let given = shown(&given.to_string());
                    return Err(format!("{name:?} of {} is {given}; allowed is {allowed}", self.name));
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// The beginning of a text.
fn shown(text: &str) -> String {
    match text.char_indices().nth(MOST_SHOWN) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// `a, b and c`.
fn listed(parts: &[String], last: &str) -> String {
    match parts {
        [first @ .., end] if !first.is_empty() => format!("{} {last} {end}", first.join(", ")),
        _ => parts.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_example_is_a_command() {
        for form in &FORMS {
            assert!(read(form.example).is_ok(), "{}", form.example);
        }
        assert_eq!(read(r#"{"command":"pause"}"#), Ok(Ask::Pause { robot: None }));
        assert_eq!(read(r#"{"robot":3,"command":"return"}"#), Ok(Ask::Return { robot: Some(3) }));
    }

    #[test]
    fn what_is_no_command_is_told_in_plain_words_with_what_is_allowed_and_an_example() {
        let check =
            |text: &str, expected: &str| assert_eq!(read(text), Err(format!("no command: {expected}")));
        let all = "allowed are pause, resume, return, end, go, clue, searched, withdraw, find, search and zone, such as {\"command\": \"pause\", \"robot\": 2}";
        check("pause", &format!("the text is not valid JSON; {all}"));
        check("[1]", &format!("the JSON is not an object; {all}"));
        check("{}", &format!("the field \"command\" is missing; {all}"));
        check(r#"{"command":"stop"}"#, &format!("\"stop\" is not known; {all}"));
        check(r#"{"command":7}"#, &format!("7 is not known; {all}"));
        let pause = "such as {\"command\": \"pause\", \"robot\": 2}";
        check(
            r#"{"command":"pause","robots":2}"#,
            &format!("pause has no field \"robots\"; allowed are \"command\" and \"robot\", {pause}"),
        );
        for wrong in ["null", "-1", "1.5", "65536", "\"2\""] {
            let allowed = "a whole number from 0 to 65535";
            check(
                &format!(r#"{{"command":"pause","robot":{wrong}}}"#),
                &format!("\"robot\" of pause is {wrong}; allowed is {allowed}, {pause}"),
            );
        }
        check(
            r#"{"command":"pause","robot":1,"robot":2}"#,
            &format!("a field is there twice; allowed is once, {pause}"),
        );
        check(
            r#"{"command":"end","now":1}"#,
            "\"now\" of end is 1; allowed is true or false, such as {\"command\": \"end\"}",
        );
        let go = "such as {\"command\": \"go\", \"robot\": 2, \"row\": 3, \"column\": 4}";
        check(
            r#"{"command":"go","robot":2,"row":3}"#,
            &format!("go needs the field \"column\": allowed is a whole number from 0 to 4294967295, {go}"),
        );
        let clue = "such as {\"command\": \"clue\", \"row\": 3, \"column\": 4, \"ratio\": 20, \"radius_meters\": 50, \"note\": \"a glove\"}";
        check(
            r#"{"command":"clue","row":1,"column":1,"ratio":1}"#,
            &format!("\"ratio\" of clue is 1; allowed is a number from 1.001 to 1000, {clue}"),
        );
        check(
            r#"{"command":"clue","row":1,"column":1,"note":7}"#,
            &format!("\"note\" of clue is 7; allowed is a text of at most 240 bytes, {clue}"),
        );
        let find = "such as {\"command\": \"find\", \"row\": 3, \"column\": 4, \"as\": \"confirmed\"}";
        check(
            r#"{"command":"find","row":1,"column":1,"as":"true"}"#,
            &format!(
                "\"as\" of find is \"true\"; allowed is \"confirmed\", \"dismissed\" or \"undone\", {find}"
            ),
        );
        let corners = read(r#"{"command":"search","corners":[[1]]}"#).unwrap_err();
        assert!(corners.contains("is [[1]]; allowed is a list of corners"), "{corners}");
        let long = read(&format!(r#"{{"command":"{}"}}"#, "é".repeat(9_000))).unwrap_err();
        assert!(long.len() < 300, "{long}");
    }
}
