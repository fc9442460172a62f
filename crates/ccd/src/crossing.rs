//! How often a path passes through a closed surface.
//!
//! A vertex that was outside a closed surface is inside after a step if it
//! passed through the surface's faces an odd number of times, wherever the
//! faces themselves have gone: each certain root of the cubic at which the
//! vertex is certainly within the face counts once. A pass that rounding cannot
//! place, through an edge or at the very end of the step, is reported as
//! undecided rather than counted twice or not at all.
//!
//! The static question, whether a point is inside now, is the limit in which
//! one of the two states is infinitely far away: the path is a ray, heights
//! over faces are of first order in time, and a choice of rays is free.
//!
//! Source: T. Brochu, E. Edwards and R. Bridson, "Efficient geometrically exact
//! continuous collision detection", ACM TOG 31(4), 2012, decide *contact* by
//! the parity of crossings. Here parity answers what it can: sides, not touches.

use std::ops::Add;

use glam::DVec3;

use crate::batch::MovingPoints;
use crate::contact::CcdParams;
use crate::cubic::RootKind;
use crate::error::{CcdError, StepEnd};
use crate::polygon::check_finite;
use crate::rounding::{RAY, UNDERFLOW};
use crate::search::Search;

/// Passes of a path through faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Crossings {
    /// Passes from the front of a face, from which its corners run
    /// counterclockwise, to its back.
    pub inward: u32,
    /// Passes from the back to the front.
    pub outward: u32,
    /// Passes that may be there or not.
    pub undecided: u32,
}

impl Crossings {
    /// Whether the path ends on the other side of a closed surface than it
    /// started; `None` while a pass is undecided.
    #[must_use]
    pub fn changes_side(&self) -> Option<bool> {
        (self.undecided == 0).then_some((self.inward + self.outward) % 2 == 1)
    }
}

impl Add for Crossings {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            inward: self.inward + other.inward,
            outward: self.outward + other.outward,
            undecided: self.undecided + other.undecided,
        }
    }
}

/// Counts how often a moving vertex passes through a moving face.
///
/// # Errors
///
/// When a coordinate is not finite.
///
/// # Example
///
/// ```
/// use glam::DVec3;
///
/// let face = [DVec3::ZERO, DVec3::X, DVec3::Y];
/// let step = |height: f64| [DVec3::new(0.2, 0.2, height), face[0], face[1], face[2]];
/// let passes = ccd::vertex_face_crossings(step(1.0), step(-1.0))?;
/// assert_eq!((passes.inward, passes.outward), (1, 0));
/// assert_eq!(passes.changes_side(), Some(true));
/// # Ok::<(), ccd::CcdError>(())
/// ```
pub fn vertex_face_crossings(x0: [DVec3; 4], x1: [DVec3; 4]) -> Result<Crossings, CcdError> {
    let count = |search: &Search<'_, 3>| {
        let mut passes = Crossings::default();
        for interval in search.intervals().iter() {
            match (search.examine(interval), interval.kind) {
                (None, _) => {}
                (Some(contact), RootKind::Rising) if contact.is_certain() => passes.inward += 1,
                (Some(contact), RootKind::Falling) if contact.is_certain() => passes.outward += 1,
                (Some(_), _) => passes.undecided += 1,
            }
        }
        passes
    };
    let passes = Search::unless_filtered(&x0, &x1, &CcdParams::DEFAULT, count)?;
    Ok(passes.unwrap_or_default())
}

impl MovingPoints<'_> {
    /// Counts how often a vertex passes through faces during the step.
    ///
    /// Over all faces of a closed surface that the vertex does not belong to,
    /// or over those its path may meet, this tells whether it has changed sides.
    ///
    /// # Errors
    ///
    /// When a face or the vertex refers to a point that does not exist.
    pub fn crossings(&self, vertex: u32, faces: &[[u32; 3]]) -> Result<Crossings, CcdError> {
        let mut all = Crossings::default();
        for (candidate, &[a, b, c]) in faces.iter().enumerate() {
            let [x0, x1] = self.points(candidate, &[vertex, a, b, c])?;
            all = all + vertex_face_crossings(x0, x1)?;
        }
        Ok(all)
    }
}

/// Counts passes of the ray from `origin` along `direction` through a face:
/// none or one.
#[must_use]
pub fn ray_crossings(origin: DVec3, direction: DVec3, face: [DVec3; 3]) -> Crossings {
    let [a, b, c] = face.map(|corner| corner - origin);
    let reach = a.abs().max(b.abs()).max(c.abs());
    let crossed = DVec3::new(reach.y * reach.z, reach.z * reach.x, reach.x * reach.y);
    let bound = RAY * direction.abs().dot(crossed) + UNDERFLOW;
    let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|n| direction.dot(n));
    let [left, right] = [1.0, -1.0].map(|side| sides.iter().any(|w| side * w > bound));
    if left && right {
        return Crossings::default();
    }
    let area = (face[1] - face[0]).cross(face[2] - face[0]);
    let height = a.dot(area);
    let height_bound = RAY * 5.0 * reach.dot(crossed) + UNDERFLOW;
    let through = sides.iter().all(|w| w.abs() > bound);
    // Along the area vector: the ray leaves the face's back if it comes through.
    if left && height < -height_bound || right && height > height_bound {
        Crossings::default()
    } else if through && height.abs() > height_bound {
        Crossings { inward: u32::from(right), outward: u32::from(left), undecided: 0 }
    } else {
        Crossings { undecided: 1, ..Crossings::default() }
    }
}

/// Whether a point is inside a closed surface: the static limit of
/// [`MovingPoints::crossings`], by rays in one direction after another until all
/// passes of one are decided. `None` if none is, as for a point on the surface.
///
/// # Errors
///
/// When a coordinate is not finite or a face refers to a point that does not exist.
pub fn is_inside(
    point: DVec3,
    positions: &[DVec3],
    faces: &[[u32; 3]],
) -> Result<Option<bool>, CcdError> {
    check_finite(positions, StepEnd::Start)?;
    check_finite(&[point], StepEnd::Start)?;
    let motion = MovingPoints { x0: positions, x1: positions };
    for direction in DIRECTIONS {
        let mut all = Crossings::default();
        for (candidate, &[a, b, c]) in faces.iter().enumerate() {
            let [[a, b, c, _], _] = motion.points(candidate, &[a, b, c, c])?;
            all = all + ray_crossings(point, direction, [a, b, c]);
        }
        if let Some(inside) = all.changes_side() {
            return Ok(Some(inside));
        }
    }
    Ok(None)
}

/// Directions of rays: none along an axis, a diagonal or another one, where
/// the edges of made surfaces lie.
const DIRECTIONS: [DVec3; 4] = [
    DVec3::new(0.614, 0.277, 0.739),
    DVec3::new(-0.351, 0.883, 0.312),
    DVec3::new(0.191, -0.467, -0.863),
    DVec3::new(-0.797, -0.543, 0.264),
];
