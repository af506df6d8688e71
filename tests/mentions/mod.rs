//! Assertions about messages by their parts: a message may be worded anew as long as it names the key, the value and the
//! allowed values.

/// Asserts that a message contains these parts, separated by ` .. `, in this order: `rows .. 0 .. 1 to 4096`. A part does
/// not match within a longer word or number.
#[track_caller]
pub(crate) fn assert_mentions(message: &str, parts: &str) {
    assert!(mentions(message, parts), "{parts:?} are not in: {message}");
}

fn mentions(message: &str, parts: &str) -> bool {
    let mut rest = message;
    parts.split(" .. ").all(|part| {
        let end = rest.match_indices(part).find_map(|(start, _)| {
            let (before, after) = (&rest[..start], &rest[start + part.len()..]);
            (is_apart(before, part) && is_apart(part, after)).then_some(start + part.len())
        });
        rest = &rest[end.unwrap_or(rest.len())..];
        end.is_some()
    })
}

/// Whether no word or number continues from one text to the next.
fn is_apart(before: &str, after: &str) -> bool {
    let is_part_of_word = |it: Option<char>| it.is_some_and(|it| it.is_alphanumeric() || it == '_');
    !(is_part_of_word(before.chars().next_back()) && is_part_of_word(after.chars().next()))
}

#[test]
fn a_message_mentions_whole_parts_in_order() {
    let message = "a.toml: map.rows is 65; allowed are 1 to 4096";
    assert!(mentions(message, "map.rows .. 65 .. 1 to 4096"));
    for wrong in
        ["map.rows .. 6 .. 1 to 4096", "map.rows .. 65 .. 1 to 40", "65 .. map.rows", "map.columns .. 65"]
    {
        assert!(!mentions(message, wrong), "{wrong}");
    }
}
