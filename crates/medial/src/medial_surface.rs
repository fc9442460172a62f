//! Medial surfaces: balls, with the cones and slabs between them.

use glam::DVec3;
use surface::Aabb;

use crate::{Ball, Foot, FootRule, MedialError, foot};

/// Volume as the union of balls, cones (pairs) and slabs (triples).
///
/// Every cone and slab is the convex hull of its balls. The connectivity is checked once; balls may
/// move and change their radii.
///
/// # Primitives
///
/// Slabs, cones and isolated balls (those of no slab and no cone) are numbered in that order as
/// *primitives*, each with three balls: a cone repeats its second ball, an isolated ball stands
/// three times. The union of the primitives is the volume.
///
/// ```
/// use glam::DVec3;
/// use medial::{Ball, MedialSurface};
///
/// let balls = [0.0, 1.0, 5.0].map(|x| Ball::new(DVec3::X * x, 0.5));
/// let medial = MedialSurface::new(balls.to_vec(), vec![[0, 1]], vec![])?;
/// assert_eq!(medial.primitives(), [[0, 1, 1], [2, 2, 2]]);
/// assert_eq!(medial.bounds().max, DVec3::new(5.5, 0.5, 0.5));
/// # Ok::<(), medial::MedialError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MedialSurface {
    balls: Vec<Ball>,
    primitives: Vec<[u32; 3]>,
    slab_count: usize,
    cone_count: usize,
}

/// Number of balls or primitives from which on none is accepted: trees of bounds keep these free.
const LIMIT: usize = 1 << 31;

impl MedialSurface {
    /// Joins `balls` by `cones` and `slabs`.
    ///
    /// # Errors
    ///
    /// - [`MedialError::Empty`] without balls, [`MedialError::TooMany`] for 2³¹ balls or primitives
    ///   and more.
    /// - [`MedialError::InvalidBall`] with the first ball that is not one.
    /// - [`MedialError::BallOutOfRange`] and [`MedialError::RepeatedBall`] with the first cone or
    ///   slab at fault.
    pub fn new(
        balls: Vec<Ball>,
        cones: Vec<[u32; 2]>,
        slabs: Vec<[u32; 3]>,
    ) -> Result<Self, MedialError> {
        check_balls(&balls)?;
        check_indices("slab", &slabs, balls.len())?;
        check_indices("cone", &cones, balls.len())?;
        let isolated = isolated_balls(balls.len(), &cones, &slabs);

        let (slab_count, cone_count) = (slabs.len(), cones.len());
        let mut primitives = slabs;
        primitives.extend(cones.into_iter().map(|[a, b]| [a, b, b]));
        primitives.extend(isolated.into_iter().map(|ball| [ball; 3]));
        check_count("primitives", primitives.len())?;
        Ok(Self { balls, primitives, slab_count, cone_count })
    }

    /// Returns the balls.
    #[must_use]
    pub fn balls(&self) -> &[Ball] {
        &self.balls
    }

    /// Returns all primitives, as three balls each: slabs, cones, isolated balls.
    #[must_use]
    pub fn primitives(&self) -> &[[u32; 3]] {
        &self.primitives
    }

    /// Returns the slabs, each of three different balls.
    #[must_use]
    pub fn slabs(&self) -> &[[u32; 3]] {
        &self.primitives[..self.slab_count]
    }

    /// Returns the cones, each of two different balls.
    #[must_use]
    pub fn cones(&self) -> impl ExactSizeIterator<Item = [u32; 2]> {
        let cones = &self.primitives[self.slab_count..self.slab_count + self.cone_count];
        cones.iter().map(|&[a, b, _]| [a, b])
    }

    /// Returns the balls that belong to no cone and no slab.
    #[must_use]
    pub fn isolated_balls(&self) -> impl ExactSizeIterator<Item = u32> {
        self.primitives[self.slab_count + self.cone_count..].iter().map(|&[ball, ..]| ball)
    }

    /// Returns the balls of one primitive.
    ///
    /// # Panics
    ///
    /// When there is no such primitive.
    #[must_use]
    pub fn primitive_balls(&self, primitive: u32) -> [Ball; 3] {
        let [a, b, c] = self.primitives[primitive as usize];
        [self.balls[a as usize], self.balls[b as usize], self.balls[c as usize]]
    }

    /// Computes the foot of `p` on one primitive.
    ///
    /// # Panics
    ///
    /// When there is no such primitive.
    #[must_use]
    pub fn foot(&self, p: DVec3, primitive: u32, rule: FootRule) -> Foot {
        foot(p, &self.primitive_balls(primitive), rule)
    }

    /// Moves and resizes all balls.
    ///
    /// # Errors
    ///
    /// [`MedialError::BallCount`] when `balls` is of another length, and
    /// [`MedialError::InvalidBall`] with the first ball that is not one; nothing is changed then.
    pub fn set_balls(&mut self, balls: &[Ball]) -> Result<(), MedialError> {
        self.check_ball_count(balls.len())?;
        check_balls(balls)?;
        self.balls.copy_from_slice(balls);
        Ok(())
    }

    /// Moves all centers and keeps the radii, for medial surfaces that are simulated themselves.
    ///
    /// # Errors
    ///
    /// As [`Self::set_balls`].
    pub fn set_centers(&mut self, centers: &[DVec3]) -> Result<(), MedialError> {
        self.check_ball_count(centers.len())?;
        let centers = centers.iter().zip(&self.balls);
        let moved: Vec<Ball> = centers.map(|(&p, ball)| Ball::new(p, ball.radius)).collect();
        self.set_balls(&moved)
    }

    /// Computes the box around the union: that of the balls, since every primitive is the hull of
    /// its own.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        bounds_of(&self.balls)
    }

    /// Returns the balls without checks, for code that keeps them valid.
    pub(crate) fn balls_mut(&mut self) -> &mut [Ball] {
        &mut self.balls
    }

    /// Checks that there is one value per ball.
    fn check_ball_count(&self, got: usize) -> Result<(), MedialError> {
        let expected = self.balls.len();
        if expected == got { Ok(()) } else { Err(MedialError::BallCount { expected, got }) }
    }
}

/// Computes the box around balls.
pub(crate) fn bounds_of(balls: &[Ball]) -> Aabb {
    let of_ball = |ball: &Ball| Aabb { min: ball.center, max: ball.center }.inflate(ball.radius);
    balls.iter().map(of_ball).fold(Aabb::EMPTY, Aabb::union)
}

fn check_balls(balls: &[Ball]) -> Result<(), MedialError> {
    if balls.is_empty() {
        return Err(MedialError::Empty);
    }
    check_count("balls", balls.len())?;
    match balls.iter().position(|ball| !ball.is_valid()) {
        Some(ball) => {
            let Ball { center: DVec3 { x, y, z }, radius } = balls[ball];
            Err(MedialError::InvalidBall { ball, x, y, z, radius })
        }
        None => Ok(()),
    }
}

fn check_count(kind: &'static str, count: usize) -> Result<(), MedialError> {
    if count < LIMIT { Ok(()) } else { Err(MedialError::TooMany { kind, count, limit: LIMIT }) }
}

/// Checks that cones or slabs refer to different balls that exist.
fn check_indices<const N: usize>(
    kind: &'static str,
    list: &[[u32; N]],
    balls: usize,
) -> Result<(), MedialError> {
    for (index, corners) in list.iter().enumerate() {
        if let Some(&ball) = corners.iter().find(|&&ball| ball as usize >= balls) {
            return Err(MedialError::BallOutOfRange { kind, index, ball, balls });
        }
        let repeated = (1..N).find(|&k| corners[..k].contains(&corners[k]));
        if let Some(k) = repeated {
            return Err(MedialError::RepeatedBall { kind, index, ball: corners[k] });
        }
    }
    Ok(())
}

/// Finds the balls of no cone and no slab; there are fewer than [`LIMIT`] balls.
fn isolated_balls(balls: usize, cones: &[[u32; 2]], slabs: &[[u32; 3]]) -> Vec<u32> {
    let mut is_joined = vec![false; balls];
    for &ball in cones.as_flattened().iter().chain(slabs.as_flattened()) {
        is_joined[ball as usize] = true;
    }
    (0..crate::index(balls)).filter(|&ball| !is_joined[ball as usize]).collect()
}
