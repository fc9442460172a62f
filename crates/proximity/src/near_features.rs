//! Closest points of all features of two surfaces that are near each other: vertices and
//! faces, edges and edges.

use glam::DVec3;
use kdop::Workspace;
use surface::{
    ClosestOnTriangle, NO_EDGE, TriangleFeature, closest_between_segments, closest_on_triangle,
    parallel,
};

use crate::SurfaceTree;
use crate::distance::are_farther;

/// Pairs of faces of which one thread finds the features, where several share them. Below, handing them over takes
/// longer; above, threads wait for each other.
const SHARED_PAIRS: usize = 4096;

/// Point of a surface, as weights of up to three vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeaturePoint {
    /// The vertices; those beyond the feature have the weight 0.
    pub vertices: [u32; 3],
    /// Their weights, which sum to 1.
    pub weights: [f64; 3],
    /// The point.
    pub point: DVec3,
    /// A face that holds it.
    pub face: u32,
}

/// Two features of two surfaces, by their closest points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearFeatures {
    /// Point of the first surface, then of the second.
    pub points: [FeaturePoint; 2],
    /// Distance of the two points.
    pub distance: f64,
}

impl NearFeatures {
    /// Lists the features of two surfaces within `max_distance` of each other, each pair of
    /// features once, in an order that depends on the two trees alone.
    ///
    /// Features are vertices against faces, where the foot may be on an edge or a corner of the
    /// face, and the interiors of edges against each other. Where surfaces do not cross, their
    /// distance is the smallest one of the list.
    pub fn find(
        a: &SurfaceTree,
        b: &SurfaceTree,
        max_distance: f64,
        workspace: &mut Workspace,
        found: &mut Vec<Self>,
    ) {
        let mut pairs = Vec::new();
        a.tree().pairs(b.tree(), max_distance, workspace, |face_a, face_b| {
            pairs.push([face_a, face_b]);
        });

        // On one thread, without lists between.
        if pairs.len() > SHARED_PAIRS && parallel::threads() > 1 {
            for mut list in features_by_parts([a, b], &pairs, max_distance) {
                found.append(&mut list);
            }
        } else {
            for faces in pairs {
                add_features([a, b], faces, max_distance, found);
            }
        }
    }
}

/// Lists the features of pairs of faces in parts that threads share, in the order of the pairs.
fn features_by_parts(
    bodies: [&SurfaceTree; 2],
    pairs: &[[u32; 2]],
    max_distance: f64,
) -> Vec<Vec<NearFeatures>> {
    let parts: Vec<&[[u32; 2]]> = pairs.chunks(SHARED_PAIRS).collect();
    parallel::map(parts.len(), |part| {
        let mut found = Vec::new();
        for faces in parts[part] {
            add_features(bodies, *faces, max_distance, &mut found);
        }
        found
    })
}

/// Adds the features of two faces: vertices of each against the other one, then edges against edges.
fn add_features(
    [a, b]: [&SurfaceTree; 2],
    [face_a, face_b]: [u32; 2],
    max_distance: f64,
    found: &mut Vec<NearFeatures>,
) {
    if are_farther(a.corners(face_a), b.corners(face_b), max_distance) {
        return;
    }
    let start = found.len();
    add_vertices([a, b], [face_a, face_b], true, found);
    let vertices_of_b = found.len();
    add_vertices([b, a], [face_b, face_a], false, found);
    for features in &mut found[vertices_of_b..] {
        features.points.swap(0, 1);
    }
    add_edges(a, face_a, b, face_b, found);
    retain_near(found, start, max_distance);
}

/// Removes features that are farther apart than `max_distance`, from the entry `start` on.
fn retain_near(found: &mut Vec<NearFeatures>, start: usize, max_distance: f64) {
    let mut end = start;
    for i in start..found.len() {
        if found[i].distance <= max_distance {
            found[end] = found[i];
            end += 1;
        }
    }
    found.truncate(end);
}

/// Adds the vertices that a face represents against a face of another surface; those against its
/// corners only `with_corners`, since they are found from either side.
fn add_vertices(
    [own, other]: [&SurfaceTree; 2],
    [own_face, face]: [u32; 2],
    with_corners: bool,
    found: &mut Vec<NearFeatures>,
) {
    for vertex in own.surface().faces()[own_face as usize] {
        if own.surface().vertex_faces(vertex)[0] != own_face {
            continue;
        }

        // A foot on an edge or a corner is left to one of the faces that share it.
        let point = own.position(vertex);
        let foot = closest_on_triangle(point, other.corners(face));
        let is_corner = matches!(foot.feature, TriangleFeature::Corner(_));
        if (is_corner && !with_corners) || !represents(other, face, &foot) {
            continue;
        }
        let vertices = [vertex; 3];
        let on_own = FeaturePoint { vertices, weights: [1.0, 0.0, 0.0], point, face: own_face };
        let on_other = FeaturePoint {
            vertices: other.surface().faces()[face as usize],
            weights: foot.barycentric,
            point: foot.point,
            face,
        };
        let distance = point.distance(foot.point);
        found.push(NearFeatures { points: [on_own, on_other], distance });
    }
}

/// Returns true if a face is the one that stands for the feature that holds the foot.
fn represents(tree: &SurfaceTree, face: u32, foot: &ClosestOnTriangle) -> bool {
    let surface = tree.surface();
    match foot.feature {
        TriangleFeature::Face => true,
        TriangleFeature::Edge(k) => {
            let edge = surface.face_edges()[face as usize][k];
            edge != NO_EDGE && surface.edge_faces(edge)[0] == face
        }
        TriangleFeature::Corner(k) => {
            surface.vertex_faces(surface.faces()[face as usize][k])[0] == face
        }
    }
}

/// Adds the edges that two faces represent, where they are closest in their interiors.
fn add_edges(
    a: &SurfaceTree,
    face_a: u32,
    b: &SurfaceTree,
    face_b: u32,
    found: &mut Vec<NearFeatures>,
) {
    for [p, q] in own_edges(a, face_a) {
        for [r, s] in own_edges(b, face_b) {
            let of_a = [a.position(p), a.position(q)];
            let of_b = [b.position(r), b.position(s)];
            let feet = closest_between_segments(of_a, of_b);
            let is_interior = |t: f64| t > 0.0 && t < 1.0;
            if is_interior(feet.s) && is_interior(feet.t) {
                let on_a = on_edge([p, q], feet.s, feet.points[0], face_a);
                let on_b = on_edge([r, s], feet.t, feet.points[1], face_b);
                let distance = feet.points[0].distance(feet.points[1]);
                found.push(NearFeatures { points: [on_a, on_b], distance });
            }
        }
    }
}

/// Returns the ends of the edges that a face represents.
fn own_edges(tree: &SurfaceTree, face: u32) -> impl Iterator<Item = [u32; 2]> {
    let surface = tree.surface();
    let edges = surface.face_edges()[face as usize].into_iter();
    let own = edges.filter(move |&edge| edge != NO_EDGE && surface.edge_faces(edge)[0] == face);
    own.map(|edge| surface.edges()[edge as usize])
}

fn on_edge([p, q]: [u32; 2], t: f64, point: DVec3, face: u32) -> FeaturePoint {
    FeaturePoint { vertices: [p, q, q], weights: [1.0 - t, t, 0.0], point, face }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use surface::closest_between_triangles;

    use super::*;

    #[test]
    fn parts_list_the_features_of_the_whole() {
        let tree = |height: f64| {
            let ball = shapes::icosphere(3.0, 3).translated(height * DVec3::Z);
            SurfaceTree::new(ball.surface(), ball.positions).expect("a tree")
        };
        let (a, b, workspace) = (tree(0.0), tree(6.1), Workspace::default);
        let mut pairs = Vec::new();
        a.tree().pairs(b.tree(), 1.5, &mut workspace(), |p, q| pairs.push([p, q]));
        let parts = features_by_parts([&a, &b], &pairs, 1.5);
        assert!(parts.len() > 2, "{} pairs are for one thread", pairs.len());

        let find = || {
            let mut found = Vec::new();
            NearFeatures::find(&a, &b, 1.5, &mut workspace(), &mut found);
            found
        };
        let whole = parallel::on_calling_thread(find);
        assert_eq!(parts.concat(), whole);
        assert_eq!(find(), whole);
    }

    #[test]
    fn the_nearest_features_are_as_far_as_all_faces_by_brute_force() {
        let ball = shapes::icosphere(3.0, 2);
        for shift in
            [DVec3::new(6.05, 0.3, 0.1), DVec3::new(4.3, 4.3, 0.2), DVec3::new(0.1, 0.2, 6.1)]
        {
            let other = shapes::ellipsoid(DVec3::new(3.0, 2.9, 3.1), 2).translated(shift);
            let a = SurfaceTree::new(ball.surface(), ball.positions.clone()).expect("a tree");
            let b = SurfaceTree::new(other.surface(), other.positions).expect("a tree");
            let mut brute = f64::INFINITY;
            for face_a in 0..u32::try_from(a.surface().faces().len()).expect("few") {
                for face_b in 0..u32::try_from(b.surface().faces().len()).expect("few") {
                    let feet = closest_between_triangles(a.corners(face_a), b.corners(face_b));
                    brute = brute.min(feet.distance());
                }
            }
            let mut found = Vec::new();
            NearFeatures::find(&a, &b, 1.5, &mut Workspace::default(), &mut found);
            let nearest = found.iter().map(|near| near.distance).fold(f64::INFINITY, f64::min);
            assert!((nearest - brute).abs() < 1e-12, "{nearest} for {brute}");

            // All pairs of edges, by brute force.
            let mut edges = 0;
            for &[p, q] in a.surface().edges() {
                for &[r, s] in b.surface().edges() {
                    let of_a = [p, q].map(|vertex| a.position(vertex));
                    let feet = closest_between_segments(of_a, [r, s].map(|v| b.position(v)));
                    let interior = [feet.s, feet.t].iter().all(|t| *t > 0.0 && *t < 1.0);
                    let distance = feet.points[0].distance(feet.points[1]);
                    edges += usize::from(interior && distance <= 1.5);
                }
            }
            let is_edge = |point: &FeaturePoint| point.vertices[1] == point.vertices[2];
            let found_edges = found.iter().filter(|near| {
                let [p, q] = &near.points;
                is_edge(p) && is_edge(q) && p.vertices[0] != p.vertices[1]
            });
            assert!(found_edges.count() == edges && edges > 10, "{edges} pairs of edges");

            // Weights are of the points, and no pair of features is listed twice.
            let mut keys = Vec::new();
            for NearFeatures { points: [p, q], distance } in &found {
                for (tree, on) in [(&a, p), (&b, q)] {
                    let mut sum = DVec3::ZERO;
                    for k in 0..3 {
                        sum += on.weights[k] * tree.position(on.vertices[k]);
                    }
                    assert!((sum - on.point).length() < 1e-12, "{on:?}");
                }
                assert!((p.point.distance(q.point) - distance).abs() < 1e-12 && *distance <= 1.5);
                keys.push([p.point, q.point].map(|point| point.to_array().map(f64::to_bits)));
            }
            let count = keys.len();
            keys.sort_unstable();
            keys.dedup();
            assert!(keys.len() == count && count > 20, "{} of {count}", keys.len());
        }
    }
}
