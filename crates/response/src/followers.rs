//! Particles that follow others: those that a reduced surface has left out.
//!
//! A detector on a reduced surface finds contacts of the particles that it has kept. The others
//! follow these by linear skinning, and the kept ones count with the masses of their followers:
//! so the contact moves tissue, not single vertices, and momentum is kept to rounding.

use glam::DVec3;
use surface::{Contact, Term};

use crate::{ContactSet, Material, ResponseError, check};

/// Particle that moves with three others.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Follower {
    /// Its number.
    pub particle: u32,
    /// Particles that it follows, with weights of at least 0 that sum to 1: each carries that share
    /// of its mass.
    pub leaders: [Term; 3],
}

/// Particles that follow others: changes of the others by contacts carry over to them, unless
/// they are in contact themselves.
///
/// ```
/// use response::{Follower, Followers};
/// use surface::Term;
///
/// let leaders = [(0, 0.5), (1, 0.25), (2, 0.25)].map(|(particle, weight)| Term { particle, weight });
/// let followers = Followers::new(vec![Follower { particle: 3, leaders }])?;
/// assert_eq!(followers.as_slice().len(), 1);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Followers(Vec<Follower>);

/// Vertices that a contact stands for: P, and those that follow it, each by its mass over that of P.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Represented {
    /// Number of them.
    pub(crate) count: f64,
    /// Mean of their depths less that of P: followers may bulge out of the reduced surface.
    pub(crate) deeper: f64,
}

impl Represented {
    /// Computes it from inverse masses, those with followers, and the sums of
    /// [`Followers::sum_offsets`]. P on a rigid object stands for itself.
    pub(crate) fn of(
        contact: &Contact,
        inverse_mass: &[f64],
        lumped: &[f64],
        offsets: &[DVec3],
    ) -> Self {
        let (mut count, mut deeper) = (0.0, 0.0);
        for Term { particle, weight } in contact.stencil.terms() {
            // The sign of a weight decides its side, also that of a zero.
            let k = *particle as usize;
            if weight.is_sign_negative() {
                let has_followers = inverse_mass[k] > lumped[k];
                count -= weight * if has_followers { inverse_mass[k] / lumped[k] } else { 1.0 };
                if has_followers {
                    let offset = offsets.get(k).copied().unwrap_or_default();
                    deeper += weight * lumped[k] * contact.normal.dot(offset);
                }
            }
        }
        if count > 0.0 { Self { count, deeper } } else { Self { count: 1.0, deeper: 0.0 } }
    }

    /// Returns a soft contact as deep as the vertices that it stands for are on average, with as many
    /// springs; a hard one as it is, and one that is met on the way, whose gap is a limit.
    pub(crate) fn of_soft(&self, contact: &Contact, material: &Material) -> (Contact, Material) {
        let Some(spring) = material.spring.filter(|_| contact.time.is_none()) else {
            return (*contact, *material);
        };
        let material = Material { spring: Some(spring.times(self.count)), ..*material };
        (Contact { gap: contact.gap - self.deeper, ..*contact }, material)
    }
}

impl Followers {
    /// Returns a list of followers, none of which leads another.
    ///
    /// # Errors
    ///
    /// - [`ResponseError::Weights`] with the number of a follower whose weights do not sum
    ///   to 1;
    /// - [`ResponseError::LeaderWeight`] with a follower that has a negative weight, beyond
    ///   rounding, which counts as 0;
    /// - [`ResponseError::Parameter`] where a leader follows, too, or a particle twice.
    pub fn new(mut followers: Vec<Follower>) -> Result<Self, ResponseError> {
        // Sorted, for the search for leaders.
        let mut particles: Vec<u32> = followers.iter().map(|follower| follower.particle).collect();
        particles.sort_unstable();
        for pair in particles.windows(2) {
            let is_new = pair[0] != pair[1];
            check::parameter("follower", f64::from(pair[1]), "listed once", is_new)?;
        }

        for (number, follower) in followers.iter_mut().enumerate() {
            let sum = follower.leaders.iter().map(|leader| leader.weight).sum();
            check::weight_sum(number, sum, 1.0, 1.0)?;
            for leader in &mut follower.leaders {
                let Term { particle, weight } = *leader;
                if weight < -check::WEIGHT_TOLERANCE {
                    let follower = follower.particle;
                    return Err(ResponseError::LeaderWeight { follower, leader: particle, weight });
                }
                leader.weight = weight.max(0.0);
                let is_free = particles.binary_search(&leader.particle).is_err();
                let value = f64::from(leader.particle);
                check::parameter("leader", value, "no follower itself", is_free)?;
            }
        }
        Ok(Self(followers))
    }

    /// Returns the followers.
    #[must_use]
    pub fn as_slice(&self) -> &[Follower] {
        &self.0
    }

    /// Checks that all particles exist.
    pub(crate) fn check(&self, particle_count: usize) -> Result<(), ResponseError> {
        for (number, Follower { particle, leaders }) in self.0.iter().enumerate() {
            let leaders = leaders.iter().map(|leader| leader.particle);
            check::particle_range(number, leaders.chain([*particle]), particle_count)?;
        }
        Ok(())
    }

    /// Marks the particles that move with others: followers that can move and have no contact
    /// of their own.
    pub(crate) fn mark(
        &self,
        inverse_mass: &[f64],
        contacts: &ContactSet,
        follows: &mut Vec<bool>,
    ) {
        // All that can move, then without those in contact.
        follows.clear();
        follows.resize(inverse_mass.len(), false);
        for Follower { particle, .. } in &self.0 {
            follows[*particle as usize] = inverse_mass[*particle as usize] > 0.0;
        }
        for term in contacts.contacts().iter().flat_map(|contact| contact.stencil.terms()) {
            follows[term.particle as usize] = false;
        }
    }

    /// Computes inverse masses in which each particle has its part of its followers' masses.
    pub(crate) fn lump(&self, inverse_mass: &[f64], follows: &[bool], lumped: &mut Vec<f64>) {
        lumped.clear();
        lumped.extend_from_slice(inverse_mass);
        for Follower { particle, leaders } in self.following(follows) {
            for leader in leaders {
                // 1 / (m + share of the follower's mass), and 0 stays 0.
                let own = &mut lumped[leader.particle as usize];
                *own /= 1.0 + *own * leader.weight / inverse_mass[*particle as usize];
            }
        }
    }

    /// Computes the offset of each follower from where its leaders are.
    pub(crate) fn compute_offsets(&self, x: &[DVec3], offsets: &mut Vec<DVec3>) {
        offsets.clear();
        for Follower { particle, leaders } in &self.0 {
            let mut offset = x[*particle as usize];
            for leader in leaders {
                offset -= leader.weight * x[leader.particle as usize];
            }
            offsets.push(offset);
        }
    }

    /// Sums, per particle, the offsets of those that follow it, times their masses and weights.
    pub(crate) fn sum_offsets(
        &self,
        inverse_mass: &[f64],
        follows: &[bool],
        offsets: &[DVec3],
        sums: &mut Vec<DVec3>,
    ) {
        sums.clear();
        if self.0.is_empty() {
            return;
        }
        sums.resize(inverse_mass.len(), DVec3::ZERO);
        for (Follower { particle, leaders }, offset) in self.0.iter().zip(offsets) {
            if !follows[*particle as usize] {
                continue;
            }
            let mass = inverse_mass[*particle as usize].recip();
            for leader in leaders {
                sums[leader.particle as usize] += leader.weight * mass * *offset;
            }
        }
    }

    /// Adds to each follower the changes of its leaders since `before`.
    pub(crate) fn follow(&self, follows: &[bool], before: &[DVec3], q: &mut [DVec3]) {
        for Follower { particle, leaders } in self.following(follows) {
            for Term { particle: leader, weight } in leaders {
                let change = q[*leader as usize] - before[*leader as usize];
                q[*particle as usize] += *weight * change;
            }
        }
    }

    fn following(&self, follows: &[bool]) -> impl Iterator<Item = &Follower> {
        self.0.iter().filter(move |follower| follows[follower.particle as usize])
    }
}
