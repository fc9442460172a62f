//! Signs of damaged and of real surfaces, against the exact winding number.

use distance_field::{FieldMethod, FieldParams, FieldWarning, Voxelization};
use fixtures::{Mesh, data, shapes};
use surface::glam::DVec3;
use surface::winding_number;

use crate::support::{build, nodes};

/// All nodes that are chosen, rather than some.
const EVERY: usize = usize::MAX;

/// Nodes that were compared with the exact winding number, and those unlike it.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    compared: usize,
    wrong: usize,
}

impl Tally {
    /// Compares about `count` of the nodes that `choose` takes, evenly.
    fn add(
        &mut self,
        mesh: &Mesh,
        spacing: f64,
        count: usize,
        choose: impl Fn(f64, DVec3) -> bool,
    ) {
        let params = FieldParams { spacing, samples: 0, ..FieldParams::new(1.0) };
        let field = build(mesh, &params).unwrap();
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).unwrap();
        let way =
            if field.report().warnings.contains(&FieldWarning::Inverted) { -1.0 } else { 1.0 };
        let grid = *field.grid();
        let chosen: Vec<_> = nodes(grid.dims())
            .filter(|&node| choose(field.node(node), grid.position(node)))
            .collect();
        let step = chosen.len().div_ceil(count).max(1);
        for &node in chosen.iter().step_by(step) {
            let winding = way * winding_number(&surface, x, grid.position(node));
            if (winding - 0.5).abs() > 1e-9 {
                let is_wrong = (field.node(node) < 0.0) != (winding > 0.5);
                if is_wrong && self.wrong == 0 {
                    println!("first mismatch: {node:?}, {winding}");
                }
                self.wrong += usize::from(is_wrong);
                self.compared += 1;
            }
        }
    }

    /// Tells of the mismatches, of which there may be none, among at least so many.
    fn tell(self, name: &str, least: usize) {
        let Self { compared, wrong } = self;
        println!("measured: {name}: signs unlike the winding number's | {wrong} of {compared} | 0");
        assert!(wrong == 0 && compared >= least, "{name}: {wrong} of {compared}");
    }
}

/// Compares as [`Tally::add`] does; how many, if none was wrong.
fn check(mesh: &Mesh, spacing: f64, count: usize, choose: impl Fn(f64, DVec3) -> bool) -> usize {
    let mut tally = Tally::default();
    tally.add(mesh, spacing, count, choose);
    assert_eq!(tally.wrong, 0, "of {}", tally.compared);
    tally.compared
}

/// A ball of 1280 faces after three halvings of its edges, of 5120 after four.
fn ball(halvings: u32) -> Mesh {
    shapes::icosphere(30.0, halvings).translated(DVec3::new(0.31, 0.17, 0.23))
}

fn middle(mesh: &Mesh, face: usize) -> DVec3 {
    mesh.corners(face).into_iter().sum::<DVec3>() / 3.0
}

#[test]
fn holes_of_three_six_and_twelve_millimetres() {
    for width in [3.0, 6.0, 12.0] {
        let at = DVec3::new(0.48, 0.6, 0.64) * 30.0;
        let mut open = ball(4);
        let keep: Vec<bool> =
            (0..open.faces.len()).map(|f| middle(&open, f).distance(at) > width / 2.0).collect();
        let mut keep = keep.iter();
        open.faces.retain(|_| *keep.next().unwrap());
        let at_hole = |_: f64, p: DVec3| p.distance(at) < 1.5 * width;
        let mut tally = Tally::default();
        tally.add(&open, 1.5, 2000, at_hole);
        assert!(tally.compared > 20, "{tally:?}");
        tally.add(&open, 6.0, EVERY, |_, _| true);
        tally.tell(&format!("ball with a hole of {width} mm"), 2000);
    }
}

#[test]
fn one_face_in_twenty_turned_over() {
    let mut flipped = ball(3);
    for face in (0..flipped.faces.len()).step_by(20) {
        flipped.faces[face].swap(1, 2);
    }
    let mut tally = Tally::default();
    tally.add(&flipped, 1.5, 4000, |value, _| value.abs() < 3.0);
    tally.add(&flipped, 6.0, EVERY, |_, _| true);
    tally.tell("ball with one face in twenty turned over", 5000);
}

#[test]
fn overlapping_shells_and_repeated_faces() {
    let shells = ball(3).joined(&ball(3).translated(DVec3::new(21.0, 9.0, -4.0)));
    let mut tally = Tally::default();
    tally.add(&shells, 6.0, EVERY, |_, _| true);
    tally.add(&shells, 2.5, 800, |value, _| value.abs() < 3.0);
    tally.tell("two balls that overlap", 2700);
    let mut repeated = ball(3);
    let again: Vec<_> = repeated.faces.iter().copied().step_by(7).collect();
    repeated.faces.extend(again);
    assert!(check(&repeated, 1.5, 3000, |value, _| value.abs() < 3.0) > 2000);
    let mut opposite = ball(3);
    let again: Vec<_> = opposite.faces.iter().step_by(9).map(|&[a, b, c]| [a, c, b]).collect();
    opposite.faces.extend(again);
    assert!(check(&opposite, 1.5, 3000, |value, _| value.abs() < 3.0) > 2000);
}

/// Corners that are stored once for each face close no edge by number, but do
/// by position.
#[test]
fn corners_of_each_face_on_its_own() {
    let ball = ball(3);
    let positions: Vec<DVec3> = (0..ball.faces.len()).flat_map(|f| ball.corners(f)).collect();
    let faces = (0..).step_by(3).take(ball.faces.len()).map(|v| [v, v + 1, v + 2]).collect();
    let soup = Mesh { positions, faces };
    let params = FieldParams { spacing: 2.5, samples: 0, ..FieldParams::new(1.0) };
    let whole = build(&ball, &params).unwrap();
    let field = build(&soup, &params).unwrap();
    assert_eq!(field.report().warnings, []);
    assert_eq!(field.report().inside_volume, whole.report().inside_volume);
}

/// Faces in planes of nodes and edges along their rows.
#[test]
fn boxes_on_the_nodes_of_their_grid() {
    let cube = shapes::cube(12.0);
    assert!(check(&cube, 1.0, 4000, |_, _| true) > 3000);
    for face in 0..12 {
        let mut open = cube.clone();
        open.faces.remove(face);
        assert!(check(&open, 1.0, 2500, |_, p| p.abs().max_element() < 8.0) > 1500);
    }
}

/// Far from the origin, positions of nodes are rounded by more than vertices are off the rows.
#[test]
fn boxes_on_the_nodes_of_a_grid_far_from_the_origin() {
    let separating = Voxelization::SixSeparating;
    let methods = [
        FieldMethod::EXACT_BAND,
        FieldMethod::Voxel { voxelization: separating },
        FieldMethod::Voxel { voxelization: Voxelization::Conservative },
    ];
    for (edge, shift) in [(0.7, 312.3), (0.3, -187.7), (0.1, 85.1), (1.1, 1024.6), (0.0007, 0.3123)]
    {
        for layers in 4..8_u32 {
            let size = edge * DVec3::new(12.0, 10.0, f64::from(layers));
            let plate = shapes::plate(size, [12, 10]).translated(DVec3::splat(shift));
            let (lower, upper) = (shift - 0.5 * size, shift + 0.5 * size);
            for (method, padding) in methods
                .into_iter()
                .flat_map(|method| [2.0, 2.5, 10.0].map(|padding| (method, padding)))
            {
                let padding = padding * edge;
                let params = FieldParams { method, padding, samples: 0, ..FieldParams::new(edge) };
                let field = build(&plate, &params).unwrap();
                let grid = *field.grid();
                for node in nodes(grid.dims()) {
                    // Voxels of the surface are within half a spacing, at 0.
                    let x = grid.position(node);
                    let depth = (x - lower).min(upper - x).min_element();
                    if depth.abs() > 0.75 * edge {
                        let value = field.node(node);
                        assert!(value * depth < 0.0, "{params:?}: {value} at a depth of {depth}");
                    }
                }
            }
        }
    }
}

/// Nodes on the straight lines from the corners of a hole to its middle, and in the middle.
#[test]
fn nodes_between_the_border_and_the_middle_of_a_hole() {
    let cube = shapes::cube(12.0);
    let mut compared = 0;
    for corner in cube.positions.clone() {
        // The three sides at a corner: their border is a hexagon around the middle of the cube.
        let mut open = cube.clone();
        open.faces.retain(|face| {
            let sum: DVec3 = face.iter().map(|&vertex| cube.positions[vertex as usize]).sum();
            let center = sum / 3.0;
            (center * corner.signum()).max_element() > 5.0
        });
        assert_eq!(open.faces.len(), 6);
        compared += check(&open, 1.0, EVERY, |_, p| p.abs().max_element() < 8.0);
    }
    assert!(compared > 20_000, "{compared}");
}

/// On a closed surface that does not meet itself, the flood of the voxel method finds the
/// inside that the winding number finds, but for the voxels of the surface.
#[test]
fn flood_and_winding_number_agree() {
    let torus = shapes::torus(20.0, 6.0, [48, 24]);
    let with = |method| {
        let params = FieldParams { method, samples: 0, ..FieldParams::new(1.0) };
        build(&torus, &params).unwrap().values()
    };
    let exact = with(FieldMethod::EXACT_BAND);
    let voxels = with(FieldMethod::Voxel { voxelization: Voxelization::SixSeparating });
    let is_far = |value: f32| value.abs() > 1.5;
    let far: Vec<_> = exact.into_iter().zip(voxels).filter(|(exact, _)| is_far(*exact)).collect();
    assert!(far.iter().filter(|(exact, _)| *exact < 0.0).count() > 5_000);
    assert!(far.iter().all(|(exact, voxel)| (*exact < 0.0) == (*voxel < 0.0)));
}

/// Every damage that balls take above, on a real femur: some hundred nodes of the
/// band of each, more of them at holes. On the same femur in fewer faces, every
/// node of a coarser grid.
#[test]
fn damaged_copies_of_a_real_bone() {
    let Some(folder) = data::anatomy("damaged_copies_of_a_real_bone") else {
        return;
    };
    let bone = data::mesh(&folder.join("vhf_left_thigh/bone_femur.ply"));
    let mut chosen = Tally::default();
    let near = |value: f64, _: DVec3| value.abs() < 3.0;
    for (open, at, width) in with_holes(&bone, [3.0, 6.0, 12.0]) {
        let at_hole = |value: f64, p: DVec3| value.abs() < 3.0 && p.distance(at) < width + 3.0;
        chosen.add(&open, 1.0, 800, at_hole);
        chosen.add(&open, 2.0, 200, near);
    }
    for damaged in with_other_damage(&bone) {
        chosen.add(&damaged, 2.0, 800, near);
    }
    chosen.tell("damaged femurs, chosen nodes", 3000);
    let bone = data::mesh(&folder.join("vhf_left_thigh_lo/bone_femur.ply"));
    let mut every = Tally::default();
    let open = with_holes(&bone, [12.0, 20.0, 30.0]).into_iter().map(|(open, ..)| open);
    for damaged in open.chain(with_other_damage(&bone)) {
        every.add(&damaged, 12.0, EVERY, |_, _| true);
    }
    every.tell("damaged femurs, every node", 20_000);
}

/// A bone with a hole of each width, on another part of it each, and where that is.
fn with_holes(bone: &Mesh, widths: [f64; 3]) -> Vec<(Mesh, DVec3, f64)> {
    let mut damaged = Vec::new();
    for (width, from) in widths.into_iter().zip([1, 2, 5]) {
        let at = middle(bone, bone.faces.len() * from / 7);
        let kept = (0..bone.faces.len())
            .filter(|&face| middle(bone, face).distance(at) > width / 2.0)
            .map(|face| bone.faces[face]);
        let open = Mesh { positions: bone.positions.clone(), faces: kept.collect() };
        assert!(open.faces.len() < bone.faces.len(), "a hole");
        damaged.push((open, at, width));
    }
    damaged
}

/// Faces turned over, two shells that overlap, faces that are there twice.
fn with_other_damage(bone: &Mesh) -> [Mesh; 3] {
    let mut flipped = bone.clone();
    for face in (0..flipped.faces.len()).step_by(20) {
        flipped.faces[face].swap(1, 2);
    }
    let shells = bone.clone().joined(&bone.clone().translated(DVec3::new(7.3, 4.1, -5.7)));
    let mut repeated = bone.clone();
    repeated.faces.extend(bone.faces.iter().step_by(7));
    [flipped, shells, repeated]
}

#[test]
fn every_real_mesh() {
    let Some(folder) = data::anatomy("every_real_mesh") else {
        return;
    };
    let (mut meshes, mut tally) = (0, Tally::default());
    for set in ["vhf_left_thigh", "vhf_left_joints", "vhf_left_thigh_lo", "dirty"] {
        let mut paths: Vec<_> =
            std::fs::read_dir(folder.join(set)).unwrap().map(|file| file.unwrap().path()).collect();
        paths.sort();
        for path in paths.iter().filter(|path| path.extension().is_some_and(|e| e == "ply")) {
            let mesh = data::mesh(path);
            println!("{}: {} faces", path.display(), mesh.faces.len());
            let (near, all) = if set == "dirty" { (3000, 3000) } else { (60, 20) };
            tally.add(&mesh, 2.0, near, |value, _| value.abs() < 3.0);
            tally.add(&mesh, 4.0, all, |_, _| true);
            meshes += 1;
        }
    }
    assert!(meshes > 30, "{meshes}");
    tally.tell(&format!("{meshes} real meshes"), 2000);
}
