//! Medial surfaces given as 2-simplex surfaces.
//!
//! A medial sheet may be given as a simplex surface with a radius per vertex. Its polygons become
//! slabs about their centers, whose balls are the means of the polygon's; forces on the ball of a
//! center go to the vertices of the polygon in equal shares, as by [`SimplexSurface::spread`].

use glam::DVec3;
use surface::SimplexSurface;

use crate::{Ball, MedialError, MedialSurface};

impl MedialSurface {
    /// Builds the medial surface of a sheet that is given as a simplex surface, with positions `x`
    /// and radii `radii` at its vertices.
    ///
    /// Its balls are those of the vertices, then one per polygon; its slabs are the faces of the
    /// sheet's [fan](SimplexSurface::fan).
    ///
    /// # Errors
    ///
    /// - [`MedialError::Surface`] when positions are missing or not finite.
    /// - [`MedialError::BallCount`] when radii are missing.
    /// - The errors of [`Self::new`].
    pub fn from_sheet(
        sheet: &SimplexSurface,
        x: &[DVec3],
        radii: &[f64],
    ) -> Result<Self, MedialError> {
        let slabs = sheet.fan()?.faces().to_vec();
        Self::new(sheet_balls(sheet, x, radii)?, Vec::new(), slabs)
    }

    /// Moves and resizes the balls of a medial surface made by [`Self::from_sheet`].
    ///
    /// # Errors
    ///
    /// As [`Self::from_sheet`]; nothing is changed then.
    pub fn set_sheet(
        &mut self,
        sheet: &SimplexSurface,
        x: &[DVec3],
        radii: &[f64],
    ) -> Result<(), MedialError> {
        self.set_balls(&sheet_balls(sheet, x, radii)?)
    }
}

/// Returns the balls of a sheet: those of the vertices, then those of the polygons.
fn sheet_balls(
    sheet: &SimplexSurface,
    x: &[DVec3],
    radii: &[f64],
) -> Result<Vec<Ball>, MedialError> {
    let positions = sheet.positions(x)?;
    if radii.len() != sheet.vertex_count() {
        return Err(MedialError::BallCount { expected: sheet.vertex_count(), got: radii.len() });
    }

    // The ball of a polygon has the mean center and the mean radius.
    let mut centers = Vec::new();
    sheet.fan_positions(positions, &mut centers);
    let mut radii = radii.to_vec();
    for polygon in 0..crate::index(sheet.polygon_count()) {
        let vertices = sheet.polygon(polygon);
        let sum: f64 = vertices.iter().map(|&vertex| radii[vertex as usize]).sum();
        radii.push(sum / crate::real(vertices.len()));
    }
    Ok(centers.into_iter().zip(radii).map(|(center, radius)| Ball::new(center, radius)).collect())
}
