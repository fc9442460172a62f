//! Two-sided Hausdorff distance of two surfaces, with certified bounds.

use kdop::Workspace;
use proximity::SurfaceTree;
use surface::progress::{Interrupted, Progress};
use surface::{Aabb, DirectedHausdorff, HausdorffBounds};

use crate::DecimateError;
use crate::directed::{Accuracy, directed_distance};
use crate::target::{Target, adjacent_faces};

/// Slack of a bound relative to the size of the full surface, for deviations near zero: a
/// micrometer on a muscle.
///
/// Smaller, and equal surfaces take many splits; larger, and small deviations are
/// overestimated.
const MIN_SLACK: f64 = 1e-5;

/// Splits before a measurement ends: half a second of work.
const MAX_SPLITS: usize = 20_000;

/// Computes certified bounds on the Hausdorff distance between a surface (`forward`) and an
/// approximation of it (`backward`).
///
/// Each upper bound exceeds its lower bound by at most a twentieth or 1e-5 of the surface's
/// size, unless the work for that exceeds a limit.
///
/// ```
/// use proximity::SurfaceTree;
/// use surface::progress::Progress;
/// use surface::{TriangleSurface, glam::DVec3};
///
/// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let tetrahedron = TriangleSurface::new(4, faces)?;
/// let low = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let high = vec![DVec3::ZERO, DVec3::X, DVec3::Y, 1.5 * DVec3::Z];
/// let low = SurfaceTree::new(tetrahedron.clone(), low)?;
/// let high = SurfaceTree::new(tetrahedron, high)?;
///
/// let bounds = decimate::hausdorff_bounds(&low, &high, Progress::none())?;
/// assert_eq!(bounds.backward.lower, 0.5);
/// assert!(bounds.forward.upper < 0.3 && bounds.upper() < 0.53);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`DecimateError::TooSmall`] for a surface without faces, and
/// [`DecimateError::Interrupted`] when the progress handler ends the call.
pub fn hausdorff_bounds(
    full: &SurfaceTree,
    reduced: &SurfaceTree,
    progress: Progress<'_>,
) -> Result<HausdorffBounds, DecimateError> {
    if full.surface().faces().is_empty() || reduced.surface().faces().is_empty() {
        return Err(DecimateError::TooSmall { faces: 0 });
    }
    let size = Aabb::of_points(full.positions().as_slice().iter().copied()).diagonal();
    let accuracy = Accuracy { min_slack: MIN_SLACK * size, max_splits: MAX_SPLITS };
    Ok(HausdorffBounds {
        forward: distance(full, reduced, accuracy, progress.part(0.0, 0.5))?,
        backward: distance(reduced, full, accuracy, progress.part(0.5, 1.0))?,
    })
}

/// Bounds a directed distance between any two surfaces.
fn distance(
    from: &SurfaceTree,
    to: &SurfaceTree,
    accuracy: Accuracy,
    progress: Progress<'_>,
) -> Result<DirectedHausdorff, Interrupted> {
    let adjacent = adjacent_faces(to.surface());
    let target = Target { tree: to, adjacent: &adjacent };

    // Consecutive vertices are mostly close to each other: one hints at the next.
    let mut workspace = Workspace::default();
    let mut near = Vec::with_capacity(from.surface().vertex_count());
    for &p in from.positions().as_slice() {
        let hint = near.last().copied().unwrap_or(0);
        near.push(target.nearest(p, hint, &mut workspace).0);
    }
    directed_distance(from, target, &near, accuracy, progress)
}
