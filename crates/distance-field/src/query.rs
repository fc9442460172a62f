//! Asking a field: at one point or at many, in its own frame or in a pose.

use glam::DVec3;
use surface::Pose;

use crate::ask::Asked;
use crate::field::DistanceField;
use crate::frame::Frame;
use crate::store::Store;

/// How a value is found between nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Interpolation {
    /// Of the eight corners, with the gradient of just that: the quickest. The
    /// gradient jumps by a few degrees between cells.
    #[default]
    Trilinear,
    /// The same value, with interpolated central differences: no jumps.
    Smooth,
    /// A cubic of 4³ nodes: value and gradient that belong together, no jumps, and
    /// the least error near smooth parts of a surface. Catmull–Rom through
    /// interpolating nodes; for those of a quasi-interpolation its mean with the
    /// cubic B-spline, which takes back what they gave way.
    Cubic,
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueryParams {
    /// How values are found between nodes.
    pub interpolation: Interpolation,
    /// Taken off every distance, in the length unit. A positive offset lets
    /// vertices keep away, so that edges and faces between them do not touch.
    pub offset: f64,
    /// Where the field's body is.
    pub pose: Pose,
}

impl Default for QueryParams {
    fn default() -> Self {
        Self { interpolation: Interpolation::Trilinear, offset: 0.0, pose: Pose::IDENTITY }
    }
}

/// A distance and where it grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Signed distance less the offset, in the length unit; negative inside.
    pub distance: f64,
    /// How it changes, in the world; not normalised.
    ///
    /// Its length is near 1 where the direction can be relied on. It falls
    /// where several parts of the surface are equally near, which leaves no one
    /// direction, and is 0 where the field is truncated.
    pub gradient: DVec3,
}

impl Sample {
    /// What a batch holds for points outside the grid: infinitely far, no
    /// direction.
    pub const OUTSIDE: Self = Self { distance: f64::INFINITY, gradient: DVec3::ZERO };

    /// Unit direction away from the surface, or none when the gradient is
    /// shorter than `least`; one half is a fair choice.
    #[must_use]
    pub fn direction(&self, least: f64) -> Option<DVec3> {
        let length = self.gradient.length();
        (length >= least && length > 0.0).then(|| self.gradient / length)
    }
}

/// SampleBatch at many points: one list for each quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampleBatch {
    /// As [`Sample::distance`]; infinite outside the grid.
    pub distance: Vec<f64>,
    /// As [`Sample::gradient`]; zero outside the grid.
    pub gradient: Vec<DVec3>,
}

impl DistanceField {
    /// The field at one point of its own frame; none outside the grid, never a
    /// value carried over from its border.
    #[must_use]
    pub fn evaluate(&self, p: DVec3, interpolation: Interpolation) -> Option<Sample> {
        let query = QueryParams { interpolation, ..QueryParams::default() };
        self.query_in(&self.frame, p, &query)
    }

    /// The field at one point of the world; none outside the grid.
    #[must_use]
    pub fn query(&self, p: DVec3, query: &QueryParams) -> Option<Sample> {
        self.query_in(&Frame::new(&self.grid, &query.pose), p, query)
    }

    #[inline]
    fn query_in(&self, frame: &Frame, p: DVec3, query: &QueryParams) -> Option<Sample> {
        match &self.store {
            Store::Floats(nodes) => Asked::new(nodes, self, frame, query).at(p),
            Store::Steps(nodes) => Asked::new(nodes, self, frame, query).at(p),
        }
    }

    /// The field at many points of the world, in their order; what `out` held
    /// is lost, its memory is used again.
    pub fn query_batch(&self, points: &[DVec3], query: &QueryParams, out: &mut SampleBatch) {
        let frame = &Frame::new(&self.grid, &query.pose);
        match &self.store {
            Store::Floats(nodes) => Asked::new(nodes, self, frame, query).all(points, out),
            Store::Steps(nodes) => Asked::new(nodes, self, frame, query).all(points, out),
        }
    }
}
