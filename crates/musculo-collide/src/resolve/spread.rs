//! A push at some vertices, handed on to the tissue around them.
//!
//! The displacement between pushed vertices is the one that a membrane on an
//! elastic foundation takes: where it is not pushed, `Δu = u / ℓ²`, with ℓ the
//! smoothing length, so that it fades along the surface and stays exactly 0 a
//! few ℓ away. Struts through the tissue take part, and thin sheets thus move
//! as one and keep their volume.

use std::collections::VecDeque;

use glam::DVec3;
use kdop::Workspace;

use super::tissue::Tissue;
use crate::scene::Body;

/// How far the push reaches, in smoothing lengths: it has faded to a twentieth
/// there, and is cut.
const REACH: f64 = 3.0;

/// Share of the strongest push below which a vertex is left where it is.
const FADED: f64 = 1e-3;

/// Gauss–Seidel sweeps, to and fro. More give a smoother field and cost time;
/// what a round leaves rough, the next ones smooth.
const SWEEPS: usize = 8;

/// Spreads a body's pushes, in place; vertices without any are those with 0.
pub(super) fn spread(
    body: &Body,
    tissue: &mut Tissue,
    pushes: &mut [DVec3],
    smoothing: f64,
    traversal: &mut Workspace,
) {
    let pushed: Vec<u32> =
        (0..).zip(&*pushes).filter(|(_, push)| **push != DVec3::ZERO).map(|(v, _)| v).collect();
    if pushed.is_empty() {
        return;
    }
    let mut free = around(body, tissue, &pushed, smoothing, traversal);
    free.sort_unstable();
    let foundation = (smoothing * smoothing).recip();
    for sweep in 0..SWEEPS {
        let relax = |&v: &u32| {
            if let Some(u) = balance(tissue, v, |next| pushes[next as usize], foundation) {
                pushes[v as usize] = u;
            }
        };
        if sweep % 2 == 0 {
            free.iter().for_each(relax);
        } else {
            free.iter().rev().for_each(relax);
        }
    }
    let strongest = pushed.iter().map(|&v| pushes[v as usize].length()).fold(0.0, f64::max);
    for v in free {
        if pushes[v as usize].length() < FADED * strongest {
            pushes[v as usize] = DVec3::ZERO;
        }
    }
}

/// How far the farthest vertex that is pushed comes to lie from its rest.
pub(super) fn farthest(body: &Body, tissue: &Tissue, pushes: &[DVec3]) -> f64 {
    let places = body.positions().iter().zip(&tissue.rest).zip(pushes);
    let pushed = places.filter(|(_, push)| **push != DVec3::ZERO);
    pushed.map(|((x, rest), push)| (*x + *push).distance(*rest)).fold(0.0, f64::max)
}

/// Vertices that are not pushed themselves, within the margin of pushed ones along
/// the surface or through the tissue.
fn around(
    body: &Body,
    tissue: &mut Tissue,
    pushed: &[u32],
    smoothing: f64,
    traversal: &mut Workspace,
) -> Vec<u32> {
    let mut seen = vec![false; tissue.rest.len()];
    pushed.iter().for_each(|&v| seen[v as usize] = true);
    let mut queue: VecDeque<(u32, u32)> = pushed.iter().map(|&v| (v, v)).collect();
    let mut free = Vec::new();
    while let Some((vertex, source)) = queue.pop_front() {
        tissue.find_struts(body, &[vertex], smoothing, traversal);
        let along = tissue.neighbours(vertex).iter().map(|&(next, _)| next);
        let through = tissue.strut(vertex).map_or([vertex; 3], |strut| strut.corners);
        for next in along.chain(through) {
            let distance = tissue.rest[next as usize].distance(tissue.rest[source as usize]);
            if !seen[next as usize] && distance <= REACH * smoothing {
                seen[next as usize] = true;
                free.push(next);
                queue.push_back((next, source));
            }
        }
    }
    free
}

/// Where a vertex comes to rest between its neighbours and the other side, which
/// are displaced by `u`; `None` where nothing holds it.
pub(super) fn balance(
    tissue: &Tissue,
    vertex: u32,
    u: impl Fn(u32) -> DVec3,
    foundation: f64,
) -> Option<DVec3> {
    let (mut sum, mut stiffness) = (DVec3::ZERO, foundation);
    for &(next, k) in tissue.neighbours(vertex) {
        sum += k * u(next);
        stiffness += k;
    }
    if let Some(strut) = tissue.strut(vertex) {
        let across = strut.corners.iter().zip(strut.weights);
        let across: DVec3 = across.map(|(&corner, weight)| weight * u(corner)).sum();
        sum += strut.stiffness * across;
        stiffness += strut.stiffness;
    }
    (stiffness > 0.0).then(|| sum / stiffness)
}
