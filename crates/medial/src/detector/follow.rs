//! Balls of a detector that follow its body.

use surface::{Positions, SurfaceError, TriangleSurface};

use super::{MedialDetector, MedialScratch, SurfaceBound};
use crate::{Deviation, MedialError};

impl MedialDetector {
    /// Moves the balls to where the body is now.
    ///
    /// The work is linear in the vertices; nothing is done where the body has not moved.
    ///
    /// # Errors
    ///
    /// [`MedialError::Surface`] when `x` is of another body, and [`MedialError::InvalidBall`] when
    /// positions are so large that a center is not finite.
    pub fn follow(&mut self, x: Positions<'_>) -> Result<(), MedialError> {
        let (expected, got) = (self.fitted_positions.len(), x.as_slice().len());
        if expected != got {
            return Err(SurfaceError::PositionCount { expected, got }.into());
        }
        if x.as_slice() == self.fitted_positions {
            return Ok(());
        }

        self.bound = None;
        self.links.follow_in(&mut self.medial, x, &mut self.scratch)?;
        self.tree.refit(&self.medial)?;
        self.fitted_positions.copy_from_slice(x.as_slice());
        Ok(())
    }

    /// Follows the body and measures the deviation there.
    ///
    /// That takes far longer than following: it is a search over the whole surface.
    ///
    /// # Errors
    ///
    /// The errors of [`follow`](Self::follow) and of [`Deviation::measure`].
    pub fn measure(
        &mut self,
        surface: &TriangleSurface,
        x: Positions<'_>,
    ) -> Result<&Deviation, MedialError> {
        self.follow(x)?;
        self.deviation = Deviation::measure(&self.medial, surface, x)?;
        Ok(&self.deviation)
    }

    /// Bounds the distance of the body's surface outside the balls, where it last followed: proved,
    /// and tight enough to decide whether it exceeds `limit`, in work linear in the faces.
    ///
    /// It is computed once where the body rests.
    ///
    /// # Errors
    ///
    /// [`MedialError::Surface`] when `surface` is not the body's.
    pub fn surface_bound(
        &mut self,
        surface: &TriangleSurface,
        limit: f64,
        scratch: &mut MedialScratch,
    ) -> Result<f64, MedialError> {
        let known = self.bound.filter(|known| known.limit.to_bits() == limit.to_bits());
        if let Some(known) = known {
            return Ok(known.bound);
        }
        let x = surface.positions(&self.fitted_positions)?;
        let links = self.links.links();
        let guess = |vertex: u32| links[vertex as usize].primitive;
        let search = &mut scratch.bound;
        let bound = search.surface_bound(&self.medial, &self.tree, surface, x, guess, limit);
        self.bound = Some(SurfaceBound { bound, limit });
        Ok(bound)
    }
}
