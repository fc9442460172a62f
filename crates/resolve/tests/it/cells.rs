//! Surfaces of volume meshes, whose cells have corners without a node inside.

use std::collections::BTreeMap;

use fixtures::volume::Block;
use fixtures::{Mesh, shapes};
use glam::DVec3;
use resolve::{CellCorners, Conditions, Resolution, ResolveError, ResolveParams, Resolver};
use scene::{BodyKind, Scene};
use surface::progress::Progress;
use volume_mesh::{Boundary, Cell, FollowParams, Followed, VolumeMesh};

use crate::scene_of;

/// Block of hexahedra with the nodes of its surface.
struct Hexahedra {
    mesh: VolumeMesh,
    nodes: Vec<DVec3>,
    boundary: Boundary,
}

impl Hexahedra {
    fn new() -> Self {
        let block = Block::new(DVec3::splat(24.0), [6, 6, 6]);
        let cells = block.hexahedra.into_iter().map(Cell::Hexahedron).collect();
        let mesh = VolumeMesh::new(block.nodes.len(), cells).expect("valid nodes");
        let boundary = mesh.boundary().expect("a closed block");
        Self { mesh, nodes: block.nodes, boundary }
    }

    /// Builds a scene of the block and of a bone in it.
    fn with_bone_at(&self, place: DVec3) -> Scene {
        let positions = self.boundary.positions(&self.nodes);
        let muscle = Mesh { positions, faces: self.boundary.faces.clone() };
        let bone = shapes::icosphere(6.0, 2).translated(place);
        scene_of([("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)])
    }

    /// Resolves the scene of a bone at some place, with corners of cells held open or not; returns what its cells
    /// follow of the surface.
    fn followed(&self, bone: DVec3, holds_corners: bool) -> (Resolution, Followed) {
        let mut scene = self.with_bone_at(bone);
        let muscle = scene.find("muscle").expect("a body");
        let follow = FollowParams::default();
        let mut conditions = Conditions::default();
        if holds_corners {
            let (body, corners) = (muscle, self.boundary.corners(&self.mesh));
            let min_jacobian_share = follow.min_jacobian_share;
            conditions.cell_corners.push(CellCorners { body, corners, min_jacobian_share });
        }
        let params = ResolveParams { gap: 0.05, ..ResolveParams::with_smoothing(6.0) };
        let resolver = Resolver::new(params).expect("valid parameters");
        let mut resolver = resolver.with_conditions(conditions);
        let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
        let target = scene.body(muscle).positions();
        let followed =
            self.mesh.follow(&self.nodes, &self.boundary, target, &follow, Progress::none());
        (resolution, followed.expect("cells that are open at the start"))
    }
}

/// In the corner of the block, at edges of it, and at one side.
#[test]
fn corners_of_cells_stay_open_where_a_bone_presses_them() {
    let block = Hexahedra::new();
    for place in [[1.0, 1.0, 1.0], [12.5, 1.0, 1.0], [0.0, 1.0, 12.0], [12.5, 2.0, 2.0]] {
        let (alone, cut) = block.followed(DVec3::from(place), false);
        assert!(alone.resolved && cut.share < 0.9, "{place:?}: {cut:?}");
        let (resolution, followed) = block.followed(DVec3::from(place), true);
        assert!(resolution.resolved, "{place:?}: {:?}", resolution.remaining);
        assert_eq!((followed.share, followed.blocking), (1.0, None), "{place:?}");
        assert_eq!(followed.after.inverted, 0, "{place:?}: {:?}", followed.after);
    }
}

/// Makes the cells of two faces of a convex surface each, apart from each other: by the vertex across their edge, the
/// ends of the edge, and the other vertex across.
fn cells_under_pairs_of_faces(mesh: &Mesh) -> Vec<[u32; 4]> {
    let mut used = vec![false; mesh.positions.len()];
    let mut across = BTreeMap::new();
    let mut cells = Vec::new();
    for &[a, b, c] in &mesh.faces {
        for [a, b, p] in [[a, b, c], [b, c, a], [c, a, b]] {
            across.insert([a, b], p);
            let Some(&q) = across.get(&[b, a]) else { continue };
            let cell = [p, a, b, q];
            if cell.iter().all(|&vertex| !used[vertex as usize]) {
                cell.iter().for_each(|&vertex| used[vertex as usize] = true);
                cells.push(cell);
            }
        }
    }
    cells
}

/// Cells under two faces that meet at a small angle are far lower than the gap. Rounds that push the body off a bone
/// keep them open, and so do those that open the gap.
#[test]
fn cells_far_lower_than_the_gap_stay_open() {
    let muscle = shapes::icosphere(12.0, 4);
    let cells = cells_under_pairs_of_faces(&muscle);
    assert!(cells.len() > 400, "{}", cells.len());
    let corners: Vec<[u32; 4]> = cells
        .into_iter()
        .flat_map(|[p, a, b, q]| [[p, a, q, b], [a, p, b, q], [b, p, q, a], [q, a, p, b]])
        .collect();
    for depth in [0.5, 1.0, 2.0, 3.0] {
        let bone = shapes::icosphere(6.0, 3).translated(DVec3::new(18.0 - depth, 0.3, 0.2));
        let bodies =
            [("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle.clone())];
        let mut scene = scene_of(bodies);
        let body = scene.find("muscle").expect("a body");
        let corners = CellCorners { body, corners: corners.clone(), min_jacobian_share: 0.1 };
        let conditions = Conditions { cell_corners: vec![corners], ..Conditions::default() };
        let params = ResolveParams { gap: 0.05, ..ResolveParams::with_smoothing(6.0) };
        let resolver = Resolver::new(params).expect("valid parameters");
        let mut resolver = resolver.with_conditions(conditions);
        let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
        let rounds = resolution.rounds.len();
        assert!(resolution.resolved, "{depth}: {:?}", resolution.broken_limits);
        assert!(rounds <= 6, "{depth}: {rounds} rounds");
    }
}

/// A corner that may hardly change is pressed all the same where rounds go on beyond limits.
#[test]
fn corners_that_are_flat_break_a_limit() {
    let block = Hexahedra::new();
    let params = ResolveParams { keep_going: true, ..ResolveParams::with_smoothing(6.0) };
    let mut scene = block.with_bone_at(DVec3::splat(2.0));
    let muscle = scene.find("muscle").expect("a body");
    let corners = CellCorners {
        body: muscle,
        corners: block.boundary.corners(&block.mesh),
        min_jacobian_share: 0.99,
    };
    let conditions = Conditions { cell_corners: vec![corners], ..Conditions::default() };
    let resolver = Resolver::new(params).expect("valid parameters");
    let mut resolver = resolver.with_conditions(conditions);
    let resolution = resolver.resolve(&mut scene, Progress::none()).expect("a resolution");
    let flat: usize = resolution.broken_limits.iter().map(|broken| broken.flat_corners).sum();
    assert!(flat > 0 && !resolution.resolved, "{:?}", resolution.broken_limits);
}

#[test]
fn corners_of_vertices_that_a_body_has_not_are_refused() {
    let block = Hexahedra::new();
    let mut scene = block.with_bone_at(DVec3::splat(2.0));
    let body = scene.find("muscle").expect("a body");
    let count = scene.body(body).positions().len();
    let vertex = u32::try_from(count).expect("a small block");
    let corners = CellCorners { body, corners: vec![[0, 1, 2, vertex]], min_jacobian_share: 0.1 };
    let conditions = Conditions { cell_corners: vec![corners], ..Conditions::default() };
    let resolver = Resolver::new(ResolveParams::with_smoothing(6.0)).expect("valid parameters");
    let refused = resolver.with_conditions(conditions).resolve(&mut scene, Progress::none());
    let error = ResolveError::NoSuchVertex { body: body.index(), vertex, count };
    assert_eq!(refused.err().map(|found| found.to_string()), Some(error.to_string()));
}

/// A corner with its edges in the wrong order is inverted at the start: it is nobody's to keep.
#[test]
fn corners_that_are_inverted_at_the_start_are_left() {
    let block = Hexahedra::new();
    let mut corners = block.boundary.corners(&block.mesh);
    corners.iter_mut().for_each(|corner| corner.swap(1, 2));
    let mut scene = block.with_bone_at(DVec3::new(12.5, 1.0, 1.0));
    let body = scene.find("muscle").expect("a body");
    let corners = CellCorners { body, corners, min_jacobian_share: 0.1 };
    let conditions = Conditions { cell_corners: vec![corners], ..Conditions::default() };
    let resolver = Resolver::new(ResolveParams::with_smoothing(6.0)).expect("valid parameters");
    let resolution = resolver.with_conditions(conditions).resolve(&mut scene, Progress::none());
    let resolution = resolution.expect("a resolution");
    assert!(resolution.resolved, "{:?}", resolution.broken_limits);
}
