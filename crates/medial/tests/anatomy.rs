//! A real muscle, where the folder of `MUSCULO_DATA` holds it: how near a hundred
//! balls come, that both bounds hold, and that no change of the method loses what it
//! once reached.
#![expect(clippy::print_stdout, reason = "what is measured is told")]

use fixtures::data;
use kdop::Workspace;
use medial::{MedialParams, PrimitiveTree, Topology, generate};

#[test]
fn a_hundred_balls_are_a_psoas() {
    let Some(folder) = data::anatomy("a_hundred_balls_are_a_psoas") else {
        return;
    };
    let mesh = data::mesh(&folder.join("vhf_left_thigh_lo/muscle_psoas_major.ply"));
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).unwrap();
    let made = generate(&surface, x, &MedialParams::balls(100), |_| {}).unwrap();
    assert!(made.deviation.rms < 0.4, "{:?}", made.deviation);
    let tree = PrimitiveTree::new(&made.medial).unwrap();
    let workspace = &mut Workspace::default();
    for corners in surface.faces() {
        let [a, b, c] = x.corners(*corners);
        let found = tree.nearest(&made.medial, (a + b + c) / 3.0, workspace);
        assert!(found.foot.distance <= made.deviation.surface_to_medial.upper);
    }
    let inside = Topology::of_inside(&surface, x).unwrap();
    assert_eq!(Topology::of_union(&made.medial, 1.0).unwrap(), inside);
}

/// A few quick rows, of coarse muscles: little more than what balls that are taken
/// away by what the surface misses reach, and less than what they reach without.
#[test]
fn rows_do_not_get_worse() {
    let Some(folder) = data::anatomy("rows_do_not_get_worse") else {
        return;
    };
    let rows = [
        ("psoas_major", 50, 0.56),
        ("vastus_lateralis", 50, 0.66),
        ("vastus_lateralis", 200, 0.268),
        ("gluteus_medius", 100, 0.379),
        ("vastus_intermedius", 400, 0.145),
    ];
    for (name, balls, most) in rows {
        let mesh = data::mesh(&folder.join(format!("vhf_left_thigh_lo/muscle_{name}.ply")));
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).unwrap();
        let made = generate(&surface, x, &MedialParams::balls(balls), |_| {}).unwrap();
        let rms = made.deviation.rms;
        println!("measured: {balls} balls of a coarse {name}, mm rms | {rms:.3} | {most}");
        assert!(rms < most, "{name}, {balls} balls: {rms}");
        assert_eq!(made.medial.balls().len(), balls);
    }
}
