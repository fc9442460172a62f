//! Speed against accuracy of the methods to detect vertices inside other bodies.
//!
//! Muscles are pressed on a bone and on each other, and shorten, frame by frame. Each method
//! reports vertices inside with their depths, at several settings. Errors are taken against exact
//! detection between the surfaces; times are of one thread, methods in turns.

pub mod costs;
mod measure;
mod methods;
mod scene;
mod score;
mod task;

use std::error::Error;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use self::measure::{Measurement, measure_all};
use self::methods::METHODS;
use self::scene::{FRAMES, MovingBodies, PRESS, SHORTENING};
use self::task::PairGroup;
use super::curves::machine;
use super::poster::{ErrorAxis, Mark, Poster};
use super::sheet::{Settings, Sheet};

/// Draws the pictures of the fixture scene and, where it is available, of real anatomy.
///
/// # Errors
///
/// When a file cannot be written, or a method fails in a frame.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut written = draw_scene("detection", &MovingBodies::fixture(), None, folder)?;
    if let Some(data) = fixtures::data::anatomy("detection in real anatomy") {
        let moving = MovingBodies::anatomy(&data.join("vhf_left_thigh_lo"));
        written.extend(draw_scene("detection-anatomy", &moving, Some(ATTRIBUTION), folder)?);
    }
    Ok(written)
}

const ATTRIBUTION: &str = "Surfaces of muscles: Univ. of Denver, Center for Orthopaedic Biomechanics, Visible Human Female lower extremity, doi 10.56902/COB.vh.2022.0, CC BY 4.0 (Andreassen et al., Sci Data 10, 34, 2023). Femur: BMFToolkit (M. Sreenivasa, D. Gonzalez Alvarado, 2017), altered.";

fn draw_scene(
    name: &'static str,
    moving: &MovingBodies,
    attribution: Option<&str>,
    folder: &Path,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut measured = measure_all(moving)?;
    let mut settings = settings(moving);
    settings.extend(attribution.map(|text| ("data", text.to_owned())));
    measured.refusals.dedup();
    settings.extend(measured.refusals.into_iter().map(|refusal| ("refused", refusal)));

    let svg = Some(draw(&measured.rows, &settings)?);
    let rows = measured.rows.iter().map(row).collect();
    Ok(Sheet { name, svg, settings, columns: COLUMNS, rows }.write(folder)?)
}

/// Titles of the rows of panels.
const BONE: &str = "bone and muscles";
const MUSCLES: &str = "muscles with each other";

/// Draws the picture as SVG: a row per group of pairs, a column per measure of error.
fn draw(measured: &[Measurement], settings: &Settings) -> Result<String, Box<dyn Error>> {
    let poster = Poster {
        heading: "Depths of vertices inside other bodies: time per frame over error, by method",
        time_label: "time per frame [ms]",
        row_height: 400,
        methods: &METHODS,
        errors: [
            ErrorAxis { label: "max error of a depth [mm]", range: [-3.0, 1.0] },
            ErrorAxis { label: "rms error of depths [mm]", range: [-3.0, 1.0] },
            ErrorAxis { label: "missed or invented [share]", range: [-4.0, 1.0] },
        ],
        figures: ["build [ms]", "held [MB]", "frame [ms]", "max error [mm]", "missed, invented"],
        groups: &[BONE, MUSCLES],
        legend_group: BONE,
        marks: measured.iter().map(mark).collect(),
        settings,
    };
    poster.draw()
}

fn mark(m: &Measurement) -> Mark {
    let [max, rms] = [m.score.max(), m.score.rms()];
    let wrong = Some(m.score.missed() + m.score.invented());
    Mark {
        group: if m.group == PairGroup::Bone { BONE } else { MUSCLES },
        method: m.method.name,
        time: m.frame,
        errors: [max, rms, wrong],
        figures: [Some(m.build), Some(m.held), Some(m.frame), max, wrong],
    }
}

fn settings(moving: &MovingBodies) -> Settings {
    let shortening = 100.0 * SHORTENING;
    let motion = format!(
        "{FRAMES} frames; muscles shortened by up to {shortening:.0} % at constant volume and pressed up to {PRESS} mm toward the bone"
    );
    vec![
        ("scene", moving.title.clone()),
        ("motion", motion),
        ("error", ERROR.to_owned()),
        ("missed or invented", MISSED.to_owned()),
        ("time", TIME.to_owned()),
        ("machine", machine()),
    ]
}

const ERROR: &str = "of the depth at each vertex that is inside, or reported to be, against exact detection; fields: muscle vertices in the bone; balls: vertices in muscles; else both. A vertex that a reduced surface left out is placed at its closest point there";
const MISSED: &str = "of the vertices inside; average-case trees: of overlapping pairs, selected pairs: of crossing faces";
const TIME: &str = "per frame: bodies followed and all pairs detected; minimum of several, mean over frames, methods in turns; average-case trees of muscles are built in each";

const COLUMNS: &[&str] = &[
    "pairs",
    "method",
    "setting",
    "max error [mm]",
    "rms error [mm]",
    "missed [share]",
    "invented [share]",
    "frame [ms]",
    "build [ms]",
    "held [MB]",
    "allocated in a frame [MB]",
];

fn row(m: &Measurement) -> Value {
    let pairs = if m.group == PairGroup::Bone { BONE } else { "muscles" };
    let (score, method) = (&m.score, m.method.name);
    let errors = [score.max(), score.rms()];
    let shares = [score.missed(), score.invented()];
    json!([
        pairs,
        method,
        m.setting,
        errors[0],
        errors[1],
        shares[0],
        shares[1],
        m.frame,
        m.build,
        m.held,
        m.allocated,
    ])
}
