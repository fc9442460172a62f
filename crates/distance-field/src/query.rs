//! Asking a field: at one point or at many, in its own frame or in a pose.

use glam::{DMat3, DQuat, DVec3};

use crate::field::DistanceField;
use crate::grid::{Cell, Grid, Locator};
use crate::interpolate::{Block, cubic, smooth, trilinear};
use crate::par;
use crate::store::{Nodes, Stepped, Store, Whole};

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
    /// Catmull–Rom through 4³ nodes: value and gradient that belong together, no
    /// jumps, and less than half the error near smooth parts of a surface.
    Cubic,
}

/// Where a rigid body is: `p ↦ rotation · p + translation`, from the frame its
/// field was built in to the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    rotation: DMat3,
    translation: DVec3,
}

impl Pose {
    /// The frame the field was built in.
    pub const IDENTITY: Self = Self { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };

    /// A rotation, which is normalised, then a translation.
    #[must_use]
    pub fn new(rotation: DQuat, translation: DVec3) -> Self {
        Self { rotation: DMat3::from_quat(rotation.normalize()), translation }
    }

    /// From the world into the body's frame.
    #[inline]
    #[must_use]
    pub fn into_body(&self, p: DVec3) -> DVec3 {
        let p = p - self.translation;
        let DMat3 { x_axis, y_axis, z_axis } = self.rotation;
        DVec3::new(x_axis.dot(p), y_axis.dot(p), z_axis.dot(p))
    }

    /// From the body's frame into the world.
    #[inline]
    #[must_use]
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.translation
    }

    /// A direction, from the body's frame into the world.
    #[inline]
    #[must_use]
    pub fn direction_to_world(&self, v: DVec3) -> DVec3 {
        self.rotation * v
    }
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// How values are found between nodes.
    pub interpolation: Interpolation,
    /// Taken off every distance, in the length unit. A positive offset lets
    /// vertices keep away, so that edges and faces between them do not touch.
    pub offset: f64,
    /// Where the field's body is.
    pub pose: Pose,
}

impl Default for Query {
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

/// Samples at many points: one list for each quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// As [`Sample::distance`]; infinite outside the grid.
    pub distance: Vec<f64>,
    /// As [`Sample::gradient`]; zero outside the grid.
    pub gradient: Vec<DVec3>,
}

/// Points that one thread takes at a time; fewer are not worth sharing out.
const BATCH: usize = 4096;

impl DistanceField {
    /// The field at one point of its own frame; none outside the grid, never a
    /// value carried over from its border.
    #[must_use]
    pub fn sample(&self, p: DVec3, interpolation: Interpolation) -> Option<Sample> {
        let query = Query { interpolation, ..Query::default() };
        self.ask(p, &query)
    }

    /// The field at one point of the world; none outside the grid.
    #[must_use]
    pub fn ask(&self, p: DVec3, query: &Query) -> Option<Sample> {
        match &self.store {
            Store::Dense(values) => one(&Whole::new(values, &self.grid), &self.grid, p, query),
            Store::Steps { step, values } => {
                one(&Stepped(Whole::new(values, &self.grid), *step), &self.grid, p, query)
            }
            Store::Bricks(bricks) => one(bricks, &self.grid, p, query),
        }
    }

    /// The field at many points of the world, in their order; what `out` held
    /// is lost, its memory is used again.
    pub fn ask_all(&self, points: &[DVec3], query: &Query, out: &mut Samples) {
        match &self.store {
            Store::Dense(values) => {
                all(&Whole::new(values, &self.grid), &self.grid, points, query, out);
            }
            Store::Steps { step, values } => {
                let nodes = Stepped(Whole::new(values, &self.grid), *step);
                all(&nodes, &self.grid, points, query, out);
            }
            Store::Bricks(bricks) => all(bricks, &self.grid, points, query, out),
        }
    }
}

fn all(nodes: &impl Nodes, grid: &Grid, points: &[DVec3], query: &Query, out: &mut Samples) {
    out.distance.resize(points.len(), 0.0);
    out.gradient.resize(points.len(), DVec3::ZERO);
    let asked = Asked::new(nodes, grid, query);
    let parts = points
        .chunks(BATCH)
        .zip(out.distance.chunks_mut(BATCH))
        .zip(out.gradient.chunks_mut(BATCH));
    par::for_each(parts.collect(), |_, ((points, distance), gradient)| {
        for ((&p, distance), gradient) in points.iter().zip(distance).zip(gradient) {
            let sample = asked.at(p).unwrap_or(Sample::OUTSIDE);
            (*distance, *gradient) = (sample.distance, sample.gradient);
        }
    });
}

fn one(nodes: &impl Nodes, grid: &Grid, p: DVec3, query: &Query) -> Option<Sample> {
    Asked::new(nodes, grid, query).at(p)
}

/// A query of one field, whatever it is stored as.
struct Asked<'a, N> {
    nodes: &'a N,
    grid: &'a Grid,
    locator: Locator,
    query: &'a Query,
    /// The query's pose, where it is one: turning takes a fifth of the time.
    pose: Option<Pose>,
}

impl<'a, N: Nodes> Asked<'a, N> {
    #[inline]
    fn new(nodes: &'a N, grid: &'a Grid, query: &'a Query) -> Self {
        let pose = (query.pose != Pose::IDENTITY).then_some(query.pose);
        Self { nodes, grid, locator: Locator::new(grid), query, pose }
    }

    #[inline]
    fn at(&self, p: DVec3) -> Option<Sample> {
        let Cell { node, place } =
            self.locator.locate(self.pose.map_or(p, |pose| pose.into_body(p)))?;
        let (value, slope) = match self.query.interpolation {
            Interpolation::Trilinear => trilinear(self.nodes.cell(node), place),
            Interpolation::Smooth => smooth(&block(self.nodes, self.grid, node), place),
            Interpolation::Cubic => cubic(&block(self.nodes, self.grid, node), place),
        };
        let slope = slope * self.locator.per_spacing;
        let gradient = self.pose.map_or(slope, |pose| pose.direction_to_world(slope));
        Some(Sample { distance: value - self.query.offset, gradient })
    }
}

/// The nodes around a cell; beyond the border the last two nodes are continued
/// in a straight line.
fn block(nodes: &impl Nodes, grid: &Grid, node: [usize; 3]) -> Block {
    let dims = grid.dims();
    let interior = (0..3).all(|axis| node[axis] > 0 && node[axis] + 2 < dims[axis]);
    let mut block = [[[0.0; 4]; 4]; 4];
    for (k, plane) in block.iter_mut().enumerate() {
        for (j, row) in plane.iter_mut().enumerate() {
            for (i, value) in row.iter_mut().enumerate() {
                // One more than the node, so that −1 can be written.
                let shifted = [node[0] + i, node[1] + j, node[2] + k];
                *value = if interior {
                    nodes.node(shifted.map(|n| n - 1))
                } else {
                    continued(nodes, dims, shifted)
                };
            }
        }
    }
    block
}

/// Value of the node `shifted − 1`, which may be one beyond the border.
fn continued(nodes: &impl Nodes, dims: [usize; 3], shifted: [usize; 3]) -> f32 {
    let beyond = (0..3).find(|&axis| shifted[axis] == 0 || shifted[axis] > dims[axis]);
    let Some(axis) = beyond else {
        return nodes.node(shifted.map(|n| n - 1));
    };
    let step = |by: usize| {
        let mut inner = shifted;
        inner[axis] = if shifted[axis] == 0 { by } else { shifted[axis] - by };
        continued(nodes, dims, inner)
    };
    2.0 * step(1) - step(2)
}
