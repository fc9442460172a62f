//! Surfaces turned over: the outer sides of bodies whose faces look inward.
//!
//! Overlaps and contacts are those of the body that such faces are around, and not of all space but it.

use glam::DVec3;
use kdop::TreeError;
use proximity::LazySurfaceTree;
use surface::{SurfaceError, TriangleSurface};

/// Surface of a body with all faces turned over, where they look inward, by the same numbers.
#[derive(Clone, Debug)]
pub(crate) struct Outward(Option<LazySurfaceTree>);

impl Outward {
    /// Turns a surface over that is inside out.
    pub(crate) fn of(given: &LazySurfaceTree) -> Result<Self, SurfaceError> {
        if !given.is_inside_out() {
            return Ok(Self(None));
        }
        let positions = given.positions().as_slice().to_vec();
        let faces = given.surface().faces().iter().map(|&[p, q, r]| [p, r, q]).collect();
        let turned = TriangleSurface::new(given.surface().vertex_count(), faces)?;
        LazySurfaceTree::new(turned, positions).map(|turned| Self(Some(turned)))
    }

    /// Returns the surface turned over, or else the given one.
    pub(crate) fn or<'a>(&'a self, given: &'a LazySurfaceTree) -> &'a LazySurfaceTree {
        self.0.as_ref().unwrap_or(given)
    }

    /// Builds or refits both trees where they are not up to date; returns false where `keep_going` ends that.
    pub(crate) fn fit_while(
        &mut self,
        given: &mut LazySurfaceTree,
        keep_going: &dyn Fn() -> bool,
    ) -> Result<bool, TreeError> {
        let is_fitted = given.fit_while(keep_going)?;
        match &mut self.0 {
            Some(turned) if is_fitted => turned.fit_while(keep_going),
            _ => Ok(is_fitted),
        }
    }

    /// Moves the vertices of both.
    pub(crate) fn set_positions(
        &mut self,
        given: &mut LazySurfaceTree,
        positions: impl Iterator<Item = DVec3> + Clone,
    ) -> Result<(), SurfaceError> {
        if let Some(turned) = &mut self.0 {
            turned.set_positions(positions.clone())?;
        }
        given.set_positions(positions)
    }
}
