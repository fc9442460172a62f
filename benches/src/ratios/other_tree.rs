//! Work that trees of boxes are set to beside trees of k-DOPs.

use glam::DVec3;

/// Tree of boxes that trees of k-DOPs are compared with, set to the same work.
///
/// It holds single precision, as they do. Vertices are converted beforehand; the conversion is not
/// part of a measurement.
pub(super) trait OtherTree: Sized {
    /// Name in figures.
    const NAME: &'static str;

    type Point;

    /// Converts points.
    fn points(points: &[DVec3]) -> Vec<Self::Point>;

    fn build(triangles: &[[u32; 3]], points: &[Self::Point]) -> Self;

    fn leaf_count(&self) -> usize;

    /// Refits to points.
    fn refit(&mut self, points: &[Self::Point]) -> usize;

    /// Refits without a better order of nodes, where [`refit`](Self::refit) looks for one.
    fn refit_in_place(&mut self, points: &[Self::Point]) -> usize {
        self.refit(points)
    }

    /// Refits to the boxes of triangles at both ends of a step.
    fn refit_swept(&mut self, ends: [&[Self::Point]; 2]) -> usize;

    /// Collects pairs of triangles.
    fn pairs(&mut self, other: &Self, out: &mut Vec<(u32, u32)>) -> usize;

    /// Collects self pairs that share no vertex.
    fn self_pairs(&mut self, out: &mut Vec<(u32, u32)>) -> usize;
}
