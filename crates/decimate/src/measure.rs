//! A surface after some collapses, measured against the full one.
//!
//! The collapses tell where to look. A vertex that has gone is near the faces around
//! the vertex that it has moved into, or around a next one; and many faces of the
//! coarser surface are still what they were.

use glam::DVec3;
use kdop::Tree;
use surface::{TriangleSurface, closest_on_triangle};

use crate::one_sided::{Aim, largest};
use crate::prefix::Prefix;
use crate::triangles::{Target, Triangles};
use crate::{DecimateError, Deviation};

/// Both surfaces with what distances between them need.
pub(crate) struct Measure<'a> {
    full: Target<'a>,
    prefix: &'a Prefix,
    reduced: TriangleSurface,
    x_reduced: Vec<DVec3>,
    tree_reduced: Tree,
}

impl<'a> Measure<'a> {
    pub(crate) fn new(
        full: Triangles<'a>,
        tree: &'a Tree,
        prefix: &'a Prefix,
    ) -> Result<Self, DecimateError> {
        let reduced = TriangleSurface::new(prefix.kept.len(), prefix.faces.clone())?;
        let x_reduced: Vec<DVec3> = prefix.kept.iter().map(|v| full.x[*v as usize]).collect();
        let tree_reduced = Triangles { faces: reduced.faces(), x: &x_reduced }.tree()?;
        let full = Target { triangles: full, tree };
        Ok(Self { full, prefix, reduced, x_reduced, tree_reduced })
    }

    /// The deviation as well as `aim` wants it; infinite where it is larger.
    pub(crate) fn deviation(&self, aim: Aim) -> Deviation {
        let reduced = Triangles { faces: self.reduced.faces(), x: &self.x_reduced };
        let target = Target { triangles: reduced, tree: &self.tree_reduced };
        let near = self.near_vertices(&target);
        let full = &self.full.triangles;
        let hints = |face: usize| full.faces[face].map(|v| near[v as usize]);
        let full_to_reduced = largest(full, &target, hints, aim);
        if full_to_reduced.at_most > aim.at_most {
            return Deviation { full_to_reduced, reduced_to_full: full_to_reduced };
        }
        let hints = |face: usize| [self.prefix.sources[face]; 3];
        let reduced_to_full = largest(&reduced, &self.full, hints, aim);
        Deviation { full_to_reduced, reduced_to_full }
    }

    /// For each vertex of the full surface a face of the reduced one that is near.
    fn near_vertices(&self, target: &Target<'_>) -> Vec<u32> {
        let mut places = vec![u32::MAX; self.prefix.moved_into.len()];
        for (place, &vertex) in (0_u32..).zip(&self.prefix.kept) {
            places[vertex as usize] = place;
        }
        let near = |(p, into): (&DVec3, &u32)| match places[*into as usize] {
            u32::MAX => 0, // no face uses it
            place => self.near(target, *p, place),
        };
        self.full.triangles.x.iter().zip(&self.prefix.moved_into).map(near).collect()
    }

    /// The nearest face around a vertex of the reduced surface, or around the next
    /// while that brings it nearer.
    fn near(&self, target: &Target<'_>, p: DVec3, vertex: u32) -> u32 {
        let mut best = (f64::INFINITY, 0, vertex);
        loop {
            let (known, _, around) = best;
            for &face in self.reduced.vertex_faces(around) {
                let foot = closest_on_triangle(p, target.triangles.corners(face));
                let distance = foot.point.distance_squared(p);
                if distance < best.0 {
                    let corner = greatest(foot.barycentric);
                    best = (distance, face, self.reduced.faces()[face as usize][corner]);
                }
            }
            if best.2 == around || best.0 >= known || best.0 <= 0.0 {
                return best.1;
            }
        }
    }
}

fn greatest([x, y, z]: [f64; 3]) -> usize {
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}
