//! RIHS01: the hash by which two ROS 2 nodes check that their definitions of a message are equal.
//!
//! It is the SHA-256 of a message's description as JSON (REP 2011, REP 2016): names and types of its fields, then those
//! of all messages in it, by name. Constants, defaults and comments play no part. JSON is written as Python's
//! `json.dumps` does, with a blank after each comma and colon; no name in it has a character to escape.

use sha2::{Digest, Sha256};

use super::{Definitions, definition, needed};

/// A message within a message, in REP 2011's `FieldType`.
const NESTED: u8 = 1;
/// Names of plain types as in `.msg` files; their numbers in `FieldType` begin with 2. Wide and extended ones, which no
/// message here has, are left empty.
const PRIMITIVES: [&str; 16] = [
    "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64", "",
    "char", "", "bool", "byte", "string",
];
/// Added to a type's number by `[N]`.
const ARRAY: u8 = 48;
/// Added to a type's number by `[]`.
const SEQUENCE: u8 = 144;

/// The hash of a message: `RIHS01_` and 64 hexadecimal digits.
pub(super) fn type_hash(name: &str, known: Definitions) -> String {
    let mut parts = needed(name, known);
    parts.sort_unstable();
    let referenced: Vec<String> = parts.into_iter().map(|part| description(part, known)).collect();
    let json = format!(
        "{{\"type_description\": {}, \"referenced_type_descriptions\": [{}]}}",
        description(name, known),
        referenced.join(", ")
    );
    format!("RIHS01_{:x}", Sha256::digest(json))
}

/// One message, its fields in order.
fn description(name: &str, known: Definitions) -> String {
    let fields: Vec<String> =
        fields(definition(name, known)).into_iter().map(|(kind, name)| field(kind, name)).collect();
    format!("{{\"type_name\": {:?}, \"fields\": [{}]}}", full_name(name), fields.join(", "))
}

fn field(kind: &str, name: &str) -> String {
    let (element, length) = kind.split_once('[').unwrap_or((kind, ""));
    let (array, capacity) = match length.trim_end_matches(']') {
        "" if length.is_empty() => (0, "0"),
        "" => (SEQUENCE, "0"),
        count => (ARRAY, count),
    };
    let plain = (2..).zip(PRIMITIVES).find(|&(_, known)| known == element);
    let (number, nested) = plain.map_or((NESTED, full_name(element)), |(number, _)| (number, String::new()));
    format!(
        "{{\"name\": {name:?}, \"type\": {{\"type_id\": {}, \"capacity\": {capacity}, \"string_capacity\": 0, \
         \"nested_type_name\": {nested:?}}}}}",
        number + array,
    )
}

/// Types and names of the fields of a definition; its constants are left out.
fn fields(definition: &str) -> Vec<(&str, &str)> {
    let lines = definition.lines().map(|line| line.split('#').next().unwrap_or_default());
    lines
        .filter(|line| !line.contains('='))
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            words.next().zip(words.next())
        })
        .collect()
}

/// `nav_msgs/Path` as written in descriptions: `nav_msgs/msg/Path`.
fn full_name(name: &str) -> String {
    name.replace('/', "/msg/")
}
