//! Real muscles, where the folder of `MUSCULO_DATA` holds them: the error of a hundred balls, their
//! bounds, and errors that no change of the method may increase.
#![expect(clippy::print_stdout, reason = "measured values are printed")]

use fixtures::data;
use kdop::Workspace;
use medial::{MedialParams, PrimitiveTree, Topology};
use surface::progress::Progress;

use crate::support::generated;

#[test]
fn a_hundred_balls_approximate_a_psoas() {
    let Some(folder) = data::anatomy("a_hundred_balls_approximate_a_psoas") else {
        return;
    };
    let mesh = data::mesh(&folder.join("vhf_left_thigh_lo/muscle_psoas_major.ply"));
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).unwrap();
    let made = generated(&mesh, &MedialParams::balls(100)).unwrap();
    assert!(made.deviation.rms < 0.4, "{:?}", made.deviation);
    let tree = PrimitiveTree::new(&made.medial).unwrap();
    let workspace = &mut Workspace::default();
    for corners in surface.faces() {
        let [a, b, c] = x.corners(*corners);
        let found = tree.nearest(&made.medial, (a + b + c) / 3.0, workspace);
        assert!(found.foot.distance <= made.deviation.surface_to_medial.upper);
    }
    let inside = Topology::of_inside(&surface, x).unwrap();
    assert_eq!(Topology::of_union(&made.medial, 1.0, Progress::none()).unwrap(), inside);
}

/// A few quick sizes of coarse muscles, each a few percent below its limit: which of two equally good
/// balls is kept is up to rounding. Without removal by the error at samples, the errors exceed the limits.
#[test]
fn errors_do_not_increase() {
    let Some(folder) = data::anatomy("errors_do_not_increase") else {
        return;
    };
    let rows = [
        ("psoas_major", 50, 0.59),
        ("vastus_lateralis", 50, 0.66),
        ("vastus_lateralis", 200, 0.268),
        ("gluteus_medius", 100, 0.395),
        ("vastus_intermedius", 400, 0.145),
    ];
    for (name, balls, limit) in rows {
        let mesh = data::mesh(&folder.join(format!("vhf_left_thigh_lo/muscle_{name}.ply")));
        let made = generated(&mesh, &MedialParams::balls(balls)).unwrap();
        let rms = made.deviation.rms;
        println!("measured: {balls} balls of a coarse {name}, mm rms | {rms:.3} | {limit}");
        assert!(rms < limit, "{name}, {balls} balls: {rms}");
        assert_eq!(made.medial.balls().len(), balls);
    }
}
