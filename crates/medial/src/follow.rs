//! A medial surface that follows the surface it was made of.
//!
//! Each vertex of the surface is linked to its foot on the medial surface at
//! rest: a primitive, the weights there, and the side of the sheet. Each ball is
//! carried by the vertices linked to it: its center is an affine combination of
//! them, exact under every affine motion of the surface; then center and radius are
//! refitted so that the union passes through the vertices again. Where these are
//! too few, or too much in one plane, to tell where the center is, those of
//! neighboring balls help.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007: radii as means of the
//! distances of the linked surface points, by their weights. Here it is the error
//! left at the exact foot, so that passes converge; the centers are combinations of
//! the same points; and least squares of a ball's errors move its center too, which
//! a mean cannot: a shortened muscle is off by a quarter less then.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat3, DVec3, DVec4};
use kdop::Workspace;
use surface::{Positions, Term, TriangleSurface};

use crate::generate::{outer, solve};
use crate::{Ball, FootRule, MedialError, MedialSurface, PrimitiveTree, parallel};

/// Where a surface vertex touches the medial surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Link {
    /// Number of the primitive.
    pub primitive: u32,
    /// Weights of its balls at the vertex's foot at rest.
    pub weights: [f64; 3],
    /// On which side of the slab the vertex lies: 1 where the normal of its
    /// balls' centers, counter-clockwise, points to it, else −1; 0 for a cone or
    /// a ball, which have no sides.
    pub side: i8,
}

/// What ties a medial surface to a surface.
///
/// ```
/// use medial::{Links, MedialParams, generate};
/// use surface::glam::DVec3;
///
/// let rest = fixtures::shapes::ellipsoid(DVec3::new(60.0, 20.0, 10.0), 3);
/// let surface = rest.surface();
/// let x = surface.positions(&rest.positions)?;
/// let mut medial = generate(&surface, x, &MedialParams::balls(20), |_| {})?.medial;
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
    /// Vertices that carry each ball, with weights that sum to one: those of
    /// ball k stand in `starts[k]..starts[k + 1]`.
    carriers: Vec<Term>,
    starts: Vec<usize>,
}

/// Passes in which [`Links::follow`] refits the balls.
pub const REFIT_PASSES: u32 = 4;

/// What following takes and gives back.
#[derive(Clone, Debug, Default)]
pub struct FollowScratch {
    balls: Vec<Ball>,
    touched: Vec<Touched>,
}

/// What the vertices that touch a ball ask of it: the least squares of
/// `e − u·dc − dr` over its change `(dc, dr)`, with e the height of a vertex over
/// the union and u the direction outward there.
#[derive(Clone, Copy, Debug, Default)]
struct Touched {
    /// Upper triangle of `Σ b (u, 1)(u, 1)ᵀ`.
    matrix: [f64; 10],
    /// `Σ b e (u, 1)`.
    pull: DVec4,
}

/// Share of the weights that holds a center where it was carried, in every
/// direction. Less lets balls slide along the sheet, more leaves errors that differ
/// between its sides.
const HELD: f64 = 0.05;

impl Touched {
    fn add(&mut self, outward: DVec3, error: f64, weight: f64) {
        let direction = outward.extend(1.0);
        for (sum, entry) in self.matrix.iter_mut().zip(outer(direction)) {
            *sum += weight * entry;
        }
        self.pull += weight * error * direction;
    }

    fn fitted(&self, ball: Ball) -> Ball {
        let mut held = self.matrix;
        let total = held[9];
        for k in [0, 4, 7] {
            held[k] += HELD * total;
        }
        match solve(&held, self.pull) {
            Some(step) => Ball::new(ball.center + step.truncate(), (ball.radius + step.w).max(0.0)),
            None => ball,
        }
    }
}

/// Share of the spread of a ball's vertices that is added to their moments in
/// every direction. Without it, vertices in a plane leave the center's offset
/// from them undetermined; a hundred times larger and affine motions are no
/// longer followed to a thousandth.
const STIFFENING: f64 = 1e-5;

impl Links {
    /// Ties `medial` to `surface`, both at rest.
    ///
    /// # Errors
    ///
    /// [`MedialError::Tree`] where the bounds of a ball cannot be stored.
    pub fn new(
        medial: &MedialSurface,
        surface: &TriangleSurface,
        x: Positions<'_>,
    ) -> Result<Self, MedialError> {
        let tree = PrimitiveTree::new(medial)?;
        let links = parallel::map(surface.vertex_count(), Workspace::default, |workspace, i| {
            link(medial, &tree, x.as_slice()[i], workspace)
        });
        let mut touching = vec![Vec::new(); medial.balls().len()];
        for (vertex, link) in (0_u32..).zip(&links) {
            let balls = medial.primitives()[link.primitive as usize];
            for (ball, weight) in balls.into_iter().zip(link.weights) {
                if weight > 0.0 {
                    touching[ball as usize].push(Term { particle: vertex, weight });
                }
            }
        }
        let neighbors = neighbors(medial);
        let mut carriers = Vec::new();
        let mut starts = vec![0];
        for ball in 0..medial.balls().len() {
            carriers.extend(carrier(medial.balls()[ball], ball, &touching, &neighbors, x));
            starts.push(carriers.len());
        }
        Ok(Self { links, carriers, starts })
    }

    /// The link of each vertex.
    #[must_use]
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The vertices that carry a ball's center, with weights that sum to one: a
    /// force on the center goes to them by the same weights. Empty for a ball
    /// from which no vertex can be reached along primitives.
    ///
    /// # Panics
    ///
    /// When there is no such ball.
    #[must_use]
    pub fn carriers(&self, ball: u32) -> &[Term] {
        let ball = ball as usize;
        &self.carriers[self.starts[ball]..self.starts[ball + 1]]
    }

    /// Moves the balls with the surface: carries the centers, then refits balls.
    ///
    /// A ball that no vertex touches keeps its radius; where no neighbor has one
    /// either, it stays. The work is linear in the vertices.
    ///
    /// # Errors
    ///
    /// [`MedialError::BallCount`] when the links are of another medial surface,
    /// and [`MedialError::NotABall`] when positions are so large that a center
    /// is not finite; `medial` is then unchanged.
    pub fn follow(&self, medial: &mut MedialSurface, x: Positions<'_>) -> Result<(), MedialError> {
        self.follow_in(medial, x, &mut FollowScratch::default())
    }

    /// As [`Self::follow`], with memory that is the caller's: with the same, no step
    /// but the first takes any.
    ///
    /// # Errors
    ///
    /// As [`Self::follow`].
    pub fn follow_in(
        &self,
        medial: &mut MedialSurface,
        x: Positions<'_>,
        memory: &mut FollowScratch,
    ) -> Result<(), MedialError> {
        self.carry(medial, x, memory)?;
        self.refit_in(medial, x, REFIT_PASSES, memory);
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
        self.carry(medial, x, &mut FollowScratch::default())
    }

    fn carry(
        &self,
        medial: &mut MedialSurface,
        x: Positions<'_>,
        FollowScratch { balls, .. }: &mut FollowScratch,
    ) -> Result<(), MedialError> {
        self.check(medial)?;
        let carried = |(ball, now): (u32, &Ball)| {
            let carriers = self.carriers(ball);
            let sum = carriers.iter().map(|term| term.weight * x.at(term.particle)).sum();
            Ball::new(if carriers.is_empty() { now.center } else { sum }, now.radius)
        };
        balls.clear();
        balls.extend((0_u32..).zip(medial.balls()).map(carried));
        medial.set_balls(balls)
    }

    /// Moves and resizes balls so that the union passes through the linked vertices:
    /// in each pass, every ball by what makes the errors of its vertices least in
    /// the square, by their weights at their present feet. Along the sheet, where
    /// these do not tell its place, it hardly moves.
    ///
    /// # Errors
    ///
    /// [`MedialError::BallCount`] when the links are of another medial surface.
    pub fn refit(
        &self,
        medial: &mut MedialSurface,
        x: Positions<'_>,
        passes: u32,
    ) -> Result<(), MedialError> {
        self.check(medial)?;
        self.refit_in(medial, x, passes, &mut FollowScratch::default());
        Ok(())
    }

    fn refit_in(
        &self,
        medial: &mut MedialSurface,
        x: Positions<'_>,
        passes: u32,
        FollowScratch { touched, .. }: &mut FollowScratch,
    ) {
        for _ in 0..passes {
            touched.clear();
            touched.resize(medial.balls().len(), Touched::default());
            for (link, &p) in self.links.iter().zip(x.as_slice()) {
                let foot = medial.foot(p, link.primitive, FootRule::Exact);
                let outward = foot.normal(p).unwrap_or(DVec3::ZERO);
                let balls = medial.primitives()[link.primitive as usize];
                for (ball, weight) in balls.into_iter().zip(foot.weights) {
                    touched[ball as usize].add(outward, foot.distance, weight);
                }
            }
            for (ball, touched) in medial.balls_mut().iter_mut().zip(&*touched) {
                *ball = touched.fitted(*ball);
            }
        }
    }

    fn check(&self, medial: &MedialSurface) -> Result<(), MedialError> {
        let (expected, got) = (self.starts.len() - 1, medial.balls().len());
        if expected == got { Ok(()) } else { Err(MedialError::BallCount { expected, got }) }
    }
}

fn link(medial: &MedialSurface, tree: &PrimitiveTree, p: DVec3, workspace: &mut Workspace) -> Link {
    let nearest = tree.nearest(medial, p, workspace);
    let [a, b, c] = medial.primitive_balls(nearest.primitive).map(|ball| ball.center);
    let height = (b - a).cross(c - a).dot(p - nearest.foot.ball.center);
    let side = if height > 0.0 { 1 } else { -i8::from(height < 0.0) };
    Link { primitive: nearest.primitive, weights: nearest.foot.weights, side }
}

/// Balls that share a primitive with each ball.
fn neighbors(medial: &MedialSurface) -> Vec<Vec<usize>> {
    let mut neighbors = vec![Vec::new(); medial.balls().len()];
    for primitive in medial.primitives() {
        for a in primitive.map(|ball| ball as usize) {
            let others = primitive.iter().map(|&ball| ball as usize).filter(|&b| b != a);
            neighbors[a].extend(others);
        }
    }
    for of_ball in &mut neighbors {
        of_ball.sort_unstable();
        of_ball.dedup();
    }
    neighbors
}

/// How far from a ball's center, in its radii, its carriers may put it at rest.
const MISPLACED: f64 = 1e-3;

/// The most that the magnitudes of a ball's weights may sum to: what noise of
/// the vertices is multiplied by. Vertices on one side of a ball, nearly in a
/// plane, tell where its center is by differences that amount to hundreds.
const AMPLIFIED: f64 = 8.0;

/// What vertices that touch a neighbor of a ball count for beside its own.
const NEIGHBOURS_SHARE: f64 = 0.1;

/// The carriers of a ball: the vertices that touch it, and those that touch its
/// neighbors, and theirs, as far as it takes to tell where the center is.
fn carrier(
    Ball { center, radius }: Ball,
    ball: usize,
    touching: &[Vec<Term>],
    neighbors: &[Vec<usize>],
    x: Positions<'_>,
) -> Vec<Term> {
    let (mut ring, mut reached) = (vec![ball], BTreeSet::from([ball]));
    let mut vertices: BTreeMap<u32, f64> = BTreeMap::new();
    let (mut share, mut carriers, mut least) = (1.0, Vec::new(), f64::INFINITY);
    while !ring.is_empty() {
        let terms = ring.iter().flat_map(|&ball| &touching[ball]);
        for Term { particle, weight } in terms {
            vertices.entry(*particle).or_insert(share * weight);
        }
        let all = vertices.iter().map(|(&particle, &weight)| Term { particle, weight });
        let found = combination(center, &all.collect::<Vec<_>>(), x);
        let placed: DVec3 = found.iter().map(|term| term.weight * x.at(term.particle)).sum();
        let amplified: f64 = found.iter().map(|term| term.weight.abs()).sum();
        let misplaced = placed.distance(center) / (MISPLACED * radius).max(f64::MIN_POSITIVE);
        // Vertices that are all but one tell nothing in numbers.
        let fault = misplaced.max(amplified / AMPLIFIED);
        if amplified.is_finite() && (carriers.is_empty() || fault < least) {
            (carriers, least) = (found, fault);
        }
        if !carriers.is_empty() && least <= 1.0 {
            break;
        }
        let next = ring.iter().flat_map(|&ball| &neighbors[ball]).copied();
        ring = next.filter(|&ball| reached.insert(ball)).collect();
        share *= NEIGHBOURS_SHARE;
    }
    carriers
}

/// Weights of vertices that reproduce `center` from their positions at rest, and
/// its image under every affine map of them: the weighted mean, and the least
/// change of the weights that moves it to the center.
fn combination(center: DVec3, touching: &[Term], x: Positions<'_>) -> Vec<Term> {
    let total: f64 = touching.iter().map(|term| term.weight).sum();
    if total <= 0.0 {
        return Vec::new();
    }
    let mean = touching.iter().map(|t| t.weight * x.at(t.particle)).sum::<DVec3>() / total;
    let mut moments = DMat3::ZERO;
    for term in touching {
        let d = x.at(term.particle) - mean;
        let column = |along: f64| term.weight / total * along * d;
        moments += DMat3::from_cols(column(d.x), column(d.y), column(d.z));
    }
    let trace = moments.x_axis.x + moments.y_axis.y + moments.z_axis.z;
    let stiffened = moments + DMat3::from_diagonal(DVec3::splat(STIFFENING * trace));
    let pull = if trace > 0.0 { stiffened.inverse() * (center - mean) } else { DVec3::ZERO };
    touching
        .iter()
        .map(|term| {
            let tilt = 1.0 + pull.dot(x.at(term.particle) - mean);
            Term { particle: term.particle, weight: term.weight / total * tilt }
        })
        .collect()
}
