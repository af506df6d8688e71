//! Rewrites serde's error messages without names of Rust types.

/// Names of Rust types, and the words that replace them.
const TYPES: [(&str, &str); 13] = [
    ("u8", "a whole number from 0 to 255"),
    ("u16", "a whole number from 0 to 65535"),
    ("u32", "a whole number from 0 to 4294967295"),
    ("u64", "a whole number from 0 to 18446744073709551615"),
    ("usize", "a whole number from 0 on"),
    ("i32", "a whole number"),
    ("i64", "a whole number"),
    ("f32", "a number"),
    ("f64", "a number"),
    ("a sequence", "a list"),
    ("a map", "a table"),
    ("path string", "a path"),
    ("a nonzero u32", "a whole number from 1 to 4294967295"),
];

/// A message of serde with each `expected TYPE` replaced by the allowed values.
#[must_use]
pub fn in_words(message: &str) -> String {
    const EXPECTED: &str = "expected ";
    let mut words = String::new();
    let mut rest = message;
    while let Some(at) = rest.find(EXPECTED) {
        let (before, after) = rest.split_at(at + EXPECTED.len());
        words.push_str(before);
        rest = after;
        let end = |text: &str| text.find([',', '\n', ';']).unwrap_or(text.len());
        let (found, left) = after.split_at(end(after));
        let name = found.trim_end();
        if name.starts_with("struct ") {
            words.push_str("a table");
        } else if let Some((_, plain)) = TYPES.iter().find(|(of, _)| *of == name) {
            words.push_str(plain);
        } else {
            continue;
        }
        words.push_str(&found[name.len()..]);
        rest = left;
    }
    // An integer that fits no type of TOML; its value is quoted.
    let words = (words + rest).replace("` as i128", "`").replace("` as u128", "`");
    words
        .replace("invalid type: sequence,", "invalid type: a list,")
        .replace("invalid type: map,", "invalid type: a table,")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_told_in_words() {
        assert_eq!(
            in_words("robot: invalid value: integer `-1`, expected u16\nin `robot`"),
            "robot: invalid value: integer `-1`, expected a whole number from 0 to 65535\nin `robot`"
        );
        assert_eq!(
            in_words("invalid type: integer `5`, expected struct MissionTable"),
            "invalid type: integer `5`, expected a table"
        );
        assert_eq!(
            in_words("unknown field `a`, expected one of `b`, `c`"),
            "unknown field `a`, expected one of `b`, `c`"
        );
        assert_eq!(
            in_words("invalid type: integer `99999999999999999999` as i128, expected i64"),
            "invalid type: integer `99999999999999999999`, expected a whole number"
        );
        assert_eq!(in_words("expected "), "expected ");
    }
}
