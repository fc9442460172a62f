//! A tree of bounds over the primitives of a medial surface, and the foot of a
//! point on all of them.

use glam::DVec3;
use kdop::{Dop18, Extents, Leaves, Tree, Workspace};

use crate::{Ball, Foot, FootRule, MedialError, MedialSurface};

/// A tree of 18-DOPs over slabs, cones and isolated balls.
///
/// A ball's bound along a direction n is `n·c ± r‖n‖`; a primitive's bound is
/// that of its balls, since it is their hull.
#[derive(Clone, Debug)]
pub struct PrimitiveTree {
    tree: Tree,
    centers: Vec<DVec3>,
    radii: Vec<f64>,
}

/// The primitive that is nearest to a point, with its foot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPrimitive {
    /// Number of the primitive.
    pub primitive: u32,
    /// The point's foot on it.
    pub foot: Foot,
}

impl PrimitiveTree {
    /// Builds a tree over the primitives of `medial`.
    ///
    /// # Errors
    ///
    /// [`MedialError::Tree`] when the bounds of a ball exceed what can be
    /// stored.
    pub fn new(medial: &MedialSurface) -> Result<Self, MedialError> {
        let (centers, radii) = split(medial.balls());
        let leaves = Leaves::Triangles(medial.primitives());
        let tree = Tree::build_from(leaves, Extents::Balls { centers: &centers, radii: &radii })?;
        Ok(Self { tree, centers, radii })
    }

    /// Follows balls that moved or changed their radii.
    ///
    /// # Errors
    ///
    /// [`MedialError::Tree`] when `medial` has another number of balls than the
    /// one the tree was built over.
    pub fn refit(&mut self, medial: &MedialSurface) -> Result<(), MedialError> {
        self.centers.clear();
        self.centers.extend(medial.balls().iter().map(|ball| ball.center));
        self.radii.clear();
        self.radii.extend(medial.balls().iter().map(|ball| ball.radius));
        Ok(self.tree.refit_from(Extents::Balls { centers: &self.centers, radii: &self.radii })?)
    }

    /// The tree itself, whose leaves are the primitives by number.
    #[must_use]
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// The primitive with the least signed distance to `p`: the distance of the
    /// union where it is positive. Of equals the one with the lowest number.
    ///
    /// Needs the medial surface the tree was built over or last refitted to,
    /// which has at least one primitive.
    #[must_use]
    pub fn nearest(
        &self,
        medial: &MedialSurface,
        p: DVec3,
        workspace: &mut Workspace,
    ) -> NearestPrimitive {
        self.nearest_from(medial, p, 0, workspace)
    }

    /// As [`Self::nearest`], sooner where `guess` is near the answer, which does
    /// not depend on it.
    pub(crate) fn nearest_from(
        &self,
        medial: &MedialSurface,
        p: DVec3,
        guess: u32,
        workspace: &mut Workspace,
    ) -> NearestPrimitive {
        let foot = medial.foot(p, guess, FootRule::Exact);
        let mut best = NearestPrimitive { primitive: guess, foot };
        // Inside the union all bounds that hold p are at distance 0, and each
        // of them may be the deepest.
        self.tree.nearest(p, best.foot.distance.max(0.0), workspace, |primitive, _| {
            let foot = medial.foot(p, primitive, FootRule::Exact);
            let found = (foot.distance, primitive);
            if found < (best.foot.distance, best.primitive) {
                best = NearestPrimitive { primitive, foot };
            }
            best.foot.distance.max(0.0)
        });
        best
    }

    /// Visits the primitives whose signed distance to `p` is
    /// not more than `limit`.
    pub(crate) fn within(
        &self,
        medial: &MedialSurface,
        p: DVec3,
        limit: f64,
        workspace: &mut Workspace,
        mut visit: impl FnMut(u32),
    ) {
        let around = Dop18::from_points(&[p]).inflated(limit.max(0.0));
        self.tree.query(&around, workspace, |primitive| {
            if medial.foot(p, primitive, FootRule::Exact).distance <= limit {
                visit(primitive);
            }
        });
    }
}

fn split(balls: &[Ball]) -> (Vec<DVec3>, Vec<f64>) {
    balls.iter().map(|ball| (ball.center, ball.radius)).unzip()
}
