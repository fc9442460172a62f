//! Speed against accuracy of the methods to detect vertices inside other bodies.
//!
//! Muscles are pressed on a bone and on each other, and shorten, frame by frame. Each method
//! reports vertices inside with their depths, at several settings. Errors are taken against exact
//! detection between the surfaces; times are of one thread, methods in turns.

pub mod costs;
mod measure;
mod methods;
mod overview;
mod scene;
mod score;
mod task;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use self::measure::measure_all;
use self::methods::METHODS;
use self::scene::{FRAMES, MovingBodies, PRESS, SHORTENING};
use self::task::PairGroup;
use super::curves::machine;
use super::poster::{ErrorAxis, Figure, Poster};
use super::sheet::{Settings, Sheet};

/// Draws the pictures of the fixture scene and, where it is available, of real anatomy.
///
/// # Errors
///
/// When a file cannot be written, or a method fails in a frame.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut written = draw_scene(FIXTURE, &MovingBodies::fixture(), None, folder)?;
    if let Some(data) = fixtures::data::anatomy("detection in real anatomy") {
        let moving = MovingBodies::anatomy(&data.join("vhf_left_thigh_lo"));
        written.extend(draw_scene("detection-anatomy", &moving, Some(ATTRIBUTION), folder)?);
    }
    Ok(written)
}

/// Name of the chart of the generated scene.
const FIXTURE: &str = "detection";

const ATTRIBUTION: &str = "Surfaces of muscles: Univ. of Denver, Center for Orthopaedic Biomechanics, Visible Human Female lower extremity, doi 10.56902/COB.vh.2022.0, CC BY 4.0 (Andreassen et al., Sci Data 10, 34, 2023). Femur: BMFToolkit (M. Sreenivasa, D. Gonzalez Alvarado, 2017), altered.";

fn draw_scene(
    name: &'static str,
    moving: &MovingBodies,
    attribution: Option<&str>,
    folder: &Path,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let measured = measure_all(moving)?;
    let mut settings = settings(moving);
    settings.extend(attribution.map(|text| ("data", text.to_owned())));
    for refusal in measured.refusals {
        settings.push(("refused", refusal));
    }

    // A row of panels per group of pairs, a column per measure of error.
    let sheet = Sheet::new(name, settings, &measured.rows)?;
    let poster = Poster {
        heading: "Depths of vertices inside other bodies: time per frame over error, by method",
        time: Figure::new("time per frame [ms]", &["frame [ms]"]),
        row_height: 400,
        methods: &METHODS.map(|method| method.key),
        errors: [
            ErrorAxis {
                error: Figure::new("max error of a depth [mm]", &["max error [mm]"]),
                range: [-3.0, 1.0],
            },
            ErrorAxis {
                error: Figure::new("rms error of depths [mm]", &["rms error [mm]"]),
                range: [-3.0, 1.0],
            },
            ErrorAxis {
                error: Figure::new("missed or invented [share]", WRONG),
                range: [-4.0, 1.0],
            },
        ],
        figures: [
            Figure::new("build [ms]", &["build [ms]"]),
            Figure::new("held [MB]", &["held [MB]"]),
            Figure::new("frame [ms]", &["frame [ms]"]),
            Figure::new("max error [mm]", &["max error [mm]"]),
            Figure::new("wrong [share]", WRONG),
        ],
        group_column: "pairs",
        groups: &[PairGroup::Bone.title(), PairGroup::Muscles.title()],
        legend_group: PairGroup::Bone.title(),
        sheet: &sheet,
    };
    let mut written = sheet.write(folder, Some(poster.draw()?))?;

    // The front page shows the generated scene.
    if name == FIXTURE {
        let path = folder.join("overview.svg");
        fs::write(&path, overview::draw(&sheet)?)?;
        written.push(path);
    }
    Ok(written)
}

const WRONG: &[&str] = &["missed [share]", "invented [share]"];

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
        ("to take from it", LESSON.to_owned()),
        ("machine", machine()),
    ]
}

const LESSON: &str = "exact surfaces are quicker than nearly all that approximates them, and contacts that were kept are quicker still while bodies touch at the same places. Fields pay for bones where a tenth of a millimeter does, and depths of surfaces (measures, plan) cost two to four times as much as those of vertices";
const ERROR: &str = "of the depth at each vertex that is inside, or reported to be, against exact detection; fields: muscle vertices in the bone; balls: vertices in muscles; else both; plan (for 100,000 frames), measures of overlaps and balls with balls: of the depth of each overlapping pair's surfaces. A vertex that a reduced surface left out is placed at its closest point there";
const MISSED: &str = "of the vertices inside; plan, measures, balls with balls and average-case trees: of overlapping pairs; exact crossings and selected pairs: of crossing faces";
const TIME: &str = "per frame: bodies followed, all pairs detected, and depths of reduced surfaces carried over to all vertices; minimum of several, mean over frames, methods in turns; simulated balls follow nothing; permanent contacts slide, and none is found anew; average-case trees of muscles are built in each frame";
