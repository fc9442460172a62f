//! How far points of a surface are outside a union of balls: the largest φ(p) over
//! surface points p, with φ the signed distance of the union.
//!
//! The distance `φ_s` of one primitive is convex, so on a triangle it is at most
//! the largest of its corners' values; φ is at most `φ_s` for any s. Where the
//! corners have the same nearest primitive, the bound is exact.

use glam::DVec3;
use kdop::Workspace;
use surface::DirectedHausdorff;

use super::largest::{Largest, least_slack};
use crate::surface_distance::SurfaceDistance;
use crate::{FootRule, MedialSurface, NearestPrimitive, PrimitiveTree};

/// A piece of a face: its corners with their nearest primitives and distances.
type Patch = [(DVec3, u32, f64); 3];

pub(super) fn surface_to_medial(
    medial: &MedialSurface,
    tree: &PrimitiveTree,
    distance: &SurfaceDistance<'_>,
    nearest: &[NearestPrimitive],
) -> DirectedHausdorff {
    let mut workspace = Workspace::default();
    let mut search = Largest::new(least_slack(medial));
    let add = |search: &mut Largest<Patch>, patch: Patch| {
        let seen = patch.iter().map(|&(.., value)| value).fold(0.0, f64::max);
        search.add(seen, patch_bound(medial, &patch), || patch);
    };
    for corners in distance.surface.faces() {
        let corner = |vertex: u32| {
            let found = &nearest[vertex as usize];
            (distance.x.at(vertex), found.primitive, found.foot.distance)
        };
        add(&mut search, corners.map(corner));
    }
    search.run(|search, [a, b, c]| {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            let p = from.0.midpoint(to.0);
            let found = tree.nearest_from(medial, p, from.1, &mut workspace);
            (p, found.primitive, found.foot.distance)
        });
        for patch in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            add(search, patch);
        }
    })
}

/// The least over the corners' primitives of the largest distance at a corner.
fn patch_bound(medial: &MedialSurface, patch: &Patch) -> f64 {
    let largest = |primitive: u32| {
        let at = |&(p, own, value): &(DVec3, u32, f64)| {
            if own == primitive {
                value
            } else {
                medial.foot(p, primitive, FootRule::Exact).distance
            }
        };
        patch.iter().map(at).fold(f64::NEG_INFINITY, f64::max)
    };
    patch.iter().map(|&(_, primitive, _)| largest(primitive)).fold(f64::INFINITY, f64::min)
}
