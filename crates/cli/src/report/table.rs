//! Tables, as plain text and as HTML.

/// Column of a table.
#[derive(Debug)]
pub(super) struct Column {
    /// Name, and the unit in square brackets where there is one.
    title: String,
    is_right: bool,
}

/// Returns a column whose entries are aligned to the left.
pub(super) fn left(title: impl Into<String>) -> Column {
    Column { title: title.into(), is_right: false }
}

/// Returns a column whose entries are aligned to the right.
pub(super) fn right(title: impl Into<String>) -> Column {
    Column { title: title.into(), is_right: true }
}

/// Table of text; entries may have several lines.
#[derive(Debug)]
pub(super) struct Table {
    columns: Vec<Column>,
    rows: Vec<Vec<String>>,
}

impl Table {
    pub(super) fn new(columns: impl IntoIterator<Item = Column>) -> Self {
        Self { columns: columns.into_iter().collect(), rows: Vec::new() }
    }

    /// Adds a row with one entry per column.
    pub(super) fn row(&mut self, entries: impl IntoIterator<Item = String>) {
        self.rows.push(entries.into_iter().collect());
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Writes lines of equal columns, two spaces apart.
    pub(super) fn to_text(&self) -> String {
        // The lines of the table, a row of several lines being several of them.
        let titles: Vec<String> = self.columns.iter().map(Column::text_title).collect();
        let mut lines: Vec<Vec<&str>> = vec![titles.iter().map(String::as_str).collect()];
        for row in &self.rows {
            let height = row.iter().map(|entry| entry.lines().count()).max().unwrap_or(0);
            for line in 0..height {
                let parts = row.iter().map(|entry| entry.lines().nth(line).unwrap_or(""));
                lines.push(parts.collect());
            }
        }

        // Widths count characters, as a terminal shows them.
        let mut widths = vec![0; self.columns.len()];
        for line in &lines {
            for (width, entry) in widths.iter_mut().zip(line) {
                *width = (*width).max(entry.chars().count());
            }
        }

        // Trailing blanks of the last column are left out.
        let mut text = String::new();
        for line in &lines {
            let mut padded = String::new();
            for ((entry, column), width) in line.iter().zip(&self.columns).zip(&widths) {
                padded += "  ";
                padded += &if column.is_right {
                    format!("{entry:>width$}")
                } else {
                    format!("{entry:<width$}")
                };
            }
            text += padded.trim_end();
            text.push('\n');
        }
        text
    }

    /// Writes a table element.
    pub(super) fn to_html(&self) -> String {
        let mut html = "<div class=\"scroll\"><table>\n<thead><tr>".to_owned();
        for column in &self.columns {
            html += &format!("<th>{}</th>", escaped(&column.title));
        }
        html += "</tr></thead>\n<tbody>\n";

        // Lines of an entry stay lines.
        for row in &self.rows {
            html += "<tr>";
            for (entry, column) in row.iter().zip(&self.columns) {
                let class = if column.is_right { " class=\"number\"" } else { "" };
                html += &format!("<td{class}>{}</td>", escaped(entry).replace('\n', "<br>"));
            }
            html += "</tr>\n";
        }
        html + "</tbody>\n</table></div>\n"
    }
}

impl Column {
    /// Returns the title in capitals, but for the unit.
    fn text_title(&self) -> String {
        match self.title.split_once('[') {
            Some((name, unit)) => format!("{}[{unit}", name.to_uppercase()),
            None => self.title.to_uppercase(),
        }
    }
}

/// Returns the mark of an absent value.
pub(super) fn dash() -> String {
    "-".to_owned()
}

/// Escapes the characters of HTML's markup.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new([left("name"), right("n [mm]")]);
        table.row(["femur × ü", "1"].map(str::to_owned));
        table.row(["x\n<y>", "100"].map(str::to_owned));
        table
    }

    #[test]
    fn columns_are_as_wide_as_their_widest_entry() {
        let expected = "  NAME       N [mm]\n  femur × ü       1\n  x             100\n  <y>\n";
        assert_eq!(table().to_text(), expected);
    }

    #[test]
    fn markup_is_escaped() {
        let html = table().to_html();
        assert!(html.contains("<td>x<br>&lt;y&gt;</td><td class=\"number\">100</td>"), "{html}");
    }
}
