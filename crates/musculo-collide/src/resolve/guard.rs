//! Keeps tissue in shape: no triangle turns over, no edge is torn, and no sheet
//! is pressed through itself.

use glam::DVec3;
use kdop::Workspace;
use surface::{Meeting, TriangleSurface, triangles_meet};

use super::spread::balance;
use super::tissue::{Strut, Tissue};
use crate::scene::Body;

/// Smallest cosine between a face's normal before and after: 0 would be a face
/// that stands on its edge, from where rounding turns it over.
const UPRIGHT: f64 = 0.2;

/// Longest difference between the displacements of two ends of an edge, in
/// lengths of the edge. Beyond 1 an edge may turn round; far below it, deep
/// overlaps would drag more tissue along than they need to.
const STRETCH: f64 = 0.8;

/// Share of a sheet's thickness that must remain; at 0 its sides would meet.
const THICKNESS: f64 = 0.35;

/// Rings around crossing faces that are smoothed with them.
const RINGS: usize = 2;

/// Cosine below which the corners of a face move as one: just before it stands
/// on its edge.
const OVER: f64 = 0.1;

/// Passes in which corners are made to move as one: faces share them.
const STIFFENINGS: usize = 3;

/// Passes over faces that lean too far. Each halves what tells their corners
/// from their surroundings.
const PASSES: usize = 20;

/// Smooths the displacement of what leans over, is torn or pressed together,
/// until nothing is. `looseness`, 1 or more, widens the limits on strain.
pub(super) fn unfold(surface: &TriangleSurface, tissue: &Tissue, looseness: f64, x: &mut [DVec3]) {
    for _ in 0..PASSES {
        let mut strained: Vec<u32> = leaning(surface, tissue, x, UPRIGHT)
            .iter()
            .flat_map(|&face| surface.faces()[face as usize])
            .chain(torn(surface, tissue, x, STRETCH * looseness))
            .chain(pressed(tissue, x, THICKNESS / looseness))
            .collect();
        if strained.is_empty() {
            return;
        }
        strained.sort_unstable();
        strained.dedup();
        smooth(tissue, &strained, x);
    }
}

/// Smooths the displacement around faces that cross others of the same body.
pub(super) fn uncross(body: &Body, tissue: &Tissue, x: &mut [DVec3], traversal: &mut Workspace) {
    let crossing = self_crossings(body, x, traversal);
    let mut corners: Vec<u32> =
        crossing.iter().flatten().flat_map(|&face| body.surface().faces()[face as usize]).collect();
    for _ in 0..RINGS {
        let ring: Vec<u32> = corners
            .iter()
            .flat_map(|&v| tissue.neighbours(v).iter().map(|&(next, _)| next))
            .collect();
        corners.extend(ring);
        corners.sort_unstable();
        corners.dedup();
    }
    for _ in 0..PASSES {
        smooth(tissue, &corners, x);
    }
}

/// Pairs of a body's own faces, without a common corner, that cross.
pub(super) fn self_crossings(body: &Body, x: &[DVec3], traversal: &mut Workspace) -> Vec<[u32; 2]> {
    let mut crossing = Vec::new();
    let mut tree = body.tree().clone();
    if tree.refit(x).is_ok() {
        let corners = |face: u32| body.surface().faces()[face as usize].map(|v| x[v as usize]);
        tree.self_pairs(0.0, traversal, |a, b| {
            if triangles_meet(corners(a), corners(b)) == Meeting::Crossing {
                crossing.push([a, b]);
            }
        });
    }
    crossing.sort_unstable();
    crossing
}

/// How many faces are turned by a right angle and more.
pub(super) fn flipped(surface: &TriangleSurface, tissue: &Tissue, x: &[DVec3]) -> usize {
    leaning(surface, tissue, x, 0.0).len()
}

/// Makes the corners of faces that are turning over move as one, as far as the
/// farthest of them has to: smoothing alone would be undone by the next push.
pub(super) fn stiffen(surface: &TriangleSurface, tissue: &Tissue, x: &mut [DVec3]) {
    for _ in 0..STIFFENINGS {
        let turned = leaning(surface, tissue, x, OVER);
        if turned.is_empty() {
            return;
        }
        for face in turned {
            let corners = surface.faces()[face as usize].map(|v| v as usize);
            let u = corners.map(|v| x[v] - tissue.rest[v]);
            let mean = u.iter().sum::<DVec3>() / 3.0;
            let way = mean.normalize_or_zero();
            let beyond = u.iter().map(|u| (*u - mean).dot(way)).fold(0.0, f64::max);
            corners.into_iter().for_each(|v| x[v] = tissue.rest[v] + mean + beyond * way);
        }
    }
}

/// Ends of edges that are stretched or turned too far.
fn torn(surface: &TriangleSurface, tissue: &Tissue, x: &[DVec3], limit: f64) -> Vec<u32> {
    let is_torn = |&&[p, q]: &&[u32; 2]| {
        let [p, q] = [p, q].map(|v| v as usize);
        let (before, after) = (tissue.rest[q] - tissue.rest[p], x[q] - x[p]);
        before != after && (after - before).length() > limit * before.length()
    };
    surface.edges().iter().filter(is_torn).flatten().copied().collect()
}

/// Both sides of sheets that are pressed too thin.
fn pressed(tissue: &Tissue, x: &[DVec3], limit: f64) -> Vec<u32> {
    let across = |x: &[DVec3], v: u32, strut: &Strut| {
        let corners = strut.corners.iter().zip(strut.weights);
        corners.map(|(&corner, weight)| weight * x[corner as usize]).sum::<DVec3>() - x[v as usize]
    };
    let mut pressed = Vec::new();
    for v in (0..).take(x.len()) {
        if let Some(strut) = tissue.strut(v) {
            let before = across(&tissue.rest, v, strut);
            if across(x, v, strut).dot(before) < limit * before.length_squared() {
                pressed.push(v);
                pressed.extend(strut.corners);
            }
        }
    }
    pressed
}

/// Faces whose normal has turned so far that the cosine is at most `limit`.
fn leaning(surface: &TriangleSurface, tissue: &Tissue, x: &[DVec3], limit: f64) -> Vec<u32> {
    let moved = |v: u32| x[v as usize] != tissue.rest[v as usize];
    let normal = |x: &[DVec3], face: [u32; 3]| {
        let [p, q, r] = face.map(|v| x[v as usize]);
        (q - p).cross(r - p)
    };
    let leans = |face: [u32; 3]| {
        let (before, after) = (normal(&tissue.rest, face), normal(x, face));
        before != DVec3::ZERO && before.dot(after) <= limit * before.length() * after.length()
    };
    let faces = (0..).zip(surface.faces());
    faces
        .filter(|&(_, &face)| face.into_iter().any(moved) && leans(face))
        .map(|(face, _)| face)
        .collect()
}

/// Takes each vertex halfway to the mean displacement of its neighbours and of
/// the other side.
fn smooth(tissue: &Tissue, vertices: &[u32], x: &mut [DVec3]) {
    for &vertex in vertices {
        let of = |v: u32| x[v as usize] - tissue.rest[v as usize];
        if let Some(mean) = balance(tissue, vertex, of, 0.0) {
            let u = 0.5 * (of(vertex) + mean);
            x[vertex as usize] = tissue.rest[vertex as usize] + u;
        }
    }
}

#[cfg(test)]
mod tests {
    use fixtures::{Mesh, shapes};

    use super::*;
    use crate::{BodyKind, Scene};

    /// A scene of one body, with its tree, and that body's tissue.
    fn planted(mesh: Mesh) -> (Scene, Tissue) {
        let mut scene = Scene::new();
        let surface = mesh.surface();
        scene.add("muscle", BodyKind::Deformable, surface, mesh.positions).expect("a body");
        scene.bound_states().expect("a tree");
        let tissue = Tissue::new(&scene.bodies()[0]);
        (scene, tissue)
    }

    /// The largest difference between the displacements of two ends of an edge,
    /// in lengths of the edge.
    fn stretch(body: &Body, tissue: &Tissue, x: &[DVec3]) -> f64 {
        let u = |v: u32| x[v as usize] - tissue.rest[v as usize];
        let length = |p: u32, q: u32| tissue.rest[p as usize].distance(tissue.rest[q as usize]);
        let edges = body.surface().edges().iter();
        edges.map(|&[p, q]| u(p).distance(u(q)) / length(p, q)).fold(0.0, f64::max)
    }

    #[test]
    fn a_vertex_torn_out_is_brought_back_until_no_edge_turns_round() {
        let (scene, tissue) = planted(shapes::icosphere(10.0, 3));
        let body = &scene.bodies()[0];
        let mut x = tissue.rest.clone();
        x[40] += 4.0 * tissue.normals[40];
        assert!(stretch(body, &tissue, &x) > 2.0, "torn out by more than two edges");
        unfold(body.surface(), &tissue, 1.0, &mut x);
        let left = stretch(body, &tissue, &x);
        assert!(left <= 1.0, "{left} lengths of an edge");
        let mut loose = tissue.rest.clone();
        loose[40] += 4.0 * tissue.normals[40];
        unfold(body.surface(), &tissue, 2.0, &mut loose);
        let looser = stretch(body, &tissue, &loose);
        assert!(looser > left, "the limit is wider: {looser}, not {left}");
    }

    /// A flat grid of quarters of millimetres by millimetres, with a vertex lifted and
    /// pushed across its long edges: faces turn over, no edge is torn.
    fn turned_over() -> (Scene, Tissue, Vec<DVec3>) {
        let plate = shapes::plate(DVec3::new(12.0, 3.0, 4.0), [12, 12]);
        let (scene, tissue) = planted(plate);
        let body = &scene.bodies()[0];
        let vertex =
            (0..).zip(&tissue.rest).find(|(_, x)| x.z > 1.9 && x.x.abs() < 0.1 && x.y.abs() < 0.1);
        let (vertex, _): (usize, _) = vertex.expect("the middle of the upper side");
        let mut x = tissue.rest.clone();
        x[vertex] += DVec3::new(0.0, 0.3, 0.05);
        assert!(flipped(body.surface(), &tissue, &x) > 0, "turned over");
        (scene, tissue, x)
    }

    #[test]
    fn faces_that_turned_over_are_brought_back_though_no_edge_is_torn() {
        let (scene, tissue, mut x) = turned_over();
        let body = &scene.bodies()[0];
        unfold(body.surface(), &tissue, 10.0, &mut x);
        assert_eq!(flipped(body.surface(), &tissue, &x), 0);
        let leans = leaning(body.surface(), &tissue, &x, 0.15);
        assert!(leans.is_empty(), "nor does one stand on its edge: {leans:?}");
    }

    #[test]
    fn a_sheet_pressed_through_itself_is_uncrossed() {
        let (scene, tissue) = planted(shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3));
        let body = &scene.bodies()[0];
        let traversal = &mut Workspace::default();
        let mut x = tissue.rest.clone();
        for (x, rest) in x.iter_mut().zip(&tissue.rest) {
            if rest.z > 0.0 && rest.truncate().length() < 3.0 {
                x.z -= 4.5;
            }
        }
        let before = self_crossings(body, &x, traversal).len();
        assert!(before > 0, "its upper side is below its lower one");
        uncross(body, &tissue, &mut x, traversal);
        let after = self_crossings(body, &x, traversal).len();
        assert_eq!(after, 0, "of {before}");
    }
}
