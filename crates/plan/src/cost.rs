//! Cost model: operation counts, and their times on a reference machine.
//!
//! Refits and projections to a surface read memory at places that the next one does not: in scenes
//! too large for the caches they take several times as long as in small ones. A share of them, by the
//! logarithm of the number of faces in the scene, is therefore counted once more, as far.
//!
//! A predicted time is a sum of counts by constants, times a factor for the machine at hand that
//! the caller passes. The factor is the same for every method: it changes no choice between
//! methods, only what is compared with a time budget.

use std::hint::black_box;
use std::ops::Add;
use std::time::Duration;

use glam::DVec3;
use scene::Scene;
use surface::closest_on_triangle;

/// Numbers of operations of a detection frame, or of the construction of a structure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OperationCounts {
    /// Faces whose bounds are refit.
    pub refit_faces: f64,
    /// The share of these whose memory no cache holds.
    pub far_refit_faces: f64,
    /// Vertices of surfaces that are compared with each other, near or far.
    pub listed_vertices: f64,
    /// Pairs of faces whose bounds overlap.
    pub tested_faces: f64,
    /// Pairs of faces that share a point.
    pub meeting_faces: f64,
    /// Vertices that are projected to the other surface.
    pub near_vertices: f64,
    /// The share of these whose memory no cache holds.
    pub far_near_vertices: f64,
    /// Pairs of faces whose crossing bounds a search for a depth, once from either side.
    pub clipped_faces: f64,
    /// Triangles that are split in searches for a depth.
    pub split_pieces: f64,
    /// Closest points in searches for a depth.
    pub depth_queries: f64,
    /// Vertices at which a field is queried, with their edges.
    pub field_vertices: f64,
    /// Vertices that are attached to balls, which follow them.
    pub tied_vertices: f64,
    /// Vertices that are compared with balls.
    pub ball_vertices: f64,
    /// Faces over which a tree is built.
    pub tree_faces: f64,
    /// Faces that are decimated to a coarser surface, and those once more that it does not keep.
    pub decimated_faces: f64,
    /// The share of these whose memory no cache holds.
    pub far_decimated_faces: f64,
    /// Nodes of fields that are built.
    pub field_nodes: f64,
}

/// Number of kinds of operations.
const KINDS: usize = 17;

/// Time of one closest point of a triangle on the reference machine \[s\].
///
/// Calibrated, as `benches regret` prints: frames on another machine are predicted too short as often as
/// too long.
const REFERENCE_QUERY_TIME: f64 = 11.2e-9;

impl OperationCounts {
    /// Times of single operations on the reference machine \[s\], as `cargo xtask chart costs`
    /// measures them. Decimation is taken to be a little dearer: what it saves is only predicted.
    pub const SECONDS: Self = Self {
        refit_faces: 2.2e-9,
        far_refit_faces: 0.8e-9,
        listed_vertices: 0.6e-9,
        tested_faces: 50e-9,
        meeting_faces: 140e-9,
        near_vertices: 130e-9,
        far_near_vertices: 1200e-9,
        clipped_faces: 215e-9,
        split_pieces: 220e-9,
        depth_queries: 2450e-9,
        field_vertices: 2750e-9,
        tied_vertices: 155e-9,
        ball_vertices: 32e-9,
        tree_faces: 73e-9,
        decimated_faces: 1500e-9,
        far_decimated_faces: 1500e-9,
        field_nodes: 34e-9,
    };

    /// Returns the counts in the order of the fields.
    #[must_use]
    pub const fn to_array(self) -> [f64; KINDS] {
        [
            self.refit_faces,
            self.far_refit_faces,
            self.listed_vertices,
            self.tested_faces,
            self.meeting_faces,
            self.near_vertices,
            self.far_near_vertices,
            self.clipped_faces,
            self.split_pieces,
            self.depth_queries,
            self.field_vertices,
            self.tied_vertices,
            self.ball_vertices,
            self.tree_faces,
            self.decimated_faces,
            self.far_decimated_faces,
            self.field_nodes,
        ]
    }

    /// Returns the counts in the order of the fields, from an array.
    const fn from_array(counts: [f64; KINDS]) -> Self {
        let [
            refit_faces,
            far_refit_faces,
            listed_vertices,
            tested_faces,
            meeting_faces,
            near_vertices,
            far_near_vertices,
            clipped_faces,
            split_pieces,
            depth_queries,
            field_vertices,
            tied_vertices,
            ball_vertices,
            tree_faces,
            decimated_faces,
            far_decimated_faces,
            field_nodes,
        ] = counts;
        Self {
            refit_faces,
            far_refit_faces,
            listed_vertices,
            tested_faces,
            meeting_faces,
            near_vertices,
            far_near_vertices,
            clipped_faces,
            split_pieces,
            depth_queries,
            field_vertices,
            tied_vertices,
            ball_vertices,
            tree_faces,
            decimated_faces,
            far_decimated_faces,
            field_nodes,
        }
    }

    /// Returns the time of these operations on the reference machine \[s\].
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.to_array().iter().zip(Self::SECONDS.to_array()).map(|(count, each)| count * each).sum()
    }

    /// Returns the way from these counts to others, by a share of it.
    #[must_use]
    pub(crate) fn lerp(self, other: Self, share: f64) -> Self {
        let (from, to) = (self.to_array(), other.to_array());
        Self::from_array(std::array::from_fn(|kind| from[kind] + share * (to[kind] - from[kind])))
    }
}

impl Add for OperationCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (p, q) = (self.to_array(), other.to_array());
        Self::from_array(std::array::from_fn(|kind| p[kind] + q[kind]))
    }
}

/// Measures the [machine factor](crate::PlanParams::machine_factor) of this machine, over a
/// millisecond of closest-point queries.
///
/// Batches of them are timed one by one, some in any case, of which the quickest counts: what else
/// the machine does in that millisecond changes little. `now` returns the time since any fixed
/// moment: the library itself has no clock.
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
    // Many queries per reading of the clock, which takes longer than one.
    const BATCH: u32 = 1000;
    const MIN_BATCHES: u32 = 20;
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let mut point = DVec3::new(0.3, 0.3, 1.0);

    // Each query depends on the last one, so that none can be left out.
    let start = now();
    let (mut last, mut quickest, mut batches) = (start, Duration::MAX, 0);
    while batches < MIN_BATCHES || last.saturating_sub(start) < Duration::from_millis(1) {
        for _ in 0..BATCH {
            let foot = closest_on_triangle(point, corners).point;
            point = DVec3::new(foot.y, 0.9 * foot.x + 0.1, 1.0);
        }
        let end = now();
        quickest = quickest.min(end.saturating_sub(last));
        last = end;
        batches += 1;
    }
    black_box(point);
    quickest.as_secs_f64() / f64::from(BATCH) / REFERENCE_QUERY_TIME
}

/// Faces of a scene of which no operation is far, and of one of which all are. A face takes some 150
/// bytes of memory, with its vertices and bounds: few caches hold the one number, none the other.
const CACHED_FACES: f64 = 2e3;
const FAR_FACES: f64 = 4e5;

/// Returns the share of operations in a scene that are far.
pub(crate) fn far_share(scene: &Scene) -> f64 {
    let faces = scene.bodies().iter().map(|body| count(body.surface().faces().len()));
    let above = (faces.sum::<f64>() / CACHED_FACES).max(1.0).ln();
    (above / (FAR_FACES / CACHED_FACES).ln()).min(1.0)
}

/// Converts a count for sums of costs.
#[expect(clippy::cast_precision_loss, reason = "no count here comes near 2^53")]
pub(crate) fn count(n: usize) -> f64 {
    n as f64
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::BodyKind;

    use super::*;

    #[test]
    fn the_share_that_is_far_grows_with_the_logarithm_of_the_faces() {
        // An icosahedron of 20 faces, each halving of whose edges makes four of one.
        let share = |halvings: u32| {
            let ball = shapes::icosphere(1.0, halvings);
            let mut scene = Scene::new();
            scene.add("ball", BodyKind::Rigid, ball.surface(), ball.positions).expect("a body");
            far_share(&scene)
        };
        assert!(share(1) <= 0.0 && share(3) <= 0.0);
        let (small, large) = (share(4), share(5));
        assert!(small > 0.0 && large < 1.0, "{small}, {large}");
        let per_halving = 4.0_f64.ln() / (FAR_FACES / CACHED_FACES).ln();
        assert!((large - small - per_halving).abs() < 1e-12, "{small}, {large}");
    }
}
