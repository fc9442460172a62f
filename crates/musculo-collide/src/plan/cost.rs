//! What detection will take, predicted.
//!
//! Times are sums of counts by constants, which are of one machine; a
//! millisecond of the work they were measured on says how much slower or faster
//! this one is. The same factor is on every method's cost, so that it changes
//! no choice between methods; only what is compared with a time budget.

use std::hint::black_box;
use std::time::{Duration, Instant};

use glam::DVec3;
use surface::closest_on_triangle;

/// Seconds on the machine of [`REFERENCE`].
pub(super) mod seconds {
    /// To bring the bounds over one face up to date.
    pub(crate) const REFIT_FACE: f64 = 12e-9;
    /// To sort one face of two surfaces into regions on one side.
    pub(crate) const REGION_FACE: f64 = 14e-9;
    /// To find the foot of one vertex on another surface, or that it has none.
    pub(crate) const SURFACE_VERTEX: f64 = 700e-9;
    /// To bring balls to where one vertex is that is tied to them.
    pub(crate) const TIED_VERTEX: f64 = 100e-9;
    /// To ask balls about one vertex.
    pub(crate) const BALLS_VERTEX: f64 = 500e-9;
    /// To ask a field about one vertex, edges included.
    pub(crate) const FIELD_VERTEX: f64 = 150e-9;
}

/// Seconds that one closest point of a triangle takes on the machine that the
/// constants are of.
const REFERENCE: f64 = 12e-9;

/// How many times slower than the reference machine this one is just now.
pub(super) fn slowness() -> f64 {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let mut point = DVec3::new(0.3, 0.3, 1.0);
    let (start, mut done) = (Instant::now(), 0_u32);
    while start.elapsed() < Duration::from_millis(1) {
        for _ in 0..1000 {
            let foot = closest_on_triangle(point, corners).point;
            point = DVec3::new(foot.y, 0.9 * foot.x + 0.1, 1.0);
        }
        done += 1000;
    }
    black_box(point);
    start.elapsed().as_secs_f64() / f64::from(done) / REFERENCE
}
