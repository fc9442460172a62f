//! How far a medial surface and a closed surface are from each other, bounded
//! in both directions.
//!
//! Each bound is found by branch and bound: what may be largest is split until
//! the bound on the rest is hardly above what has been seen.

mod largest;
mod medial_to_surface;
mod surface_to_medial;

use kdop::Workspace;
use surface::{DirectedHausdorff, Positions, TriangleSurface};

use self::medial_to_surface::medial_to_surface;
use self::surface_to_medial::surface_to_medial;
use crate::surface_distance::SurfaceDistance;
use crate::{MedialError, MedialSurface, NearestPrimitive, PrimitiveTree, parallel};

/// How far a medial surface is from the closed surface it stands for, in the
/// caller's length unit. Each bound is within a twentieth of what was seen, unless
/// the work for that exceeds its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Deviation {
    /// How far points of the surface are outside the union of balls.
    pub surface_to_medial: DirectedHausdorff,
    /// How far balls reach out of the surface.
    pub medial_to_surface: DirectedHausdorff,
    /// Root of the mean square of the union's signed distance over the surface,
    /// at its vertices by their areas.
    pub rms: f64,
    /// The size of that distance which 95 % of the vertices do not exceed.
    pub p95: f64,
}

impl Deviation {
    /// Measures `medial` against a closed, manifold, oriented surface.
    ///
    /// # Errors
    ///
    /// [`MedialError::Surface`] for a surface without inside, and
    /// [`MedialError::Tree`] where its bounds cannot be stored.
    pub fn measure(
        medial: &MedialSurface,
        surface: &TriangleSurface,
        x: Positions<'_>,
    ) -> Result<Self, MedialError> {
        surface.require_closed()?;
        surface.require_manifold()?;
        surface.require_oriented()?;
        Self::of(medial, &SurfaceDistance::new(surface, x)?)
    }

    pub(crate) fn of(
        medial: &MedialSurface,
        distance: &SurfaceDistance<'_>,
    ) -> Result<Self, MedialError> {
        let tree = PrimitiveTree::new(medial)?;
        let x = distance.x.as_slice();
        // Vertices next to each other in the list mostly are so on the surface.
        let start = || (0, Workspace::default());
        let nearest = parallel::map(x.len(), start, |(guess, workspace), vertex| {
            let found = tree.nearest_from(medial, x[vertex], *guess, workspace);
            *guess = found.primitive;
            found
        });
        let (rms, p95) = statistics(distance, &nearest);
        Ok(Self {
            surface_to_medial: surface_to_medial(medial, &tree, distance, &nearest),
            medial_to_surface: medial_to_surface(medial, distance),
            rms,
            p95,
        })
    }

    /// The larger of the two bounds.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.surface_to_medial.upper.max(self.medial_to_surface.upper)
    }
}

fn statistics(distance: &SurfaceDistance<'_>, nearest: &[NearestPrimitive]) -> (f64, f64) {
    let mut area = vec![0.0; nearest.len()];
    for (face, corners) in (0_u32..).zip(distance.surface.faces()) {
        let [a, b, c] = distance.corners(face);
        for &corner in corners {
            area[corner as usize] += (b - a).cross(c - a).length();
        }
    }
    let values = nearest.iter().map(|n| n.foot.distance);
    let squares: f64 = values.clone().zip(&area).map(|(value, area)| area * value * value).sum();
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    let p95 = sizes.get(sizes.len() * 95 / 100).copied().unwrap_or(0.0);
    ((squares / area.iter().sum::<f64>()).sqrt(), p95)
}
