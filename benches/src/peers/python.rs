//! Answers of packages for Python, by a script that runs those which are installed.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::{Map, Value, json};

use super::libraries::Bodies;
use super::{Answers, Asked, REACH};

/// Script that answers, of this workspace.
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../python/benches/pairs.py");

/// Returns the answers of all packages that the Python of the search path has; none without one,
/// which is told in one line.
#[expect(clippy::print_stderr, reason = "says what is missing, as tests without data do")]
#[must_use]
pub fn answers(bodies: &Bodies, asked: &[Asked]) -> Vec<Answers> {
    let lines = run(&request(bodies, asked)).unwrap_or_else(|reason| {
        eprintln!("packages for Python are skipped: {reason}");
        String::new()
    });
    lines.lines().filter_map(read).collect()
}

/// Formats bodies and questions for the script.
fn request(bodies: &Bodies, asked: &[Asked]) -> Value {
    let mut meshes = Vec::new();
    for body in &bodies.own {
        let vertices = body.positions().as_slice().iter().map(|x| x.to_array());
        let vertices = Value::from_iter(vertices.map(|x| Value::from(x.to_vec())));
        meshes.push(json!({ "vertices": vertices, "faces": body.surface().faces() }));
    }

    let mut questions = Map::new();
    for Asked { question, answers } in asked {
        let pairs: Vec<[usize; 2]> = answers.iter().map(|exact| exact.pair).collect();
        questions.insert(question.key().to_owned(), json!(pairs));
    }
    json!({ "reach": REACH, "bodies": meshes, "questions": questions })
}

/// Runs the script; returns what it prints, or why there is nothing.
fn run(request: &Value) -> Result<String, String> {
    if !Path::new(SCRIPT).exists() {
        return Err(format!("{SCRIPT} is missing"));
    }
    let mut command = Command::new("python3");
    command.arg(SCRIPT).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().map_err(|error| format!("python3 cannot be run: {error}"))?;

    // The script reads all of its input before it answers; one that ends early closes the pipe.
    if let Some(mut input) = child.stdin.take() {
        input.write_all(request.to_string().as_bytes()).map_err(|error| error.to_string())?;
    }
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("{SCRIPT} ended with {}", output.status))
    }
}

/// Reads a line of the script; `None` for any other text.
fn read(line: &str) -> Option<Answers> {
    let value: Value = serde_json::from_str(line).ok()?;
    let answers = value["answers"].as_array()?.iter().map(Value::as_f64).collect();
    Some(Answers {
        library: value["library"].as_str()?.to_owned(),
        question: super::QUESTIONS.into_iter().find(|known| value["question"] == known.key())?,
        time: value["time"].as_f64()?,
        preparation: value["preparation"].as_f64()?,
        answers,
    })
}

#[cfg(test)]
mod tests {
    use super::super::Question;
    use super::*;

    #[test]
    fn lines_of_the_script_are_answers() {
        let line = r#"{"library": "coal 3.0", "question": "gap", "time": 2.5,
                       "preparation": 8.0, "answers": [1.5, null]}"#;
        let read_line = read(line).unwrap();
        assert_eq!((read_line.question, read_line.answers), (Question::Gap, vec![Some(1.5), None]));
        assert!(read(&line.replace("gap", "color")).is_none() && read("hello").is_none());
    }
}
