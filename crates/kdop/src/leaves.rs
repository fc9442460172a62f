//! Leaves of a tree: each the convex hull of one to three numbered points.

use crate::error::TreeError;

/// Leaves, numbered by their position in the list, over points numbered by theirs.
///
/// A leaf is the convex hull of its points, or of the balls around them when the
/// [`Extents`](crate::Extents) have radii: a cone is an edge of balls, a slab a triangle of balls.
/// An index may occur twice in a leaf, so lists of mixed arity fit into the larger form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaves<'a> {
    /// Every point or ball is a leaf of its own.
    Points,
    /// Segments (|E| × 2).
    Edges(&'a [[u32; 2]]),
    /// Triangles (|F| × 3).
    Triangles(&'a [[u32; 3]]),
}

/// Upper limit of the numbers of leaves and of points, exclusive.
///
/// Positions of three corners per leaf then fit 32 bits, and so does a reference to a node or a
/// cluster with the bit that distinguishes them.
const LIMIT: usize = 1 << 30;

impl Leaves<'_> {
    /// Returns the number of leaves over `points` points.
    #[must_use]
    pub fn count(&self, points: usize) -> usize {
        match self {
            Self::Points => points,
            Self::Edges(edges) => edges.len(),
            Self::Triangles(triangles) => triangles.len(),
        }
    }

    /// Returns the corners of a leaf; one with fewer than three repeats its last.
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

    /// Checks every index and both counts, and returns the number of leaves.
    pub(crate) fn validate(&self, points: usize) -> Result<u32, TreeError> {
        check_count(points)?;
        let count = check_count(self.count(points))?;
        for leaf in 0..count {
            let outside = self.corners(leaf).into_iter().find(|&p| p as usize >= points);
            if let Some(point) = outside {
                return Err(TreeError::PointOutOfRange { leaf: leaf as usize, point, points });
            }
        }
        Ok(count)
    }
}

fn check_count(count: usize) -> Result<u32, TreeError> {
    match u32::try_from(count) {
        Ok(small) if count < LIMIT => Ok(small),
        _ => Err(TreeError::TooMany { count, limit: LIMIT }),
    }
}
