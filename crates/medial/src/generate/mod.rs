//! A medial surface from a closed surface: shrink, collapse, refit.
//!
//! 1. [Shrink](shrink): the maximal ball at each vertex, by closest points.
//! 2. [Collapse](collapse): balls merge, the cheapest pair first, along edges
//!    and across the sheet; the surface's triangles become slabs and cones.
//! 3. [Refit](refit): the balls that are left, still too many, move until the union
//!    fits the surface best from both sides; those that are [missed the least](thin)
//!    by the surface itself go, a few at a time, and the others are fitted again. Of
//!    more than two hundred, [neighbors move](replacement) into their places, and some
//!    are added [where the surface is missed](split) in exchange for others.
//!
//! No Delaunay triangulation is needed: every triangle of the surface lies in
//! the hull of its corners' balls, so the surface is covered before the first
//! merge and its connectivity is that of the sheet.

mod collapse;
mod inscribed;
mod normal_equations;
mod quadric;
mod refit;
mod replacement;
mod seeds;
mod shrink;
mod split;
mod thin;
mod tracking;

use std::cell::OnceCell;
use std::cmp::Reverse;

use surface::{Inspection, Positions, TriangleSurface, inspect};

use self::collapse::Collapse;
pub(crate) use self::quadric::{outer, solve};
use self::refit::RefitParams;
use self::seeds::Seeds;
use self::shrink::MaximalBall;
use crate::surface_distance::SurfaceDistance;
use crate::{Deviation, MedialError, MedialSurface};

/// How large a medial surface is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum MedialSize {
    /// So many balls. There may be more where no two are left that could merge. More than
    /// 200 are fitted with more care, which takes several times as long.
    Balls(usize),
    /// As few balls as bring both bounds of the deviation within this length,
    /// found by doubling and halving: within a tenth of the least number.
    Tolerance(f64),
}

/// How a medial surface is generated.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MedialParams {
    /// How large it is.
    pub size: MedialSize,
    /// Steps of the last fit at most, once as few balls are left as asked for; each
    /// costs as much as the others.
    pub fit_steps: u32,
    /// What balls that reach out of the surface count for in the fit beside
    /// samples of the surface, `>= 0`.
    ///
    /// Without it (0) a slab may leave the shape by many times the error that
    /// the surface's samples see; at 1 the fit shrinks away from the surface to
    /// avoid the least excess. Of more than two hundred balls, those count for less.
    pub inscribed_weight: f64,
}

impl MedialParams {
    /// A fit that has settled, for this many balls.
    #[must_use]
    pub const fn balls(count: usize) -> Self {
        Self { size: MedialSize::Balls(count), fit_steps: 15, inscribed_weight: 0.2 }
    }

    /// A fit that has settled, for as many balls as this tolerance needs.
    #[must_use]
    pub const fn tolerance(tolerance: f64) -> Self {
        Self { size: MedialSize::Tolerance(tolerance), ..Self::balls(1) }
    }
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Looking the surface over.
    Inspect,
    /// Finding maximal balls.
    Shrink,
    /// Merging them.
    Collapse,
    /// Fitting what is left.
    Fit,
    /// Bounding the deviation.
    Measure,
}

/// How far the work has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The step at hand.
    pub step: Step,
    /// Balls that the medial surface at hand will have.
    pub balls: usize,
    /// Share of the step that is done, in `0.0..=1.0`.
    pub share: f64,
}

/// A medial surface and how far it is from the surface it was made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Generated {
    /// The medial surface.
    pub medial: MedialSurface,
    /// Its deviation from the surface, in both directions.
    pub deviation: Deviation,
}

/// Generates a medial surface of a closed surface at rest.
///
/// The surface may have handles, and its vertices may carry noise well below its
/// thickness. The result is the same to the bit for any number of threads.
///
/// ```
/// use medial::{MedialParams, generate};
///
/// let muscle = fixtures::shapes::ellipsoid(surface::glam::DVec3::new(60.0, 20.0, 10.0), 4);
/// let surface = muscle.surface();
/// let x = surface.positions(&muscle.positions)?;
/// let generated = generate(&surface, x, &MedialParams::balls(20), |_| {})?;
/// assert_eq!(generated.medial.balls().len(), 20);
/// assert!(generated.deviation.rms < 0.3, "of 20 balls on 120 × 40 × 20");
/// # Ok::<(), medial::MedialError>(())
/// ```
///
/// # Errors
///
/// - [`MedialError::Surface`] for a surface that is open, not manifold or not
///   oriented.
/// - [`MedialError::Disconnected`], [`MedialError::InsideOut`],
///   [`MedialError::SelfCrossing`], [`MedialError::TooThin`] for one that has no
///   one sheet inside.
/// - [`MedialError::TooManyBalls`] and [`MedialError::Parameter`] for what was
///   asked.
/// - [`MedialError::ToleranceNotReached`] when a ball at every eighth vertex is
///   not enough.
pub fn generate(
    surface: &TriangleSurface,
    x: Positions<'_>,
    params: &MedialParams,
    mut progress: impl FnMut(Progress),
) -> Result<Generated, MedialError> {
    check_params(surface, params)?;
    progress(Progress { step: Step::Inspect, balls: 0, share: 0.0 });
    let inspection = check_surface(surface, x)?;
    let distance = SurfaceDistance::new(surface, x)?;
    distance.check_crossings()?;
    let generator = Generator::new(&distance, &inspection, params);
    match params.size {
        MedialSize::Balls(count) => generator.with_balls(count, &mut progress),
        MedialSize::Tolerance(tolerance) => generator.within(tolerance, &mut progress),
    }
}

/// As [`generate`] for several numbers of balls, in their order: what they have in
/// common is done once. The size of `params` is not looked at.
///
/// Where some of the numbers are so small that balls at few of the vertices would do
/// for them alone, they start from the same balls as the largest number here, and
/// their result may be another one.
///
/// ```
/// use medial::{MedialParams, generate_each};
///
/// let muscle = fixtures::shapes::ellipsoid(surface::glam::DVec3::new(60.0, 20.0, 10.0), 4);
/// let surface = muscle.surface();
/// let x = surface.positions(&muscle.positions)?;
/// let made = generate_each(&surface, x, &[10, 20, 40], &MedialParams::balls(1), |_| {})?;
/// assert!(made[0].deviation.rms > 2.0 * made[2].deviation.rms);
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
    mut progress: impl FnMut(Progress),
) -> Result<Vec<Generated>, MedialError> {
    for &count in balls {
        check_params(surface, &MedialParams { size: MedialSize::Balls(count), ..*params })?;
    }
    progress(Progress { step: Step::Inspect, balls: 0, share: 0.0 });
    let inspection = check_surface(surface, x)?;
    let distance = SurfaceDistance::new(surface, x)?;
    distance.check_crossings()?;
    let generator = Generator::new(&distance, &inspection, params);
    generator.with_each(balls, &mut progress)
}

/// Vertices a ball below which all of them start with a ball.
const DENSE: usize = 80;

/// Share of the vertices that a tolerance may take as balls: beyond it the
/// balls follow the vertices' noise.
const MAX_BALLS: usize = 8;

/// Thickness of a sheet, in mean edges, below which it is refused. At half an
/// edge the balls of neighbors still overlap into a sheet; at a tenth they are
/// beads, and which vertex faces which is chance.
const THINNEST: f64 = 0.5;

/// Balls that the search for a tolerance starts from.
const FEWEST_BALLS: usize = 8;

fn check_params(surface: &TriangleSurface, params: &MedialParams) -> Result<(), MedialError> {
    let vertices = surface.vertex_count();
    match params.size {
        MedialSize::Balls(asked) if asked > vertices => {
            return Err(MedialError::TooManyBalls { asked, vertices });
        }
        MedialSize::Balls(0) => {
            return Err(MedialError::Parameter { name: "size", value: 0.0, range: "at least 1" });
        }
        MedialSize::Tolerance(value) if !value.is_finite() || value <= 0.0 => {
            let range = "positive and finite";
            return Err(MedialError::Parameter { name: "tolerance", value, range });
        }
        MedialSize::Balls(_) | MedialSize::Tolerance(_) => {}
    }
    let value = params.inscribed_weight;
    if !value.is_finite() || value < 0.0 {
        let range = "at least 0 and finite";
        return Err(MedialError::Parameter { name: "inscribed weight", value, range });
    }
    Ok(())
}

fn check_surface(surface: &TriangleSurface, x: Positions<'_>) -> Result<Inspection, MedialError> {
    surface.require_closed()?;
    surface.require_manifold()?;
    surface.require_oriented()?;
    let inspection = inspect(surface, x);
    if inspection.components != 1 {
        return Err(MedialError::Disconnected { components: inspection.components });
    }
    if inspection.volume <= 0.0 {
        return Err(MedialError::InsideOut { volume: inspection.volume });
    }
    Ok(inspection)
}

/// One surface, checked, from which medial surfaces of several sizes are made.
struct Generator<'a> {
    distance: &'a SurfaceDistance<'a>,
    inspection: &'a Inspection,
    params: &'a MedialParams,
    sparse: OnceCell<Start>,
    dense: OnceCell<Start>,
}

/// The balls that merge first, with the vertices that they are at.
#[derive(Clone)]
struct Start {
    seeds: Seeds,
    maximal: Vec<MaximalBall>,
}

impl<'a> Generator<'a> {
    const fn new(
        distance: &'a SurfaceDistance<'a>,
        inspection: &'a Inspection,
        params: &'a MedialParams,
    ) -> Self {
        Self { distance, inspection, params, sparse: OnceCell::new(), dense: OnceCell::new() }
    }

    fn with_balls(
        &self,
        count: usize,
        progress: &mut impl FnMut(Progress),
    ) -> Result<Generated, MedialError> {
        let mut collapse = self.collapse(count, progress)?;
        self.fitted(&mut collapse, count, progress)
    }

    /// Of one collapse, in the order of `counts`.
    fn with_each(
        &self,
        counts: &[usize],
        progress: &mut impl FnMut(Progress),
    ) -> Result<Vec<Generated>, MedialError> {
        let mut order: Vec<usize> = (0..counts.len()).collect();
        order.sort_by_key(|&k| Reverse(counts[k]));
        let Some(&first) = order.first() else { return Ok(Vec::new()) };
        let mut collapse = self.collapse(counts[first], progress)?;
        let mut made = Vec::with_capacity(counts.len());
        for &k in &order {
            made.push((k, self.fitted(&mut collapse, counts[k], progress)?));
        }
        made.sort_by_key(|&(k, _)| k);
        Ok(made.into_iter().map(|(_, made)| made).collect())
    }

    /// Balls that are about to merge, for medial surfaces of up to `count`.
    fn collapse(
        &self,
        count: usize,
        progress: &mut impl FnMut(Progress),
    ) -> Result<Collapse<'a>, MedialError> {
        progress(Progress { step: Step::Shrink, balls: count, share: 0.0 });
        let start = self.start(count);
        self.check_thickness(&start.maximal)?;
        Ok(Collapse::new(self.distance, &start.seeds, &start.maximal))
    }

    fn start(&self, count: usize) -> &Start {
        let distance = self.distance;
        let sparse = self.sparse.get_or_init(|| {
            let seeds = Seeds::sparse(distance.surface, distance.x);
            Start { maximal: shrink::maximal_balls(distance, &seeds), seeds }
        });
        if distance.surface.vertex_count() > DENSE * refit::balls_at_first(distance, count) {
            return sparse;
        }
        self.dense.get_or_init(|| Start {
            maximal: shrink::maximal_balls_between(distance, &sparse.seeds, &sparse.maximal),
            seeds: Seeds::all(distance.surface),
        })
    }

    /// Merges balls until `count` are left, and fits those.
    fn fitted(
        &self,
        collapse: &mut Collapse<'_>,
        count: usize,
        progress: &mut impl FnMut(Progress),
    ) -> Result<Generated, MedialError> {
        let mut at = |step, share| progress(Progress { step, balls: count, share });
        at(Step::Collapse, 0.0);
        collapse.run(refit::balls_at_first(self.distance, count));
        let mut medial = collapse.medial_surface()?;
        let params = RefitParams {
            balls: count,
            steps: self.params.fit_steps,
            inscribed_weight: self.params.inscribed_weight,
        };
        refit::refit(&mut medial, self.distance, params, |share| at(Step::Fit, share))?;
        at(Step::Measure, 0.0);
        let deviation = Deviation::of(&medial, self.distance)?;
        Ok(Generated { medial, deviation })
    }

    /// Doubles the balls until the tolerance is met, then halves the gap
    /// between what met it and what did not.
    fn within(
        &self,
        tolerance: f64,
        progress: &mut impl FnMut(Progress),
    ) -> Result<Generated, MedialError> {
        let most = (self.distance.surface.vertex_count() / MAX_BALLS).max(FEWEST_BALLS);
        let (mut low, mut high) = (0, FEWEST_BALLS);
        let mut best = self.with_balls(high, progress)?;
        while best.deviation.largest() > tolerance {
            if high >= most {
                let reached = best.deviation.largest();
                return Err(MedialError::ToleranceNotReached { tolerance, reached, balls: high });
            }
            (low, high) = (high, (2 * high).min(most));
            best = self.with_balls(high, progress)?;
        }
        while low > 0 && high - low > (high / 10).max(1) {
            let middle = low.midpoint(high);
            let found = self.with_balls(middle, progress)?;
            if found.deviation.largest() > tolerance {
                low = middle;
            } else {
                (high, best) = (middle, found);
            }
        }
        Ok(best)
    }

    /// Where the balls are much smaller than the faces, the vertices do not show
    /// where the other side of the sheet is.
    fn check_thickness(&self, maximal: &[MaximalBall]) -> Result<(), MedialError> {
        let mut radii: Vec<f64> = maximal.iter().map(|m| m.ball.radius).collect();
        radii.sort_by(f64::total_cmp);
        let thickness = 2.0 * radii[radii.len() / 2];
        let edge = self.inspection.mean_edge;
        if thickness < THINNEST * edge {
            Err(MedialError::TooThin { thickness, edge })
        } else {
            Ok(())
        }
    }
}
