//! What no values at the nodes of a grid could better: those that fit exact distances best, and
//! those that fit exact slopes best, beside a field as it is built.
//!
//! ```text
//! MUSCULO_DATA=... cargo run --release -p benches --bin distance_field_floor -- [SPACING]...
//! ```
//!
//! Every node near the surface is free; what it should be is found by least squares over some
//! two million points, spread as those are at which fields are judged. Errors are told where
//! fields are judged, and at the fitted points themselves: there they are, if anything, smaller
//! than they would be at all points there are. It takes about a minute a bone at 1 mm, and eight
//! times as long and as much memory at half of that; the same for any number of threads.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

mod exact;
mod fit;
mod spline;
#[cfg(test)]
mod tests;

use std::error::Error;

use benches::bodies::Body;
use distance_field::{BuildOptions, DistanceField, Grid, Interpolation};
use fixtures::sampling::{Errors, Truth, points_near};
use fixtures::{Mesh, data};
use indicatif::{ProgressBar, ProgressStyle};

use crate::exact::truths;
use crate::fit::{Aim, Fit, answers, sort};
use crate::spline::{B_SPLINE, CATMULL_ROM, LINEAR, MEAN, Spline};

/// Heights over the surface at which fields are judged \[mm\], and points for that.
const REACH: f64 = 2.0;
const JUDGED: u32 = 4000;

/// Points to fit, a cell. With fewer, errors at these and at others lie further apart.
const FITTED: f64 = 12.0;

/// Steps of a fit: after half as many its errors change by less than a hundredth.
const STEPS: u64 = 24;

/// One spacing counts as much as the length of a direction.
const DISTANCES: Aim = Aim { distance: 1.0, slope: 0.0 };
const BOTH: Aim = Aim { distance: 1.0, slope: 1.0 };
/// With as little of distances as keeps the fit from drifting off as a whole.
const SLOPES: Aim = Aim { distance: 0.01, slope: 1.0 };

fn main() -> Result<(), Box<dyn Error>> {
    let Some(folder) = data::anatomy("distance_field_floor") else {
        return Ok(());
    };
    let spacings: Result<Vec<f64>, _> = std::env::args().skip(1).map(|word| word.parse()).collect();
    let spacings = Some(spacings?).filter(|spacings| !spacings.is_empty());
    println!("| values at nodes | rms [mm] | direction rms [°] | fitted: rms | direction rms |");
    println!("|---|--:|--:|--:|--:|");
    for spacing in spacings.unwrap_or_else(|| vec![1.0]) {
        for (bone, file) in [("femur", "bone_femur.ply"), ("pelvis", "bone_pelvis.ply")] {
            let mesh = data::mesh(&folder.join("vhf_left_thigh").join(file));
            println!("| **{bone} of {} vertices, {spacing} mm** | | | | |", mesh.positions.len());
            Bone::new(mesh, spacing)?.floors();
        }
    }
    Ok(())
}

/// A field as it is built, and what is true near its bone.
struct Bone {
    field: DistanceField,
    judged: Vec<Truth>,
    fitted: Vec<Truth>,
    progress: ProgressBar,
}

impl Bone {
    fn new(mesh: Mesh, spacing: f64) -> Result<Self, Box<dyn Error>> {
        let progress = progress();
        let judged = points_near(&mesh, JUDGED, REACH);
        let fitted = points_near(&mesh, fitted_count(&mesh, spacing), REACH);
        let body = Body { surface: mesh.surface(), x: mesh.positions };
        let options = BuildOptions { spacing, samples: 0, ..BuildOptions::default() };
        let x = body.surface.positions(&body.x)?;
        let field = DistanceField::build(&body.surface, x, &options)?;
        let judged = truths(&body, &judged, &progress);
        let mut fitted = truths(&body, &fitted, &progress);
        sort(&mut fitted, field.grid());
        Ok(Self { field, judged, fitted, progress })
    }

    fn floors(&self) {
        let linear = [("distances", DISTANCES), ("both alike", BOTH), ("slopes", SLOPES)];
        let cubic = [linear[0], linear[2]];
        self.built("trilinear, as built", Interpolation::Trilinear);
        self.best("trilinear", LINEAR, &linear);
        self.built("cubic, as built", Interpolation::Cubic);
        self.best("cubic", MEAN, &cubic);
        self.best("Catmull–Rom", CATMULL_ROM, &cubic);
        self.best("B-spline", B_SPLINE, &cubic);
        self.progress.finish_and_clear();
    }

    fn built(&self, name: &str, interpolation: Interpolation) {
        self.row(name, |truths| {
            let sample = |truth: &Truth| self.field.sample(truth.point, interpolation);
            let samples = truths.iter().map(|truth| sample(truth).expect("near the bone"));
            Errors::new(truths, samples.map(|sample| (sample.distance, sample.gradient)))
        });
    }

    /// What fits each of `aims` best, beginning with the field as it is.
    fn best<const N: usize>(&self, name: &str, spline: Spline<N>, aims: &[(&str, Aim)]) {
        let grid: &Grid = self.field.grid();
        let values: Vec<f64> = self.field.values().into_iter().map(f64::from).collect();
        let fit = Fit::new(spline, *grid, &self.fitted);
        for (aimed, aim) in aims {
            let best = fit.best(aim, &values, STEPS, || self.progress.inc(1));
            self.row(&format!("{name}, best for {aimed}"), |truths| {
                Errors::new(truths, answers(spline, grid, &best, truths))
            });
        }
    }

    fn row(&self, name: &str, errors: impl Fn(&[Truth]) -> Errors) {
        let [judged, fitted] = [&self.judged, &self.fitted].map(|truths| errors(truths));
        self.progress.suspend(|| {
            println!(
                "| {name} | {:.4} | {:.2} | {:.4} | {:.2} |",
                judged.rms, judged.direction, fitted.rms, fitted.direction
            );
        });
    }
}

/// So many that each cell within reach has [`FITTED`].
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "millions")]
fn fitted_count(mesh: &Mesh, spacing: f64) -> u32 {
    let doubled_area = |face: usize| {
        let [a, b, c] = mesh.corners(face);
        (b - a).cross(c - a).length()
    };
    let area = 0.5 * (0..mesh.faces.len()).map(doubled_area).sum::<f64>();
    (FITTED * 2.0 * REACH * area / spacing.powi(3)) as u32
}

/// Of one bone: exact distances, then nine fits.
fn progress() -> ProgressBar {
    let style = ProgressStyle::with_template("{spinner} [{bar:30}] {pos}/{len} {elapsed}");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(2 * exact::PARTS + 9 * STEPS).with_style(style)
}
