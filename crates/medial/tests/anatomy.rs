//! A real muscle, where the folder of `MUSCULO_DATA` holds it: how near a hundred
//! balls come, and that both bounds hold.

use fixtures::data;
use kdop::Workspace;
use medial::{Params, PrimitiveTree, Topology, generate};

#[test]
fn a_hundred_balls_are_a_psoas() {
    let Some(folder) = data::anatomy("a_hundred_balls_are_a_psoas") else {
        return;
    };
    let mesh = data::mesh(&folder.join("vhf_left_thigh_lo/muscle_psoas_major.ply"));
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).unwrap();
    let made = generate(&surface, x, &Params::balls(100), |_| {}).unwrap();
    assert!(made.deviation.rms < 0.4, "{:?}", made.deviation);
    let tree = PrimitiveTree::new(&made.medial).unwrap();
    let workspace = &mut Workspace::default();
    for corners in surface.faces() {
        let [a, b, c] = x.corners(*corners);
        let found = tree.nearest(&made.medial, (a + b + c) / 3.0, workspace);
        assert!(found.foot.distance <= made.deviation.surface_to_medial.at_most);
    }
    let inside = Topology::of_inside(&surface, x).unwrap();
    assert_eq!(Topology::of_union(&made.medial, 1.0).unwrap(), inside);
}
