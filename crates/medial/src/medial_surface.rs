//! The medial surface itself: balls, and the cones and slabs between them.

use glam::DVec3;

use crate::{Ball, Foot, FootRule, MedialError, foot};

/// A volume as the union of balls, cones (pairs) and slabs (triples).
///
/// Every cone and slab is the convex hull of its balls. The connectivity is
/// checked once; balls may move and change their radii.
///
/// # Primitives
///
/// Slabs, cones and isolated balls (those of no slab and no cone) are numbered
/// in that order as *primitives*, each with three balls: a cone repeats its
/// second ball, an isolated ball stands three times. The union of the
/// primitives is the volume.
///
/// ```
/// use glam::DVec3;
/// use medial::{Ball, MedialSurface};
///
/// let balls = [0.0, 1.0, 5.0].map(|x| Ball::new(DVec3::X * x, 0.5));
/// let medial = MedialSurface::new(balls.to_vec(), vec![[0, 1]], vec![])?;
/// assert_eq!(medial.primitives(), [[0, 1, 1], [2, 2, 2]]);
/// assert_eq!(medial.bounds(), [DVec3::splat(-0.5), DVec3::new(5.5, 0.5, 0.5)]);
/// # Ok::<(), medial::MedialError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct MedialSurface {
    balls: Vec<Ball>,
    primitives: Vec<[u32; 3]>,
    slabs: usize,
    cones: usize,
}

/// Numbers from here on are kept free, as they are in trees of bounds.
const LIMIT: usize = 1 << 31;

impl MedialSurface {
    /// Joins `balls` by `cones` and `slabs`.
    ///
    /// # Errors
    ///
    /// - [`MedialError::Empty`] without balls, [`MedialError::TooMany`] for more
    ///   than 2³¹ balls or primitives.
    /// - [`MedialError::NotABall`] with the first ball that is not one.
    /// - [`MedialError::BallOutOfRange`] and [`MedialError::RepeatedBall`] with
    ///   the first cone or slab at fault.
    pub fn new(
        balls: Vec<Ball>,
        cones: Vec<[u32; 2]>,
        slabs: Vec<[u32; 3]>,
    ) -> Result<Self, MedialError> {
        check_balls(&balls)?;
        check_indices("slab", &slabs, balls.len())?;
        check_indices("cone", &cones, balls.len())?;
        let isolated = isolated(balls.len(), &cones, &slabs)?;
        let (slab_count, cone_count) = (slabs.len(), cones.len());
        let mut primitives = slabs;
        primitives.extend(cones.into_iter().map(|[a, b]| [a, b, b]));
        primitives.extend(isolated.into_iter().map(|ball| [ball; 3]));
        check_count("primitives", primitives.len())?;
        Ok(Self { balls, primitives, slabs: slab_count, cones: cone_count })
    }

    /// The balls.
    #[must_use]
    pub fn balls(&self) -> &[Ball] {
        &self.balls
    }

    /// All primitives, as three balls each: slabs, cones, isolated balls.
    #[must_use]
    pub fn primitives(&self) -> &[[u32; 3]] {
        &self.primitives
    }

    /// The slabs, each of three different balls.
    #[must_use]
    pub fn slabs(&self) -> &[[u32; 3]] {
        &self.primitives[..self.slabs]
    }

    /// The cones, each of two different balls.
    #[must_use]
    pub fn cones(&self) -> impl ExactSizeIterator<Item = [u32; 2]> {
        self.primitives[self.slabs..self.slabs + self.cones].iter().map(|&[a, b, _]| [a, b])
    }

    /// Balls that belong to no cone and no slab.
    #[must_use]
    pub fn isolated_balls(&self) -> impl ExactSizeIterator<Item = u32> {
        self.primitives[self.slabs + self.cones..].iter().map(|&[ball, ..]| ball)
    }

    /// The balls of one primitive.
    ///
    /// # Panics
    ///
    /// When there is no such primitive.
    #[must_use]
    pub fn primitive_balls(&self, primitive: u32) -> [Ball; 3] {
        self.primitives[primitive as usize].map(|ball| self.balls[ball as usize])
    }

    /// The foot of `p` on one primitive.
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
    /// - [`MedialError::BallCount`] when `balls` is of another length.
    /// - [`MedialError::NotABall`] with the first ball that is not one; nothing
    ///   is changed then.
    pub fn set_balls(&mut self, balls: &[Ball]) -> Result<(), MedialError> {
        if balls.len() != self.balls.len() {
            return Err(MedialError::BallCount { expected: self.balls.len(), got: balls.len() });
        }
        check_balls(balls)?;
        self.balls.copy_from_slice(balls);
        Ok(())
    }

    /// Moves all centers and keeps the radii: the medial surface as the
    /// simulated object itself.
    ///
    /// # Errors
    ///
    /// As [`Self::set_balls`].
    pub fn set_centers(&mut self, centers: &[DVec3]) -> Result<(), MedialError> {
        if centers.len() != self.balls.len() {
            return Err(MedialError::BallCount { expected: self.balls.len(), got: centers.len() });
        }
        let moved: Vec<Ball> = centers
            .iter()
            .zip(&self.balls)
            .map(|(&center, ball)| Ball::new(center, ball.radius))
            .collect();
        self.set_balls(&moved)
    }

    /// Least and greatest corner of the box around the union: that of the
    /// balls, since every primitive is the hull of its own.
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.balls.iter().fold(empty, |[low, high], ball| {
            [low.min(ball.center - ball.radius), high.max(ball.center + ball.radius)]
        })
    }

    /// Balls without checks, for code that made them valid.
    pub(crate) fn balls_mut(&mut self) -> &mut [Ball] {
        &mut self.balls
    }
}

fn check_balls(balls: &[Ball]) -> Result<(), MedialError> {
    if balls.is_empty() {
        return Err(MedialError::Empty);
    }
    check_count("balls", balls.len())?;
    match balls.iter().position(|ball| !ball.is_valid()) {
        Some(ball) => {
            let Ball { center: DVec3 { x, y, z }, radius } = balls[ball];
            Err(MedialError::NotABall { ball, x, y, z, radius })
        }
        None => Ok(()),
    }
}

fn check_count(what: &'static str, count: usize) -> Result<(), MedialError> {
    if count < LIMIT { Ok(()) } else { Err(MedialError::TooMany { what, count, limit: LIMIT }) }
}

fn check_indices<const N: usize>(
    what: &'static str,
    list: &[[u32; N]],
    balls: usize,
) -> Result<(), MedialError> {
    for (index, corners) in list.iter().enumerate() {
        if let Some(&ball) = corners.iter().find(|&&ball| ball as usize >= balls) {
            return Err(MedialError::BallOutOfRange { what, index, ball, balls });
        }
        let repeated = (1..N).find(|&k| corners[..k].contains(&corners[k]));
        if let Some(k) = repeated {
            return Err(MedialError::RepeatedBall { what, index, ball: corners[k] });
        }
    }
    Ok(())
}

fn isolated(balls: usize, cones: &[[u32; 2]], slabs: &[[u32; 3]]) -> Result<Vec<u32>, MedialError> {
    let mut joined = vec![false; balls];
    for &ball in cones.as_flattened().iter().chain(slabs.as_flattened()) {
        joined[ball as usize] = true;
    }
    let count = u32::try_from(balls).map_err(|_| MedialError::TooMany {
        what: "balls",
        count: balls,
        limit: LIMIT,
    })?;
    Ok((0..count).filter(|&ball| !joined[ball as usize]).collect())
}
