//! What detection will take, predicted.
//!
//! Times are sums of counts by constants, which are of one reference machine, times a
//! factor for the machine at hand that the caller passes. The same factor is on every
//! method's cost: it changes no choice between methods, only what is compared with a
//! time budget.

use std::hint::black_box;
use std::ops::Add;
use std::time::Duration;

use glam::DVec3;
use surface::closest_on_triangle;

/// What a frame of detection has to do, counted; and how long each of it takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OperationCounts {
    /// Faces whose bounds are brought up to date.
    pub refit_faces: f64,
    /// Faces of two surfaces that are compared with each other.
    pub compared_faces: f64,
    /// Vertices that a field is asked about, with their edges.
    pub field_vertices: f64,
    /// Vertices that balls are tied to and follow.
    pub tied_vertices: f64,
    /// Vertices that balls are asked about.
    pub ball_vertices: f64,
}

/// Seconds that one closest point of a triangle takes on the machine that the
/// constants are of.
const REFERENCE_QUERY_SECONDS: f64 = 12e-9;

impl OperationCounts {
    /// Seconds that one of each takes on the reference machine, as
    /// `cargo xtask chart costs` measures them.
    pub const SECONDS: Self = Self {
        refit_faces: 3e-9,
        compared_faces: 26e-9,
        field_vertices: 380e-9,
        tied_vertices: 200e-9,
        ball_vertices: 1000e-9,
    };

    /// In the order of the fields.
    #[must_use]
    pub const fn to_array(self) -> [f64; 5] {
        let Self { refit_faces, compared_faces, field_vertices, tied_vertices, ball_vertices } =
            self;
        [refit_faces, compared_faces, field_vertices, tied_vertices, ball_vertices]
    }

    /// From values in the order of the fields.
    #[must_use]
    pub const fn from_array(values: [f64; 5]) -> Self {
        let [refit_faces, compared_faces, field_vertices, tied_vertices, ball_vertices] = values;
        Self { refit_faces, compared_faces, field_vertices, tied_vertices, ball_vertices }
    }

    /// Returns the seconds that these operations take on the reference machine.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.to_array().iter().zip(Self::SECONDS.to_array()).map(|(count, each)| count * each).sum()
    }
}

/// Measures how much slower than the reference machine this one is, over a
/// millisecond of closest-point queries.
///
/// `now` returns the time since any fixed moment: the library has no clock of its
/// own.
///
/// ```
/// use plan::{PlanParams, machine_factor};
///
/// let start = std::time::Instant::now();
/// let machine_factor = machine_factor(|| start.elapsed());
/// let params = PlanParams { machine_factor, ..PlanParams::with_tolerance(0.5) };
/// # assert!(params.validate().is_ok());
/// ```
pub fn machine_factor(now: impl Fn() -> Duration) -> f64 {
    const BATCH: u32 = 1000;
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let mut point = DVec3::new(0.3, 0.3, 1.0);
    let mut queries = 0;

    // Each query depends on the last one, so that none can be left out.
    let start = now();
    let mut elapsed = Duration::ZERO;
    while elapsed < Duration::from_millis(1) {
        for _ in 0..BATCH {
            let foot = closest_on_triangle(point, corners).point;
            point = DVec3::new(foot.y, 0.9 * foot.x + 0.1, 1.0);
        }
        queries += BATCH;
        elapsed = now().saturating_sub(start);
    }
    black_box(point);
    elapsed.as_secs_f64() / f64::from(queries) / REFERENCE_QUERY_SECONDS
}

impl Add for OperationCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let [a, b] = [self, other].map(Self::to_array);
        Self::from_array(std::array::from_fn(|kind| a[kind] + b[kind]))
    }
}
