//! Soft contacts: forces with their derivatives, for an explicit step or the
//! system of an implicit one.
//!
//! A row with depth δ and relative motion P_c, V_c has the force F on the side
//! of P̄ (β_k F on each particle): a normal part −N n and friction.
//! The derivatives hold the normal, and for friction N, constant:
//!
//! ```text
//! D_P = ∂F/∂P_c    D_V = ∂F/∂V_c    K = Σ Bᵀ D_P B    C = Σ Bᵀ D_V B
//! ```
//!
//! with B the row's weights, so K and C are symmetric and negative semidefinite.
//!
//! Sources: B. Gilles, PhD thesis, 2007, section 4.7.2 (soft constraints as
//! weighted forces); M. Li et al., "Incremental potential contact", ACM TOG
//! 39(4), 2020, sections 4 and 5, for the barrier and for friction that is
//! smooth in the slip; it creeps at a fraction of the slip speed.

use glam::{DMat3, DVec3};
use surface::Term;
use surface::vectors::outer;

use crate::contact_rows::ContactRow;
use crate::{ContactRows, ResponseError, check};

/// Normal force as a function of the depth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum NormalForce {
    /// Penalty: N = k δ + c V_c · n while δ > 0, never pulling. `stiffness` k `>= 0`
    /// \[force / length\], `damping` c `>= 0` \[force / speed\].
    Penalty {
        /// k.
        stiffness: f64,
        /// c.
        damping: f64,
    },
    /// The same at every depth, pulling too: restrains a permanent contact.
    TwoSided {
        /// k.
        stiffness: f64,
        /// c.
        damping: f64,
    },
    /// Log barrier: N = −κ b'(d) with b(d) = −(d − r)² ln(d / r) where the gap d = −δ is
    /// below the range r, else zero. `stiffness` κ `>= 0` \[force / length\],
    /// `range` r `> 0` \[length\]. Needs every gap above 0.
    Barrier {
        /// κ.
        stiffness: f64,
        /// r.
        range: f64,
    },
}

/// Contact force: a normal force and smooth Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SoftLaw {
    normal: NormalForce,
    slip_speed: f64,
}

#[cfg(feature = "serde")]
check::deserialize_checked!(
    SoftLaw { normal: NormalForce, slip_speed: f64 },
    Self::new(normal, slip_speed)
);

impl SoftLaw {
    /// Returns the law of a normal force and the slip speed `> 0` at which friction
    /// reaches µ N (µ is the rows').
    ///
    /// Below it friction is µ N (2 y − y²), with y the slip relative to that speed: a
    /// sticking contact creeps by `slip_speed (1 − √(1 − T / (µ N)))` under a tangential
    /// load T.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] outside the ranges.
    pub fn new(normal: NormalForce, slip_speed: f64) -> Result<Self, ResponseError> {
        match normal {
            NormalForce::Penalty { stiffness, damping }
            | NormalForce::TwoSided { stiffness, damping } => {
                check::not_negative("stiffness", stiffness)?;
                check::not_negative("damping", damping)?;
            }
            NormalForce::Barrier { stiffness, range } => {
                check::not_negative("stiffness", stiffness)?;
                check::positive("range", range)?;
            }
        }
        Ok(Self { normal, slip_speed: check::positive("slip speed", slip_speed)? })
    }
}

/// Block of 3 × 3 entries of a sparse matrix over particles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MatrixBlock {
    /// Particle of the force.
    pub row: u32,
    /// Particle of the motion.
    pub column: u32,
    /// The block.
    pub value: DMat3,
}

/// Products with the derivatives of forces, for implicit steps.
pub trait LinearForces {
    /// Adds K `dx` to `out`, where K = ∂f/∂x.
    fn add_stiffness(&self, dx: &[DVec3], out: &mut [DVec3]);
    /// Adds C `dv` to `out`, where C = ∂f/∂v.
    fn add_damping(&self, dv: &[DVec3], out: &mut [DVec3]);
}

/// Forces of all rows at one state, with their derivatives.
///
/// ```
/// use glam::DVec3;
/// use response::{ContactLaw, ContactRows, Margins, NormalForce, SoftContacts, SoftLaw};
/// use surface::{Anchor, Contact, Stencil, Term};
///
/// let contact = Contact {
///     stencil: Stencil::single(Term { particle: 0, weight: -1.0 }),
///     anchor: Some(Anchor::default()),
///     normal: DVec3::Z,
///     offset: 0.0,
///     gap: -0.5,
///     time: None,
/// };
/// let mut rows = ContactRows::new(1);
/// rows.push(&contact, ContactLaw::new(Margins::new(0.0, 1.0)?, 0.0)?)?;
/// let law = SoftLaw::new(NormalForce::Penalty { stiffness: 8.0, damping: 0.0 }, 1.0)?;
/// let soft = SoftContacts::new(&rows, &[DVec3::ZERO], law)?;
/// let mut force = [DVec3::ZERO];
/// soft.add_forces(&mut force)?;
/// assert_eq!(force[0], DVec3::Z * 4.0);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SoftContacts<'a> {
    rows: &'a ContactRows,
    forces: Vec<RowForce>,
}

/// F, D_P and D_V of one row.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RowForce {
    force: DVec3,
    by_position: DMat3,
    by_velocity: DMat3,
}

impl<'a> SoftContacts<'a> {
    /// Computes the forces at the positions at which the rows' contacts were detected and
    /// at the velocities `v`.
    ///
    /// # Errors
    ///
    /// - [`ResponseError::Count`] or [`ResponseError::ParticleNotFinite`] for `v`;
    /// - [`ResponseError::Overlapped`] where a barrier meets a gap `<= 0`;
    /// - [`ResponseError::ContactNotFinite`] when a force or its derivative would not be finite.
    pub fn new(rows: &'a ContactRows, v: &[DVec3], law: SoftLaw) -> Result<Self, ResponseError> {
        check::particles("velocity", rows.particle_count(), v)?;
        let mut forces = Vec::with_capacity(rows.len());
        for (number, row) in rows.iter().enumerate() {
            forces.push(RowForce::new(number, &row, v, law)?);
        }
        Ok(Self { rows, forces })
    }

    /// Adds each row's force to its particles.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Count`] unless there is one entry per particle.
    pub fn add_forces(&self, out: &mut [DVec3]) -> Result<(), ResponseError> {
        check::count("forces", self.rows.particle_count(), out.len())?;
        for (row, of_row) in self.rows.iter().zip(&self.forces) {
            add_to_terms(row.terms, of_row.force, out);
        }
        Ok(())
    }

    /// Returns the blocks of K, row by row of the contacts; blocks of one place add up.
    #[must_use]
    pub fn stiffness_blocks(&self) -> Vec<MatrixBlock> {
        self.blocks(|of_row| of_row.by_position)
    }

    /// Returns the blocks of C, likewise.
    #[must_use]
    pub fn damping_blocks(&self) -> Vec<MatrixBlock> {
        self.blocks(|of_row| of_row.by_velocity)
    }

    fn blocks(&self, derivative: impl Fn(&RowForce) -> DMat3) -> Vec<MatrixBlock> {
        let mut blocks = Vec::new();
        for (row, of_row) in self.rows.iter().zip(&self.forces) {
            let derivative = derivative(of_row);
            if derivative == DMat3::ZERO {
                continue;
            }

            // Bᵀ D B: one block per pair of the row's particles.
            for i in row.terms {
                for j in row.terms {
                    let value = derivative * (i.weight * j.weight);
                    blocks.push(MatrixBlock { row: i.particle, column: j.particle, value });
                }
            }
        }
        blocks
    }
}

impl LinearForces for SoftContacts<'_> {
    fn add_stiffness(&self, dx: &[DVec3], out: &mut [DVec3]) {
        for (row, of_row) in self.rows.iter().zip(&self.forces) {
            add_to_terms(row.terms, of_row.by_position * row.combine(dx), out);
        }
    }

    fn add_damping(&self, dv: &[DVec3], out: &mut [DVec3]) {
        for (row, of_row) in self.rows.iter().zip(&self.forces) {
            add_to_terms(row.terms, of_row.by_velocity * row.combine(dv), out);
        }
    }
}

/// Adds β_k times a vector to each particle of a row.
#[inline]
fn add_to_terms(terms: &[Term], vector: DVec3, out: &mut [DVec3]) {
    for &Term { particle, weight } in terms {
        out[particle as usize] += weight * vector;
    }
}

impl RowForce {
    fn new(
        number: usize,
        row: &ContactRow<'_>,
        v: &[DVec3],
        law: SoftLaw,
    ) -> Result<Self, ResponseError> {
        // Normal force and friction at the present state.
        let velocity = row.anchor.velocity + row.combine(v);
        let approach = velocity.dot(row.normal);
        let normal = NormalResponse::new(number, law.normal, row.depth, approach)?;
        let (friction, by_slip) = friction(row, velocity, normal.force.max(0.0), law.slip_speed);

        // The normal force acts, and changes, along the normal only.
        let along = outer(row.normal, row.normal);
        let force = friction - normal.force * row.normal;
        check::contact_vector(number, "force", force)?;

        // That of friction by the speed is a factor of the force.
        check::contact_number(number, "stiffness", normal.by_depth)?;
        Ok(Self {
            force,
            by_position: along * -normal.by_depth,
            by_velocity: along * -normal.by_approach + by_slip,
        })
    }
}

/// Normal force N and its derivatives.
struct NormalResponse {
    force: f64,
    by_depth: f64,
    by_approach: f64,
}

impl NormalResponse {
    const NONE: Self = Self { force: 0.0, by_depth: 0.0, by_approach: 0.0 };

    fn new(
        contact: usize,
        law: NormalForce,
        depth: f64,
        approach: f64,
    ) -> Result<Self, ResponseError> {
        match law {
            NormalForce::TwoSided { stiffness, damping } => {
                Ok(Self::spring(stiffness, damping, depth, approach))
            }
            NormalForce::Penalty { stiffness, damping } => {
                let spring = Self::spring(stiffness, damping, depth, approach);
                Ok(if depth > 0.0 && spring.force > 0.0 { spring } else { Self::NONE })
            }
            NormalForce::Barrier { stiffness, range } => {
                let gap = -depth;
                if gap <= 0.0 {
                    return Err(ResponseError::Overlapped { contact, gap });
                }
                Ok(Self::barrier(stiffness, range, gap))
            }
        }
    }

    /// Computes a linear spring with damping.
    fn spring(stiffness: f64, damping: f64, depth: f64, approach: f64) -> Self {
        let force = stiffness * depth + damping * approach;
        Self { force, by_depth: stiffness, by_approach: damping }
    }

    /// Computes the log barrier's first two derivatives.
    fn barrier(stiffness: f64, range: f64, gap: f64) -> Self {
        if gap >= range {
            return Self::NONE;
        }
        let (inside, log) = (gap - range, (gap / range).ln());
        let first = -2.0 * inside * log - inside * inside / gap;
        let second = -2.0 * log - 4.0 * inside / gap + inside * inside / (gap * gap);
        Self { force: -stiffness * first, by_depth: stiffness * second, by_approach: 0.0 }
    }
}

/// Computes the friction on the side of P̄ and its derivative by V_c.
fn friction(row: &ContactRow<'_>, velocity: DVec3, normal: f64, slip_speed: f64) -> (DVec3, DMat3) {
    let limit = row.law.friction().coefficient() * normal;
    if limit <= 0.0 {
        return (DVec3::ZERO, DMat3::ZERO);
    }

    // The slip in the tangent plane, relative to the speed at which friction is full.
    let slip = velocity - velocity.dot(row.normal) * row.normal;
    let speed = slip.length();
    let plane = DMat3::IDENTITY - outer(row.normal, row.normal);
    let y = speed / slip_speed;

    // Force over speed, and the additional derivative along the slip.
    let (secant, bend) = if y < 1.0 {
        ((2.0 - y) / slip_speed, -y / slip_speed)
    } else {
        (speed.recip(), -speed.recip())
    };
    let along = slip.try_normalize().map_or(DMat3::ZERO, |along| outer(along, along));
    (-limit * secant * slip, (plane * secant + along * bend) * -limit)
}
