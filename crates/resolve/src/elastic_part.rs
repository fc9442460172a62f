//! Part of an elastic problem that is of one body: the tissue that takes part, with all that holds it.

use glam::DVec3;
use proximity::SurfaceTree;
use scene::Body;
use surface::progress::{Interrupted, Progress};

use crate::elastic::{ActiveParticle, Bond, ElasticProblem};
use crate::tissue::Tissue;

impl Tissue {
    /// Finds the vertices around `seeds` and all that are displaced, ascending.
    pub(crate) fn active_vertices(
        &mut self,
        mut seeds: Vec<u32>,
        displacements: &[DVec3],
        tree: &SurfaceTree,
        length: f64,
        progress: Progress<'_>,
    ) -> Result<Vec<u32>, Interrupted> {
        seeds.sort_unstable();
        seeds.dedup();
        let mut active = self.vertices_around(&seeds, tree, length, progress)?;
        active.extend(seeds);
        for (vertex, displacement) in (0..).zip(displacements) {
            if *displacement != DVec3::ZERO {
                active.push(vertex);
            }
        }
        active.sort_unstable();
        active.dedup();
        Ok(active)
    }

    /// Makes the part of a problem that is of the body: its active vertices, with all that holds them.
    pub(crate) fn elastic_part(&self, body: &Body, active: &[u32], length: f64) -> ElasticProblem {
        let mut problem = ElasticProblem { missing_volumes: vec![0.0], ..Default::default() };
        if active.is_empty() {
            return problem;
        }
        let (x, first) = (body.positions(), body.particles().start);
        let mass_per_area = self.mass_per_area();
        for vertex in self.along_body(active) {
            if !self.is_free(vertex) {
                continue;
            }
            let mass = mass_per_area * self.area(vertex);
            let particle = ActiveParticle {
                particle: first + vertex,
                foundation: mass / (length * length),
                area: self.volume_gradient(vertex, x),
                ..ActiveParticle::default()
            };
            let links = self.links(vertex).iter().map(|link| {
                let mean = 0.5 * (mass + mass_per_area * self.area(link.neighbor));
                (first + link.neighbor, mean * link.stiffness)
            });
            problem.push(particle, links);
            if let Some(strut) = self.strut(vertex) {
                let corners = strut.corners.into_iter().zip(strut.weights);
                let corners = corners.map(|(corner, weight)| (first + corner, -weight));
                let terms = std::iter::once((first + vertex, 1.0)).chain(corners).collect();
                problem.bonds.push(Bond { terms, stiffness: mass * strut.stiffness });
            }
        }

        if let Some(volume) = self.volume {
            problem.missing_volumes[0] = volume - self.volume_at(x);
        }
        problem
    }

    /// Orders vertices along a line through the body, between two that are far from each other at rest.
    fn along_body(&self, vertices: &[u32]) -> Vec<u32> {
        let x = |vertex: u32| self.rest[vertex as usize];
        let farthest_from = |from: DVec3| {
            let (mut farthest, mut distance) = (from, 0.0);
            for &vertex in vertices {
                let other = x(vertex).distance_squared(from);
                if other > distance {
                    (farthest, distance) = (x(vertex), other);
                }
            }
            farthest
        };
        let from = vertices.first().map_or(DVec3::ZERO, |first| farthest_from(x(*first)));
        let along = farthest_from(from) - from;

        let place = |vertex: u32| ((x(vertex) - from).dot(along), vertex);
        let mut ordered: Vec<(f64, u32)> = vertices.iter().map(|vertex| place(*vertex)).collect();
        ordered.sort_unstable_by(|(a, v), (b, w)| a.total_cmp(b).then(v.cmp(w)));
        ordered.into_iter().map(|(_, vertex)| vertex).collect()
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;

    use super::*;

    use crate::run::Run;
    use crate::test_scenes::bone_and_muscle;
    use crate::{Conditions, ResolveParams};

    #[test]
    fn particles_follow_each_other_along_the_body_however_its_vertices_are_numbered() {
        let axis = DVec3::new(1.0, 2.0, -3.0).normalize();
        let mut muscle = shapes::ellipsoid(DVec3::new(30.0, 5.0, 4.0), 3);
        muscle
            .positions
            .iter_mut()
            .for_each(|p| *p = glam::DQuat::from_rotation_arc(DVec3::X, axis) * *p);
        let bone = shapes::icosphere(1.0, 1).translated(DVec3::splat(90.0));
        let mut scene = bone_and_muscle(bone, muscle);
        let (params, conditions) = (ResolveParams::with_smoothing(6.0), Conditions::default());
        let run = Run::start(&mut scene, params, &conditions);
        let run = run.expect("a run");
        let (tissue, body) = (&run.tissues[1], &run.scene.bodies()[1]);

        // Every third vertex, in no order of space.
        let (first, end) = (body.particles().start, body.particles().end);
        let active: Vec<u32> = (0..end - first).step_by(3).collect();
        let problem = tissue.elastic_part(body, &active, 6.0);
        let along = |particle: u32| tissue.rest[(particle - first) as usize].dot(axis);
        let places: Vec<f64> =
            problem.particles.iter().map(|active| along(active.particle)).collect();
        assert_eq!(places.len(), active.len());
        let rises = places.windows(2).all(|pair| pair[0] <= pair[1] + 0.3);
        let falls = places.windows(2).all(|pair| pair[1] <= pair[0] + 0.3);
        assert!(rises || falls, "{places:?}");
    }
}
