//! Medial surfaces that follow the surface they were generated from.
//!
//! Each vertex of the surface is linked to its foot on the medial surface at rest: a primitive, the
//! weights there, and the side of the sheet. Each ball is carried by the vertices linked to it: its
//! center is an affine combination of them, exact under every affine motion of the surface. Then
//! center and radius are refitted so that the union passes through the vertices again. Where these
//! are too few, or too close to a plane, to define the center, those of neighboring balls help.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal system using
//! MRI*, PhD thesis, 2007: radii as means of the distances of the linked surface points, by their
//! weights. Here the error left at the exact foot is used, so that passes converge; the centers are
//! combinations of the same points; and least squares of the errors of a ball move its center too,
//! which a mean cannot: the error of a shortened muscle is a quarter smaller.

mod carriers;
mod refit;

use glam::DVec3;
use kdop::Workspace;
use surface::{Positions, SurfaceError, Term, TriangleSurface, parallel, triangle};

use self::carriers::find_carriers;
use self::refit::BallFit;
use crate::{Ball, MedialError, MedialSurface, PrimitiveTree};

/// Link of a surface vertex to the medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Link {
    /// Number of the primitive.
    pub primitive: u32,
    /// Weights of its balls at the foot of the vertex at rest.
    pub weights: [f64; 3],
    /// Side of the slab that the vertex is on: 1 where the normal of the centers, counter-clockwise,
    /// points to it, else −1; 0 for a cone or a ball, which have no sides.
    pub side: i8,
}

/// Links between a medial surface and the surface that carries it.
///
/// ```
/// use medial::{Links, MedialParams, generate};
/// use surface::glam::DVec3;
/// use surface::progress::Progress;
///
/// let rest = fixtures::shapes::ellipsoid(DVec3::new(60.0, 20.0, 10.0), 3);
/// let surface = rest.surface();
/// let x = surface.positions(&rest.positions)?;
/// let mut medial = generate(&surface, x, &MedialParams::balls(20), Progress::none())?.medial;
/// let links = Links::new(&medial, &surface, x)?;
///
/// // The muscle shortens by a quarter and thickens.
/// let short = rest.clone().scaled(DVec3::new(0.75, 1.15, 1.15));
/// links.follow(&mut medial, surface.positions(&short.positions)?)?;
/// assert!(medial.balls().iter().all(|ball| ball.center.x.abs() < 45.0));
/// # Ok::<(), medial::MedialError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Links {
    links: Vec<Link>,
    /// Vertices that carry each ball, with weights that sum to one: those of ball k are
    /// `starts[k]..starts[k + 1]`.
    carriers: Vec<Term>,
    starts: Vec<usize>,
    /// Number of primitives of the medial surface.
    primitives: usize,
}

/// Number of passes in which [`Links::follow`] refits the balls.
pub const REFIT_PASSES: u32 = 4;

/// Memory of [`Links::follow_in`], which is reused from step to step.
#[derive(Clone, Debug, Default)]
pub struct FollowScratch {
    balls: Vec<Ball>,
    fits: Vec<BallFit>,
}

impl Links {
    /// Links `medial` to `surface`, both at rest.
    ///
    /// # Errors
    ///
    /// [`MedialError::Tree`] where the bounds of a ball cannot be stored, and
    /// [`MedialError::Surface`] when `x` is of another surface.
    pub fn new(
        medial: &MedialSurface,
        surface: &TriangleSurface,
        x: Positions<'_>,
    ) -> Result<Self, MedialError> {
        let tree = PrimitiveTree::new(medial)?;
        let vertices = surface.vertex_count();
        check_positions(vertices, x)?;
        let links = parallel::map_with(vertices, Workspace::default, |workspace, i| {
            Link::new(medial, &tree, x.as_slice()[i], workspace)
        });

        // The carriers of all balls, one list after the other.
        let mut carriers = Vec::new();
        let mut starts = vec![0];
        for of_ball in find_carriers(medial, &links, x) {
            carriers.extend(of_ball);
            starts.push(carriers.len());
        }
        Ok(Self { links, carriers, starts, primitives: medial.primitives().len() })
    }

    /// Returns the link of each vertex.
    #[must_use]
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Returns the vertices that carry the center of a ball, with weights that sum to one: a force
    /// on the center is distributed to them by the same weights.
    ///
    /// Empty for a ball from which no vertex can be reached along primitives.
    ///
    /// # Panics
    ///
    /// When there is no such ball.
    #[must_use]
    pub fn carriers(&self, ball: u32) -> &[Term] {
        let ball = ball as usize;
        &self.carriers[self.starts[ball]..self.starts[ball + 1]]
    }

    /// Moves the balls with the surface: carries the centers, then refits the balls.
    ///
    /// A ball that no vertex touches keeps its radius; where no neighbor has one either, it stays.
    /// The work is linear in the vertices.
    ///
    /// # Errors
    ///
    /// `medial` is unchanged then.
    ///
    /// - [`MedialError::BallCount`] or [`MedialError::PrimitiveCount`] when the links are of another
    ///   medial surface;
    /// - [`MedialError::Surface`] when `x` is of another surface;
    /// - [`MedialError::InvalidBall`] when positions are so large that a center is not finite.
    pub fn follow(&self, medial: &mut MedialSurface, x: Positions<'_>) -> Result<(), MedialError> {
        self.follow_in(medial, x, &mut FollowScratch::default())
    }

    /// Moves the balls as [`Self::follow`] does, in reused memory: only the first step allocates.
    ///
    /// # Errors
    ///
    /// As [`Self::follow`].
    pub fn follow_in(
        &self,
        medial: &mut MedialSurface,
        x: Positions<'_>,
        scratch: &mut FollowScratch,
    ) -> Result<(), MedialError> {
        self.carry_centers(medial, x, scratch)?;
        self.refit_balls(medial, x, REFIT_PASSES, scratch);
        Ok(())
    }

    /// Moves the centers with the surface and keeps the radii.
    ///
    /// # Errors
    ///
    /// As [`Self::follow`].
    pub fn move_centers(
        &self,
        medial: &mut MedialSurface,
        x: Positions<'_>,
    ) -> Result<(), MedialError> {
        self.carry_centers(medial, x, &mut FollowScratch::default())
    }

    fn carry_centers(
        &self,
        medial: &mut MedialSurface,
        x: Positions<'_>,
        FollowScratch { balls, .. }: &mut FollowScratch,
    ) -> Result<(), MedialError> {
        self.check(medial, x)?;
        balls.clear();
        for (number, &ball) in (0_u32..).zip(medial.balls()) {
            let carriers = self.carriers(number);
            let center = if carriers.is_empty() { ball.center } else { combine(carriers, x) };
            balls.push(Ball::new(center, ball.radius));
        }
        medial.set_balls(balls)
    }

    /// Moves and resizes balls so that the union passes through the linked vertices.
    ///
    /// Each pass minimizes the sum of squares of the errors of each ball's vertices, by their
    /// weights at their present feet. Along the sheet, where these do not define its place, a ball
    /// hardly moves.
    ///
    /// # Errors
    ///
    /// As [`Self::follow`], but for [`MedialError::InvalidBall`].
    pub fn refit(
        &self,
        medial: &mut MedialSurface,
        x: Positions<'_>,
        passes: u32,
    ) -> Result<(), MedialError> {
        self.check(medial, x)?;
        self.refit_balls(medial, x, passes, &mut FollowScratch::default());
        Ok(())
    }

    /// Checks that the links are of this medial surface, and of the surface with these positions.
    fn check(&self, medial: &MedialSurface, x: Positions<'_>) -> Result<(), MedialError> {
        let (expected, got) = (self.starts.len() - 1, medial.balls().len());
        if expected != got {
            return Err(MedialError::BallCount { expected, got });
        }
        let (expected, got) = (self.primitives, medial.primitives().len());
        if expected != got {
            return Err(MedialError::PrimitiveCount { expected, got });
        }
        check_positions(self.links.len(), x)
    }
}

/// Checks that there is a position per vertex.
fn check_positions(vertices: usize, x: Positions<'_>) -> Result<(), MedialError> {
    let (expected, got) = (vertices, x.as_slice().len());
    if expected == got { Ok(()) } else { Err(SurfaceError::PositionCount { expected, got }.into()) }
}

impl Link {
    /// Links a vertex to its foot.
    fn new(
        medial: &MedialSurface,
        tree: &PrimitiveTree,
        p: DVec3,
        workspace: &mut Workspace,
    ) -> Self {
        let nearest = tree.nearest(medial, p, workspace);
        let centers = Ball::centers(&medial.primitive_balls(nearest.primitive));
        let height = triangle::normal(centers).dot(p - nearest.foot.ball.center);
        let side = if height > 0.0 { 1 } else { -i8::from(height < 0.0) };
        Self { primitive: nearest.primitive, weights: nearest.foot.weights, side }
    }
}

/// Computes the combination of vertices at `x`.
fn combine(terms: &[Term], x: Positions<'_>) -> DVec3 {
    terms.iter().map(|term| term.weight * x.at(term.particle)).sum()
}
