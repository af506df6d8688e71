//! Tables of aligned columns.

/// A table, its title row first.
#[derive(Default)]
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these titles.
    pub(crate) fn new<const COLUMNS: usize>(titles: [&str; COLUMNS]) -> Self {
        Self { rows: vec![titles.map(str::to_owned).to_vec()] }
    }

    /// A table of these rows, that of the titles first, all of as many cells.
    pub(crate) const fn of_rows(rows: Vec<Vec<String>>) -> Self {
        Self { rows }
    }

    /// Adds a row, as many cells as there are titles.
    pub(crate) fn push<const COLUMNS: usize>(&mut self, cells: [String; COLUMNS]) {
        debug_assert_eq!(COLUMNS, self.rows[0].len());
        self.rows.push(Vec::from(cells));
    }

    /// The table as text: the first `names` columns are left-aligned, the others right-aligned.
    pub(crate) fn draw(&self, names: usize) -> String {
        let width =
            |column: usize| self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.rows[0].len()).map(width).collect();
        let mut text = String::new();
        for row in &self.rows {
            let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
                if column < names { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
            text += cells.collect::<Vec<_>>().join("  ").trim_end();
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_to_the_left_and_numbers_to_the_right() {
        let mut table = Table::new(["policy", "F1"]);
        table.push(["path".to_owned(), "0.9 ± 0.1".to_owned()]);
        table.push(["path-additive".to_owned(), "1".to_owned()]);
        let expected = "\
policy                F1
path           0.9 ± 0.1
path-additive          1
";
        assert_eq!(table.draw(1), expected);
    }
}
