//! Aligned columns.

use std::fmt;

/// A table whose columns are as wide as their widest cell; numbers to the right, the rest to the left.
#[derive(Clone, Debug)]
pub(super) struct Table<const N: usize> {
    columns: [Column; N],
    rows: Vec<[String; N]>,
}

/// A column of a table.
#[derive(Clone, Copy, Debug)]
pub(super) enum Column {
    /// Words, aligned to the left.
    Text(&'static str),
    /// Numbers with as many decimals each, aligned to the right.
    Number(&'static str),
}

impl Column {
    fn title(self) -> &'static str {
        match self {
            Self::Text(title) | Self::Number(title) => title,
        }
    }
}

impl<const N: usize> Table<N> {
    pub(super) fn new(columns: [Column; N]) -> Self {
        Self { columns, rows: Vec::new() }
    }

    pub(super) fn row(&mut self, cells: [String; N]) {
        self.rows.push(cells);
    }

    fn width(&self, column: usize) -> usize {
        let cells = self.rows.iter().map(|row| row[column].chars().count());
        cells.chain([self.columns[column].title().len()]).max().unwrap_or(0)
    }
}

impl<const N: usize> fmt::Display for Table<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths: [usize; N] = std::array::from_fn(|column| self.width(column));
        let titles = self.columns.map(|column| column.title().to_owned());
        for row in std::iter::once(&titles).chain(&self.rows) {
            let cells = std::array::from_fn::<_, N, _>(|at| match self.columns[at] {
                Column::Text(_) => format!("{:<width$}", row[at], width = widths[at]),
                Column::Number(_) => format!("{:>width$}", row[at], width = widths[at]),
            });
            writeln!(f, "{}", cells.join("  ").trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::collection::vec;
    use proptest::prelude::*;

    #[test]
    fn words_stand_left_and_numbers_right() {
        let mut table =
            Table::new([Column::Text("ROBOT"), Column::Number("X"), Column::Text("STATE")]);
        table.row(["a".into(), "-0.5 m".into(), "lost".into()]);
        table.row(["rover-7".into(), "0.5 m".into(), String::new()]);
        assert_eq!(
            table.to_string(),
            "\
ROBOT         X  STATE
a        -0.5 m  lost
rover-7   0.5 m
"
        );
    }

    proptest! {
        #[test]
        fn the_last_column_begins_at_the_same_place_in_every_line(rows in vec(("[a-zä]{0,9}", "[0-9.]{0,9}"), 0..9)) {
            let mut table = Table::new([Column::Text("A"), Column::Number("B"), Column::Text("C")]);
            for (a, b) in rows {
                table.row([a, b, "|".into()]);
            }
            let text = table.to_string().replace('C', "|");
            let places: Vec<_> = text.lines().map(|line| line.chars().position(|c| c == '|')).collect();
            prop_assert!(places.iter().all(|place| place.is_some() && *place == places[0]));
        }
    }
}
