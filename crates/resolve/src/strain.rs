//! Limits on strain: no face turns over, no edge is torn, and no sheet is pressed through
//! itself.

use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use surface::triangle;

use crate::tissue::{Strut, Tissue};
use crate::tuning;

/// Smooths the displacement where a limit on strain is exceeded, until none is or all passes
/// are done.
///
/// A `looseness` of 1 or more widens the limits on edges and sheets.
pub(crate) fn limit_strain(tissue: &Tissue, looseness: f64, x: &mut [DVec3]) {
    for _ in 0..tuning::SMOOTHING_PASSES {
        let mut strained = Vec::new();
        for face in turned_faces(tissue, x, tuning::MIN_NORMAL_COSINE) {
            strained.extend(tissue.corners(face));
        }
        strained.extend(torn_vertices(tissue, x, tuning::MAX_STRETCH * looseness));
        strained.extend(pressed_vertices(tissue, x, tuning::MIN_THICKNESS / looseness));
        if strained.is_empty() {
            return;
        }
        sort_dedup(&mut strained);
        smooth(tissue, &strained, x);
    }
}

/// Smooths the displacement around faces that cross others of the same body.
pub(crate) fn uncross(tree: &SurfaceTree, tissue: &Tissue, x: &mut [DVec3]) {
    let mut vertices = Vec::new();
    for face in self_crossings_at(x, tree).into_iter().flatten() {
        vertices.extend(tissue.corners(face));
    }
    for _ in 0..tuning::UNCROSSING_RINGS {
        for i in 0..vertices.len() {
            let links = tissue.links(vertices[i]).iter();
            vertices.extend(links.map(|link| link.neighbor));
        }
        sort_dedup(&mut vertices);
    }

    for _ in 0..tuning::SMOOTHING_PASSES {
        smooth(tissue, &vertices, x);
    }
}

/// Finds the pairs of a body's own faces, without a common corner, that would cross at `x`.
pub(crate) fn self_crossings_at(x: &[DVec3], tree: &SurfaceTree) -> Vec<[u32; 2]> {
    let mut moved = tree.clone();
    match moved.set_positions(x.iter().copied()) {
        Ok(()) => moved.self_crossings(&mut Workspace::default()),
        Err(_) => Vec::new(),
    }
}

/// Counts the pairs of a body's own faces that cross and did not at rest.
pub(crate) fn count_new_self_crossings(tree: &SurfaceTree, tissue: &Tissue) -> usize {
    if tree.positions().as_slice() == tissue.rest {
        return 0;
    }
    let now = tree.self_crossings(&mut Workspace::default()).len();
    if now == 0 { 0 } else { now.saturating_sub(self_crossings_at(&tissue.rest, tree).len()) }
}

/// Counts the faces that are turned by a right angle or more.
pub(crate) fn count_flipped(tissue: &Tissue, x: &[DVec3]) -> usize {
    turned_faces(tissue, x, 0.0).len()
}

/// Moves the corners of faces that are about to turn over as one, as far as the one that moves
/// farthest. Smoothing alone would be undone by the next push.
pub(crate) fn stiffen(tissue: &Tissue, x: &mut [DVec3]) {
    for _ in 0..tuning::STIFFENING_PASSES {
        let turned = turned_faces(tissue, x, tuning::STIFFENING_COSINE);
        if turned.is_empty() {
            return;
        }
        for face in turned {
            let corners = tissue.corners(face).map(|v| v as usize);
            let u = corners.map(|v| x[v] - tissue.rest[v]);
            let mean = u.iter().sum::<DVec3>() / 3.0;
            let direction = mean.normalize_or_zero();
            let beyond = u.iter().map(|u| (*u - mean).dot(direction)).fold(0.0, f64::max);
            for v in corners {
                x[v] = tissue.rest[v] + mean + beyond * direction;
            }
        }
    }
}

/// Finds the ends of edges whose displacements differ by more than `limit` edge lengths.
fn torn_vertices(tissue: &Tissue, x: &[DVec3], limit: f64) -> Vec<u32> {
    let is_torn = |&&[p, q]: &&[u32; 2]| {
        let [p, q] = [p, q].map(|v| v as usize);
        let (before, after) = (tissue.rest[q] - tissue.rest[p], x[q] - x[p]);
        before != after && (after - before).length() > limit * before.length()
    };
    tissue.surface.edges().iter().filter(is_torn).flatten().copied().collect()
}

/// Finds both sides of sheets that are thinner than `limit` of their thickness at rest.
fn pressed_vertices(tissue: &Tissue, x: &[DVec3], limit: f64) -> Vec<u32> {
    let across = |x: &[DVec3], v: u32, strut: &Strut| {
        strut.interpolate(|corner| x[corner as usize]) - x[v as usize]
    };
    let mut pressed = Vec::new();
    for v in (0..).take(x.len()) {
        let Some(strut) = tissue.strut(v) else { continue };
        let before = across(&tissue.rest, v, strut);
        if across(x, v, strut).dot(before) < limit * before.length_squared() {
            pressed.push(v);
            pressed.extend(strut.corners);
        }
    }
    pressed
}

/// Finds the faces whose normals have turned until their cosine is at most `limit`.
fn turned_faces(tissue: &Tissue, x: &[DVec3], limit: f64) -> Vec<u32> {
    let has_moved = |v: u32| x[v as usize] != tissue.rest[v as usize];
    let normal = |x: &[DVec3], face: [u32; 3]| triangle::normal(face.map(|v| x[v as usize]));
    let mut turned = Vec::new();
    for (number, &face) in (0..).zip(tissue.surface.faces()) {
        if !face.into_iter().any(has_moved) {
            continue;
        }
        let (before, after) = (normal(&tissue.rest, face), normal(x, face));
        let is_turned = before.dot(after) <= limit * before.length() * after.length();
        if before != DVec3::ZERO && is_turned {
            turned.push(number);
        }
    }
    turned
}

/// Moves each vertex halfway to its equilibrium with its links.
fn smooth(tissue: &Tissue, vertices: &[u32], x: &mut [DVec3]) {
    for &vertex in vertices {
        let of = |v: u32| x[v as usize] - tissue.rest[v as usize];
        if let Some(mean) = tissue.equilibrium(vertex, of, 0.0) {
            let u = 0.5 * (of(vertex) + mean);
            x[vertex as usize] = tissue.rest[vertex as usize] + u;
        }
    }
}

fn sort_dedup(vertices: &mut Vec<u32>) {
    vertices.sort_unstable();
    vertices.dedup();
}

#[cfg(test)]
mod tests {
    use fixtures::{Mesh, shapes};

    use super::*;

    /// Builds the tree of a mesh, and its tissue.
    fn planted(mesh: Mesh) -> (SurfaceTree, Tissue) {
        let tree = SurfaceTree::new(mesh.surface(), mesh.positions).expect("a tree");
        let tissue = Tissue::new(&tree);
        (tree, tissue)
    }

    /// The largest difference between the displacements of two ends of an edge,
    /// in lengths of the edge.
    fn stretch(tissue: &Tissue, x: &[DVec3]) -> f64 {
        let u = |v: u32| x[v as usize] - tissue.rest[v as usize];
        let length = |p: u32, q: u32| tissue.rest[p as usize].distance(tissue.rest[q as usize]);
        let edges = tissue.surface.edges().iter();
        edges.map(|&[p, q]| u(p).distance(u(q)) / length(p, q)).fold(0.0, f64::max)
    }

    #[test]
    fn a_vertex_torn_out_is_brought_back_until_no_edge_turns_round() {
        let (_, tissue) = planted(shapes::icosphere(10.0, 3));
        let mut x = tissue.rest.clone();
        x[40] += 4.0 * tissue.normals[40];
        assert!(stretch(&tissue, &x) > 2.0, "torn out by more than two edges");
        limit_strain(&tissue, 1.0, &mut x);
        let left = stretch(&tissue, &x);
        assert!(left <= 1.0, "{left} lengths of an edge");
        let mut loose = tissue.rest.clone();
        loose[40] += 4.0 * tissue.normals[40];
        limit_strain(&tissue, 2.0, &mut loose);
        let looser = stretch(&tissue, &loose);
        assert!(looser > left, "the limit is wider: {looser}, not {left}");
    }

    /// A flat grid of quarters of millimetres by millimetres, with a vertex lifted and
    /// pushed across its long edges: faces turn over, no edge is torn.
    fn turned_over() -> (Tissue, Vec<DVec3>) {
        let plate = shapes::plate(DVec3::new(12.0, 3.0, 4.0), [12, 12]);
        let (_, tissue) = planted(plate);
        let vertex =
            (0..).zip(&tissue.rest).find(|(_, x)| x.z > 1.9 && x.x.abs() < 0.1 && x.y.abs() < 0.1);
        let (vertex, _): (usize, _) = vertex.expect("the middle of the upper side");
        let mut x = tissue.rest.clone();
        x[vertex] += DVec3::new(0.0, 0.3, 0.05);
        assert!(count_flipped(&tissue, &x) > 0, "turned over");
        (tissue, x)
    }

    #[test]
    fn faces_that_turned_over_are_brought_back_though_no_edge_is_torn() {
        let (tissue, mut x) = turned_over();
        limit_strain(&tissue, 10.0, &mut x);
        assert_eq!(count_flipped(&tissue, &x), 0);
        let leans = turned_faces(&tissue, &x, 0.15);
        assert!(leans.is_empty(), "nor does one stand on its edge: {leans:?}");
    }

    #[test]
    fn a_sheet_pressed_through_itself_is_uncrossed() {
        let (tree, tissue) = planted(shapes::ellipsoid(DVec3::new(12.0, 12.0, 2.0), 3));
        let mut x = tissue.rest.clone();
        for (x, rest) in x.iter_mut().zip(&tissue.rest) {
            if rest.z > 0.0 && rest.truncate().length() < 3.0 {
                x.z -= 4.5;
            }
        }
        let before = self_crossings_at(&x, &tree).len();
        assert!(before > 0, "its upper side is below its lower one");
        uncross(&tree, &tissue, &mut x);
        let after = self_crossings_at(&x, &tree).len();
        assert_eq!(after, 0, "of {before}");
    }
}
