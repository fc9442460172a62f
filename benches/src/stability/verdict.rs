//! Verdicts on runs: held, or the first thing that failed.

use super::detector::TOLERANCE;
use super::scenes::Expected;
use super::{Figures, Planted};

/// Largest move of a vertex per step at rest \[mm\].
pub(super) const MAX_JITTER: f64 = 5e-3;

/// Largest speed of a body that has to rest \[mm/s\].
pub(super) const MAX_CREEP: f64 = 1e-4;

/// Largest gain of energy, over that of the fall.
pub(super) const MAX_GAIN: f64 = 1e-6;

/// Error of the acceleration down a slope.
pub(super) const MAX_SLIDE_ERROR: f64 = 0.02;

/// Distance from its place that a muscle may keep after a bone has left it \[mm\].
pub(super) const MAX_AWAY: f64 = 0.01;

/// Verdict on a run: held, or the first thing that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// All limits are kept.
    Holds,
    /// A particle left the scene.
    Thrown,
    /// A vertex left by the far side.
    Through,
    /// More overlap is left than the tolerance.
    Sinks,
    /// Energy was gained.
    Gains,
    /// Vertices do not come to rest.
    Shakes,
    /// A body that has to rest moves on.
    Creeps,
    /// A body that has to slide is held, or slides too fast.
    SlidesWrong,
    /// A body is not let go.
    Clings,
    /// The library refuses the combination.
    Refused,
}

/// Limits of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    expected: Expected,
}

impl Verdict {
    /// Returns the word in tables and pictures.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Thrown => "thrown",
            Self::Through => "through",
            Self::Sinks => "sinks in",
            Self::Gains => "gains",
            Self::Shakes => "shakes",
            Self::Creeps => "creeps",
            Self::SlidesWrong => "slides",
            Self::Clings => "clings",
            Self::Refused => "refused",
        }
    }

    /// Returns the figure that decides, with its unit.
    #[must_use]
    pub fn figure(self, figures: &Figures) -> String {
        match self {
            Self::Through => format!("{} vertices", figures.far_side),
            Self::Sinks => format!("{:.2} mm", figures.overlap),
            Self::Gains => format!("{:.0e} of the fall", figures.energy.unwrap_or(f64::NAN)),
            Self::Shakes => format!("{:.0} µm/step", 1e3 * figures.jitter),
            Self::Creeps => format!("{:.1e} mm/s", figures.creep),
            Self::SlidesWrong => format!("{:.2} of right", figures.slide),
            Self::Clings => format!("{:.2} mm", figures.away),
            Self::Holds | Self::Thrown | Self::Refused => String::new(),
        }
    }
}

impl Limits {
    /// Returns the limits of a scene.
    #[must_use]
    pub fn of(planted: Planted) -> Self {
        Self { expected: planted.expected() }
    }

    /// Returns the first limit that is not kept.
    #[must_use]
    pub fn verdict(&self, figures: &Figures) -> Verdict {
        let must_stick = self.expected == Expected::Stick;
        let must_rest = must_stick || matches!(self.expected, Expected::Rest | Expected::Return);
        let slides = matches!(self.expected, Expected::Slide { .. });
        let failures = [
            (figures.lost, Verdict::Thrown),
            (figures.far_side > 0, Verdict::Through),
            (figures.overlap > TOLERANCE, Verdict::Sinks),
            (figures.energy.is_some_and(|gain| gain > MAX_GAIN), Verdict::Gains),
            (must_stick && figures.creep > MAX_CREEP, Verdict::Creeps),
            (must_rest && figures.jitter > MAX_JITTER, Verdict::Shakes),
            (slides && (figures.slide - 1.0).abs() > MAX_SLIDE_ERROR, Verdict::SlidesWrong),
            (self.expected == Expected::Return && figures.away > MAX_AWAY, Verdict::Clings),
        ];
        let failure = failures.iter().find(|(fails, _)| *fails);
        failure.map_or(Verdict::Holds, |(_, verdict)| *verdict)
    }
}
