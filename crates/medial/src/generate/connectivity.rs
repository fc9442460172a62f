//! Connectivity of balls: neighbors that may merge, and the slabs and cones that faces become.

use std::collections::BTreeSet;

use glam::DVec3;

use super::shrink::MaximalBall;
use crate::surface_distance::SurfaceDistance;
use crate::{Ball, MedialError, MedialSurface, index};

/// Finds the balls that each ball may merge with: along the surface's edges, and across the sheet.
///
/// `owners` are the balls of the vertices.
pub(super) fn sheet_neighbors(
    distance: &SurfaceDistance<'_>,
    owners: &[u32],
    maximal: &[MaximalBall],
) -> Vec<Vec<u32>> {
    let mut neighbors = vec![Vec::new(); maximal.len()];
    let mut join = |i: u32, j: u32| {
        if i != j {
            neighbors[i as usize].push(j);
            neighbors[j as usize].push(i);
        }
    };

    // Along the edges.
    for edge in distance.surface.edges() {
        let [i, j] = edge.map(|vertex| owners[vertex as usize]);
        join(i, j);
    }

    // Across the sheet, with a vertex near the other point that a ball touches.
    for (i, maximal) in (0_u32..).zip(maximal) {
        if let Some(face) = maximal.opposite_face {
            let corner = nearest_corner(distance, face, maximal.opposite);
            join(i, owners[corner as usize]);
        }
    }

    for list in &mut neighbors {
        list.sort_unstable();
        list.dedup();
    }
    neighbors
}

/// Returns the corner of a face that is nearest to a point, the first of equals.
fn nearest_corner(distance: &SurfaceDistance<'_>, face: u32, p: DVec3) -> u32 {
    let [a, b, c] = distance.surface.faces()[face as usize];
    let [d_a, d_b, d_c] = distance.corners(face).map(|corner| corner.distance_squared(p));
    if d_a <= d_b && d_a <= d_c {
        a
    } else if d_b <= d_c {
        b
    } else {
        c
    }
}

/// Builds the medial surface that is left when every ball is replaced by the one that `into` names.
///
/// Balls are renumbered; `into` names itself for those that are left.
pub(super) fn merged(
    balls: &[Ball],
    faces: &[[u32; 3]],
    into: &[u32],
) -> Result<MedialSurface, MedialError> {
    // Balls that are left keep their order.
    let mut numbers = vec![u32::MAX; balls.len()];
    let mut left = Vec::new();
    for (ball, number) in numbers.iter_mut().enumerate() {
        if into[ball] as usize == ball {
            *number = index(left.len());
            left.push(balls[ball]);
        }
    }
    let renumbered = |ball: u32| numbers[into[ball as usize] as usize];
    joined(left, faces.iter().map(|corners| corners.map(renumbered)))
}

/// Builds a medial surface from triples of balls: slabs, and cones where two of the three are the
/// same, unless they are sides of slabs.
pub(super) fn joined(
    balls: Vec<Ball>,
    triples: impl Iterator<Item = [u32; 3]>,
) -> Result<MedialSurface, MedialError> {
    // Three different balls are a slab, two a cone, one nothing.
    let mut slabs = BTreeSet::new();
    let mut cones = BTreeSet::new();
    for mut triple in triples {
        triple.sort_unstable();
        let [a, b, c] = triple;
        match (a == b, b == c) {
            (false, false) => {
                slabs.insert([a, b, c]);
            }
            (true, true) => {}
            _ => {
                cones.insert([a, c]);
            }
        }
    }

    // A slab contains its sides.
    for &[a, b, c] in &slabs {
        for side in [[a, b], [b, c], [a, c]] {
            cones.remove(&side);
        }
    }
    MedialSurface::new(balls, cones.into_iter().collect(), slabs.into_iter().collect())
}
