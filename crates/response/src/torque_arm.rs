//! Friction at a surface point that no particle is at.
//!
//! A medial contact lies between a point P and a medial point P̄, a radius
//! below the surface. Friction acts at the surface. If the impulse J_t were
//! given to the medial particles alone, the angular momentum would change by
//! P_c × J_t, which is radius times impulse, and an axis would never be rolled.
//!
//! Here the surface point is carried by three particles (the corners of a
//! slab) as a rigid body would carry it. With d_k their positions from their
//! center, I = Σ (|d_k|² − d_k d_kᵀ) and r the arm from P̄ to the surface point,
//!
//! ```text
//! ω = I⁻¹ Σ d_k × q_k             surface point's q = q(P̄) + ω × r
//! θ = I⁻¹ (r × J)                 impulse on k, beside β_k J: θ × d_k
//! ```
//!
//! The impulses θ × d_k sum to zero and have the moment r × J.

use glam::{DMat3, DVec3};
use surface::triangle;

use crate::{ResponseError, check};

/// Height of a triangle over its longest edge, relative to that edge, below which the
/// triangle counts as a line. Its impulses grow as the inverse of this ratio: at 1e-6
/// they still keep the angular momentum to 1e-10, and a slab that thin has no width to
/// roll on.
const LINE_RATIO: f64 = 1e-6;

/// Side of a contact that a torque arm belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ArmSide {
    /// The side of P, whose weights are negative.
    Point,
    /// The side of P̄.
    Projection,
}

/// Torque arm: a surface point at `arm` from P or P̄, carried by three particles there.
///
/// For a medial contact of normal n with radius r at P̄ the arm is r n; with
/// −P_c instead, friction acts exactly at P and no angular momentum is lost
/// when the gap is not zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TorqueArm {
    /// Side of the point and its particles.
    pub side: ArmSide,
    /// Particles that carry it, not in a line.
    pub particles: [u32; 3],
    /// Vector from P or P̄ to the surface point, in the caller's length unit.
    pub arm: DVec3,
}

/// Torque arm of one row, with the inverse inertia of its particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TorqueArmRow {
    pub(crate) row: u32,
    pub(crate) particles: [u32; 3],
    sign: f64,
    arm: DVec3,
    from_center: [DVec3; 3],
    inverse_inertia: DMat3,
}

impl TorqueArmRow {
    pub(crate) fn new(row: u32, arm: &TorqueArm, x: &[DVec3]) -> Result<Self, ResponseError> {
        let contact = row as usize;
        let TorqueArm { side, particles, arm } = *arm;
        check::particle_range(contact, particles, x.len())?;
        check::contact_vector(contact, "arm", arm)?;

        let corners = particles.map(|k| x[k as usize]);
        if is_line(corners) {
            return Err(ResponseError::Collinear { contact });
        }

        // Unit masses: their scale cancels between the inertia and the impulses.
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let from_center = corners.map(|x| x - center);
        let inverse_inertia = inertia(from_center).inverse();
        let sign = if side == ArmSide::Point { -1.0 } else { 1.0 };
        Ok(Self { row, particles, sign, arm, from_center, inverse_inertia })
    }

    /// Computes the torque arm's part of Σ β_k q_k at the surface point.
    pub(crate) fn gather(&self, q: impl Fn(u32) -> DVec3) -> DVec3 {
        let [a, b, c] = self.particles.map(q);
        let [da, db, dc] = self.from_center;
        let spin: DVec3 = [da.cross(a), db.cross(b), dc.cross(c)].into_iter().sum();
        self.sign * (self.inverse_inertia * spin).cross(self.arm)
    }

    /// Computes the impulses on the particles that belong to the impulse J at the surface
    /// point.
    pub(crate) fn impulses(&self, impulse: DVec3) -> [DVec3; 3] {
        let turn = self.inverse_inertia * self.arm.cross(self.sign * impulse);
        self.from_center.map(|d| turn.cross(d))
    }
}

fn inertia(from_center: [DVec3; 3]) -> DMat3 {
    let mut sum = DMat3::ZERO;
    for d in from_center {
        let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        sum = sum + DMat3::from_diagonal(DVec3::splat(d.length_squared())) - outer;
    }
    sum
}

fn is_line([a, b, c]: [DVec3; 3]) -> bool {
    let longest =
        (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    triangle::normal([a, b, c]).length() <= LINE_RATIO * longest
}
