//! Balls of a detector that follow its body.

use surface::{Positions, SurfaceError, TriangleSurface};

use super::MedialDetector;
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
}
