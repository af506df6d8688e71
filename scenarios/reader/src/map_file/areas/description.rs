//! The description of a feature as lines: plain text, or HTML, which Google Earth and other tools write.

use html5gum::{Token, Tokenizer};

/// Elements that begin a line, beside `<br>`.
const LINES: [&[u8]; 24] = [
    b"address",
    b"article",
    b"blockquote",
    b"body",
    b"br",
    b"caption",
    b"center",
    b"dd",
    b"div",
    b"dl",
    b"dt",
    b"h1",
    b"h2",
    b"h3",
    b"h4",
    b"h5",
    b"h6",
    b"hr",
    b"li",
    b"ol",
    b"p",
    b"pre",
    b"table",
    b"ul",
];
/// Elements of a table row: a key and its value.
const CELLS: [&[u8]; 3] = [b"dd", b"td", b"th"];
/// Elements that hold them.
const ROWS: [&[u8]; 2] = [b"dl", b"tr"];
/// Elements whose text is not displayed.
const HIDDEN: [&[u8]; 3] = [b"script", b"style", b"title"];

/// The displayed lines, without comments; `<td>poa</td><td>60%</td>` is displayed as `poa: 60%`.
pub(super) fn lines(description: &str) -> Vec<String> {
    let mut seen = Seen { lines: vec![String::new()], last: None, hidden: 0, is_row: false };
    for token in Tokenizer::new(description).flatten() {
        match token {
            Token::StartTag(tag) => seen.begin(&tag.name, tag.self_closing),
            Token::EndTag(tag) => seen.end(&tag.name),
            Token::String(text) if seen.hidden == 0 => seen.write(&String::from_utf8_lossy(&text)),
            _ => {}
        }
    }
    let lines = seen.lines.into_iter().map(|line| line.trim().to_owned());
    lines.filter(|line| !line.is_empty()).collect()
}

struct Seen {
    lines: Vec<String>,
    /// The last letter of the last line, except spaces.
    last: Option<char>,
    /// Number of open elements whose text is not displayed.
    hidden: usize,
    /// Within a row of a table a line that ends is a space.
    is_row: bool,
}

impl Seen {
    fn begin(&mut self, name: &[u8], is_empty: bool) {
        if HIDDEN.contains(&name) && !is_empty {
            self.hidden += 1;
        }
        self.is_row |= ROWS.contains(&name);
        match self.last {
            // A key that ends with a sign needs no second one.
            Some(':' | '=') if CELLS.contains(&name) => self.write(" "),
            Some(_) if CELLS.contains(&name) => self.write(": "),
            _ if name == b"tr" || LINES.contains(&name) => self.new_line(),
            _ => {}
        }
    }

    fn new_line(&mut self) {
        self.lines.push(String::new());
        self.last = None;
    }

    fn end(&mut self, name: &[u8]) {
        if HIDDEN.contains(&name) {
            self.hidden = self.hidden.saturating_sub(1);
        }
        self.is_row &= !(ROWS.contains(&name) || name == b"table");
        if name == b"tr" || (LINES.contains(&name) && name != b"dt") {
            self.new_line();
        }
    }

    fn write(&mut self, text: &str) {
        for (number, part) in text.split(['\n', '\r']).enumerate() {
            match number {
                0 => {}
                _ if self.is_row => self.write_line(" "),
                _ => self.new_line(),
            }
            self.last = part.trim_end().chars().next_back().or(self.last);
            self.write_line(part);
        }
    }

    fn write_line(&mut self, part: &str) {
        if let Some(line) = self.lines.last_mut() {
            line.push_str(part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(description: &str, expected: &[&str]) {
        assert_eq!(lines(description), expected, "{description}");
    }

    #[test]
    fn a_line_is_a_displayed_line() {
        check("kind: no_go", &["kind: no_go"]);
        check("Steep!\r\npoa: 60 %\n\nspread_meters = 100", &["Steep!", "poa: 60 %", "spread_meters = 100"]);
        check("<div>kind: no_go</div>", &["kind: no_go"]);
        check("<p>poa: 60%</p><p>spread_meters: 100</p>", &["poa: 60%", "spread_meters: 100"]);
        check("Steep!<br>kind: no_go<BR/>really", &["Steep!", "kind: no_go", "really"]);
        check("<b>kind</b>:&nbsp;<i>no&#95;go</i>", &["kind:\u{a0}no_go"]);
        check("<ul><li>a<li>poa: 1%</ul>", &["a", "poa: 1%"]);
        check("a < b & c: 5", &["a < b & c: 5"]);
    }

    #[test]
    fn a_table_is_keys_and_values() {
        let table = "<table><tr><th>kind</th><td>prior</td></tr>\n<tr><td>poa:</td><td>60%</td></tr></table>";
        check(table, &["kind: prior", "poa: 60%"]);
        let spaced =
            "<table>\n <tr>\n  <td><b>kind</b></td>\n  <td>no_go</td>\n </tr>\n</table>\nspread_meters: 5\na";
        check(spaced, &["kind   : no_go", "spread_meters: 5", "a"]);
        check("<dl>\n<dt>kind</dt>\n<dd>prior</dd>\n</dl>", &["kind : prior"]);
        check("<dl><dt>kind</dt><dd>no_go</dd><dt>by</dt><dd>me</dd></dl>", &["kind: no_go", "by: me"]);
    }

    #[test]
    fn cells_out_of_view_are_not_read() {
        check("<!-- kind: no_go -->a wood", &["a wood"]);
        check("<style>p { kind: no_go }</style><p title='kind: no_go'>a wood</p>", &["a wood"]);
        check("<!-- kind: no_go", &[]);
    }
}
