//! The voxel method against its definition: voxels face by face, distances from the nearest of all
//! voxels, and a flood node by node.

use distance_field::{DistanceField, FieldGrid, FieldMethod, FieldParams, Voxelization};
use fixtures::{Mesh, shapes};
use surface::closest_on_triangle;
use surface::glam::DVec3;

use crate::support::{build, nodes};

/// Distance in spacings below which a decision may fall either way.
const TIE: f64 = 1e-9;

/// Closed bodies with faces of several voxels, some of them along the axes.
fn bodies() -> Vec<Mesh> {
    let mut bodies = vec![
        shapes::ellipsoid(DVec3::new(5.3, 4.1, 3.2), 0),
        shapes::ellipsoid(DVec3::new(5.3, 4.1, 3.2), 1).rotated(DVec3::ONE.normalize(), 0.8),
        shapes::tetrahedron(1.0).scaled(DVec3::new(3.1, 4.2, 2.3)),
        shapes::torus(4.0, 1.7, [7, 5]).rotated(DVec3::X, 0.4),
        shapes::plate(DVec3::new(6.0, 5.0, 2.0), [1, 1]),
        shapes::plate(DVec3::new(7.3, 5.1, 0.2), [2, 1]).rotated(DVec3::new(0.6, 0.8, 0.0), 0.6),
    ];
    // A pyramid whose edges meet nodes and middles between nodes.
    let mut pyramid = shapes::tetrahedron(1.0);
    pyramid.positions =
        vec![DVec3::ZERO, DVec3::X * 6.0, DVec3::Y * 4.5, DVec3::new(1.0, 1.5, 7.0)];
    bodies.push(pyramid);
    bodies
}

fn field_of(mesh: &Mesh, voxelization: Voxelization) -> DistanceField {
    let method = FieldMethod::Voxel { voxelization };
    let params = FieldParams { method, padding: 2.0, samples: 0, ..FieldParams::voxel(1.0) };
    build(mesh, &params).expect("closed and small")
}

/// Returns the corners of all faces in spacings from the first node.
fn faces(mesh: &Mesh, grid: &FieldGrid) -> Vec<[DVec3; 3]> {
    let place = |p: DVec3| (p - grid.origin()) / grid.spacing();
    (0..mesh.faces.len()).map(|face| mesh.corners(face).map(place)).collect()
}

fn center(node: [usize; 3]) -> DVec3 {
    DVec3::from_array(node.map(|n| n as f64))
}

/// Returns the voxels of the surface, which are at distance 0.
fn voxels(field: &DistanceField) -> Vec<[usize; 3]> {
    nodes(field.grid().dims()).filter(|node| field.node(*node) == 0.0).collect()
}

/// Distances from the nearest voxel, negative where no way along the axes leads out.
#[test]
fn values_are_those_of_all_voxels_and_of_a_flood() {
    for mesh in bodies() {
        for voxelization in
            [Voxelization::Bresenham, Voxelization::SixSeparating, Voxelization::Conservative]
        {
            let field = field_of(&mesh, voxelization);
            let (dims, voxels) = (field.grid().dims(), voxels(&field));
            let mut outside = vec![false; field.grid().node_count()];
            let mut front: Vec<[usize; 3]> = nodes(dims)
                .filter(|node| (0..3).any(|k| node[k] == 0 || node[k] + 1 == dims[k]))
                .collect();
            while let Some(node) = front.pop() {
                let is_new = !std::mem::replace(&mut outside[field.grid().index(node)], true);
                if is_new && field.node(node) != 0.0 {
                    front.extend(neighbors(node, dims));
                }
            }

            for node in nodes(dims) {
                let value = field.node(node);
                let distances = voxels.iter().map(|voxel| center(*voxel).distance(center(node)));
                let nearest = distances.fold(f64::INFINITY, f64::min);
                assert!((value.abs() - nearest).abs() < 1e-5, "{node:?} {value} {nearest}");
                let is_enclosed = value != 0.0 && !outside[field.grid().index(node)];
                assert_eq!(value < 0.0, is_enclosed, "{node:?} by {voxelization:?}");
            }
        }
    }
}

/// Returns the six neighbors of a node that are in the grid.
fn neighbors(node: [usize; 3], dims: [usize; 3]) -> Vec<[usize; 3]> {
    let mut neighbors = Vec::new();
    for axis in 0..3 {
        for along in [node[axis].wrapping_sub(1), node[axis] + 1] {
            let mut neighbor = node;
            neighbor[axis] = along;
            if along < dims[axis] {
                neighbors.push(neighbor);
            }
        }
    }
    neighbors
}

/// Returns true if a face has a point in the cube around a node, by clipping it at all six sides.
fn meets_cube(face: [DVec3; 3], node: DVec3, half: f64) -> bool {
    let mut polygon = face.to_vec();
    for side in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z] {
        let depth = |p: DVec3| half - (p - node).dot(side);
        let mut clipped = Vec::new();
        for (k, &p) in polygon.iter().enumerate() {
            let q = polygon[(k + 1) % polygon.len()];
            if depth(p) >= 0.0 {
                clipped.push(p);
            }
            if (depth(p) >= 0.0) != (depth(q) >= 0.0) {
                clipped.push(p.lerp(q, depth(p) / (depth(p) - depth(q))));
            }
        }
        polygon = clipped;
    }
    !polygon.is_empty()
}

#[test]
fn conservative_voxels_are_those_that_a_face_touches() {
    let mut count = 0;
    for mesh in bodies() {
        let field = field_of(&mesh, Voxelization::Conservative);
        let faces = faces(&mesh, field.grid());
        for node in nodes(field.grid().dims()) {
            let meets = |half: f64| faces.iter().any(|face| meets_cube(*face, center(node), half));
            let is_on = field.node(node) == 0.0;
            assert!(is_on || !meets(0.5 - TIE), "{node:?} is touched");
            assert!(!is_on || meets(0.5 + TIE), "{node:?} is not touched");
            count += usize::from(is_on);
        }
    }
    assert!(count > 500, "{count}");
}

/// Where the way from a node to the next one crosses a face, one of both is a voxel; and all voxels
/// are touched.
#[test]
fn six_separating_voxels_are_on_either_side_of_each_crossing() {
    let mut count = 0;
    for mesh in bodies() {
        let field = field_of(&mesh, Voxelization::SixSeparating);
        let (dims, faces) = (field.grid().dims(), faces(&mesh, field.grid()));
        for node in nodes(dims) {
            let is_on = |node: [usize; 3]| field.node(node) == 0.0;
            for neighbor in neighbors(node, dims) {
                let way = [center(node), center(neighbor)];
                if faces.iter().any(|face| crosses(way, *face)) {
                    assert!(is_on(node) || is_on(neighbor), "{node:?} {neighbor:?}");
                    count += 1;
                }
            }
            let is_touched = faces.iter().any(|face| meets_cube(*face, center(node), 0.5 + TIE));
            assert!(!is_on(node) || is_touched, "{node:?} is not touched");
        }
    }
    assert!(count > 500, "{count}");
}

/// Returns true if a way crosses a face in its inside, by the signs of volumes.
fn crosses([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let sides = [volume(a, b, c, p), volume(a, b, c, q)];
    let around = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    let is_inside = around.iter().all(|v| *v > TIE) || around.iter().all(|v| *v < -TIE);
    is_inside && sides[0] * sides[1] < -TIE
}

/// Voxels that a face must or may switch on.
struct Thin {
    must: Vec<bool>,
    may: Vec<bool>,
}

impl Thin {
    /// Adds the voxel of a point, or all whose border the point is on.
    fn add(&mut self, grid: &FieldGrid, p: DVec3) {
        let [low, high] = [p - TIE, p + TIE].map(DVec3::round);
        for corner in 0..8_usize {
            let is_high = |axis: usize| corner >> axis & 1 == 1;
            let at =
                DVec3::from_array([0, 1, 2].map(|k| if is_high(k) { high[k] } else { low[k] }));
            let node = nodes(grid.dims()).find(|node| center(*node) == at);
            let index = grid.index(node.expect("the padding holds it"));
            self.must[index] |= low == high;
            self.may[index] = true;
        }
    }
}

/// Lines between the voxels of corners, and one voxel per column inside a face.
#[test]
fn thin_voxels_are_lines_and_columns() {
    for mesh in bodies() {
        let field = field_of(&mesh, Voxelization::Bresenham);
        let (grid, faces) = (field.grid(), faces(&mesh, field.grid()));
        let count = grid.node_count();
        let mut thin = Thin { must: vec![false; count], may: vec![false; count] };
        for [a, b, c] in faces.iter().copied() {
            for [from, to] in [[a, b], [b, c], [c, a]].map(|ends| ends.map(DVec3::round)) {
                let steps = (to - from).abs().max_element();
                let mut step = 0.0;
                while step <= steps {
                    thin.add(grid, from.lerp(to, step / steps.max(1.0)));
                    step += 1.0;
                }
            }

            // Columns along the axis that is nearest to the normal.
            let normal = (b - a).cross(c - a);
            let along = normal.abs();
            let w = (0..3).rev().max_by(|i, j| along[*i].total_cmp(&along[*j])).expect("axes");
            for mut node in nodes(grid.dims()) {
                if std::mem::replace(&mut node[w], 0) != 0 {
                    continue;
                }
                let p = center(node);
                let axis = [DVec3::X, DVec3::Y, DVec3::Z][w] * normal[w].signum();
                let left = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(axis);
                let inside = left(a, b).min(left(b, c)).min(left(c, a));
                if inside >= 0.0 {
                    thin.add(grid, p.with_axis(w, p[w] + (a - p).dot(normal) / normal[w]));
                }
            }
        }
        for node in nodes(grid.dims()) {
            let index = grid.index(node);
            let is_on = field.node(node) == 0.0;
            assert!(is_on || !thin.must[index], "{node:?} is off");
            assert!(!is_on || thin.may[index], "{node:?} is on");
            let distance = |face: &[DVec3; 3]| {
                closest_on_triangle(center(node), *face).point.distance(center(node))
            };
            let nearest = faces.iter().map(distance).fold(f64::INFINITY, f64::min);
            assert!(!is_on || nearest < 3.0_f64.sqrt(), "{node:?} at {nearest}");
        }
    }
}

/// A point with another coordinate.
trait WithAxis {
    fn with_axis(self, axis: usize, value: f64) -> Self;
}

impl WithAxis for DVec3 {
    fn with_axis(mut self, axis: usize, value: f64) -> Self {
        self[axis] = value;
        self
    }
}
