//! Numbers as a person reads them, and tables of plain text.

use crate::scene::Unit;

/// A length to about a micrometre, whatever the unit.
pub(super) fn length(value: f64, unit: Unit) -> String {
    format!("{value:.*}", unit.decimals())
}

/// A measure with four digits that count, and no exponent.
pub(super) fn measure(value: f64) -> String {
    let tens = std::iter::successors(Some(1.0), |ten| Some(ten * 10.0));
    let decimals = tens.take(12).position(|ten| value.abs() * ten >= 1000.0);
    format!("{value:.*}", decimals.unwrap_or(0))
}

/// `1 pair`, `2 pairs`.
pub(super) fn counted(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {what}{plural}", grouped(count))
}

/// A count with its thousands apart.
pub(super) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// On which side of its column a text stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    Left,
    Right,
}

/// Rows whose columns are as wide as their longest entry.
#[derive(Debug)]
pub(super) struct TextTable {
    aligns: Vec<Align>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table with a line of titles.
    pub(super) fn new(columns: &[(&str, Align)]) -> Self {
        let titles = columns.iter().map(|(title, _)| (*title).to_owned()).collect();
        Self { aligns: columns.iter().map(|(_, align)| *align).collect(), rows: vec![titles] }
    }

    /// Adds a row with one entry a column.
    pub(super) fn row(&mut self, entries: Vec<String>) {
        self.rows.push(entries);
    }

    /// Lines of equal columns, two blanks apart.
    pub(super) fn render(&self) -> String {
        let width = |column: usize| {
            self.rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.aligns.len()).map(width).collect();
        let mut text = String::new();
        for row in &self.rows {
            let mut line = String::new();
            for ((entry, align), width) in row.iter().zip(&self.aligns).zip(&widths) {
                line += "  ";
                line += &match align {
                    Align::Left => format!("{entry:<width$}"),
                    Align::Right => format!("{entry:>width$}"),
                };
            }
            text += line.trim_end();
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_keep_four_digits() {
        let cases = [
            (0.0, "0"),
            (0.000_012_345, "0.00001234"),
            (1.234_56, "1.235"),
            (-12.345_6, "-12.35"),
            (12_345.6, "12346"),
        ];
        for (value, expected) in cases {
            assert_eq!(measure(value), expected);
        }
    }

    #[test]
    fn thousands_stand_apart() {
        let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (579_046, "579,046")];
        for (count, expected) in cases {
            assert_eq!(grouped(count), expected);
        }
        assert_eq!(counted(1, "pair"), "1 pair");
        assert_eq!(counted(2, "pair"), "2 pairs");
    }

    #[test]
    fn columns_are_as_wide_as_their_widest_entry() {
        let mut table = TextTable::new(&[("NAME", Align::Left), ("N", Align::Right)]);
        table.row(vec!["femur × ü".to_owned(), "1".to_owned()]);
        table.row(vec!["x".to_owned(), "100".to_owned()]);
        assert_eq!(table.render(), "  NAME         N\n  femur × ü    1\n  x          100\n");
    }
}
