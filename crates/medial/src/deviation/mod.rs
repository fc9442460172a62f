//! Deviation of a medial surface from a closed surface: directed Hausdorff distances in both
//! directions, by branch and bound.
//!
//! The piece with the largest bound is split until the bound on the rest is hardly above the
//! largest distance that was evaluated.

mod medial_to_surface;
mod surface_to_medial;

use kdop::Workspace;
use proximity::MaximumSearch;
use surface::progress::{Interrupted, Progress};
use surface::{DirectedHausdorff, Positions, TriangleSurface, triangle};

use self::medial_to_surface::medial_to_surface;
pub(crate) use self::surface_to_medial::BoundSearch;
use self::surface_to_medial::surface_to_medial;
use crate::batches::map_in_batches;
use crate::surface_distance::SurfaceDistance;
use crate::{MedialError, MedialSurface, NearestPrimitive, PreparedSlabs, PrimitiveTree};

/// Excess of a bound over the largest evaluated distance at which splitting ends, relative to the
/// size of the medial surface: a micrometer on a muscle.
///
/// Below, deviations of nearly 0 take long; above, they are known less well.
const MIN_SLACK: f64 = 1e-5;

/// Number of pieces at which splitting ends: seconds of work.
const MAX_PIECES: usize = 400_000;

/// Number of splits between two polls of the progress handler: some milliseconds.
const SPLITS_PER_POLL: usize = 64;

/// Number of vertices per batch of nearest primitives: about a millisecond.
const VERTICES_PER_BATCH: usize = 128;

/// Deviation of a medial surface from the closed surface that it approximates, in the caller's
/// length unit.
///
/// Each upper bound is within 5 % of the lower one, unless the work for that exceeds its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Deviation {
    /// Distance of points of the surface outside the union of balls.
    pub surface_to_medial: DirectedHausdorff,
    /// Distance by which balls extend outside the surface.
    pub medial_to_surface: DirectedHausdorff,
    /// Root mean square of the union's signed distance over the surface, at its vertices weighted by
    /// their areas.
    pub rms: f64,
    /// Magnitude of that distance which 95 % of the vertices do not exceed.
    pub p95: f64,
}

impl Deviation {
    /// Measures `medial` against a closed, manifold, oriented surface.
    ///
    /// # Errors
    ///
    /// [`MedialError::Surface`] for a surface without an inside, and [`MedialError::Tree`] where its
    /// bounds cannot be stored.
    pub fn measure(
        medial: &MedialSurface,
        surface: &TriangleSurface,
        x: Positions<'_>,
    ) -> Result<Self, MedialError> {
        surface.require_closed()?;
        surface.require_manifold()?;
        surface.require_oriented()?;
        Self::from_surface(medial, &SurfaceDistance::new(surface, x)?, Progress::none())
    }

    /// Measures `medial` against a surface that has been checked.
    pub(crate) fn from_surface(
        medial: &MedialSurface,
        distance: &SurfaceDistance<'_>,
        progress: Progress<'_>,
    ) -> Result<Self, MedialError> {
        // The nearest primitive of each vertex, from that of the previous one, which mostly is next
        // to it on the surface.
        let (tree, slabs) = (PrimitiveTree::new(medial)?, PreparedSlabs::new(medial));
        let x = distance.x.as_slice();
        let nearest = map_in_batches(
            x.len(),
            VERTICES_PER_BATCH,
            progress.part(0.0, 0.2),
            || (0, Workspace::default()),
            |(guess, workspace), vertex| {
                let found = tree.nearest_from(&slabs, x[vertex], *guess, workspace);
                *guess = found.primitive;
                found
            },
        )?;

        let (outward, inward) = (progress.part(0.2, 0.2), progress.part(0.6, 0.6));
        Ok(Self {
            surface_to_medial: surface_to_medial(medial, &tree, distance, &nearest, outward)?,
            medial_to_surface: medial_to_surface(medial, distance, inward)?,
            rms: root_mean_square(distance, &nearest),
            p95: percentile_95(&nearest),
        })
    }

    /// Returns the larger of the two upper bounds.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.surface_to_medial.upper.max(self.medial_to_surface.upper)
    }
}

/// Starts a search for the largest distance on a medial surface.
fn search<T>(medial: &MedialSurface) -> MaximumSearch<T> {
    MaximumSearch::new(MIN_SLACK * medial.bounds().diagonal(), f64::INFINITY)
}

/// Splits pieces until the bounds are tight.
fn split_all<T>(
    search: &mut MaximumSearch<T>,
    max_pieces: usize,
    progress: Progress<'_>,
    mut split: impl FnMut(&mut MaximumSearch<T>, T),
) -> Result<DirectedHausdorff, Interrupted> {
    let mut splits = 0_usize;
    while search.added() < max_pieces
        && let Some((_, piece)) = search.next()
    {
        if splits.is_multiple_of(SPLITS_PER_POLL) {
            progress.report(0.0)?;
        }
        splits += 1;
        split(search, piece);
    }

    // Pieces that are left out are bounded by what was sufficient then, which only grows.
    let upper = search.remaining().max(search.sufficient());
    Ok(DirectedHausdorff { lower: search.lower(), upper })
}

/// Computes the root mean square of distances, weighted by the areas of the vertices.
fn root_mean_square(distance: &SurfaceDistance<'_>, nearest: &[NearestPrimitive]) -> f64 {
    // Six times the area of each vertex: the factor cancels.
    let mut areas = vec![0.0; nearest.len()];
    for (face, corners) in (0_u32..).zip(distance.surface.faces()) {
        let double_area = triangle::normal(distance.corners(face)).length();
        for &corner in corners {
            areas[corner as usize] += double_area;
        }
    }

    let mut squares = 0.0;
    for (area, NearestPrimitive { foot, .. }) in areas.iter().zip(nearest) {
        squares += area * foot.distance * foot.distance;
    }
    (squares / areas.iter().sum::<f64>()).sqrt()
}

/// Returns the magnitude of the distance that 95 % of the vertices do not exceed.
fn percentile_95(nearest: &[NearestPrimitive]) -> f64 {
    let mut sizes: Vec<f64> = nearest.iter().map(|nearest| nearest.foot.distance.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() * 95 / 100).copied().unwrap_or(0.0)
}
