//! Long tables: one number per row, as pandas, polars and R take them.
//!
//! ```text
//! subject,frame,time,a,b,measure,value
//! p03/scene.toml,0,,femur,vastus,overlap.volume,12.25
//! p03/scene.toml,0,,femur,vastus,depth_of_a_in_b.lower,1.5
//! ```
//!
//! A measure has the name of its place in the pair's JSON, so that both say the same.

use csv::Writer;
use serde::Serialize;
use serde_json::Value;

use crate::failure::Failure;

/// Names of the columns.
const COLUMNS: [&str; 7] = ["subject", "frame", "time", "a", "b", "measure", "value"];

/// Frame that rows belong to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TableFrame {
    pub(crate) frame: usize,
    /// Time in seconds, where the motion has one.
    pub(crate) time: Option<f64>,
}

/// Table that is being written, as comma-separated values.
#[derive(Debug)]
pub(crate) struct LongTable {
    subject: String,
    writer: Writer<Vec<u8>>,
}

impl LongTable {
    /// Begins a table of a subject with its columns.
    pub(crate) fn new(subject: impl Into<String>) -> Result<Self, Failure> {
        let mut writer = Writer::from_writer(Vec::new());
        writer.write_record(COLUMNS)?;
        Ok(Self { subject: subject.into(), writer })
    }

    /// Adds a row for every number of a pair's record, and for every truth value as 0 or 1.
    ///
    /// Lists are left out: separate regions and places are in the JSON.
    pub(crate) fn add_pair(
        &mut self,
        frame: TableFrame,
        record: &impl Serialize,
    ) -> Result<(), Failure> {
        let record = serde_json::to_value(record)?;
        let name = |key: &str| record[key].as_str().unwrap_or_default().to_owned();
        let mut row = [
            self.subject.clone(),
            frame.frame.to_string(),
            frame.time.map(|time| time.to_string()).unwrap_or_default(),
            name("a"),
            name("b"),
            String::new(),
            String::new(),
        ];

        let mut measures = Vec::new();
        collect_numbers("", &record, &mut measures);
        for (measure, value) in measures {
            row[5] = measure;
            row[6] = value;
            self.writer.write_record(&row)?;
        }
        Ok(())
    }

    /// Returns the content of the file.
    pub(crate) fn finish(self) -> Result<Vec<u8>, Failure> {
        Ok(self.writer.into_inner()?)
    }
}

/// Collects the numbers of a record with their paths, in the order of the alphabet.
fn collect_numbers(path: &str, value: &Value, measures: &mut Vec<(String, String)>) {
    match value {
        Value::Number(number) => measures.push((path.to_owned(), number.to_string())),
        Value::Bool(holds) => measures.push((path.to_owned(), u8::from(*holds).to_string())),
        Value::Object(entries) => {
            // The order of a map may be that of the record, or of the alphabet.
            let mut entries: Vec<(&String, &Value)> = entries.iter().collect();
            entries.sort_unstable_by_key(|&(key, _)| key);
            for (key, value) in entries {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                collect_numbers(&path, value, measures);
            }
        }
        Value::Null | Value::String(_) | Value::Array(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn numbers_stand_in_rows_with_their_paths() {
        let mut table = LongTable::new("knee, left").expect("a table");
        let pair = json!({
            "b": "tibia", "a": "femur \"old\"", "overlaps": true, "distance": null,
            "overlap": {"volume": 0.1, "centroid": [1.0, 2.0, 3.0], "area": 1e-12},
        });
        let none = TableFrame { frame: 0, time: None };
        table.add_pair(none, &pair).expect("rows");
        let later = TableFrame { frame: 1, time: Some(0.25) };
        table.add_pair(later, &json!({"a": "x", "b": "y", "contacts": 3})).expect("rows");

        let text = String::from_utf8(table.finish().expect("a file")).expect("text");
        let expected = "subject,frame,time,a,b,measure,value\n\
            \"knee, left\",0,,\"femur \"\"old\"\"\",tibia,overlap.area,1e-12\n\
            \"knee, left\",0,,\"femur \"\"old\"\"\",tibia,overlap.volume,0.1\n\
            \"knee, left\",0,,\"femur \"\"old\"\"\",tibia,overlaps,1\n\
            \"knee, left\",1,0.25,x,y,contacts,3\n";
        assert_eq!(text, expected);
    }
}
