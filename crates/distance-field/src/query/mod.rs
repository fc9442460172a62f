//! Queries of a field: at one point or at many, in its own frame or in a pose.

mod batch;
mod interpolate;
mod sampler;
mod segment;

use glam::DVec3;
use surface::Pose;

use self::sampler::Sampler;
pub use self::segment::SegmentMinimum;
use crate::DistanceField;
use crate::frame::Frame;
use crate::store::NodeStore;

/// Interpolation between nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Interpolation {
    /// Trilinear value of the eight corners, with its own gradient: the fastest. The gradient
    /// jumps by a few degrees between cells.
    #[default]
    Trilinear,
    /// The same value with interpolated central differences, which are continuous.
    Smooth,
    /// Cubic of 4³ nodes: value and gradient that belong together, continuous, with the
    /// smallest error near smooth parts of a surface. Catmull–Rom between distances; between
    /// coefficients of a quasi-interpolation its mean with the cubic B-spline, which takes
    /// the correction back.
    Cubic,
}

/// Parameters of a query.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct QueryParams {
    /// Interpolation between nodes.
    pub interpolation: Interpolation,
    /// Length that is subtracted from every distance. A positive offset keeps vertices away,
    /// so that edges and faces between them do not touch.
    pub offset: f64,
    /// Pose of the field's body.
    pub pose: Pose,
}

impl Default for QueryParams {
    fn default() -> Self {
        Self { interpolation: Interpolation::Trilinear, offset: 0.0, pose: Pose::IDENTITY }
    }
}

/// Value of a field at a point, with its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sample {
    /// Signed distance less the offset, in the length unit; negative inside.
    pub distance: f64,
    /// Gradient in the world, not normalized.
    ///
    /// Its length is near 1 where its direction is reliable. It is shorter where several
    /// parts of the surface are equally near, so that there is no single direction, and 0
    /// where the field is truncated.
    pub gradient: DVec3,
}

impl Sample {
    /// Sample that a batch holds for points outside the grid: infinitely far, no direction.
    pub const OUTSIDE: Self = Self { distance: f64::INFINITY, gradient: DVec3::ZERO };

    /// Returns the unit direction away from the surface; `None` where the gradient is
    /// shorter than `min_length`, of which one half is a fair choice.
    #[must_use]
    pub fn direction(&self, min_length: f64) -> Option<DVec3> {
        let length = self.gradient.length();
        (length >= min_length && length > 0.0).then(|| self.gradient / length)
    }
}

/// Samples at many points, one list per quantity.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SampleBatch {
    /// Distances as [`Sample::distance`]; infinite outside the grid.
    pub distance: Vec<f64>,
    /// Gradients as [`Sample::gradient`]; zero outside the grid.
    pub gradient: Vec<DVec3>,
}

impl DistanceField {
    /// Evaluates the field at a point of its own frame; `None` outside the grid.
    #[must_use]
    pub fn evaluate(&self, p: DVec3, interpolation: Interpolation) -> Option<Sample> {
        let params = QueryParams { interpolation, ..QueryParams::default() };
        self.query_in(&self.frame, p, &params)
    }

    /// Evaluates the field at a point of the world; `None` outside the grid.
    #[must_use]
    pub fn query(&self, p: DVec3, params: &QueryParams) -> Option<Sample> {
        self.query_in(&Frame::new(&self.grid, &params.pose), p, params)
    }

    #[inline]
    fn query_in(&self, frame: &Frame, p: DVec3, params: &QueryParams) -> Option<Sample> {
        match &self.store {
            NodeStore::Floats(nodes) => Sampler { field: self, nodes, frame, params }.sample(p),
            NodeStore::Steps(nodes) => Sampler { field: self, nodes, frame, params }.sample(p),
        }
    }

    /// Evaluates the field at many points of the world, in their order. The memory of `out`
    /// is reused.
    pub fn query_batch(&self, points: &[DVec3], params: &QueryParams, out: &mut SampleBatch) {
        let frame = &Frame::new(&self.grid, &params.pose);
        match &self.store {
            NodeStore::Floats(nodes) => {
                Sampler { field: self, nodes, frame, params }.batch(points, out);
            }
            NodeStore::Steps(nodes) => {
                Sampler { field: self, nodes, frame, params }.batch(points, out);
            }
        }
    }
}
