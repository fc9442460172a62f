//! Parts of a body that face the wrong way.

use fixtures::Mesh;
use fixtures::shapes::{cube, icosphere};
use glam::DVec3;
use proximity::SurfaceTree;

fn inverted(parts: &[Mesh]) -> Vec<u32> {
    let mut mesh = Mesh { positions: Vec::new(), faces: Vec::new() };
    for part in parts {
        mesh = mesh.joined(part);
    }
    let tree = SurfaceTree::new(mesh.surface(), mesh.positions).expect("positions are finite");
    let found = tree.inverted_parts();
    let mut vertices = (0..).take(tree.surface().vertex_count());
    let is_doubled = vertices.any(|vertex| tree.is_beside_doubled_place(vertex));
    assert_eq!(is_doubled, !found.is_empty(), "{found:?}");
    found.to_vec()
}

#[test]
fn parts_are_to_look_outward_in_the_open_and_inward_in_others() {
    let [outer, inner, core] = [10.0, 6.0, 2.0].map(cube);
    let beside = cube(4.0).translated(20.0 * DVec3::X);
    assert!(inverted(&[outer.clone(), beside.clone()]).is_empty());
    assert!(inverted(&[outer.clone(), inner.clone().flipped(), core.clone()]).is_empty());
    assert_eq!(inverted(&[outer.clone(), inner.clone()]), [8]);
    assert_eq!(inverted(&[inner.clone(), outer.clone()]), [0]);
    assert_eq!(inverted(&[outer.clone(), inner.flipped(), core.clone().flipped()]), [16]);
    assert_eq!(inverted(&[outer.clone(), beside.flipped()]), [8]);
    assert!(inverted(std::slice::from_ref(&core)).is_empty());

    // Reversed, the cavity makes the part in it right.
    assert_eq!(inverted(&[outer, cube(6.0), core]), [8]);
}

#[test]
fn parts_that_touch_cross_or_coincide_are_not_in_each_other() {
    let outer = cube(10.0);
    let flush = cube(4.0).translated(DVec3::new(7.0, 0.0, 0.0));
    let crossing = icosphere(3.0, 2).translated(DVec3::new(4.0, 0.0, 0.0));
    let lining = cube(6.0).flipped();
    assert!(inverted(&[outer.clone(), flush]).is_empty());
    assert!(inverted(&[outer.clone(), crossing]).is_empty());
    assert!(inverted(&[outer.clone(), outer.clone()]).is_empty());
    assert!(inverted(&[outer, lining, cube(6.0)]).is_empty());
}
