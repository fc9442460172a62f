//! Distribution of one contact's correction onto its particles.
//!
//! Among the changes dq_k with Σ β_k dq_k = ΔQ_c, the one of minimal kinetic
//! norm Σ m_k |dq_k|² is
//!
//! ```text
//! m_eff = 1 / Σ β_k² / m_k     J = m_eff ΔQ_c     dq_k = β_k J / m_k
//! ```
//!
//! It keeps the momentum Σ m_k dq_k = J Σ β_k = 0 to rounding, whatever the
//! masses; a fixed particle has the inverse mass 0.

use glam::DVec3;
use surface::Term;

use crate::{ResponseError, check};

/// Changes `q` of the particles in `terms` such that Σ β_k q_k changes by
/// `correction`, and returns the impulse J given to the side of P̄ (and −J to
/// that of P); J / h is the force.
///
/// A particle may occur more than once. The same rule serves positions,
/// velocities and accelerations.
///
/// ```
/// use glam::DVec3;
/// use surface::Stencil;
///
/// // A vertex over the center of a face, four equal masses.
/// let contact = Stencil::vertex_face(0, [1, 2, 3], [1.0 / 3.0; 3]);
/// let mut x = [DVec3::ZERO; 4];
/// response::distribute(contact.terms(), &[1.0; 4], DVec3::Z, &mut x)?;
/// assert!((contact.combine(|k| x[k as usize]) - DVec3::Z).length() < 1e-15);
/// assert!(x.iter().sum::<DVec3>().length() < 1e-15);
/// # Ok::<(), response::ResponseError>(())
/// ```
///
/// # Errors
///
/// Nothing is changed when
/// - the lists differ in length ([`ResponseError::Count`]) or a term refers
///   beyond them ([`ResponseError::ParticleOutOfRange`]);
/// - the correction or a changed value is not finite;
/// - no particle can move ([`ResponseError::NoFreeParticle`]).
pub fn distribute(
    terms: &[Term],
    inverse_mass: &[f64],
    correction: DVec3,
    q: &mut [DVec3],
) -> Result<DVec3, ResponseError> {
    // Check all input before anything is computed.
    check::count("inverse masses", q.len(), inverse_mass.len())?;
    check::contact_vector(0, "correction", correction)?;
    for term in terms {
        check_term(term, inverse_mass)?;
    }

    // Steps β_k / m_k of the particles, and the impulse that makes them sum to the correction.
    let mut steps = Vec::with_capacity(terms.len());
    merge_onto(&mut steps, terms);
    let mut compliance = 0.0;
    for Term { particle, weight } in &mut steps {
        let w = inverse_mass[*particle as usize];
        compliance += *weight * *weight * w;
        *weight *= w;
    }
    if compliance <= 0.0 {
        return Err(ResponseError::NoFreeParticle { contact: 0 });
    }
    let impulse = check::contact_vector(0, "impulse", correction / compliance)?;

    // Check all values before the first is changed.
    for step in &steps {
        let value = q[step.particle as usize] + step.weight * impulse;
        check::contact_vector(0, "corrected value", value)?;
    }
    for step in &steps {
        q[step.particle as usize] += step.weight * impulse;
    }
    Ok(impulse)
}

/// Appends terms with the weights of each particle added up, in order of first
/// occurrence.
pub(crate) fn merge_onto(merged: &mut Vec<Term>, terms: &[Term]) {
    let start = merged.len();
    for term in terms {
        match merged[start..].iter_mut().find(|other| other.particle == term.particle) {
            Some(other) => other.weight += term.weight,
            None => merged.push(*term),
        }
    }
}

fn check_term(term: &Term, inverse_mass: &[f64]) -> Result<(), ResponseError> {
    check::contact_number(0, "weight", term.weight)?;
    check::particle_range(0, [term.particle], inverse_mass.len())?;
    let (particle, value) = (term.particle as usize, inverse_mass[term.particle as usize]);
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(ResponseError::InverseMass { particle, value })
    }
}
