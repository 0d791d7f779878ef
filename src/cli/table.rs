//! Columns that line up.

/// On which side of its column a cell stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
}

/// Rows of cells below a header, indented by two; columns are as wide as their widest cell.
#[derive(Clone, Debug)]
pub(super) struct Table {
    sides: Vec<Side>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these columns.
    pub(super) fn new(header: &[(&str, Side)]) -> Table {
        let titles = header.iter().map(|(title, _)| (*title).to_owned()).collect();
        Table { sides: header.iter().map(|&(_, side)| side).collect(), rows: vec![titles] }
    }

    /// Adds a row; cells beyond the columns are left out.
    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().take(self.sides.len()).collect());
    }

    /// Whether there is nothing below the header.
    pub(super) fn is_empty(&self) -> bool {
        self.rows.len() == 1
    }

    /// All lines, each ended.
    pub(super) fn text(&self) -> String {
        let wide = |column: usize| {
            self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.sides.len()).map(wide).collect();
        let mut text = String::new();
        for row in &self.rows {
            let cells = row.iter().zip(&self.sides).zip(&widths).map(|((cell, side), &width)| match side {
                Side::Left => format!("  {cell:<width$}"),
                Side::Right => format!("  {cell:>width$}"),
            });
            let line: String = cells.collect();
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let mut table = Table::new(&[("name", Side::Left), ("frames", Side::Right), ("", Side::Left)]);
        assert!(table.is_empty());
        table.row(["a/long name".to_owned(), "1,204".to_owned(), String::new()]);
        table.row(["ä".to_owned(), "7".to_owned(), "odd".to_owned()]);
        assert_eq!(table.text(), "  name         frames\n  a/long name   1,204\n  ä                 7  odd\n");
    }
}
