//! Particles that are linear combinations of others: the centers about which polygons of a simplex
//! surface are fanned.
//!
//! A contact on such a particle acts on those that it combines, by its weights: momentum is kept to
//! rounding, and the center moves with its polygon.

use glam::DVec3;
use surface::Term;

use crate::{ResponseError, check};

/// Particles that are combinations of others. They have no mass of their own: their inverse mass
/// is 0, and their states are computed.
///
/// ```
/// use response::Combinations;
/// use surface::Term;
///
/// // Particle 4 is the center of a square.
/// let corners = [0, 1, 2, 3].map(|particle| Term { particle, weight: 0.25 });
/// let mut combinations = Combinations::default();
/// combinations.push(4, &corners)?;
/// assert_eq!(combinations.len(), 1);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Combinations {
    /// Ascending.
    particles: Vec<u32>,
    /// End of the terms of each.
    ends: Vec<usize>,
    terms: Vec<Term>,
}

impl Combinations {
    /// Adds a particle, with a number above those before it.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] unless numbers ascend, and [`ResponseError::Weights`] with the
    /// number of the combination unless its weights sum to 1.
    pub fn push(&mut self, particle: u32, terms: &[Term]) -> Result<(), ResponseError> {
        let ascends = self.particles.last().is_none_or(|last| *last < particle);
        check::parameter("combined particle", f64::from(particle), "ascending", ascends)?;
        let sum = terms.iter().map(|term| term.weight).sum();
        check::weight_sum(self.len(), sum, 1.0, 1.0)?;
        self.terms.extend_from_slice(terms);
        self.particles.push(particle);
        self.ends.push(self.terms.len());
        Ok(())
    }

    /// Returns the number of combined particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.particles.len()
    }

    /// Returns true if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.particles.is_empty()
    }

    /// Checks that all particles exist, that none combines another combination, and that they have
    /// no mass of their own.
    pub(crate) fn check(&self, inverse_mass: &[f64]) -> Result<(), ResponseError> {
        let count = inverse_mass.len();
        for (number, &particle) in self.particles.iter().enumerate() {
            let terms = self.terms_of(number);
            let all = terms.iter().map(|term| term.particle).chain([particle]);
            check::particle_range(number, all, count)?;
            for term in terms {
                let is_free = self.find(term.particle).is_none();
                let value = f64::from(term.particle);
                check::parameter("particle of a combination", value, "no combination", is_free)?;
            }
            let own = inverse_mass[particle as usize];
            check::parameter("inverse mass of a combination", own, "0", own <= 0.0)?;
        }
        Ok(())
    }

    /// Computes the states of combined particles.
    pub(crate) fn apply(&self, q: &mut [DVec3]) {
        for (number, &particle) in self.particles.iter().enumerate() {
            let mut combined = DVec3::ZERO;
            for term in self.terms_of(number) {
                combined += term.weight * q[term.particle as usize];
            }
            q[particle as usize] = combined;
        }
    }

    /// Replaces combined particles by those that they combine, into `out`.
    pub(crate) fn expand(&self, terms: &[Term], out: &mut Vec<Term>) {
        out.clear();
        for term in terms {
            let Some(number) = self.find(term.particle) else {
                out.push(*term);
                continue;
            };
            for own in self.terms_of(number) {
                out.push(Term { particle: own.particle, weight: term.weight * own.weight });
            }
        }
    }

    fn find(&self, particle: u32) -> Option<usize> {
        self.particles.binary_search(&particle).ok()
    }

    fn terms_of(&self, number: usize) -> &[Term] {
        let start = number.checked_sub(1).map_or(0, |last| self.ends[last]);
        &self.terms[start..self.ends[number]]
    }
}
