//! Which side of a body deep vertices are to leave it by.
//!
//! The nearest way out of a thin bone may lead through to its other side. Where
//! tissue entered is told by vertices that are shallow and whose own surface
//! faces that of the other body; their directions are spread over all vertices
//! inside, along the surface and through the tissue, and a vertex whose nearest
//! way out points against that is projected anew, to faces on the right side.

use glam::DVec3;
use kdop::Workspace;
use surface::closest_on_triangle;

use super::tissue::Tissue;
use crate::scene::Body;
use crate::{NearVertex, VertexReport};

/// Cosine beyond which two normals are said to agree: exactly across is 0, and
/// the normals of coarse meshes are off by some ten degrees.
const AGREES: f64 = 0.2;

/// Depth at which a vertex's own direction counts a third, in smoothing
/// lengths: bones are as thin as that where tissue is deepest in them.
const TRUSTED_DEPTH: f64 = 0.15;

/// Sweeps that spread directions over what is inside: patches are some thirty
/// edges wide.
const SWEEPS: usize = 30;

/// Contacts of the vertices of `p` with `q`: those of a report, without those
/// that come from behind, and with deep vertices turned to the right side.
pub(super) fn straighten(
    (p, tissue): (&Body, &Tissue),
    (q, normals): (&Body, &[DVec3]),
    report: &VertexReport,
    smoothing: f64,
    traversal: &mut Workspace,
) -> Vec<NearVertex> {
    let faces = |near: &NearVertex| normals[near.vertex as usize].dot(near.normal) < AGREES;
    let rigid = p.kind() == crate::BodyKind::Rigid;
    let kept = report.near.iter().filter(|near| (near.gap < 0.0 && !rigid) || faces(near));
    let mut kept: Vec<NearVertex> = kept.copied().collect();
    if rigid || !kept.iter().any(|near| near.gap < 0.0) {
        return kept;
    }
    let directions = directions(tissue, normals, &kept, smoothing);
    for near in kept.iter_mut().filter(|near| near.gap < 0.0) {
        let direction = directions[near.vertex as usize];
        if near.normal.dot(direction) < 0.0 {
            let position = p.positions()[near.vertex as usize];
            if let Some(turned) = project(q, near.vertex, position, direction, traversal) {
                *near = turned;
            }
        }
    }
    kept
}

/// For each vertex inside, which way leads out; 0 for others.
fn directions(
    tissue: &Tissue,
    normals: &[DVec3],
    near: &[NearVertex],
    smoothing: f64,
) -> Vec<DVec3> {
    let inside: Vec<&NearVertex> = near.iter().filter(|near| near.gap < 0.0).collect();
    let mut own = vec![DVec3::ZERO; normals.len()];
    for near in &inside {
        let facing = (-normals[near.vertex as usize].dot(near.normal)).max(0.0);
        let trust = facing * (near.gap / (TRUSTED_DEPTH * smoothing)).exp();
        own[near.vertex as usize] = trust * near.normal;
    }
    let mut directions = own.clone();
    let mut relax = |near: &&NearVertex| {
        let (mut sum, mut stiffness) = (DVec3::ZERO, 0.0);
        for &(next, k) in tissue.neighbours(near.vertex) {
            sum += k * directions[next as usize];
            stiffness += k;
        }
        if let Some(strut) = tissue.strut(near.vertex) {
            for (corner, weight) in strut.corners.into_iter().zip(strut.weights) {
                sum += strut.stiffness * weight * directions[corner as usize];
            }
            stiffness += strut.stiffness;
        }
        if stiffness > 0.0 {
            directions[near.vertex as usize] = own[near.vertex as usize] + sum / stiffness;
        }
    };
    for sweep in 0..SWEEPS {
        if sweep % 2 == 0 {
            inside.iter().for_each(&mut relax);
        } else {
            inside.iter().rev().for_each(&mut relax);
        }
    }
    directions.into_iter().map(DVec3::normalize_or_zero).collect()
}

/// The nearest point of a body's surface on a side of it, for a vertex inside.
fn project(
    body: &Body,
    vertex: u32,
    position: DVec3,
    side: DVec3,
    traversal: &mut Workspace,
) -> Option<NearVertex> {
    let mut best: Option<(f64, u32)> = None;
    body.tree().nearest(position, f64::INFINITY, traversal, |face, _| {
        let corners = body.corners(face);
        let distance = closest_on_triangle(position, corners).point.distance(position);
        let nearer = best.is_none_or(|least| (distance, face) < least);
        if nearer && unit_normal(corners).dot(side) > AGREES {
            best = Some((distance, face));
        }
        best.map_or(f64::INFINITY, |(least, _)| least)
    });
    let (distance, face) = best?;
    let corners = body.corners(face);
    let foot = closest_on_triangle(position, corners);
    Some(NearVertex {
        vertex,
        gap: -distance,
        foot: foot.point,
        face,
        barycentric: foot.barycentric,
        normal: (foot.point - position).try_normalize().unwrap_or_else(|| unit_normal(corners)),
    })
}

fn unit_normal([p, q, r]: [DVec3; 3]) -> DVec3 {
    (q - p).cross(r - p).normalize_or_zero()
}
