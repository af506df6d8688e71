//! Values as Python prints them, which ultralytics writes into ONNX files: `{0: 'person', 1: "pilot's seat"}`.
//!
//! JSON is read too.

use std::collections::BTreeMap;
use std::iter::Peekable;
use std::str::Chars;

/// Two numbers in brackets.
pub(super) fn pair(text: &str) -> Option<[u32; 2]> {
    let inner = text.trim().strip_prefix(['[', '('])?.strip_suffix([']', ')'])?;
    let (first, second) = inner.split_once(',')?;
    Some([first.trim().parse().ok()?, second.trim().parse().ok()?])
}

/// Names by their numbers, or in the order of a list.
pub(super) fn names(text: &str) -> Option<BTreeMap<u32, String>> {
    let mut rest = Rest(text.trim().chars().peekable());
    let (has_numbers, end) = match rest.0.next()? {
        '{' => (true, '}'),
        '[' => (false, ']'),
        _ => return None,
    };
    let mut names = BTreeMap::new();
    while rest.peek()? != end {
        let number = if has_numbers { rest.number()? } else { u32::try_from(names.len()).ok()? };
        names.insert(number, rest.string()?);
        if rest.peek()? == ',' {
            rest.0.next();
        }
    }
    (rest.0.next() == Some(end) && rest.0.next().is_none()).then_some(names)
}

struct Rest<'a>(Peekable<Chars<'a>>);

impl Rest<'_> {
    /// The next character that is no space.
    fn peek(&mut self) -> Option<char> {
        while self.0.next_if(|letter| letter.is_whitespace()).is_some() {}
        self.0.peek().copied()
    }

    /// A number, which JSON has in quotes, and the colon behind it.
    fn number(&mut self) -> Option<u32> {
        let number = if self.peek()?.is_ascii_digit() {
            let mut digits = String::new();
            while let Some(digit) = self.0.next_if(char::is_ascii_digit) {
                digits.push(digit);
            }
            digits
        } else {
            self.string()?
        };
        (self.peek()? == ':').then_some(())?;
        self.0.next();
        number.parse().ok()
    }

    fn string(&mut self) -> Option<String> {
        let quote = self.peek().filter(|letter| ['\'', '"'].contains(letter))?;
        self.0.next();
        let mut string = String::new();
        loop {
            match self.0.next()? {
                '\\' => string.push(self.escaped()?),
                letter if letter == quote => return Some(string),
                letter => string.push(letter),
            }
        }
    }

    /// The character behind a backslash.
    fn escaped(&mut self) -> Option<char> {
        let digits = match self.0.next()? {
            'n' => return Some('\n'),
            't' => return Some('\t'),
            'r' => return Some('\r'),
            'x' => 2,
            'u' => 4,
            'U' => 8,
            letter => return Some(letter),
        };
        let code = (0..digits).try_fold(0, |code, _| Some(16 * code + self.0.next()?.to_digit(16)?))?;
        char::from_u32(code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, expected: &[(u32, &str)]) {
        let expected = expected.iter().map(|&(number, name)| (number, name.to_owned())).collect();
        assert_eq!(names(text), Some(expected), "{text}");
    }

    #[test]
    fn names_are_read_as_python_and_json_write_them() {
        check("{0: 'person', 7: 'boat'}", &[(0, "person"), (7, "boat")]);
        check(
            r#"{0: "pilot's seat", 1: 'a "b", {c}: \'d\''}"#,
            &[(0, "pilot's seat"), (1, r#"a "b", {c}: 'd'"#)],
        );
        check(r"{0: 'a\\b\n', 1: '\x41\u00e9\U0001f6a4'}", &[(0, "a\\b\n"), (1, "Aé🚤")]);
        check(r#"{"0": "person", "1": "Mädchen"}"#, &[(0, "person"), (1, "Mädchen")]);
        check(" ['person', 'boat',] ", &[(0, "person"), (1, "boat")]);
        check("{}", &[]);
    }

    #[test]
    fn other_texts_are_none() {
        for text in [
            "",
            "{",
            "{0",
            "{0:",
            "{0: 'a",
            "{0: a}",
            "{a: 'b'}",
            "{0: 'a'}}",
            "{-1: 'a'}",
            "{4294967296: 'a'}",
        ] {
            assert_eq!(names(text), None, "{text}");
        }
        for text in [r"{0: '\", r"{0: '\x4", r"{0: '\ud800'}", r"{0: '\U99999999'}", "0: 'a'", "[0, 1]"] {
            assert_eq!(names(text), None, "{text}");
        }
    }

    #[test]
    fn two_numbers_are_a_pair() {
        assert_eq!(pair("[384, 640]"), Some([384, 640]));
        assert_eq!(pair("(384,640)"), Some([384, 640]));
        for text in ["", "640", "[640]", "[1, 2, 3]", "[-1, 2]", "[1, 4294967296]", "[a, 2]"] {
            assert_eq!(pair(text), None, "{text}");
        }
    }
}
