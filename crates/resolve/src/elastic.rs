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

/// Smallest number of sweeps, in which displacements spread over that many edges.
const MIN_GAP_SWEEPS: usize = 8;

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
    pub(crate) multiplier: f64,
    /// Stiffness of the augmented term.
    pub(crate) penalty: f64,
    /// Opening by the present displacement.
    pub(crate) opening: f64,
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

impl GapRow {
    /// Returns a row that is not in force.
    pub(crate) fn new(terms: Vec<(u32, f64)>, normal: DVec3, missing: f64) -> Self {
        Self { terms, normal, missing, multiplier: 0.0, penalty: 0.0, opening: 0.0 }
    }

    /// Computes the opening by the displacements `u` of all particles.
    pub(crate) fn opening_by(&self, u: &[DVec3]) -> f64 {
        let mut opening = 0.0;
        for &(particle, weight) in &self.terms {
            opening += weight * self.normal.dot(u[particle as usize]);
        }
        opening
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
    /// Computes the steps of all particles from their displacements `u` to those of least energy;
    /// 0 for those that are not active.
    ///
    /// Ends after `max_sweeps`, or when no row is missing more than `tolerance`. The `penalty` is the
    /// stiffness of each row's augmented term, relative to what it moves.
    pub(crate) fn minimize(
        self,
        u: &[DVec3],
        max_sweeps: usize,
        tolerance: f64,
        penalty: f64,
    ) -> Vec<DVec3> {
        let mut relaxation = Relaxation::new(self, u, penalty);
        let count = relaxation.particles.len();

        // Multipliers follow the rows after every sweep: inexact, but each sweep counts.
        for sweep in 0..max_sweeps {
            for step in 0..count {
                let i = if sweep % 2 == 0 { step } else { count - 1 - step };
                relaxation.relax(i);
            }
            let most_missing = relaxation.update_multipliers();
            if sweep + 1 >= MIN_GAP_SWEEPS && most_missing <= tolerance {
                break;
            }
        }

        let mut steps = vec![DVec3::ZERO; u.len()];
        for (active, displaced) in relaxation.particles.iter().zip(&relaxation.u) {
            steps[active.particle as usize] = *displaced - u[active.particle as usize];
        }
        steps
    }
}

/// Occurrence of a particle in a row or a bond.
#[derive(Clone, Copy, Debug, Default)]
struct Occurrence {
    number: u32,
    weight: f64,
}

/// Marks particles that are not active.
const INACTIVE: u32 = u32::MAX;

/// Problem with its particles numbered without gaps, and the state of its solution.
struct Relaxation {
    particles: Vec<RelaxedParticle>,
    /// Displacements of the active particles.
    u: Vec<DVec3>,
    /// Links to active particles, by their numbers.
    links: Vec<(u32, f64)>,
    rows: Vec<GapRow>,
    in_rows: Vec<Occurrence>,
    bonds: Vec<RelaxedBond>,
    in_bonds: Vec<Occurrence>,
    volumes: Vec<VolumeRow>,
}

/// Active particle with the ends of its parts of all lists, which begin where those of the particle
/// before end.
#[derive(Clone, Copy, Debug, Default)]
struct RelaxedParticle {
    particle: u32,
    body: usize,
    area: DVec3,
    /// Force of links to particles that are not active.
    pull: DVec3,
    /// Stiffness of links and foundation, and that of bonds too.
    own: f64,
    diagonal: f64,
    links_end: usize,
    rows_end: usize,
    bonds_end: usize,
}

/// Stiffness of a bond, and its stretch at the present displacements.
#[derive(Clone, Copy, Debug)]
struct RelaxedBond {
    stiffness: f64,
    stretch: DVec3,
}

impl Relaxation {
    fn new(problem: ElasticProblem, u: &[DVec3], penalty: f64) -> Self {
        let ElasticProblem { particles: active, mut rows, bonds, volumes } = problem;
        let mut numbers = vec![INACTIVE; u.len()];
        for (number, active) in (0..).zip(&active) {
            numbers[active.particle as usize] = number;
        }

        // Links between active particles; all others pull with a constant force.
        let mut particles = Vec::with_capacity(active.len());
        let mut links = Vec::new();
        for active in &active {
            let mut particle = RelaxedParticle {
                particle: active.particle,
                body: active.body,
                area: active.area,
                own: active.foundation,
                ..RelaxedParticle::default()
            };
            for &(next, stiffness) in &active.links {
                particle.own += stiffness;
                match numbers[next as usize] {
                    INACTIVE => particle.pull += stiffness * u[next as usize],
                    number => links.push((number, stiffness)),
                }
            }
            particle.diagonal = particle.own;
            particle.links_end = links.len();
            particles.push(particle);
        }

        // Particles that are not active do not change an opening.
        for row in &mut rows {
            row.terms.retain(|(particle, _)| numbers[*particle as usize] != INACTIVE);
        }
        let in_rows = occurrences(rows.iter().map(|row| &row.terms), &numbers, active.len());
        let in_bonds = occurrences(bonds.iter().map(|bond| &bond.terms), &numbers, active.len());
        let mut relaxed = Vec::with_capacity(bonds.len());
        for Bond { terms, stiffness } in &bonds {
            let mut stretch = DVec3::ZERO;
            for &(particle, weight) in terms {
                stretch += weight * u[particle as usize];
            }
            relaxed.push(RelaxedBond { stiffness: *stiffness, stretch });
        }
        for (i, particle) in particles.iter_mut().enumerate() {
            (particle.rows_end, particle.bonds_end) = (in_rows.ends[i], in_bonds.ends[i]);
            for bond in in_bonds.of(i) {
                let stiffness = relaxed[bond.number as usize].stiffness;
                particle.diagonal += stiffness * bond.weight * bond.weight;
            }
        }
        let mut relaxation = Self {
            u: particles.iter().map(|active| u[active.particle as usize]).collect(),
            particles,
            links,
            rows,
            in_rows: in_rows.all,
            bonds: relaxed,
            in_bonds: in_bonds.all,
            volumes,
        };
        relaxation.set_penalties(&numbers, penalty);
        relaxation
    }

    /// Sets the stiffness of each row's augmented term in proportion to what it moves.
    fn set_penalties(&mut self, numbers: &[u32], penalty: f64) {
        for row in &mut self.rows {
            let mut compliance = 0.0;
            for &(particle, weight) in &row.terms {
                let stiffness = self.particles[numbers[particle as usize] as usize].diagonal;
                if stiffness > 0.0 {
                    compliance += weight * weight / stiffness;
                }
            }
            row.penalty = if compliance > 0.0 { penalty / compliance } else { 0.0 };
        }

        let mut compliances = vec![0.0; self.volumes.len()];
        for active in &self.particles {
            if active.diagonal > 0.0 {
                compliances[active.body] += active.area.length_squared() / active.diagonal;
            }
        }
        for (volume, compliance) in self.volumes.iter_mut().zip(compliances) {
            volume.penalty = if compliance > 0.0 { compliance.recip() } else { 0.0 };
        }
    }

    /// Moves one particle to where the energy is least while all others rest.
    fn relax(&mut self, i: usize) {
        let active = self.particles[i];
        let before = if i == 0 { RelaxedParticle::default() } else { self.particles[i - 1] };
        if active.diagonal <= 0.0 {
            return;
        }

        // Elastic forces.
        let mut force = active.pull - active.own * self.u[i];
        for &(next, stiffness) in &self.links[before.links_end..active.links_end] {
            force += stiffness * self.u[next as usize];
        }
        let bonds = before.bonds_end..active.bonds_end;
        for occurrence in &self.in_bonds[bonds.clone()] {
            let bond = &self.bonds[occurrence.number as usize];
            force -= bond.stiffness * occurrence.weight * bond.stretch;
        }

        // The volume, then rows in force.
        let volume = &self.volumes[active.body];
        force += volume.force() * active.area;
        let mut hessian = DMat3::from_diagonal(DVec3::splat(active.diagonal));
        hessian += outer(active.area, volume.penalty);
        let rows = before.rows_end..active.rows_end;
        for occurrence in &self.in_rows[rows.clone()] {
            let row = &self.rows[occurrence.number as usize];
            let push = row.force();
            if push > 0.0 {
                force += push * occurrence.weight * row.normal;
                hessian += outer(row.normal, row.penalty * occurrence.weight * occurrence.weight);
            }
        }

        // All that depends on the particle follows it.
        let step = hessian.inverse() * force;
        self.u[i] += step;
        self.volumes[active.body].gained += active.area.dot(step);
        for occurrence in &self.in_bonds[bonds] {
            self.bonds[occurrence.number as usize].stretch += occurrence.weight * step;
        }
        for occurrence in &self.in_rows[rows] {
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

/// Occurrences of all active particles, one after the other (compressed sparse rows).
struct Occurrences {
    all: Vec<Occurrence>,
    ends: Vec<usize>,
}

impl Occurrences {
    fn of(&self, i: usize) -> &[Occurrence] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.all[start..self.ends[i]]
    }
}

/// Lists where each active particle occurs in the terms of rows or bonds.
fn occurrences<'t>(
    terms: impl Iterator<Item = &'t Vec<(u32, f64)>> + Clone,
    numbers: &[u32],
    count: usize,
) -> Occurrences {
    // Counted first, so that each list is filled in place.
    let mut ends = vec![0; count];
    for &(particle, _) in terms.clone().flatten() {
        let number = numbers[particle as usize];
        if number != INACTIVE {
            ends[number as usize] += 1;
        }
    }
    let mut total = 0;
    for end in &mut ends {
        (*end, total) = (total, total + *end);
    }

    // Each start moves to the end of its list.
    let mut all = vec![Occurrence::default(); total];
    for (number, terms) in (0..).zip(terms) {
        for &(particle, weight) in terms {
            let i = numbers[particle as usize];
            if i != INACTIVE {
                let end = &mut ends[i as usize];
                all[*end] = Occurrence { number, weight };
                *end += 1;
            }
        }
    }
    Occurrences { all, ends }
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
        let d = problem.minimize(&[DVec3::ZERO; 2], 60, 1e-12, 2.0);
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
        assert_eq!(problem.minimize(&[DVec3::ZERO; 1], 60, 1e-12, 2.0), [DVec3::ZERO]);
    }

    #[test]
    fn what_was_displaced_too_far_comes_back() {
        // A chain whose first particle is held out by its row, and whose second is out too far.
        let mut problem =
            ElasticProblem { volumes: vec![VolumeRow::new(0.0)], ..Default::default() };
        let mut chain = [held(0, 1.0), held(1, 1.0)];
        chain[0].links.push((1, 1.0));
        chain[1].links.push((0, 1.0));
        problem.particles = chain.to_vec();
        problem.rows = vec![GapRow::new(vec![(0, 1.0)], DVec3::Z, 0.0)];
        let displaced = [DVec3::Z, 3.0 * DVec3::Z];
        let d = problem.minimize(&displaced, 60, 1e-12, 2.0);
        assert!(d[0].length() < 1e-3, "{d:?}");
        assert!((d[1] + 2.5 * DVec3::Z).length() < 1e-3, "back to half of the first: {d:?}");
    }

    #[test]
    fn a_volume_is_given_back_where_no_row_pushes() {
        let mut problem =
            ElasticProblem { volumes: vec![VolumeRow::new(0.0)], ..Default::default() };
        for particle in 0..4 {
            problem.particles.push(ActiveParticle { area: DVec3::Z, ..held(particle, 1.0) });
        }
        problem.rows = vec![GapRow::new(vec![(0, -1.0)], DVec3::Z, 0.3)];
        let d = problem.minimize(&[DVec3::ZERO; 4], 60, 1e-9, 2.0);
        let gained: f64 = d.iter().map(|d| d.z).sum();
        assert!((d[0].z + 0.3).abs() < 1e-6 && gained.abs() < 1e-4, "{d:?}");
        assert!((d[1].z - 0.1).abs() < 1e-4, "{d:?}");
    }
}
