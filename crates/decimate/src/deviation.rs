//! How far two surfaces are from each other, both ways, with certified bounds.

use kdop::Workspace;
use surface::{DirectedHausdorff, Positions, TriangleSurface};

use crate::DecimateError;
use crate::one_sided::{Aim, largest};
use crate::triangles::{Target, Triangles};

/// The two-sided Hausdorff distance of a surface and a coarser one, in the caller's
/// length unit. Each bound is within a twentieth of what was seen or 1e-5 of the
/// surface's size, unless the work for that exceeds its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Deviation {
    /// How far points of the full surface are from the reduced one.
    pub full_to_reduced: DirectedHausdorff,
    /// How far points of the reduced surface are from the full one.
    pub reduced_to_full: DirectedHausdorff,
}

impl Deviation {
    /// The larger of the two bounds: each point of either surface is at most this
    /// far from the other.
    #[must_use]
    pub const fn largest(&self) -> f64 {
        self.full_to_reduced.upper.max(self.reduced_to_full.upper)
    }

    /// That of a surface from itself.
    pub(crate) const NONE: Self = {
        let none = DirectedHausdorff { lower: 0.0, upper: 0.0 };
        Self { full_to_reduced: none, reduced_to_full: none }
    };
}

/// Slack of a bound relative to the size of what it is measured on, for deviations
/// that are hardly there: a micrometre on a muscle.
pub(crate) const MIN_SLACK: f64 = 1e-5;

/// Splits before a measurement ends anyway: half a second of work.
pub(crate) const MAX_SPLITS: usize = 20_000;

/// Measures a surface against another: a reduced one at the positions that it has
/// gathered after a deformation, for instance.
///
/// ```
/// use surface::{TriangleSurface, glam::DVec3};
///
/// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let tetrahedron = TriangleSurface::new(4, faces)?;
/// let low = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let high = [DVec3::ZERO, DVec3::X, DVec3::Y, 1.5 * DVec3::Z];
/// let (low, high) = (tetrahedron.positions(&low)?, tetrahedron.positions(&high)?);
///
/// let deviation = decimate::deviation(&tetrahedron, low, &tetrahedron, high)?;
/// assert_eq!(deviation.reduced_to_full.lower, 0.5);
/// assert!(deviation.full_to_reduced.upper < 0.3 && deviation.largest() < 0.53);
/// # Ok::<(), decimate::DecimateError>(())
/// ```
///
/// # Errors
///
/// [`DecimateError::TooSmall`] for a surface without faces, and [`DecimateError::Tree`]
/// where bounds cannot be stored.
pub fn deviation(
    full: &TriangleSurface,
    x_full: Positions<'_>,
    reduced: &TriangleSurface,
    x_reduced: Positions<'_>,
) -> Result<Deviation, DecimateError> {
    let full = Triangles { surface: full, x: x_full.as_slice() };
    let reduced = Triangles { surface: reduced, x: x_reduced.as_slice() };
    if full.faces().is_empty() || reduced.faces().is_empty() {
        return Err(DecimateError::TooSmall { faces: 0 });
    }
    let slack = MIN_SLACK * full.size();
    let aim = Aim { slack, at_most: f64::INFINITY, splits: MAX_SPLITS };
    Ok(Deviation {
        full_to_reduced: without_hints(&full, &reduced, aim)?,
        reduced_to_full: without_hints(&reduced, &full, aim)?,
    })
}

fn without_hints(
    from: &Triangles<'_>,
    to: &Triangles<'_>,
    aim: Aim,
) -> Result<DirectedHausdorff, DecimateError> {
    let (tree, across) = (to.tree()?, to.across());
    let target = Target { triangles: *to, tree: &tree, across: &across };
    let (mut workspace, mut guess) = (Workspace::default(), 0);
    let mut nearest = |p| {
        // Vertices next to each other in the list mostly are so on the surface.
        guess = target.nearest(p, guess, &mut workspace).0;
        guess
    };
    let near: Vec<u32> = from.x.iter().map(|p| nearest(*p)).collect();
    Ok(largest(from, &target, |face| from.faces()[face].map(|v| near[v as usize]), aim))
}
