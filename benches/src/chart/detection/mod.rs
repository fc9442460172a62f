//! Speed against accuracy of the ways to detect who is in whom.
//!
//! Muscles are pressed on a bone and on each other, and shorten, frame by frame; each method tells
//! which vertices are how deep in the other body, at several settings. Errors are taken against
//! exact detection between the surfaces, times on one thread, in turns.

pub mod costs;
mod draw;
mod measure;
mod methods;
mod question;
mod scene;
mod score;

use std::error::Error;
use std::path::{Path, PathBuf};

use self::measure::Measured;
use self::question::Pairs;
use self::scene::{FRAMES, Moving, PRESS, SHORTENING};
use super::curves::{machine, number};
use super::sheet::{Cell, Sheet};

/// Draws the pictures and writes the numbers behind them: of the fixture scene, and of real
/// anatomy where it is at hand.
///
/// # Errors
///
/// When a file cannot be written, or a method refuses a body.
pub fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut written = draw_scene("detection", &Moving::fixture(), None, folder)?;
    if let Some(data) = fixtures::data::anatomy("detection in real anatomy") {
        let moving = Moving::anatomy(&data.join("vhf_left_thigh_lo"));
        written.extend(draw_scene("detection-anatomy", &moving, Some(ATTRIBUTION), folder)?);
    }
    Ok(written)
}

const ATTRIBUTION: &str = "Surfaces of muscles: Univ. of Denver, Center for Orthopaedic Biomechanics, Visible Human Female lower extremity, doi 10.56902/COB.vh.2022.0, CC BY 4.0 (Andreassen et al., Sci Data 10, 34, 2023). Femur: BMFToolkit (M. Sreenivasa, D. Gonzalez Alvarado, 2017), altered.";

fn draw_scene(
    name: &'static str,
    moving: &Moving,
    attribution: Option<&'static str>,
    folder: &Path,
) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let (measured, mut refused) = measure::all(moving)?;
    let mut settings = settings(moving, attribution);
    refused.dedup();
    settings.extend(refused.into_iter().map(|refusal| ("refused", refusal)));
    let svg = draw::draw(&measured, &settings)?;
    let (columns, rows) = table(&measured);
    Ok(Sheet { name, svg: Some(svg), settings, columns, rows }.write(folder)?)
}

fn settings(moving: &Moving, attribution: Option<&str>) -> Vec<(&'static str, String)> {
    let mut settings = vec![
        ("scene", moving.title.clone()),
        (
            "motion",
            format!(
                "{FRAMES} frames; muscles shortened by up to {:.0} % at constant volume and pressed up to {PRESS} mm towards the bone",
                100.0 * SHORTENING
            ),
        ),
        (
            "error",
            "of the depth at each vertex that is inside, or told to be, beside exact detection; with a field, muscle vertices in the bone; with balls, vertices in muscles; else both. A vertex that a reduced surface left out stands at its nearest point there".to_owned(),
        ),
        (
            "missed or invented",
            "of the vertices inside; average-case trees: of overlapping pairs, selected pairs: of crossing faces".to_owned(),
        ),
        (
            "time",
            "of a frame: bodies followed and all pairs looked at; least of several, mean over frames, methods in turns; average-case trees of muscles are built in each".to_owned(),
        ),
        ("machine", machine()),
    ];
    settings.extend(attribution.map(|text| ("data", text.to_owned())));
    settings
}

fn table(measured: &[Measured]) -> (Vec<&'static str>, Vec<Vec<Cell>>) {
    let columns = vec![
        "pairs",
        "method",
        "setting",
        "worst error [mm]",
        "rms error [mm]",
        "missed [share]",
        "invented [share]",
        "frame [ms]",
        "build [ms]",
        "held [MB]",
        "taken in a frame [MB]",
    ];
    let row = |m: &Measured| {
        let mut row = vec![Cell::text(pairs(m.of)), Cell::text(m.method.name())];
        row.push(Cell::text(&m.setting));
        row.extend([m.score.worst(), m.score.rms()].map(number));
        let rest = [m.score.missed(), m.score.invented(), m.frame, m.build, m.held, m.taken];
        row.extend(rest.map(Cell::Number));
        row
    };
    (columns, measured.iter().map(row).collect())
}

const fn pairs(of: Pairs) -> &'static str {
    match of {
        Pairs::Bone => "bone and muscles",
        Pairs::Muscles => "muscles",
    }
}
