//! Detection and response together, over time: planted scenes in steps, with every detector and
//! every response.
//!
//! A combination *holds* in a scene if nothing is thrown, gets through, sinks in, gains energy,
//! shakes, creeps or clings: [`Verdict`] names the first of these that happens. Results have the
//! same bytes from run to run.

pub mod detector;
pub mod drive;
pub mod responder;
pub mod scenes;
pub mod simulation;
pub mod tissue;
mod verdict;

use rayon::prelude::*;

pub use self::detector::Detector;
pub use self::responder::Response;
pub use self::scenes::Planted;
pub use self::simulation::Figures;
pub use self::verdict::{Limits, Verdict};
use crate::selected;

/// Setting of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Name in tables.
    pub name: &'static str,
    /// Step \[s\].
    pub step: f64,
    /// Stiffness of soft bodies, over that of the scene.
    pub stiffness: f64,
    /// Mass of the particles of the last soft body \[g\]; all others have 1 g.
    pub mass_ratio: f64,
}

impl Setting {
    /// Steps of 1 ms, equal masses.
    pub const BASE: Self = Self { name: "1 ms", step: 1e-3, stiffness: 1.0, mass_ratio: 1.0 };
    /// Twice the step.
    pub const LONG_STEP: Self = Self { name: "2 ms", step: 2e-3, ..Self::BASE };
    /// Stiffer soft bodies.
    pub const STIFF: Self = Self { name: "10 × stiffer", stiffness: 10.0, ..Self::BASE };
    /// A heavy body, the last.
    pub const HEAVY: Self = Self { name: "mass 100 : 1", mass_ratio: 100.0, ..Self::BASE };

    /// All settings.
    pub const ALL: [Self; 4] = [Self::BASE, Self::LONG_STEP, Self::STIFF, Self::HEAVY];

    /// Returns true if the setting makes a difference in a scene: only a stack has masses to
    /// compare.
    #[must_use]
    pub fn suits(&self, planted: Planted) -> bool {
        planted == Planted::Stack || *self != Self::HEAVY
    }
}

/// A run and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The scene.
    pub planted: Planted,
    /// The detector.
    pub detector: Detector,
    /// The response.
    pub response: Response,
    /// The setting.
    pub setting: Setting,
    /// Measured figures; what the library says, where it refuses.
    pub outcome: Result<Figures, String>,
}

impl Run {
    /// Returns whether and why it does not hold.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        match &self.outcome {
            Ok(figures) => Limits::of(self.planted).verdict(figures),
            Err(_) => Verdict::Refused,
        }
    }
}

/// Runs scenes with detectors, each with all responses and settings.
#[must_use]
pub fn run_all(scenes: &[Planted], detectors: &[Detector], settings: &[Setting]) -> Vec<Run> {
    let mut jobs = Vec::new();
    for &planted in scenes {
        jobs.extend(detectors.iter().map(|&detector| (planted, detector)));
    }

    // Jobs keep their order whatever the threads, so that tables have the same rows every time.
    let runs: Vec<Vec<Run>> =
        jobs.par_iter().map(|(planted, detector)| run_job(*planted, *detector, settings)).collect();
    runs.concat()
}

/// Runs a scene with one detector, which is prepared once.
fn run_job(planted: Planted, detector: Detector, settings: &[Setting]) -> Vec<Run> {
    // A refusal is kept as text, since every run of the job reports it.
    let prepared = planted.build().map_err(|error| error.to_string()).and_then(|world| {
        let detectors = detector.prepare(&world)?;
        Ok((world, detectors))
    });
    let mut runs = Vec::new();
    let mut prepared = prepared;

    // Kept contacts are forgotten before each run, so that runs do not depend on their order.
    for &setting in settings.iter().filter(|setting| setting.suits(planted)) {
        for response in Response::ALL {
            let outcome = match &mut prepared {
                Ok((world, detectors)) => detector.restart(detectors, world).and_then(|()| {
                    let run = simulation::run(world, detectors, response, setting);
                    run.map_err(|error| error.to_string())
                }),
                Err(refusal) => Err(refusal.clone()),
            };
            runs.push(Run { planted, detector, response, setting, outcome });
        }
    }
    runs
}

/// Runs the named scenes, or all, and returns a table of what came of them.
///
/// # Errors
///
/// When there is no such scene.
pub fn table(names: &[String]) -> Result<String, String> {
    let all = Planted::ALL.map(|planted| (planted.name(), planted));
    let scenes: Vec<Planted> = selected(&all, names)?.into_iter().map(|(_, scene)| scene).collect();
    let mut text = String::new();
    for run in run_all(&scenes, &Detector::ALL, &Setting::ALL) {
        let names = [run.planted.name(), run.detector.name(), run.response.name()];
        let verdict = run.verdict();
        let figure = match &run.outcome {
            Ok(figures) => format!("{:<16}{}", verdict.figure(figures), line(figures)),
            Err(refusal) => refusal.clone(),
        };
        let [planted, detector, response] = names;
        let (setting, word) = (run.setting.name, verdict.word());
        text +=
            &format!("{planted:<14}{detector:<8}{response:<14}{setting:<14}{word:<10}{figure}\n");
    }
    Ok(text)
}

/// Formats the figures of a run.
fn line(figures: &Figures) -> String {
    let Figures { jitter, overlap, false_depth, iterations, .. } = figures;
    let energy = figures.energy.unwrap_or(f64::NAN);
    format!(
        "jit {jitter:.0e} cr {:.0e} ch {:.1} ov {overlap:.3} false {false_depth:.2} E {energy:.0e} \
         add {:.0e} far {} unk {} fb {:.2} it {iterations:.0}",
        figures.creep,
        figures.changes,
        figures.added,
        figures.far_side,
        figures.unknown_sides,
        figures.fallbacks
    )
}

/// Returns the number of steps in a time.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small counts")]
fn steps_in(time: f64, step: f64) -> u32 {
    (time / step).round() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(planted: Planted, detector: Detector, response: Response) -> (Verdict, Figures) {
        let mut world = planted.build().unwrap();
        let mut detectors = detector.prepare(&world).unwrap();
        let figures = simulation::run(&mut world, &mut detectors, response, Setting::BASE).unwrap();
        (Limits::of(planted).verdict(&figures), figures)
    }

    #[test]
    #[expect(clippy::print_stdout, reason = "figures for the table of measured values")]
    fn what_is_recommended_holds() {
        let scenes = [
            Planted::Rest,
            Planted::SlopeCatching,
            Planted::Squeeze,
            Planted::DrivenIn,
            Planted::ThinPlate,
            Planted::EdgeOnEdge,
        ];
        for planted in scenes {
            let (verdict, figures) = run(planted, Detector::Exact, Response::Sequence);
            assert_eq!(verdict, Verdict::Holds, "{planted:?}: {figures:?}");
            let (name, overlap) = (planted.name(), figures.overlap);
            println!("measured: {name}, exact overlap [mm] | {overlap:.4} | 0.2");
            if planted == Planted::Rest {
                let jitter = 1e3 * figures.jitter;
                println!("measured: {name}, move per step [µm] | {jitter:.3} | 5");
            }
        }
    }

    #[test]
    fn what_cannot_hold_is_found() {
        // Corrections of positions have no friction: the slab slides, and leaves the slope in time.
        let (verdict, figures) = run(Planted::SlopeHeld, Detector::Exact, Response::Positions);
        assert!(matches!(verdict, Verdict::Creeps | Verdict::Thrown), "{verdict:?}, {figures:?}");
        assert!(figures.creep > 100.0, "{figures:?}");

        // Penalties that are too stiff for the step.
        let (verdict, figures) = run(Planted::Rest, Detector::Exact, Response::SoftExplicit);
        assert!(matches!(verdict, Verdict::Sinks | Verdict::Gains), "{verdict:?}, {figures:?}");
    }

    #[test]
    fn runs_are_the_same_every_time() {
        let twice = [(); 2].map(|()| run(Planted::EdgeOnEdge, Detector::Field, Response::Sequence));
        assert_eq!(twice[0], twice[1]);
    }
}
