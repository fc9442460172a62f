//! A picture and its numbers, as files of one name.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// An entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A name.
    Text(String),
    /// A value; in files with five digits, and none where it is not finite.
    Number(f64),
}

/// A picture with what it was made from.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Name of its files.
    pub name: &'static str,
    /// The picture, if there is one.
    pub svg: Option<String>,
    /// What was held fixed: name and value with unit, as the caption tells.
    pub settings: Vec<(&'static str, String)>,
    /// Names of the columns, units in brackets.
    pub columns: Vec<&'static str>,
    /// One entry a column.
    pub rows: Vec<Vec<Cell>>,
}

impl Sheet {
    /// Writes the picture as SVG and its numbers as JSON and CSV.
    ///
    /// # Errors
    ///
    /// When a file cannot be written.
    pub fn write(&self, folder: &Path) -> io::Result<Vec<PathBuf>> {
        fs::create_dir_all(folder)?;
        let contents =
            [("svg", self.svg.clone()), ("json", Some(self.json())), ("csv", Some(self.csv()))];
        let write = |(extension, content): (&str, Option<String>)| {
            let path = folder.join(format!("{}.{extension}", self.name));
            content.map(|content| fs::write(&path, content).map(|()| path))
        };
        contents.into_iter().filter_map(write).collect()
    }

    fn csv(&self) -> String {
        let mut text = self.columns.join(",");
        text.push('\n');
        for row in &self.rows {
            let entries: Vec<String> = row.iter().map(Cell::plain).collect();
            text += &entries.join(",");
            text.push('\n');
        }
        text
    }

    fn json(&self) -> String {
        let settings: Vec<String> = self
            .settings
            .iter()
            .map(|(name, value)| format!("    {}: {}", quoted(name), quoted(value)))
            .collect();
        let columns: Vec<String> = self.columns.iter().map(|column| quoted(column)).collect();
        let row = |row: &Vec<Cell>| {
            let entries: Vec<String> = row.iter().map(Cell::json).collect();
            format!("    [{}]", entries.join(", "))
        };
        let rows: Vec<String> = self.rows.iter().map(row).collect();
        format!(
            "{{\n  \"settings\": {{\n{}\n  }},\n  \"columns\": [{}],\n  \"rows\": [\n{}\n  ]\n}}\n",
            settings.join(",\n"),
            columns.join(", "),
            rows.join(",\n")
        )
    }
}

impl Cell {
    /// A name as an entry.
    #[must_use]
    pub fn text(text: &str) -> Self {
        Self::Text(text.to_owned())
    }

    fn plain(&self) -> String {
        match self {
            Self::Text(text) if text.contains([',', '"', '\n']) => {
                format!("\"{}\"", text.replace('"', "\"\""))
            }
            Self::Text(text) => text.clone(),
            Self::Number(value) if value.is_finite() => digits(*value),
            Self::Number(_) => String::new(),
        }
    }

    fn json(&self) -> String {
        match self {
            Self::Text(text) => quoted(text),
            Self::Number(value) if value.is_finite() => digits(*value),
            Self::Number(_) => "null".to_owned(),
        }
    }
}

/// Five digits, without idle zeros: a length of text that rounding of the last
/// bits does not change.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.4e}").parse().unwrap_or(value);
    rounded.to_string()
}

fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            control if control.is_control() => {
                let _ = write!(quoted, "\\u{:04x}", u32::from(control)); // never fails
            }
            other => quoted.push(other),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_in_both_files() {
        let sheet = Sheet {
            name: "a",
            svg: None,
            settings: vec![("spring \"soft\"", "1 N".to_owned())],
            columns: vec!["name", "value [mm]"],
            rows: vec![
                vec![Cell::text("x"), Cell::Number(0.123_456)],
                vec![Cell::text("y"), Cell::Number(f64::INFINITY)],
                vec![Cell::text("z, \"w\""), Cell::Number(-2e-7)],
            ],
        };
        assert_eq!(sheet.csv(), "name,value [mm]\nx,0.12346\ny,\n\"z, \"\"w\"\"\",-0.0000002\n");
        let json = sheet.json();
        assert!(json.contains("\"spring \\\"soft\\\"\": \"1 N\""), "{json}");
        assert!(json.contains("[\"x\", 0.12346],\n    [\"y\", null]"), "{json}");
    }
}
