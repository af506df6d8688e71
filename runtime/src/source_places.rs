//! Removes source positions from the errors of libraries: they contain paths of the computer that built this program.

use std::borrow::Cow;

/// The delimiters of a position: `... at /folder/file.rs:12.`
const BEGIN: &str = " at ";
const END: &str = ".rs:";

/// The text without positions in Rust source files.
#[must_use]
pub fn without(text: &str) -> Cow<'_, str> {
    let mut left = text;
    let mut kept = String::new();
    while let Some((before, after)) = next_place(left) {
        kept.push_str(before);
        left = after;
    }
    if kept.is_empty() && left.len() == text.len() {
        return Cow::Borrowed(text);
    }
    kept.push_str(left);
    Cow::Owned(kept)
}

/// The text before the first position, and the text after it.
fn next_place(text: &str) -> Option<(&str, &str)> {
    let mut searched = 0;
    loop {
        let end = searched + text[searched..].find(END)? + END.len();
        searched = end;
        let Some(begin) = text[..end].rfind(BEGIN) else { continue };
        let path = &text[begin + BEGIN.len()..end];
        let after = text[end..].trim_start_matches(|letter: char| letter.is_ascii_digit());
        let is_source = path.contains("/src/") || path.contains("\\src\\");
        if !is_source || path.contains(char::is_whitespace) || after.len() == text.len() - end {
            continue;
        }
        return Some((&text[..begin], after.strip_prefix('.').unwrap_or(after)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_source_files_are_left_out_and_nothing_else_is() {
        let check = |text: &str, expected: &str| assert_eq!(without(text), expected);
        check(
            "Unable to open listener tcp/1.2.3.4:5: Can not create a new TCP listener bound to tcp/1.2.3.4:5: [Address \
             already in use (os error 98)] at /root/.cargo/registry/src/index/zenoh-link-tcp-1.10.2/src/unicast.rs:430.",
            "Unable to open listener tcp/1.2.3.4:5: Can not create a new TCP listener bound to tcp/1.2.3.4:5: [Address \
             already in use (os error 98)]",
        );
        check(
            "refused at zenoh/src/a.rs:1. - Caused by none at C:\\cargo\\src\\b.rs:22. - Caused by the rest",
            "refused - Caused by none - Caused by the rest",
        );
        check("listening at tcp/robot.rs:7447", "listening at tcp/robot.rs:7447");
        check("cannot read robot.rs: it is at home", "cannot read robot.rs: it is at home");
        check("what is at a.rs: nothing", "what is at a.rs: nothing");
        check("", "");
    }
}
