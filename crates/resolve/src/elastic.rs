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
//! one vertex at a time with all its rows, forward and backward in turn.
//!
//! Source: M. R. Hestenes, "Multiplier and gradient methods", Journal of Optimization Theory and
//! Applications 4, 1969, and R. T. Rockafellar's form for inequalities (1973). The order of
//! relaxation is that of A. H. Chen et al., "Vertex Block Descent", ACM TOG 43(4), 2024.

use glam::{DMat3, DVec3};

use crate::tuning;

/// Linear inequality on the displacements of a few particles.
#[derive(Clone, Debug)]
pub(crate) struct GapRow {
    /// Particles that can move, with their weights in the opening of the gap.
    pub(crate) terms: Vec<(u32, f64)>,
    /// Unit direction in which the gap opens.
    pub(crate) normal: DVec3,
    /// Opening that is missing; negative where the gap is wider than asked.
    pub(crate) missing: f64,
    /// Force that keeps the gap open, `>= 0`.
    multiplier: f64,
    /// Stiffness of the augmented term.
    penalty: f64,
    /// Opening by the present displacement.
    opening: f64,
}

/// Elastic bond between a few particles, at rest where their weighted displacements cancel.
#[derive(Clone, Debug)]
pub(crate) struct Bond {
    pub(crate) terms: Vec<(u32, f64)>,
    pub(crate) stiffness: f64,
}

/// Particle that takes part in a round.
#[derive(Clone, Debug, Default)]
pub(crate) struct ActiveParticle {
    pub(crate) particle: u32,
    /// Links to other particles with their stiffness.
    pub(crate) links: Vec<(u32, f64)>,
    /// Stiffness of the link to its own place.
    pub(crate) foundation: f64,
    /// Gradient of the body's volume with respect to the particle.
    pub(crate) area: DVec3,
    /// Body, by its number.
    pub(crate) body: usize,
}

/// Volume of a body as an equality.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct VolumeRow {
    /// Volume to be gained.
    pub(crate) missing: f64,
    multiplier: f64,
    penalty: f64,
    gained: f64,
}

/// Problem of one round.
#[derive(Debug, Default)]
pub(crate) struct ElasticProblem {
    pub(crate) particles: Vec<ActiveParticle>,
    pub(crate) rows: Vec<GapRow>,
    pub(crate) bonds: Vec<Bond>,
    /// Per body.
    pub(crate) volumes: Vec<VolumeRow>,
}

/// Occurrence of a particle in a row or a bond.
#[derive(Clone, Copy, Debug)]
struct Occurrence {
    number: u32,
    weight: f64,
}

impl GapRow {
    /// Returns a row that is not in force.
    pub(crate) fn new(terms: Vec<(u32, f64)>, normal: DVec3, missing: f64) -> Self {
        Self { terms, normal, missing, multiplier: 0.0, penalty: 0.0, opening: 0.0 }
    }

    /// Returns the force at the present opening.
    fn force(&self) -> f64 {
        (self.multiplier + self.penalty * (self.missing - self.opening)).max(0.0)
    }
}

impl VolumeRow {
    pub(crate) fn new(missing: f64) -> Self {
        Self { missing, ..Self::default() }
    }

    fn force(&self) -> f64 {
        self.multiplier + self.penalty * (self.missing - self.gained)
    }
}

impl ElasticProblem {
    /// Computes the displacements of all `particle_count` particles; 0 for those that are not
    /// active.
    ///
    /// Ends when no row is missing more than `tolerance`.
    pub(crate) fn minimize(mut self, particle_count: usize, tolerance: f64) -> Vec<DVec3> {
        let mut d = vec![DVec3::ZERO; particle_count];
        let [of_rows, of_bonds] = self.occurrences(particle_count);
        let stiffness = self.diagonal(&of_bonds, particle_count);
        self.set_penalties(&stiffness);

        // Multipliers follow the rows after every sweep: inexact, but each sweep counts.
        for sweep in 0..tuning::GAP_SWEEPS {
            for step in 0..self.particles.len() {
                let last = self.particles.len() - 1;
                let i = if sweep % 2 == 0 { step } else { last - step };
                self.relax(i, &stiffness, &of_rows, &of_bonds, &mut d);
            }
            let most_missing = self.update_multipliers();
            if sweep + 1 >= tuning::MIN_GAP_SWEEPS && most_missing <= tolerance {
                break;
            }
        }
        d
    }

    /// Lists the rows and the bonds of each particle.
    fn occurrences(&self, particle_count: usize) -> [Vec<Vec<Occurrence>>; 2] {
        let mut of_rows = vec![Vec::new(); particle_count];
        for (number, row) in (0..).zip(&self.rows) {
            for &(particle, weight) in &row.terms {
                of_rows[particle as usize].push(Occurrence { number, weight });
            }
        }
        let mut of_bonds = vec![Vec::new(); particle_count];
        for (number, bond) in (0..).zip(&self.bonds) {
            for &(particle, weight) in &bond.terms {
                of_bonds[particle as usize].push(Occurrence { number, weight });
            }
        }
        [of_rows, of_bonds]
    }

    /// Sums the elastic stiffness at each particle; 0 for those that are not active.
    fn diagonal(&self, of_bonds: &[Vec<Occurrence>], particle_count: usize) -> Vec<f64> {
        let mut diagonal = vec![0.0; particle_count];
        for active in &self.particles {
            let mut stiffness = active.foundation;
            for (_, link) in &active.links {
                stiffness += link;
            }
            for bond in &of_bonds[active.particle as usize] {
                let of_bond = self.bonds[bond.number as usize].stiffness;
                stiffness += of_bond * bond.weight * bond.weight;
            }
            diagonal[active.particle as usize] = stiffness;
        }
        diagonal
    }

    /// Sets the stiffness of each row's augmented term in proportion to what it moves.
    fn set_penalties(&mut self, stiffness: &[f64]) {
        for row in &mut self.rows {
            let mut compliance = 0.0;
            row.terms.retain(|(particle, _)| stiffness[*particle as usize] > 0.0);
            for &(particle, weight) in &row.terms {
                compliance += weight * weight / stiffness[particle as usize];
            }
            row.penalty = if compliance > 0.0 { tuning::GAP_PENALTY / compliance } else { 0.0 };
        }

        let mut compliances = vec![0.0; self.volumes.len()];
        for active in &self.particles {
            let own = stiffness[active.particle as usize];
            if own > 0.0 {
                compliances[active.body] += active.area.length_squared() / own;
            }
        }
        for (volume, compliance) in self.volumes.iter_mut().zip(compliances) {
            volume.penalty = if compliance > 0.0 { compliance.recip() } else { 0.0 };
        }
    }

    /// Moves one particle to where the energy is least while all others rest.
    fn relax(
        &mut self,
        i: usize,
        stiffness: &[f64],
        of_rows: &[Vec<Occurrence>],
        of_bonds: &[Vec<Occurrence>],
        d: &mut [DVec3],
    ) {
        let active = &self.particles[i];
        let own = active.particle as usize;
        if stiffness[own] <= 0.0 {
            return;
        }

        // Elastic forces.
        let mut force = -active.foundation * d[own];
        for &(next, link) in &active.links {
            force += link * (d[next as usize] - d[own]);
        }
        for bond in &of_bonds[own] {
            let Bond { terms, stiffness } = &self.bonds[bond.number as usize];
            let mut stretch = DVec3::ZERO;
            for &(particle, weight) in terms {
                stretch += weight * d[particle as usize];
            }
            force -= stiffness * bond.weight * stretch;
        }
        let mut hessian = DMat3::from_diagonal(DVec3::splat(stiffness[own]));

        // The volume, then rows in force.
        let volume = self.volumes[active.body];
        force += volume.force() * active.area;
        hessian += outer(active.area, volume.penalty);
        for occurrence in &of_rows[own] {
            let row = &self.rows[occurrence.number as usize];
            let push = row.force();
            if push > 0.0 {
                force += push * occurrence.weight * row.normal;
                hessian += outer(row.normal, row.penalty * occurrence.weight * occurrence.weight);
            }
        }

        // All that depends on the particle follows it.
        let step = hessian.inverse() * force;
        d[own] += step;
        self.volumes[active.body].gained += active.area.dot(step);
        for occurrence in &of_rows[own] {
            let row = &mut self.rows[occurrence.number as usize];
            row.opening += occurrence.weight * row.normal.dot(step);
        }
    }

    /// Adds what rows and volumes are missing to their forces; returns the largest part of a gap
    /// that is missing.
    fn update_multipliers(&mut self) -> f64 {
        let mut most: f64 = 0.0;
        for row in &mut self.rows {
            row.multiplier = row.force();
            if row.penalty > 0.0 {
                most = most.max(row.missing - row.opening);
            }
        }
        for volume in &mut self.volumes {
            volume.multiplier = volume.force();
        }
        most
    }
}

/// Returns `scale · v vᵀ`.
fn outer(v: DVec3, scale: f64) -> DMat3 {
    let scaled = scale * v;
    DMat3::from_cols(v.x * scaled, v.y * scaled, v.z * scaled)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Builds a particle on a foundation.
    fn held(particle: u32, foundation: f64) -> ActiveParticle {
        ActiveParticle { particle, foundation, ..ActiveParticle::default() }
    }

    #[test]
    fn two_particles_share_a_gap_by_stiffness() {
        let mut problem =
            ElasticProblem { volumes: vec![VolumeRow::new(0.0)], ..Default::default() };
        problem.particles = vec![held(0, 1.0), held(1, 3.0)];
        problem.rows = vec![GapRow::new(vec![(0, 1.0), (1, -1.0)], DVec3::Z, 0.4)];
        let d = problem.minimize(2, 1e-12);
        // Forces are equal: displacements are as 3 to 1.
        assert!((d[0] - 0.3 * DVec3::Z).length() < 1e-3, "{d:?}");
        assert!((d[1] + 0.1 * DVec3::Z).length() < 1e-3, "{d:?}");
    }

    #[test]
    fn a_gap_that_is_wide_enough_moves_nothing() {
        let mut problem =
            ElasticProblem { volumes: vec![VolumeRow::new(0.0)], ..Default::default() };
        problem.particles = vec![held(0, 1.0)];
        problem.rows = vec![GapRow::new(vec![(0, 1.0)], DVec3::Z, -0.1)];
        assert_eq!(problem.minimize(1, 1e-12), [DVec3::ZERO]);
    }

    #[test]
    fn a_volume_is_given_back_where_no_row_pushes() {
        let mut problem =
            ElasticProblem { volumes: vec![VolumeRow::new(0.0)], ..Default::default() };
        for particle in 0..4 {
            problem.particles.push(ActiveParticle { area: DVec3::Z, ..held(particle, 1.0) });
        }
        problem.rows = vec![GapRow::new(vec![(0, -1.0)], DVec3::Z, 0.3)];
        let d = problem.minimize(4, 1e-9);
        let gained: f64 = d.iter().map(|d| d.z).sum();
        assert!((d[0].z + 0.3).abs() < 1e-6 && gained.abs() < 1e-4, "{d:?}");
        assert!((d[1].z - 0.1).abs() < 1e-4, "{d:?}");
    }
}
