//! Tables of the data folder that the environment variable `MUSCULO_DATA` names.

use std::path::PathBuf;

/// Reads a comma-separated table, without its head.
pub(crate) fn rows(path: PathBuf) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).expect("a table");
    text.lines().skip(1).map(fields).collect()
}

/// Splits a line into fields; commas within quotes separate none.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            c => fields.last_mut().expect("one at least").push(c),
        }
    }
    fields
}
