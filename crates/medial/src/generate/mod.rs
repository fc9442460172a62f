//! Generation of a medial surface from a closed surface: shrink, collapse, refit.
//!
//! 1. [Shrink](shrink): the maximal ball at each vertex, by closest points.
//! 2. [Collapse](collapse): balls merge, the cheapest pair first, along edges and across the sheet;
//!    the surface's triangles become slabs and cones.
//! 3. [Refit](refit): the balls that are left, still too many, move until the union fits the surface
//!    best from both sides. A few at a time, those are [removed](removal) that increase the error
//!    least, and the others are fitted again. Of more than two hundred,
//!    [neighbors move](replacement) into their places, and some are added where the error is
//!    [largest](split) in exchange for others.
//!
//! No Delaunay triangulation is needed: every triangle of the surface lies in the hull of its
//! corners' balls, so that the surface is covered before the first merge and its connectivity is
//! that of the sheet.

mod collapse;
mod connectivity;
mod fit;
mod generator;
mod inscribed;
mod normal_equations;
mod quadric;
mod refit;
mod removal;
mod replacement;
mod sample_map;
mod samples;
mod seeds;
mod shrink;
mod split;
mod tracking;

use surface::progress::Progress;
use surface::{Defect, Finding, Inspection, Positions, TriangleSurface, inspect};

use self::generator::Generator;
use crate::surface_distance::SurfaceDistance;
use crate::{Deviation, MedialError, MedialSurface};

/// Size of a medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum MedialSize {
    /// Number of balls. There may be more where no two are left that could merge. More than 200 are
    /// fitted with more care, which takes several times as long.
    Balls(usize),
    /// Bound on the deviation in both directions, in the length unit, with as few balls as it
    /// needs: found by doubling and bisection, within a tenth of the smallest number.
    Tolerance(f64),
}

/// Parameters of the generation of a medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MedialParams {
    /// Size of the medial surface.
    pub size: MedialSize,
    /// Maximum number of steps of the last fit, once only the requested balls are left; each takes
    /// as long as the others.
    pub fit_steps: u32,
    /// Weight of balls that extend outside the surface, relative to samples of the surface, `>= 0`.
    ///
    /// At 0 a slab may leave the shape by many times the error at the surface's samples; at 1 the
    /// fit shrinks away from the surface to avoid the least excess. It is reduced for more than two
    /// hundred balls.
    pub inscribed_weight: f64,
}

impl MedialParams {
    /// Returns parameters of a converged fit for this number of balls.
    #[must_use]
    pub const fn balls(count: usize) -> Self {
        Self { size: MedialSize::Balls(count), fit_steps: 15, inscribed_weight: 0.2 }
    }

    /// Returns parameters of a converged fit with as many balls as this tolerance needs.
    #[must_use]
    pub const fn tolerance(tolerance: f64) -> Self {
        Self { size: MedialSize::Tolerance(tolerance), ..Self::balls(1) }
    }

    /// Checks the range of each parameter.
    ///
    /// # Errors
    ///
    /// [`MedialError::Parameter`] with the first one outside its range.
    pub fn validate(&self) -> Result<(), MedialError> {
        let weight = self.inscribed_weight;
        match self.size {
            MedialSize::Balls(0) => {
                let (name, range) = ("number of balls", "at least 1");
                Err(MedialError::Parameter { name, value: 0.0, range })
            }
            MedialSize::Tolerance(value) if !value.is_finite() || value <= 0.0 => {
                let range = "positive and finite";
                Err(MedialError::Parameter { name: "tolerance", value, range })
            }
            _ if !weight.is_finite() || weight < 0.0 => {
                let range = "at least 0 and finite";
                Err(MedialError::Parameter { name: "inscribed weight", value: weight, range })
            }
            _ => Ok(()),
        }
    }
}

/// Medial surface with its deviation from the surface that it was generated from.
#[derive(Clone, Debug, PartialEq)]
pub struct Generated {
    /// The medial surface.
    pub medial: MedialSurface,
    /// Its deviation from the surface, in both directions.
    pub deviation: Deviation,
}

/// Generates a medial surface of a closed surface at rest.
///
/// The surface may have handles, and its vertices may carry noise well below its thickness. The
/// result is the same to the bit for any number of threads.
///
/// ```
/// use medial::{MedialParams, generate};
/// use surface::progress::Progress;
///
/// let muscle = fixtures::shapes::ellipsoid(surface::glam::DVec3::new(60.0, 20.0, 10.0), 4);
/// let surface = muscle.surface();
/// let x = surface.positions(&muscle.positions)?;
/// let generated = generate(&surface, x, &MedialParams::balls(20), Progress::none())?;
/// assert_eq!(generated.medial.balls().len(), 20);
/// assert!(generated.deviation.rms < 0.3, "of 20 balls on 120 × 40 × 20");
/// # Ok::<(), medial::MedialError>(())
/// ```
///
/// # Errors
///
/// - [`MedialError::Surface`] for a surface that is open, not manifold or not oriented.
/// - [`MedialError::Defect`] for vertices without a face and faces that repeat a vertex.
/// - [`MedialError::Disconnected`], [`MedialError::InsideOut`], [`MedialError::SelfCrossing`],
///   [`MedialError::TooThin`] for one that has no single sheet inside.
/// - [`MedialError::TooManyBalls`] and [`MedialError::Parameter`] for the parameters.
/// - [`MedialError::ToleranceNotReached`] when a ball per eight vertices is not sufficient.
/// - [`MedialError::Interrupted`] when the handler ends the call.
pub fn generate(
    surface: &TriangleSurface,
    x: Positions<'_>,
    params: &MedialParams,
    progress: Progress<'_>,
) -> Result<Generated, MedialError> {
    check_params(surface, params)?;
    progress.report(0.0)?;
    let inspection = check_surface(surface, x)?;
    let distance = SurfaceDistance::new(surface, x)?;
    distance.check_crossings(progress)?;

    let generator = Generator::new(&distance, &inspection, params);
    match params.size {
        MedialSize::Balls(count) => generator.with_balls(count, progress),
        MedialSize::Tolerance(tolerance) => generator.within(tolerance, progress),
    }
}

/// Generates medial surfaces as [`generate`] does for several numbers of balls, in their order: the
/// work that they have in common is done once. The size of `params` is ignored.
///
/// Where some of the numbers are so small that balls at few of the vertices would do for them alone,
/// they start from the same balls as the largest number here, and their result may differ.
///
/// ```
/// use medial::{MedialParams, generate_each};
/// use surface::progress::Progress;
///
/// let muscle = fixtures::shapes::ellipsoid(surface::glam::DVec3::new(60.0, 20.0, 10.0), 4);
/// let surface = muscle.surface();
/// let x = surface.positions(&muscle.positions)?;
/// let params = MedialParams::balls(1);
/// let sizes = generate_each(&surface, x, &[10, 20, 40], &params, Progress::none())?;
/// assert!(sizes[0].deviation.rms > 2.0 * sizes[2].deviation.rms);
/// # Ok::<(), medial::MedialError>(())
/// ```
///
/// # Errors
///
/// As [`generate`].
pub fn generate_each(
    surface: &TriangleSurface,
    x: Positions<'_>,
    balls: &[usize],
    params: &MedialParams,
    progress: Progress<'_>,
) -> Result<Vec<Generated>, MedialError> {
    for &count in balls {
        check_params(surface, &MedialParams { size: MedialSize::Balls(count), ..*params })?;
    }
    progress.report(0.0)?;
    let inspection = check_surface(surface, x)?;
    let distance = SurfaceDistance::new(surface, x)?;
    distance.check_crossings(progress)?;
    Generator::new(&distance, &inspection, params).with_each(balls, progress)
}

/// Checks the parameters, also against the surface.
fn check_params(surface: &TriangleSurface, params: &MedialParams) -> Result<(), MedialError> {
    params.validate()?;
    let vertices = surface.vertex_count();
    match params.size {
        MedialSize::Balls(requested) if requested > vertices => {
            Err(MedialError::TooManyBalls { requested, vertices })
        }
        MedialSize::Balls(_) | MedialSize::Tolerance(_) => Ok(()),
    }
}

/// Checks that the surface bounds one volume.
fn check_surface(surface: &TriangleSurface, x: Positions<'_>) -> Result<Inspection, MedialError> {
    surface.require_closed()?;
    surface.require_manifold()?;
    surface.require_oriented()?;

    let inspection = inspect(surface, x);
    let is_loose =
        |it: &&Finding| matches!(it.defect, Defect::IsolatedVertex | Defect::RepeatedCorner);
    if let Some(&finding) = inspection.findings.iter().find(is_loose) {
        return Err(MedialError::Defect(finding));
    }
    if inspection.components != 1 {
        return Err(MedialError::Disconnected { components: inspection.components });
    }
    if inspection.volume <= 0.0 {
        return Err(MedialError::InsideOut { volume: inspection.volume });
    }
    Ok(inspection)
}
