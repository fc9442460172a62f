//! What a tree bounds: leaves, each the hull of one to three numbered points.

use crate::error::TreeError;

/// Leaves, numbered by their position in the list, over points numbered by theirs.
///
/// A leaf is the convex hull of its points, or of the balls around them when the
/// [`Extents`](crate::Extents) have radii: a cone is an edge of balls, a slab a triangle of balls.
/// An index may occur twice in a leaf, so lists of mixed arity fit into the larger form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaves<'a> {
    /// Every point, ball or box is a leaf of its own.
    Points,
    /// Segments (|E| × 2).
    Edges(&'a [[u32; 2]]),
    /// Triangles (|F| × 3).
    Triangles(&'a [[u32; 3]]),
}

/// Three corners for each of fewer leaves than this still have 32-bit positions, with room for the
/// bit that tells clusters from nodes.
pub(crate) const LIMIT: usize = 1 << 30;

impl Leaves<'_> {
    /// How many leaves there are over `points` points.
    #[must_use]
    pub fn count(&self, points: usize) -> usize {
        match self {
            Self::Points => points,
            Self::Edges(edges) => edges.len(),
            Self::Triangles(triangles) => triangles.len(),
        }
    }

    /// Corners of leaf `leaf`; one with fewer than three repeats its last.
    pub(crate) fn corners(&self, leaf: u32) -> [u32; 3] {
        match self {
            Self::Points => [leaf; 3],
            Self::Edges(edges) => {
                let [a, b] = edges[leaf as usize];
                [a, b, b]
            }
            Self::Triangles(triangles) => triangles[leaf as usize],
        }
    }

    /// Checks every index and both counts; afterwards they fit 32 bits.
    pub(crate) fn check(&self, points: usize) -> Result<u32, TreeError> {
        let leaves = self.count(points);
        fits(points)?;
        let count = fits(leaves)?;
        for leaf in 0..count {
            let outside = self.corners(leaf).into_iter().find(|&p| p as usize >= points);
            if let Some(point) = outside {
                return Err(TreeError::PointOutOfRange { leaf: leaf as usize, point, points });
            }
        }
        Ok(count)
    }
}

fn fits(count: usize) -> Result<u32, TreeError> {
    match u32::try_from(count) {
        Ok(small) if count < LIMIT => Ok(small),
        _ => Err(TreeError::TooMany { count, limit: LIMIT }),
    }
}
