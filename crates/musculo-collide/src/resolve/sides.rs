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
use crate::{BodyKind, NearVertex, VertexReport};

/// Cosine beyond which two normals are said to agree: exactly across is 0, and
/// the normals of coarse meshes are off by some ten degrees.
const AGREES: f64 = 0.2;

/// Depth at which a vertex's own direction counts a third, in smoothing
/// lengths: bones are as thin as that where tissue is deepest in them.
const TRUSTED_DEPTH: f64 = 0.15;

/// How far bone may be sent through tissue, in smoothing lengths: beyond, what
/// faces it is another part of the tissue.
const FARTHEST: f64 = 2.0;

/// Sweeps that spread directions over what is inside: patches are some thirty
/// edges wide.
const SWEEPS: usize = 30;

/// Ways out that were taken before, of the vertices of one body out of another;
/// 0 for those that never were inside. A vertex keeps to its way.
pub(super) type Memory = Vec<DVec3>;

/// Contacts of the vertices of `p` with `q`: those of a report, without those
/// that come from behind, and with deep vertices turned to the right side.
pub(super) fn straighten(
    (p, tissue): (&Body, &Tissue),
    (q, normals): (&Body, &[DVec3]),
    report: &VertexReport,
    memory: &mut Memory,
    smoothing: f64,
    traversal: &mut Workspace,
) -> Vec<NearVertex> {
    if p.kind() == BodyKind::Rigid {
        return straighten_rigid(p, (q, normals), report, smoothing, traversal);
    }
    let directions = if report.near.iter().any(|near| near.gap < 0.0) || !memory.is_empty() {
        directions(tissue, normals, &report.near, memory, smoothing)
    } else {
        Vec::new()
    };
    let turn = |near: &NearVertex| -> Option<NearVertex> {
        let direction = directions.get(near.vertex as usize).copied().unwrap_or_default();
        let astray = near.normal.dot(direction) < 0.0;
        let behind = normals[near.vertex as usize].dot(near.normal) > AGREES;
        match (near.gap < 0.0, astray) {
            (true, false) => Some(*near),
            (true, true) => {
                let position = p.positions()[near.vertex as usize];
                let turned = project(q, near.vertex, position, direction, traversal);
                Some(turned.filter(|turned| turned.gap < 0.0).unwrap_or(*near))
            }
            (false, _) => (!astray && !behind).then_some(*near),
        }
    };
    report.near.iter().filter_map(turn).collect()
}

/// Bone in tissue: its vertices leave by the side of the tissue that faces
/// them.
fn straighten_rigid(
    p: &Body,
    (q, normals): (&Body, &[DVec3]),
    report: &VertexReport,
    smoothing: f64,
    traversal: &mut Workspace,
) -> Vec<NearVertex> {
    let turn = |near: &NearVertex| -> Option<NearVertex> {
        let normal = normals[near.vertex as usize];
        if normal.dot(near.normal) < AGREES {
            return Some(*near);
        }
        if near.gap >= 0.0 {
            return None;
        }
        let position = p.positions()[near.vertex as usize];
        let turned = project(q, near.vertex, position, -normal, traversal);
        turned.filter(|near| near.gap < 0.0 && near.gap > -FARTHEST * smoothing)
    };
    report.near.iter().filter_map(turn).collect()
}

/// For each vertex inside or near, which way leads out; 0 for others.
fn directions(
    tissue: &Tissue,
    normals: &[DVec3],
    near: &[NearVertex],
    memory: &mut Memory,
    smoothing: f64,
) -> Vec<DVec3> {
    memory.resize(normals.len(), DVec3::ZERO);
    let mut own = memory.clone();
    let unknown =
        |near: &&NearVertex| near.gap < 0.0 && memory[near.vertex as usize] == DVec3::ZERO;
    for near in near.iter().filter(unknown) {
        let facing = (-normals[near.vertex as usize].dot(near.normal)).max(0.0);
        let trust = facing * (near.gap / (TRUSTED_DEPTH * smoothing)).exp();
        own[near.vertex as usize] = trust * near.normal;
    }
    let mut directions = own.clone();
    let mut relax = |near: &NearVertex| {
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
            near.iter().for_each(&mut relax);
        } else {
            near.iter().rev().for_each(&mut relax);
        }
    }
    let directions: Vec<DVec3> = directions.into_iter().map(DVec3::normalize_or_zero).collect();
    for near in near.iter().filter(|near| near.gap < 0.0) {
        let known = &mut memory[near.vertex as usize];
        if *known == DVec3::ZERO {
            *known = directions[near.vertex as usize];
        }
    }
    directions
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
    let (_, face) = best?;
    let corners = body.corners(face);
    let foot = closest_on_triangle(position, corners);
    let way = (foot.point - position).normalize_or_zero();
    let normal = if way.dot(side) > AGREES { way } else { unit_normal(corners) };
    Some(NearVertex {
        vertex,
        gap: (position - foot.point).dot(normal),
        foot: foot.point,
        face,
        barycentric: foot.barycentric,
        normal,
    })
}

fn unit_normal([p, q, r]: [DVec3; 3]) -> DVec3 {
    (q - p).cross(r - p).normalize_or_zero()
}
