//! A picture and its numbers, as files of one name.

use std::path::{Path, PathBuf};
use std::{fs, io};

use serde_json::Value;

/// An entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A name.
    Text(String),
    /// A value; in files with five digits, and empty where it is not finite.
    Number(f64),
}

/// A picture with its settings and numbers.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Name of its files.
    pub name: &'static str,
    /// The picture, if there is one.
    pub svg: Option<String>,
    /// Settings of the caption: name, and value with unit.
    pub settings: Vec<(&'static str, String)>,
    /// Names of the columns, units in brackets.
    pub columns: Vec<&'static str>,
    /// Rows with one entry per column.
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
        let mut contents = vec![("json", self.json()), ("csv", self.csv())];
        contents.extend(self.svg.clone().map(|svg| ("svg", svg)));

        let mut written = Vec::new();
        for (extension, content) in contents {
            let path = folder.join(format!("{}.{extension}", self.name));
            fs::write(&path, content)?;
            written.push(path);
        }
        Ok(written)
    }

    fn csv(&self) -> String {
        let mut text = self.columns.join(",") + "\n";
        for row in &self.rows {
            let entries: Vec<String> = row.iter().map(Cell::plain).collect();
            text += &entries.join(",");
            text.push('\n');
        }
        text
    }

    /// Formats one row per line, so that versions compare line by line.
    fn json(&self) -> String {
        let setting =
            |(name, value): &(&str, String)| format!("{}: {}", quoted(name), quoted(value));
        let settings: Vec<String> = self.settings.iter().map(setting).collect();
        let columns: Vec<String> = self.columns.iter().map(|column| quoted(column)).collect();
        let mut rows = Vec::new();
        for row in &self.rows {
            let entries: Vec<String> = row.iter().map(Cell::json).collect();
            rows.push(format!("[{}]", entries.join(", ")));
        }
        format!(
            "{{\n  \"settings\": {{\n    {}\n  }},\n  \"columns\": [{}],\n  \"rows\": [\n    {}\n  ]\n}}\n",
            settings.join(",\n    "),
            columns.join(", "),
            rows.join(",\n    ")
        )
    }
}

impl Cell {
    /// Returns a name as an entry.
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

/// Returns a value as an entry, empty for `None`.
#[must_use]
pub fn number(value: Option<f64>) -> Cell {
    Cell::Number(value.unwrap_or(f64::NAN))
}

/// Formats five digits without trailing zeros, which rounding of the last bits does not change.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.4e}").parse().unwrap_or(value);
    rounded.to_string()
}

fn quoted(text: &str) -> String {
    Value::from(text).to_string()
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
        assert!(serde_json::from_str::<Value>(&json).is_ok(), "{json}");
    }
}
