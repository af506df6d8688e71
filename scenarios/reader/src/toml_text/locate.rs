//! Finds the line of a key in a TOML file.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

/// The line, from 1, of the value at a key path such as `network.partitions[0].groups`; if the file does not contain
/// it, that of the innermost table around it that it does contain.
pub(crate) fn line_of_key(text: &str, key: &str) -> Option<usize> {
    let table = DeTable::parse(text).ok()?;
    let mut value = DeValue::Table(table.into_inner());
    let mut found: Option<Range<usize>> = None;
    for step in key.split(['.', '[']) {
        let next = match (&value, step.trim_end_matches(']')) {
            (DeValue::Table(table), name) => table.get(name),
            (DeValue::Array(array), index) => index.parse().ok().and_then(|index: usize| array.get(index)),
            _ => None,
        };
        let Some(next) = next else { break };
        found = Some(next.span());
        value = next.get_ref().clone();
    }
    found.map(|span| line_at(text, span.start))
}

/// The line, from 1, that contains the most dots, and so the key with the most parts.
pub(super) fn line_of_longest_key(text: &str) -> usize {
    let dots = |line: &str| line.bytes().filter(|&byte| byte == b'.').count();
    (1..).zip(text.lines()).max_by_key(|(_, line)| dots(line)).map_or(1, |(number, _)| number)
}

/// The line, from 1, of a byte of the text.
pub(super) fn line_at(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|&byte| byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "name = 'a'\n[robots]\ncount = 3\n[[robots.robot]]\nnumber = 1\n[[robots.robot]]\nnumber = 2\nstart = [\n 1,\n 2]\n";

    #[test]
    fn a_key_is_found_in_its_line() {
        for (key, line) in [
            ("name", Some(1)),
            ("robots.count", Some(3)),
            ("robots.robot[1].number", Some(7)),
            ("robots.robot[1].start[1]", Some(10)),
            ("robots.start", Some(2)),
            ("mission.detection_threshold", None),
        ] {
            assert_eq!(line_of_key(TEXT, key), line, "{key}");
        }
    }
}
