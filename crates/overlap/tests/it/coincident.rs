//! Bodies of one shape whose faces divide it in other ways.

use fixtures::Mesh;
use fixtures::shapes::cube;
use glam::DVec3;
use overlap::NearAreas;
use proximity::{PairProximity, PairSide, SurfaceTree};
use surface::progress::Progress;

fn tree(mesh: Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions).expect("planted bodies are finite")
}

#[test]
fn all_of_a_surface_is_near_one_that_coincides_with_it() {
    let (mut pair, mut areas) = (PairProximity::default(), NearAreas::default());
    for step in 0..200_u32 {
        let turns = f64::from(step) / 1000.0;
        let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
        let [a, b] = [cube(4.0), cube(4.0).rotated(DVec3::X, 0.25)]
            .map(|mesh| tree(mesh.rotated(axis, turns).translated(DVec3::new(3.0, 1.0, 7.0))));
        let margin = 0.3;
        pair.compute(&a, &b, margin).expect("few faces are near");
        let near_faces = pair.sides().map(PairSide::near_faces);
        let found = areas.measure([&a, &b], margin, near_faces, Progress::none());
        for area in found.expect("nothing interrupts") {
            assert!(area.upper >= 96.0 * (1.0 - 1e-12), "{area:?} turned by {turns}");
        }
    }
}
