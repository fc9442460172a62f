//! Medial surfaces carried by 2-simplex surfaces.
//!
//! A medial sheet may be given as a simplex surface with a radius at each
//! vertex. Its polygons become slabs about their centers, whose balls are the
//! means of the polygon's; what acts on a center's ball goes to the polygon's
//! vertices in equal shares, as [`SimplexSurface::spread`] does.

use glam::DVec3;
use surface::SimplexSurface;

use crate::{Ball, MedialError, MedialSurface};

impl MedialSurface {
    /// The medial surface of a sheet given as a simplex surface, with positions
    /// `x` and radii `radii` at its vertices.
    ///
    /// Its balls are the vertices', then one a polygon; its slabs are the faces
    /// of the sheet's [fan](SimplexSurface::fan).
    ///
    /// # Errors
    ///
    /// - [`MedialError::Surface`] when positions are missing or not finite.
    /// - [`MedialError::BallCount`] when radii are missing.
    /// - What [`Self::new`] refuses.
    pub fn from_sheet(
        sheet: &SimplexSurface,
        x: &[DVec3],
        radii: &[f64],
    ) -> Result<Self, MedialError> {
        let slabs = sheet.fan()?.faces().to_vec();
        Self::new(sheet_balls(sheet, x, radii)?, Vec::new(), slabs)
    }

    /// Moves and resizes the balls of a medial surface made by
    /// [`Self::from_sheet`].
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

fn sheet_balls(
    sheet: &SimplexSurface,
    x: &[DVec3],
    radii: &[f64],
) -> Result<Vec<Ball>, MedialError> {
    let positions = sheet.positions(x)?;
    if radii.len() != sheet.vertex_count() {
        return Err(MedialError::BallCount { expected: sheet.vertex_count(), got: radii.len() });
    }
    let mut centers = Vec::new();
    sheet.fan_positions(positions, &mut centers);
    let polygon_radius = |polygon: u32| {
        let vertices = sheet.polygon(polygon);
        let sum: f64 = vertices.iter().map(|&vertex| radii[vertex as usize]).sum();
        sum / crate::real(vertices.len())
    };
    let polygons = 0..crate::index(sheet.polygon_count());
    let radii = radii.iter().copied().chain(polygons.map(polygon_radius));
    Ok(centers.into_iter().zip(radii).map(|(center, radius)| Ball::new(center, radius)).collect())
}
