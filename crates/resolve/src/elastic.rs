//! Least elastic energy under gaps: displacements of one round.
//!
//! Minimizes the energy of a displacement d over the vertices around all contacts,
//!
//! ```text
//! E(d) = ½ Σ_edges k |d_i − d_j|² + ½ Σ_bonds k |Σ w d|² + ½ Σ_vertices f |d_i|²
//! ```
//!
//! (a membrane with struts through the body on an elastic foundation, times the stiffness of the
//! body), subject to one linear inequality `n · Σ w d ≥ missing` per pair of near features and one
//! linear equality per body, that of its volume.
//!
//! Solved by the augmented Lagrangian method. Its inner problem is relaxed by block Gauss–Seidel,
//! one vertex at a time with all its rows, forward and backward in turn; parts of bodies that have nothing
//! in common side by side.
//!
//! Source: M. R. Hestenes, "Multiplier and gradient methods", Journal of Optimization Theory and
//! Applications 4, 1969, and R. T. Rockafellar's form for inequalities (1973). The order of
//! relaxation is that of A. H. Chen et al., "Vertex Block Descent", ACM TOG 43(4), 2024.

use arrayvec::ArrayVec;
use glam::DVec3;

/// Weight of a particle in an opening below which it only holds. Below, a corner next to one that stays
/// is thrown far for a little; above, less is opened in a round.
const MIN_LEVER: f64 = 0.01;

/// Largest number of particles in an opening: the corners of two faces.
pub(crate) const MAX_TERMS: usize = 6;

/// Particles with their weights.
pub(crate) type Terms = ArrayVec<(u32, f64), MAX_TERMS>;

/// Linear inequality on the displacements of a few particles.
#[derive(Clone, Debug)]
pub(crate) struct GapRow {
    /// Particles that can move, with their weights in the opening of the gap.
    pub(crate) terms: Terms,
    /// Unit direction in which the gap opens.
    pub(crate) normal: DVec3,
    /// Opening that is missing; negative where the gap is wider than asked.
    pub(crate) missing: f64,
}

/// Elastic bond between a few particles, at rest where their weighted displacements cancel.
#[derive(Clone, Debug)]
pub(crate) struct Bond {
    pub(crate) terms: Terms,
    pub(crate) stiffness: f64,
}

/// Particle that takes part in a round.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ActiveParticle {
    pub(crate) particle: u32,
    /// End of its part of all links, which begins where that of the particle before ends.
    pub(crate) links_end: usize,
    /// Stiffness of the link to its own place.
    pub(crate) foundation: f64,
    /// Gradient of the body's volume with respect to the particle.
    pub(crate) area: DVec3,
    /// Body, by its number.
    pub(crate) body: usize,
}

/// Gradient of the volume of one more body with respect to a particle that is of several.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SharedArea {
    pub(crate) particle: u32,
    /// Body, by its number.
    pub(crate) body: usize,
    pub(crate) area: DVec3,
}

/// Problem of one round.
#[derive(Debug, Default)]
pub(crate) struct ElasticProblem {
    /// Body by body, along each, so that particles near in the list are near in the body.
    pub(crate) particles: Vec<ActiveParticle>,
    /// Links of all particles to others, with their stiffness.
    pub(crate) links: Vec<(u32, f64)>,
    pub(crate) rows: Vec<GapRow>,
    pub(crate) bonds: Vec<Bond>,
    /// Areas in bodies other than their own, in the order of the particles.
    pub(crate) shared_areas: Vec<SharedArea>,
    /// Volume that each body is to gain.
    pub(crate) missing_volumes: Vec<f64>,
}

impl GapRow {
    /// Returns a row that is not in force.
    pub(crate) fn new(terms: Terms, normal: DVec3, missing: f64) -> Self {
        Self { terms, normal, missing }
    }

    /// Leaves out particles that are not active. Where that leaves next to no lever, the others hold what
    /// the displacements `u` have opened: to open more they would go far.
    pub(crate) fn keep_active(&mut self, is_active: impl Fn(u32) -> bool, u: &[DVec3]) {
        self.terms.retain(|&mut (particle, _)| is_active(particle));
        if self.terms.iter().all(|(_, weight)| weight.abs() < MIN_LEVER) {
            self.missing = self.missing.min(self.opening_by(u));
        }
    }

    /// Computes the opening by the displacements `u` of all particles.
    pub(crate) fn opening_by(&self, u: &[DVec3]) -> f64 {
        let mut opening = 0.0;
        for &(particle, weight) in &self.terms {
            opening += weight * self.normal.dot(u[particle as usize]);
        }
        opening
    }
}

impl ElasticProblem {
    /// Adds a particle with its links to others.
    pub(crate) fn push(
        &mut self,
        active: ActiveParticle,
        links: impl IntoIterator<Item = (u32, f64)>,
    ) {
        self.links.extend(links);
        self.particles.push(ActiveParticle { links_end: self.links.len(), ..active });
    }

    /// Adds the particles of the next bodies, with all that holds them.
    pub(crate) fn extend(&mut self, bodies: Vec<Self>) {
        // Reserved at once: lists are long.
        self.particles.reserve(bodies.iter().map(|body| body.particles.len()).sum());
        self.links.reserve(bodies.iter().map(|body| body.links.len()).sum());
        self.bonds.reserve(bodies.iter().map(|body| body.bonds.len()).sum());
        for part in bodies {
            let (body, first) = (self.missing_volumes.len(), self.links.len());
            let placed = |active: ActiveParticle| {
                let links_end = first + active.links_end;
                ActiveParticle { body, links_end, ..active }
            };
            self.particles.extend(part.particles.into_iter().map(placed));
            self.links.extend(part.links);
            self.bonds.extend(part.bonds);
            self.missing_volumes.extend(part.missing_volumes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Builds a particle on a foundation.
    fn held(particle: u32, foundation: f64) -> ActiveParticle {
        ActiveParticle { particle, foundation, ..ActiveParticle::default() }
    }

    /// Builds a row upward.
    fn row(terms: &[(u32, f64)], missing: f64) -> GapRow {
        GapRow::new(terms.iter().copied().collect(), DVec3::Z, missing)
    }

    #[test]
    fn two_particles_share_a_gap_by_stiffness() {
        let mut problem = ElasticProblem { missing_volumes: vec![0.0], ..Default::default() };
        problem.particles = vec![held(0, 1.0), held(1, 3.0)];
        problem.rows = vec![row(&[(0, 1.0), (1, -1.0)], 0.4)];
        let d = problem.minimize(&[DVec3::ZERO; 2], 60, 1e-12, 2.0);
        // Forces are equal: displacements are as 3 to 1.
        assert!((d[0] - 0.3 * DVec3::Z).length() < 1e-3, "{d:?}");
        assert!((d[1] + 0.1 * DVec3::Z).length() < 1e-3, "{d:?}");
    }

    #[test]
    fn a_gap_that_is_wide_enough_moves_nothing() {
        let mut problem = ElasticProblem { missing_volumes: vec![0.0], ..Default::default() };
        problem.particles = vec![held(0, 1.0)];
        problem.rows = vec![row(&[(0, 1.0)], -0.1)];
        assert_eq!(problem.minimize(&[DVec3::ZERO; 1], 60, 1e-12, 2.0), [DVec3::ZERO]);
    }

    #[test]
    fn a_corner_without_a_lever_is_not_thrown_far() {
        let mut problem = ElasticProblem { missing_volumes: vec![0.0], ..Default::default() };
        problem.particles = vec![held(0, 1.0)];
        for particle in [0, 1] {
            // The second particle is at the foot, and stays.
            problem.rows.push(row(&[(0, 1e-9), (particle, 1e-9), (1, 1.0)], 1e-5));
        }
        let d = problem.minimize(&[DVec3::ZERO; 2], 60, 1e-12, 0.25);
        assert_eq!(d, [DVec3::ZERO; 2]);
    }

    #[test]
    fn rows_that_contradict_each_other_throw_nothing() {
        // One row asks for more than many others allow.
        let mut problem = ElasticProblem { missing_volumes: vec![0.0], ..Default::default() };
        problem.particles = vec![held(0, 1.0)];
        problem.rows = vec![row(&[(0, 1.0)], 0.05)];
        for tilt in -8..=8 {
            let normal = DVec3::new(0.02 * f64::from(tilt), 0.0, -1.0).normalize();
            problem.rows.push(GapRow { normal, ..row(&[(0, 1.0)], -0.001) });
        }
        let d = problem.minimize(&[DVec3::ZERO], 20, 1e-12, 0.5);
        assert!(d[0].z > -0.001 && d[0].length() < 0.02, "{d:?}");
    }

    #[test]
    fn what_was_displaced_too_far_comes_back() {
        // A chain whose first particle is held out by its row, and whose second is out too far.
        let mut problem = ElasticProblem { missing_volumes: vec![0.0], ..Default::default() };
        problem.push(held(0, 1.0), [(1, 1.0)]);
        problem.push(held(1, 1.0), [(0, 1.0)]);
        problem.rows = vec![row(&[(0, 1.0)], 0.0)];
        let displaced = [DVec3::Z, 3.0 * DVec3::Z];
        let d = problem.minimize(&displaced, 60, 1e-12, 2.0);
        assert!(d[0].length() < 1e-3, "{d:?}");
        assert!((d[1] + 2.5 * DVec3::Z).length() < 1e-3, "back to half of the first: {d:?}");
    }

    #[test]
    fn a_volume_is_given_back_where_no_row_pushes() {
        let mut problem = ElasticProblem { missing_volumes: vec![0.0], ..Default::default() };
        for particle in 0..4 {
            problem.particles.push(ActiveParticle { area: DVec3::Z, ..held(particle, 1.0) });
        }
        problem.rows = vec![row(&[(0, -1.0)], 0.3)];
        let d = problem.minimize(&[DVec3::ZERO; 4], 60, 1e-9, 2.0);
        let gained: f64 = d.iter().map(|d| d.z).sum();
        assert!((d[0].z + 0.3).abs() < 1e-6 && gained.abs() < 1e-4, "{d:?}");
        assert!((d[1].z - 0.1).abs() < 1e-4, "{d:?}");
    }

    #[test]
    fn parts_of_a_body_gain_its_volume_together() {
        // A chain of many parts with hardly any foundation: each would gain all by itself.
        let count = 9000;
        let mut problem =
            ElasticProblem { missing_volumes: vec![1.0], ..ElasticProblem::default() };
        for particle in 0..count {
            let mut active = ActiveParticle { particle, foundation: 1e-3, ..Default::default() };
            active.area = DVec3::Z;
            let next = [particle.wrapping_sub(1), particle + 1].into_iter();
            problem.push(active, next.filter(|next| *next < count).map(|next| (next, 1.0)));
        }
        let steps = problem.minimize(&vec![DVec3::ZERO; count as usize], 20, 0.0, 0.5);
        let gained: f64 = steps.iter().map(|step| step.z).sum();
        assert!((gained - 1.0).abs() < 0.01, "{gained}");
    }
}
