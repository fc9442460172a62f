//! Bounds of a field: a box around all points within a margin, and where its gradient
//! cannot descend to the margin.

use glam::{BVec3, DVec3};
use surface::Aabb;

use super::gradient::GradientBounds;
use crate::DistanceField;

/// Bounds of a field for a margin, in the field's own frame.
#[derive(Clone, Debug)]
pub(super) struct FieldBounds {
    /// Box around all points of the grid within the margin, empty where there is none.
    region: Aabb,
    /// The grid.
    grid: Aabb,
    /// Smallest value on the border of the grid.
    min_border: f64,
    gradients: GradientBounds,
    margin: f64,
    max_value: f64,
}

/// Distance of the box from the border of the grid, in spacings: more than rounding carries
/// a point of the box out of the grid.
const BORDER: f64 = 1e-9;

impl FieldBounds {
    /// Computes the bounds in one pass over the nodes.
    pub(super) fn new(field: &DistanceField, margin: f64) -> Self {
        let (grid, values) = (field.grid(), field.values());
        let [nx, ny, nz] = grid.dims();

        // The box around the nodes within the margin, the largest value, and the least on the border.
        let (mut nodes, mut max_value) = (Aabb::EMPTY, f32::NEG_INFINITY);
        let mut min_border = f32::INFINITY;
        for (row, values) in values.chunks(nx).enumerate() {
            let (j, k) = (row % ny, row / ny);
            for (i, &value) in values.iter().enumerate() {
                max_value = max_value.max(value);
                if f64::from(value) <= margin {
                    nodes = nodes.with_point(grid.position([i, j, k]));
                }
            }
            let is_outer = j == 0 || j + 1 == ny || k == 0 || k + 1 == nz;
            let border = values.iter().step_by(if is_outer { 1 } else { nx - 1 });
            min_border = border.copied().fold(min_border, f32::min);
        }

        // A point within the margin has such a node within a spacing along each axis.
        let spacing = grid.spacing();
        let last = grid.position([nx - 1, ny - 1, nz - 1]);
        let inner = Aabb { min: grid.origin(), max: last }.inflate(-BORDER * spacing);
        let region = nodes.inflate(spacing).intersection(inner);
        let gradients = GradientBounds::new(grid, &values);
        let (max_value, min_border) = (f64::from(max_value), f64::from(min_border));
        Self { region, grid: inner, min_border, gradients, margin, max_value }
    }

    /// Computes a lower bound on the distance of a point outside the grid.
    ///
    /// The way to the body's nearest point enters the box where the value is the margin, or with
    /// the grid, whose border may be within the margin. Without a box, it enters the grid alone.
    pub(super) fn min_distance_outside(&self, p: DVec3) -> f64 {
        let Aabb { min, max } = if self.region.is_empty() { self.grid } else { self.region };
        self.margin.min(self.min_border) + p.distance(p.max(min).min(max))
    }

    /// Returns the largest value of a node: one that is not less may be truncated.
    pub(super) fn max_value(&self) -> f64 {
        self.max_value
    }

    /// Returns the corners of the box; `None` where no point is within the margin.
    pub(super) fn corners(&self) -> Option<[DVec3; 8]> {
        if self.region.is_empty() {
            return None;
        }
        let Aabb { min, max } = self.region;
        let mut corners = [min; 8];
        for (k, corner) in corners.iter_mut().enumerate() {
            let is_upper = BVec3::new(k & 1 > 0, k & 2 > 0, k & 4 > 0);
            *corner = DVec3::select(is_upper, max, min);
        }
        Some(corners)
    }

    /// Returns the center of the box.
    pub(super) fn center(&self) -> DVec3 {
        0.5 * (self.region.min + self.region.max)
    }

    /// Returns the nearest point of the box.
    pub(super) fn clamp(&self, p: DVec3) -> DVec3 {
        p.max(self.region.min).min(self.region.max)
    }

    /// Returns the nearest point of the grid.
    pub(super) fn clamp_to_grid(&self, p: DVec3) -> DVec3 {
        p.max(self.grid.min).min(self.grid.max)
    }

    /// Returns true if a ball may contain a point within the margin, given the value at the
    /// point of the box that is nearest to its center.
    pub(super) fn may_descend(&self, center: DVec3, radius: f64, value: f64) -> bool {
        let excess = self.excess(value);
        if excess > self.gradients.max() * radius {
            return false;
        }

        // The bound of the whole field does not decide: that around the ball is smaller.
        let (min, max) = (self.clamp(center - radius), self.clamp(center + radius));
        excess <= self.gradients.max_in(Aabb { min, max }) * radius
    }

    /// Returns true if no segment of this length between points of these values comes
    /// within the margin.
    pub(super) fn clears_length(&self, [a, b]: [f64; 2], length: f64) -> bool {
        self.excess(a) + self.excess(b) > self.gradients.max() * length
    }

    /// Returns true if the segment between two points of these values does not come within
    /// the margin.
    ///
    /// Points outside the box are represented by the nearest points of it.
    pub(super) fn clears_segment(&self, ends: [DVec3; 2], [a, b]: [f64; 2]) -> bool {
        let around = Aabb::of_points([self.clamp(ends[0]), self.clamp(ends[1])]);
        let gradient = self.gradients.max_in(around);
        self.excess(a) + self.excess(b) > gradient * ends[0].distance(ends[1])
    }

    /// Returns the height of a value over the margin; 0 for infinity, which stands for
    /// points outside the grid.
    fn excess(&self, value: f64) -> f64 {
        if value == f64::INFINITY { 0.0 } else { value - self.margin }
    }

    /// Returns the memory of the bounds, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.gradients.bytes()
    }
}
