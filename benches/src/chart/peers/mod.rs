//! Chart of the answers of all libraries about the same pairs of bodies.

mod draw;

use std::error::Error;
use std::path::{Path, PathBuf};

use fixtures::{data, thigh};

use super::curves::machine;
use super::sheet::{Settings, Sheet};
use crate::peers::libraries::Bodies;
use crate::peers::{
    Asked, Measurement, QUESTIONS, REACH, RIGHT_LENGTH, RIGHT_VOLUME, ROUNDS, own_and_rust, python,
};

/// Measures answers about the generated thigh and, where it is available, a real one; draws the last.
///
/// # Errors
///
/// When a body is refused, or a file cannot be written.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    // A generated scene, and real anatomy where that is at hand.
    let generated = thigh::thigh().bodies.into_iter().map(|body| body.mesh).collect();
    let mut scenes = vec![Bodies::new("generated thigh", generated)?];
    if let Some(anatomy) = data::anatomy("peers of a real thigh") {
        let files = data::bodies(&anatomy.join("vhf_left_thigh_lo"));
        let meshes = files.iter().map(|file| data::mesh(file)).collect();
        scenes.push(Bodies::new("thigh of the Visible Human Female, simplified", meshes)?);
    }

    // All libraries answer all questions, and are judged by the exact answers.
    let mut rows = Vec::new();
    for bodies in &scenes {
        let asked = QUESTIONS.map(|question| Asked::new(question, bodies));
        let mut answers = Vec::new();
        for asked in &asked {
            answers.extend(own_and_rust(bodies, asked));
        }
        answers.extend(python::answers(bodies, &asked));
        for asked in &asked {
            rows.extend(asked.judge_all(&bodies.title, &answers));
        }
    }

    // The last scene is drawn.
    let titles: Vec<&str> = scenes.iter().map(|bodies| bodies.title.as_str()).collect();
    let sheet = Sheet::new("peers", settings(&titles), &rows)?;
    let drawn = titles.last().copied().unwrap_or_default();
    let last: Vec<&Measurement> = rows.iter().filter(|row| row.scene == drawn).collect();
    let svg = draw::draw(&last, &sheet.settings)?;
    Ok(sheet.write(folder, Some(svg))?)
}

fn settings(scenes: &[&str]) -> Settings {
    let pairs = format!(
        "those with boxes within {REACH} mm; gaps of those that are apart, depths and volumes of those that overlap"
    );
    let wrong = format!(
        "more than {RIGHT_LENGTH} mm from the exact length, or {RIGHT_VOLUME} of the exact volume and as many mm³; rings: some are wrong or refused"
    );
    let time = format!(
        "of the processor per pair, the quickest of {ROUNDS} rounds over all pairs (Python: 3, fewer where they take seconds); what a library keeps of a body is made before"
    );
    vec![
        ("scenes", scenes.join("; ")),
        ("pairs", pairs),
        ("wrong", wrong),
        ("time", time),
        ("libraries", "blue: this one; orange: in Rust; black: packages for Python, of which fcl, coal and parry3d take bodies for surfaces without an inside, with the depth of a pair of faces; trimesh asks fcl and manifold3d; libigl asks CGAL".to_owned()),
        ("to take from it", "all agree on which of these bodies cross, where fcl is as quick, since it stops at the first crossing; gaps and volumes take others 4 to 500 times as long, and none has the depth of an overlap".to_owned()),
        ("machine", machine()),
    ]
}
