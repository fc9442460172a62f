//! A picture and its numbers, as files of one name.

use std::path::{Path, PathBuf};
use std::{fs, io};

use serde_json::Value;

/// Settings of a caption: name, and value with unit.
pub type Settings = Vec<(&'static str, String)>;

/// A picture with its settings and numbers.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Name of its files.
    pub name: &'static str,
    /// The picture, if there is one.
    pub svg: Option<String>,
    /// Settings of the caption.
    pub settings: Settings,
    /// Names of the columns, units in brackets.
    pub columns: &'static [&'static str],
    /// Rows: arrays with one text or number per column, or null where a number is missing or not
    /// finite. Numbers are written with five digits.
    pub rows: Vec<Value>,
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
            text += &joined(row, ",", plain_entry);
            text.push('\n');
        }
        text
    }

    /// Formats one row per line, so that versions compare line by line.
    fn json(&self) -> String {
        let mut settings = Vec::new();
        for (name, value) in &self.settings {
            settings.push(format!("{}: {}", Value::from(*name), Value::from(value.as_str())));
        }
        let mut rows = Vec::new();
        for row in &self.rows {
            rows.push(format!("[{}]", joined(row, ", ", json_entry)));
        }
        format!(
            "{{\n  \"settings\": {{\n    {}\n  }},\n  \"columns\": [{}],\n  \"rows\": [\n    {}\n  ]\n}}\n",
            settings.join(",\n    "),
            joined(&Value::from(self.columns), ", ", json_entry),
            rows.join(",\n    ")
        )
    }
}

/// Joins the entries of a row.
fn joined(row: &Value, separator: &str, entry: fn(&Value) -> String) -> String {
    let entries: Vec<String> = row.as_array().into_iter().flatten().map(entry).collect();
    entries.join(separator)
}

/// Formats an entry of a CSV file: quotes only where they are needed, empty for null.
fn plain_entry(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) if text.contains([',', '"', '\n']) => {
            format!("\"{}\"", text.replace('"', "\"\""))
        }
        Value::String(text) => text.clone(),
        other => json_entry(other),
    }
}

/// Formats five digits without trailing zeros, which rounding of the last bits does not change.
fn json_entry(value: &Value) -> String {
    value.as_f64().map_or_else(
        || value.to_string(),
        |number| format!("{number:.4e}").parse().unwrap_or(number).to_string(),
    )
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn numbers_stand_in_both_files() {
        let sheet = Sheet {
            name: "a",
            svg: None,
            settings: vec![("spring \"soft\"", "1 N".to_owned())],
            columns: &["name", "value [mm]"],
            rows: vec![
                json!(["x", 0.123_456]),
                json!(["y", f64::INFINITY]),
                json!(["z, \"w\"", -2e-7]),
                json!(["v", 100.0]),
            ],
        };
        let csv = "name,value [mm]\nx,0.12346\ny,\n\"z, \"\"w\"\"\",-0.0000002\nv,100\n";
        assert_eq!(sheet.csv(), csv);
        let json = sheet.json();
        assert!(json.contains("\"spring \\\"soft\\\"\": \"1 N\""), "{json}");
        assert!(json.contains("[\"x\", 0.12346],\n    [\"y\", null]"), "{json}");
        assert!(serde_json::from_str::<Value>(&json).is_ok(), "{json}");
    }
}
