//! Distance of points of a surface outside a union of balls: the maximum of φ(p) over surface points
//! p, with φ the signed distance of the union.
//!
//! The distance `φ_s` of one primitive is convex, so on a triangle it is at most the maximum of its
//! values at the corners; φ is at most `φ_s` for any s. Where the corners have the same nearest
//! primitive, the bound is exact.

use glam::DVec3;
use kdop::Workspace;
use proximity::MaximumSearch;
use surface::DirectedHausdorff;
use surface::progress::{Interrupted, Progress};

use super::{search, split_all};
use crate::surface_distance::SurfaceDistance;
use crate::{FootRule, MedialSurface, NearestPrimitive, PrimitiveTree};

/// Corner of a piece of a face.
#[derive(Clone, Copy)]
struct Corner {
    p: DVec3,
    /// Nearest primitive.
    primitive: u32,
    /// Signed distance of that primitive.
    distance: f64,
}

/// Piece of a face.
type Patch = [Corner; 3];

pub(super) fn surface_to_medial(
    medial: &MedialSurface,
    tree: &PrimitiveTree,
    surface: &SurfaceDistance<'_>,
    nearest: &[NearestPrimitive],
    progress: Progress<'_>,
) -> Result<DirectedHausdorff, Interrupted> {
    // Whole faces first.
    let mut search = search(medial);
    for face in surface.surface.faces() {
        let patch = face.map(|vertex| {
            let NearestPrimitive { primitive, foot } = nearest[vertex as usize];
            Corner { p: surface.x.at(vertex), primitive, distance: foot.distance }
        });
        add(&mut search, medial, patch);
    }

    // Then quarters, by the middles of the sides.
    let mut workspace = Workspace::default();
    let mut middle = |from: &Corner, to: &Corner| {
        let p = from.p.midpoint(to.p);
        let nearest = tree.nearest_from(medial, p, from.primitive, &mut workspace);
        Corner { p, primitive: nearest.primitive, distance: nearest.foot.distance }
    };
    split_all(search, progress, |search, [a, b, c]| {
        let (ab, bc, ca) = (middle(&a, &b), middle(&b, &c), middle(&c, &a));
        for quarter in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            add(search, medial, quarter);
        }
    })
}

fn add(search: &mut MaximumSearch<Patch>, medial: &MedialSurface, patch: Patch) {
    for corner in &patch {
        search.evaluated(corner.distance);
    }
    search.add(upper_bound(medial, &patch), patch);
}

/// Computes the minimum over the corners' primitives of the maximum distance at a corner.
fn upper_bound(medial: &MedialSurface, patch: &Patch) -> f64 {
    let mut bound = f64::INFINITY;
    for &Corner { primitive, .. } in patch {
        let mut max = f64::NEG_INFINITY;
        for corner in patch {
            let distance = if corner.primitive == primitive {
                corner.distance
            } else {
                medial.foot(corner.p, primitive, FootRule::Exact).distance
            };
            max = max.max(distance);
        }
        bound = bound.min(max);
    }
    bound
}
