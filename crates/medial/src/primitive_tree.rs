//! Tree of bounds over the primitives of a medial surface, and the nearest of them to a point.

use glam::DVec3;
use kdop::{Dop18, Extents, Leaves, Tree, Workspace};

use crate::distance::PreparedSlab;
use crate::{Foot, FootRule, MedialError, MedialSurface};

/// Tree of 18-DOPs over slabs, cones and isolated balls.
///
/// The bound of a ball along a direction n is `n·c ± r‖n‖`; that of a primitive is that of its
/// balls, since it is their hull.
#[derive(Clone, Debug)]
pub struct PrimitiveTree {
    tree: Tree,
    centers: Vec<DVec3>,
    radii: Vec<f64>,
}

/// Nearest primitive to a point, with its foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPrimitive {
    /// Number of the primitive.
    pub primitive: u32,
    /// Foot of the point on it.
    pub foot: Foot,
}

impl PrimitiveTree {
    /// Builds a tree over the primitives of `medial`.
    ///
    /// # Errors
    ///
    /// [`MedialError::Tree`] when the bounds of a ball exceed what can be stored.
    pub fn new(medial: &MedialSurface) -> Result<Self, MedialError> {
        let mut built = Self { tree: Tree::default(), centers: Vec::new(), radii: Vec::new() };
        built.copy_balls(medial);
        let leaves = Leaves::Triangles(medial.primitives());
        built.tree = Tree::build_from(leaves, built.extents())?;
        Ok(built)
    }

    /// Fits the tree to balls that moved or changed their radii.
    ///
    /// # Errors
    ///
    /// [`MedialError::Tree`] when `medial` has another number of balls than at the start.
    pub fn refit(&mut self, medial: &MedialSurface) -> Result<(), MedialError> {
        self.copy_balls(medial);
        let extents = Extents::Balls { centers: &self.centers, radii: &self.radii };
        Ok(self.tree.refit_from(extents)?)
    }

    fn copy_balls(&mut self, medial: &MedialSurface) {
        self.centers.clear();
        self.radii.clear();
        for ball in medial.balls() {
            self.centers.push(ball.center);
            self.radii.push(ball.radius);
        }
    }

    fn extents(&self) -> Extents<'_> {
        Extents::Balls { centers: &self.centers, radii: &self.radii }
    }

    /// Returns the tree itself, whose leaves are the primitives by number.
    #[must_use]
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Finds the primitive with the smallest signed distance to `p`, of equals the one of the
    /// lowest number. Where positive, the distance is that of the union.
    ///
    /// `medial` must be the medial surface that the tree was built over or last refit to.
    #[must_use]
    pub fn nearest(
        &self,
        medial: &MedialSurface,
        p: DVec3,
        workspace: &mut Workspace,
    ) -> NearestPrimitive {
        self.nearest_from(medial, p, 0, workspace)
    }

    /// Finds the primitive that [`Self::nearest`] finds, faster where `guess` is near it.
    pub(crate) fn nearest_from(
        &self,
        medial: &impl ExactFeet,
        p: DVec3,
        guess: u32,
        workspace: &mut Workspace,
    ) -> NearestPrimitive {
        let mut best = medial.nearest_on(p, guess);
        // Inside the union, all bounds that contain p are at distance 0, and each of them may be
        // that of the deepest primitive.
        self.tree.nearest_unordered(p, best.foot.distance.max(0.0), workspace, |primitive| {
            let found = medial.nearest_on(p, primitive);
            if (found.foot.distance, primitive) < (best.foot.distance, best.primitive) {
                best = found;
            }
            best.foot.distance.max(0.0)
        });
        best
    }

    /// Visits the primitives whose signed distance to `p` is at most `limit`, with their feet.
    pub(crate) fn within(
        &self,
        medial: &impl ExactFeet,
        p: DVec3,
        limit: f64,
        workspace: &mut Workspace,
        mut visit: impl FnMut(NearestPrimitive),
    ) {
        let around = Dop18::from_points(&[p]).inflated(limit.max(0.0));
        self.tree.query(&around, workspace, |primitive| {
            let found = medial.nearest_on(p, primitive);
            if found.foot.distance <= limit {
                visit(found);
            }
        });
    }
}

/// Exact feet on the primitives of a medial surface.
pub(crate) trait ExactFeet {
    /// Computes the exact foot of `p` on a primitive.
    fn exact_foot(&self, p: DVec3, primitive: u32) -> Foot;

    /// Computes the exact foot of `p` on a primitive, with its number.
    fn nearest_on(&self, p: DVec3, primitive: u32) -> NearestPrimitive {
        NearestPrimitive { primitive, foot: self.exact_foot(p, primitive) }
    }
}

impl ExactFeet for MedialSurface {
    fn exact_foot(&self, p: DVec3, primitive: u32) -> Foot {
        self.foot(p, primitive, FootRule::Exact)
    }
}

/// Primitives of a medial surface in one state, prepared for the feet of many points.
pub(crate) struct PreparedSlabs(Vec<PreparedSlab>);

impl PreparedSlabs {
    pub(crate) fn new(medial: &MedialSurface) -> Self {
        let mut slabs = Vec::with_capacity(medial.primitives().len());
        for (primitive, _) in (0_u32..).zip(medial.primitives()) {
            slabs.push(PreparedSlab::new(medial.primitive_balls(primitive)));
        }
        Self(slabs)
    }
}

impl ExactFeet for PreparedSlabs {
    fn exact_foot(&self, p: DVec3, primitive: u32) -> Foot {
        self.0[primitive as usize].foot(p)
    }
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;

    use super::*;
    use crate::Ball;

    #[test]
    fn all_primitives_within_a_distance_are_visited() {
        let mut random = Random(3);
        let mut point = || DVec3::from_array([(); 3].map(|()| 20.0 * random.unit()));
        let balls = (0..60).map(|_| Ball::new(point(), 0.1 * point().x)).collect();
        let cones = (0..59).map(|first| [first, first + 1]).collect();
        let medial = MedialSurface::new(balls, cones, vec![]).expect("a chain");
        let tree = PrimitiveTree::new(&medial).expect("finite balls");
        let mut workspace = Workspace::default();
        let mut all = 0;
        for _ in 0..200 {
            let (p, limit) = (point(), 0.4 * point().x);
            let mut visited = Vec::new();
            tree.within(&medial, p, limit, &mut workspace, |near| visited.push(near.primitive));
            visited.sort_unstable();
            let near = (0..59).filter(|&cone| medial.nearest_on(p, cone).foot.distance <= limit);
            let expected: Vec<u32> = near.collect();
            assert_eq!(visited, expected, "within {limit} of {p}");
            all += visited.len();
        }
        assert!(all > 1000, "{all}");
    }
}
