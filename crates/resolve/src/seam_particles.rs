//! Particles of an elastic problem that are at one point of a seam, made one.

use crate::elastic::{ActiveParticle, ElasticProblem, SharedArea, Terms};
use crate::seams::{Seams, merged_terms};

impl ElasticProblem {
    /// Makes one particle of all at each point of a seam that are active: with the links, foundations, rows and bonds
    /// of all of them, and with its part of the volume of each of their bodies.
    pub(crate) fn join_seams(&mut self, seams: &Seams) {
        if seams.is_empty() {
            return;
        }
        let members = self.members(seams);
        let joined = |particle: u32| {
            let first = seams.point_of(particle).and_then(|point| members[point].first());
            first.map_or(particle, |first| self.particles[*first].particle)
        };
        let merge = |terms: &Terms| merged_terms(terms.iter().copied(), joined);
        let rows: Vec<Terms> = self.rows.iter().map(|row| merge(&row.terms)).collect();
        let bonds: Vec<Terms> = self.bonds.iter().map(|bond| merge(&bond.terms)).collect();

        // Particles in their order, each with all that is of others at its point.
        let mut whole = Self::default();
        for (number, active) in self.particles.iter().enumerate() {
            let own = [number];
            let point = seams.point_of(active.particle);
            let together = point.map_or(&own[..], |point| &members[point]);
            if together[0] == number {
                self.push_joined(together, joined, &mut whole);
            }
        }
        self.particles = whole.particles;
        self.links = whole.links;
        self.shared_areas = whole.shared_areas;
        for (row, terms) in self.rows.iter_mut().zip(rows) {
            row.terms = terms;
        }
        for (bond, terms) in self.bonds.iter_mut().zip(bonds) {
            bond.terms = terms;
        }
    }

    /// Lists the numbers of the active particles at each point.
    fn members(&self, seams: &Seams) -> Vec<Vec<usize>> {
        let mut members = vec![Vec::new(); seams.points().len()];
        for (number, active) in self.particles.iter().enumerate() {
            if let Some(point) = seams.point_of(active.particle) {
                members[point].push(number);
            }
        }
        members
    }

    /// Adds the first of some particles to another problem, with all that holds any of them.
    fn push_joined(&self, together: &[usize], joined: impl Fn(u32) -> u32, whole: &mut Self) {
        let mut one = self.particles[together[0]];
        let mut links = Vec::new();
        for &number in together {
            let first = if number == 0 { 0 } else { self.particles[number - 1].links_end };
            for &(next, stiffness) in &self.links[first..self.particles[number].links_end] {
                links.push((joined(next), stiffness));
            }
        }
        for &number in &together[1..] {
            let ActiveParticle { foundation, area, body, .. } = self.particles[number];
            one.foundation += foundation;
            if body == one.body {
                one.area += area;
            } else {
                whole.shared_areas.push(SharedArea { particle: one.particle, body, area });
            }
        }
        links.retain(|(next, _)| *next != one.particle);
        whole.push(one, links);
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::elastic::{Bond, GapRow};
    use crate::seams::Seams;

    const COUNT: u32 = 8;

    /// Builds a problem of rows of particles, one per body, with links between neighbors and volumes along z. Row by
    /// row, the particle in the `middle` is pushed down and its neighborhood aside.
    fn chains(bodies: &[&[u32]], middle: u32) -> ElasticProblem {
        let mut parts = Vec::new();
        for particles in bodies {
            let mut part = ElasticProblem { missing_volumes: vec![0.0], ..Default::default() };
            for (place, &particle) in particles.iter().enumerate() {
                // Half of what is in the middle is of either body.
                let is_half = bodies.len() == 2 && [3, 4].contains(&particle);
                let foundation = if is_half { 0.5 } else { 1.0 };
                let area = foundation * DVec3::Z;
                let active = ActiveParticle { particle, foundation, area, ..Default::default() };
                let next = [place.checked_sub(1), Some(place + 1)].into_iter().flatten();
                let links = next.filter_map(|next| Some((*particles.get(next)?, 2.0)));
                part.push(active, links);
            }
            parts.push(part);
        }
        let mut problem = ElasticProblem::default();
        problem.extend(parts);
        problem.rows = vec![
            GapRow::new([(middle, 1.0)].into_iter().collect(), -DVec3::Z, 0.3),
            GapRow::new([(3, 0.5), (2, 0.5)].into_iter().collect(), DVec3::X, 0.1),
        ];
        let strut = [(1, 1.0), (middle, -0.4), (6, -0.6)].into_iter().collect();
        problem.bonds = vec![Bond { terms: strut, stiffness: 0.7 }];
        problem
    }

    /// Solves a problem by many sweeps.
    fn solve(mut problem: ElasticProblem, seams: &Seams) -> Vec<DVec3> {
        problem.join_seams(seams);
        let mut steps = problem.minimize(&[DVec3::ZERO; COUNT as usize], 400, -1.0, 0.5);
        seams.follow(&mut steps);
        steps
    }

    #[test]
    fn bodies_with_a_common_particle_move_as_one() {
        let seams = Seams::of_points(vec![vec![3, 4]], COUNT);
        let mut two = chains(&[&[0, 1, 2, 3], &[4, 5, 6, 7]], 4);
        let mut one = chains(&[&[0, 1, 2, 3, 5, 6, 7]], 3);

        // Without volumes, which two bodies have of their own.
        for problem in [&mut two, &mut one] {
            for active in &mut problem.particles {
                active.area = DVec3::ZERO;
            }
        }
        let (two, one) = (solve(two, &seams), solve(one, &Seams::default()));
        assert!(two[3] == two[4] && (two[3].z + 0.3).abs() < 1e-9, "{two:?}");
        for particle in [0, 1, 2, 3, 5, 6, 7] {
            let difference = two[particle].distance(one[particle]);
            assert!(difference < 1e-9, "{particle}: {} and {}", two[particle], one[particle]);
        }
    }

    #[test]
    fn both_bodies_keep_their_volumes_where_a_common_particle_moves() {
        let seams = Seams::of_points(vec![vec![3, 4]], COUNT);
        let problem = chains(&[&[0, 1, 2, 3], &[4, 5, 6, 7]], 4);
        let areas: Vec<f64> = problem.particles.iter().map(|active| active.area.z).collect();
        let steps = solve(problem, &seams);
        assert!((steps[4].z + 0.3).abs() < 1e-6, "{steps:?}");
        for body in [0..4, 4..8] {
            let gained: f64 = body.map(|particle| areas[particle] * steps[particle].z).sum();
            assert!(gained.abs() < 1e-6, "{gained} gained");
        }
    }
}
