//! Spreading of a push from some vertices to the tissue around them.
//!
//! Vertices that are not pushed take the displacement of a membrane on an elastic
//! foundation, `Δu = u / ℓ²` with the smoothing length ℓ. It fades along the surface, and is
//! cut to exactly 0 a few ℓ away. Struts take part, so that thin sheets move as one and keep
//! their volume.

use std::collections::VecDeque;

use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;

use crate::tissue::Tissue;
use crate::tuning;

/// Spreads a body's pushes in place; vertices that are not pushed hold 0.
pub(crate) fn spread(
    tree: &SurfaceTree,
    tissue: &mut Tissue,
    pushes: &mut [DVec3],
    smoothing: f64,
    workspace: &mut Workspace,
) {
    let pushed: Vec<u32> =
        (0..).zip(&*pushes).filter(|(_, push)| **push != DVec3::ZERO).map(|(v, _)| v).collect();
    if pushed.is_empty() {
        return;
    }

    // The distance to spread over grows with the push, so that no tissue strains more.
    let radius = smoothing.max(max_displacement(tree, tissue, pushes) / tuning::MAX_SLOPE);
    let free = vertices_around(tree, tissue, &pushed, radius, workspace);
    let foundation = (radius * radius).recip();
    symmetric_sweeps(&free, tuning::SPREAD_SWEEPS, |&v| {
        if let Some(u) = tissue.equilibrium(v, |next| pushes[next as usize], foundation) {
            pushes[v as usize] = u;
        }
    });

    let strongest = pushed.iter().map(|&v| pushes[v as usize].length()).fold(0.0, f64::max);
    for v in free {
        if pushes[v as usize].length() < tuning::MIN_SPREAD * strongest {
            pushes[v as usize] = DVec3::ZERO;
        }
    }
}

/// Relaxes all items `sweeps` times, forward and backward in turn (symmetric Gauss–Seidel).
pub(crate) fn symmetric_sweeps<T>(items: &[T], sweeps: usize, mut relax: impl FnMut(&T)) {
    for sweep in 0..sweeps {
        if sweep % 2 == 0 {
            items.iter().for_each(&mut relax);
        } else {
            items.iter().rev().for_each(&mut relax);
        }
    }
}

/// Returns the largest distance from rest of a pushed vertex, with its push.
fn max_displacement(tree: &SurfaceTree, tissue: &Tissue, pushes: &[DVec3]) -> f64 {
    let places = tree.positions().as_slice().iter().zip(&tissue.rest).zip(pushes);
    let pushed = places.filter(|(_, push)| **push != DVec3::ZERO);
    pushed.map(|((x, rest), push)| (*x + *push).distance(*rest)).fold(0.0, f64::max)
}

/// Finds the vertices around pushed ones, along the surface or through the tissue, that are
/// not pushed themselves, ascending.
fn vertices_around(
    tree: &SurfaceTree,
    tissue: &mut Tissue,
    pushed: &[u32],
    smoothing: f64,
    workspace: &mut Workspace,
) -> Vec<u32> {
    let max_distance = tuning::SPREAD_RADIUS * smoothing;
    let mut visited = vec![false; tissue.rest.len()];
    let mut queue = VecDeque::new();
    for &vertex in pushed {
        visited[vertex as usize] = true;
        queue.push_back((vertex, vertex));
    }

    let mut free = Vec::new();
    while let Some((vertex, source)) = queue.pop_front() {
        tissue.find_strut(tree, vertex, smoothing, workspace);
        let along = tissue.links(vertex).iter().map(|link| link.neighbor);
        let through = tissue.strut(vertex).map_or([vertex; 3], |strut| strut.corners);
        for next in along.chain(through) {
            let distance = tissue.rest[next as usize].distance(tissue.rest[source as usize]);
            if !visited[next as usize] && distance <= max_distance {
                visited[next as usize] = true;
                free.push(next);
                queue.push_back((next, source));
            }
        }
    }
    free.sort_unstable();
    free
}
