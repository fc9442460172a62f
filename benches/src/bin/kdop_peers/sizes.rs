//! Meshes of mixed sizes, from the folder that `MUSCULO_DATA` names: candidates beside the pairs of
//! triangles that really are that close.

use std::path::Path;
use std::time::Duration;

use benches::ratio::{amount, interleave};
use fixtures::{Mesh, data};
use glam::DVec3;
use kdop::{DopTree, Leaves, Workspace};
use surface::closest_between_triangles;

/// Prints the table, or that it is skipped.
pub(crate) fn print() {
    let Some(folder) = data::anatomy("mixed sizes") else {
        return;
    };
    println!(
        "pair                        faces      margin mm  candidates k=6, k=18  exact  pairs us"
    );
    for (a, b) in [
        ("vhf_left_thigh/bone_pelvis", "vhf_left_thigh/muscle_psoas_major"),
        ("vhf_left_joints/cartilage_tibia_medial", "vhf_left_thigh/bone_tibia"),
    ] {
        let (a, b) = (Body::read(&folder, a), Body::read(&folder, b));
        for margin in [0.0, 0.1, 1.0, 5.0] {
            line(&a, &b, margin);
        }
    }
}

fn line(a: &Body, b: &Body, margin: f64) {
    let boxes = candidates(&a.tree::<3>(), &b.tree(), margin);
    let (tree_a, tree_b) = (a.tree::<9>(), b.tree());
    let dops = candidates(&tree_a, &tree_b, margin);
    let near = |&(i, j): &(u32, u32)| {
        closest_between_triangles(a.corners(i), b.corners(j)).distance() <= margin
    };
    let exact = dops.iter().filter(|pair| near(pair)).count();
    let mut workspace = Workspace::new();
    let [timing] = interleave(
        Duration::from_millis(100),
        [&mut || {
            let mut count = 0;
            tree_a.pairs(&tree_b, margin, &mut workspace, |_, _| count += 1);
            count
        }],
    );
    let name = format!("{}, {}", a.name, b.name);
    let faces = format!("{}, {}", a.mesh.faces.len(), b.mesh.faces.len());
    let (boxes, dops, time) = (boxes.len(), dops.len(), timing.least * 1e-3);
    println!("{name} ({faces})  {margin:>4}  {boxes:>8} {dops:>8} {exact:>8} {time:>10.1}");
    let share = amount(exact) / amount(dops.max(1));
    println!("    exact share of the candidates: {share:.3}");
}

fn candidates<const S: usize>(a: &DopTree<S>, b: &DopTree<S>, margin: f64) -> Vec<(u32, u32)> {
    let mut out = Vec::new();
    a.pairs(b, margin, &mut Workspace::new(), |i, j| out.push((i, j)));
    out
}

/// A surface and what it is called.
struct Body {
    name: String,
    mesh: Mesh,
}

impl Body {
    fn read(folder: &Path, path: &str) -> Self {
        let name = path.rsplit('/').next().unwrap_or(path).to_owned();
        Self { name, mesh: data::mesh(&folder.join(path).with_extension("ply")) }
    }

    fn tree<const S: usize>(&self) -> DopTree<S> {
        let Mesh { positions, faces } = &self.mesh;
        DopTree::build(Leaves::Triangles(faces), positions).expect("a valid mesh")
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.mesh.corners(triangle as usize)
    }
}
