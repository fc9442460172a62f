//! A surface after some collapses, measured against the full one.
//!
//! The collapses tell where to look. A vertex that has gone is near the faces around
//! the vertex that it has moved into, or around a next one; and many faces of the
//! coarser surface are still what they were.

use glam::DVec3;
use kdop::{Tree, Workspace};
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
    /// Of the reduced surface.
    tree: Tree,
    across: Vec<[u32; 3]>,
    /// For each vertex of the full surface a face of the reduced one that is near,
    /// and its distance.
    near: Vec<(u32, f64)>,
}

impl<'a> Measure<'a> {
    pub(crate) fn new(full: Target<'a>, prefix: &'a Prefix) -> Result<Self, DecimateError> {
        let reduced = TriangleSurface::new(prefix.kept.len(), prefix.faces.clone())?;
        let x_reduced: Vec<DVec3> =
            prefix.kept.iter().map(|v| full.triangles.x[*v as usize]).collect();
        let triangles = Triangles { surface: &reduced, x: &x_reduced };
        let (tree, across) = (triangles.tree()?, triangles.across());
        let mut measure = Self { full, prefix, reduced, x_reduced, tree, across, near: vec![] };
        measure.near = measure.near_vertices();
        Ok(measure)
    }

    /// The largest distance of a vertex of the full surface from the reduced one.
    pub(crate) fn farthest_vertex(&self) -> f64 {
        let (target, mut workspace) = (self.reduced(), Workspace::default());
        let mut farthest = 0.0;
        for (p, &(face, distance)) in self.full.triangles.x.iter().zip(&self.near) {
            if distance > farthest {
                farthest = target.nearest(*p, face, &mut workspace).1.max(farthest);
            }
        }
        farthest
    }

    /// The deviation as well as `aim` wants it; infinite where it is larger.
    pub(crate) fn deviation(&self, aim: Aim) -> Deviation {
        let (full, reduced) = (self.full.triangles, self.reduced());
        let hints = |face: usize| full.faces()[face].map(|v| self.near[v as usize].0);
        let full_to_reduced = largest(&full, &reduced, hints, aim);
        if full_to_reduced.upper > aim.at_most {
            return Deviation { full_to_reduced, reduced_to_full: full_to_reduced };
        }
        let hints = |face: usize| [self.prefix.sources[face]; 3];
        let reduced_to_full = largest(&reduced.triangles, &self.full, hints, aim);
        Deviation { full_to_reduced, reduced_to_full }
    }

    fn reduced(&self) -> Target<'_> {
        let triangles = Triangles { surface: &self.reduced, x: &self.x_reduced };
        Target { triangles, tree: &self.tree, across: &self.across }
    }

    fn near_vertices(&self) -> Vec<(u32, f64)> {
        let mut places = vec![u32::MAX; self.prefix.moved_into.len()];
        for (place, &vertex) in (0_u32..).zip(&self.prefix.kept) {
            places[vertex as usize] = place;
        }
        let triangles = self.reduced().triangles;
        let near = |(p, into): (&DVec3, &u32)| match places[*into as usize] {
            u32::MAX => (0, 0.0), // no face uses it
            place => near(&triangles, *p, place),
        };
        self.full.triangles.x.iter().zip(&self.prefix.moved_into).map(near).collect()
    }
}

/// The nearest face around a vertex, or around the next while that brings it nearer;
/// and its distance from `p`.
fn near(triangles: &Triangles<'_>, p: DVec3, vertex: u32) -> (u32, f64) {
    let mut best = (f64::INFINITY, 0, vertex);
    loop {
        let (known, _, around) = best;
        for &face in triangles.surface.vertex_faces(around) {
            let foot = closest_on_triangle(p, triangles.corners(face));
            let distance = foot.point.distance_squared(p);
            if distance < best.0 {
                let corner = greatest(foot.barycentric);
                best = (distance, face, triangles.faces()[face as usize][corner]);
            }
        }
        if best.2 == around || best.0 >= known || best.0 <= 0.0 {
            return (best.1, best.0.sqrt());
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
