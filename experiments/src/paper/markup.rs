//! HTML that is well-formed XML too: paragraphs, tables, figures.

use std::fmt::Write;

/// A piece of a page; its text is escaped.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Markup(String);

/// A table with a caption, a row of titles, and groups of rows.
pub(super) struct Table {
    caption: String,
    content: Content,
    titles: Vec<String>,
    groups: Vec<Group>,
}

/// The content of the columns after the first.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Content {
    Numbers,
    Words,
}

#[derive(Default)]
struct Group {
    title: Option<String>,
    rows: Vec<Vec<String>>,
}

impl Markup {
    pub(super) fn new() -> Self {
        Self::default()
    }

    /// Wraps existing markup.
    pub(super) fn raw(markup: String) -> Self {
        Self(markup)
    }

    pub(super) fn as_str(&self) -> &str {
        &self.0
    }

    /// Appends another piece.
    pub(super) fn then(mut self, other: &Self) -> Self {
        self.0 += &other.0;
        self
    }

    /// Adds a paragraph; text in backticks is code.
    pub(super) fn paragraph(self, text: &str) -> Self {
        self.then(&Self(format!("<p>{}</p>\n", prose(text))))
    }

    pub(super) fn table(self, table: &Table) -> Self {
        self.then(&table.draw())
    }

    /// Adds a line of code that can be copied.
    pub(super) fn command(self, text: &str) -> Self {
        self.then(&Self(format!("<pre><code>{}</code></pre>\n", escape(text))))
    }

    /// Adds drawings under a caption, each in its frame; `class` sets their layout.
    pub(super) fn figure(self, class: &str, caption: &str, drawings: &[Self]) -> Self {
        let mut markup = format!("<figure>\n<div class=\"{class}\">\n");
        for drawing in drawings {
            markup += drawing.as_str();
        }
        let _ = writeln!(markup, "</div>\n<figcaption>{}</figcaption>\n</figure>", prose(caption));
        self.then(&Self(markup))
    }

    /// A drawing in SVG in a frame, with a description in words.
    pub(super) fn drawing(description: &str, svg: &str) -> Self {
        let description = escape(description);
        Self(format!(
            "<div class=\"drawing\" role=\"img\" tabindex=\"0\" aria-label=\"{description}\">\n{svg}\n</div>\n"
        ))
    }
}

impl Table {
    /// A table whose first column names the rows of numbers.
    pub(super) fn of_numbers(caption: &str, titles: &[&str]) -> Self {
        Self::new(caption, Content::Numbers, titles)
    }

    pub(super) fn of_words(caption: &str, titles: &[&str]) -> Self {
        Self::new(caption, Content::Words, titles)
    }

    fn new(caption: &str, content: Content, titles: &[&str]) -> Self {
        let titles = titles.iter().map(|&title| title.to_owned()).collect();
        Self { caption: caption.to_owned(), content, titles, groups: Vec::new() }
    }

    /// Begins a group of rows.
    pub(super) fn group(&mut self, title: &str) {
        self.groups.push(Group { title: Some(title.to_owned()), rows: Vec::new() });
    }

    /// Adds a row, as many cells as there are titles.
    pub(super) fn row(&mut self, cells: Vec<String>) {
        debug_assert_eq!(cells.len(), self.titles.len());
        if self.groups.is_empty() {
            self.groups.push(Group::default());
        }
        if let Some(group) = self.groups.last_mut() {
            group.rows.push(cells);
        }
    }

    fn draw(&self) -> Markup {
        let class = match self.content {
            Content::Numbers => "numbers",
            Content::Words => "words",
        };
        let caption = prose(&self.caption);
        let titles = self.titles.iter().map(|title| format!("<th scope=\"col\">{}</th>", prose(title)));
        let titles = titles.collect::<Vec<_>>().concat();
        let groups: String = self.groups.iter().map(|group| group.draw(self.titles.len())).collect();
        Markup(format!(
            "<div class=\"table\" tabindex=\"0\">\n<table class=\"{class}\">\n<caption>{caption}</caption>\n\
             <thead><tr>{titles}</tr></thead>\n{groups}</table>\n</div>\n"
        ))
    }
}

impl Group {
    fn draw(&self, columns: usize) -> String {
        let mut markup = "<tbody>\n".to_owned();
        if let Some(title) = &self.title {
            let title = prose(title);
            let _ = writeln!(
                markup,
                "<tr><th class=\"group\" scope=\"rowgroup\" colspan=\"{columns}\">{title}</th></tr>"
            );
        }
        for row in &self.rows {
            markup += &draw_row(row);
        }
        markup + "</tbody>\n"
    }
}

fn draw_row(cells: &[String]) -> String {
    let mut markup = "<tr>".to_owned();
    for (column, cell) in cells.iter().enumerate() {
        let cell = prose(cell);
        let _ = match column {
            0 => write!(markup, "<th scope=\"row\">{cell}</th>"),
            _ => write!(markup, "<td>{cell}</td>"),
        };
    }
    markup + "</tr>\n"
}

/// Text as HTML, with text in backticks as code.
fn prose(text: &str) -> String {
    let parts = text.split('`').enumerate();
    parts
        .map(|(place, part)| match place % 2 {
            0 => escape(part),
            _ => format!("<code>{}</code>", escape(part)),
        })
        .collect()
}

/// Text as HTML, in an element or in an attribute's quotes.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_backticks_are_code() {
        let markup = Markup::new().paragraph("a < \"b\" & `c > d`");
        assert_eq!(markup.as_str(), "<p>a &lt; &quot;b&quot; &amp; <code>c &gt; d</code></p>\n");
    }

    #[test]
    fn a_table_names_its_columns_its_groups_and_its_rows() {
        let mut table = Table::of_numbers("What it shows", &["policy", "area"]);
        table.group("A map");
        table.row(vec!["`path`".to_owned(), "0.9".to_owned()]);
        let expected = "\
<div class=\"table\" tabindex=\"0\">
<table class=\"numbers\">
<caption>What it shows</caption>
<thead><tr><th scope=\"col\">policy</th><th scope=\"col\">area</th></tr></thead>
<tbody>
<tr><th class=\"group\" scope=\"rowgroup\" colspan=\"2\">A map</th></tr>
<tr><th scope=\"row\"><code>path</code></th><td>0.9</td></tr>
</tbody>
</table>
</div>
";
        assert_eq!(table.draw().as_str(), expected);
    }
}
