//! Tables of the numbers behind pictures, as files of one name.

use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::Serialize;
use serde_json::{Map, Value};

/// Settings of a caption: name, and value with unit.
pub type Settings = Vec<(&'static str, String)>;

/// Settings and numbers of a picture.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Name of its files.
    pub name: &'static str,
    /// Settings of the caption.
    pub settings: Settings,
    /// Rows: objects with the same columns, units in brackets. An entry is a text, a number, or
    /// null where a number is missing or not finite. Numbers are written with five digits.
    rows: Vec<Value>,
}

impl Sheet {
    /// Makes a table of records, whose fields are the columns.
    ///
    /// # Errors
    ///
    /// When a record is not an object.
    pub fn new(
        name: &'static str,
        settings: Settings,
        records: &[impl Serialize],
    ) -> serde_json::Result<Self> {
        let rows = records.iter().map(serde_json::to_value).collect::<Result<_, _>>()?;
        Ok(Self { name, settings, rows })
    }

    /// Returns the rows with this text in a column.
    pub fn rows_of<'a>(
        &'a self,
        column: &'a str,
        text: &'a str,
    ) -> impl Iterator<Item = &'a Value> {
        self.rows.iter().filter(move |row| row[column] == text)
    }

    /// Writes a picture as SVG and the numbers as JSON and CSV; returns the paths.
    ///
    /// # Errors
    ///
    /// When a file cannot be written.
    pub fn write(&self, folder: &Path, svg: Option<String>) -> io::Result<Vec<PathBuf>> {
        fs::create_dir_all(folder)?;
        let mut contents = vec![("json", self.json()), ("csv", self.csv())];
        contents.extend(svg.map(|svg| ("svg", svg)));

        let mut written = Vec::new();
        for (extension, content) in contents {
            let path = folder.join(format!("{}.{extension}", self.name));
            fs::write(&path, content)?;
            written.push(path);
        }
        Ok(written)
    }

    fn columns(&self) -> Vec<&str> {
        let first = self.rows.first().and_then(Value::as_object);
        first.into_iter().flat_map(Map::keys).map(String::as_str).collect()
    }

    fn csv(&self) -> String {
        let mut text = self.columns().join(",") + "\n";
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
            joined(&Value::from(self.columns()), ", ", json_entry),
            rows.join(",\n    ")
        )
    }
}

/// Joins the entries of a row.
fn joined(row: &Value, separator: &str, entry: fn(&Value) -> String) -> String {
    // Columns are an array, rows are objects.
    let of_array = row.as_array().into_iter().flatten();
    let of_object = row.as_object().into_iter().flat_map(Map::values);
    of_array.chain(of_object).map(entry).collect::<Vec<_>>().join(separator)
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
        let settings = vec![("spring \"soft\"", "1 N".to_owned())];
        let row = |name: &str, value: f64| json!({"name": name, "value [mm]": value});
        let rows =
            [row("x", 0.123_456), row("y", f64::INFINITY), row("z, \"w\"", -2e-7), row("v", 100.0)];
        let sheet = Sheet::new("a", settings, &rows).unwrap();
        let csv = "name,value [mm]\nx,0.12346\ny,\n\"z, \"\"w\"\"\",-0.0000002\nv,100\n";
        assert_eq!(sheet.csv(), csv);
        let json = sheet.json();
        assert!(json.contains("\"spring \\\"soft\\\"\": \"1 N\""), "{json}");
        assert!(json.contains("[\"x\", 0.12346],\n    [\"y\", null]"), "{json}");
        assert!(serde_json::from_str::<Value>(&json).is_ok(), "{json}");
    }
}
