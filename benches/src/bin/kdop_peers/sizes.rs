//! Meshes of mixed sizes, from the folder that `MUSCULO_DATA` names: candidates beside the pairs of
//! triangles that really are that close.

use std::path::Path;
use std::time::Duration;

use benches::ratio::{amount, interleave};
use glam::DVec3;
use kdop::{DopTree, Leaves, Workspace};
use surface::closest_between_triangles;

/// Prints the table, or that it is skipped.
pub(crate) fn print() {
    let Some(folder) = std::env::var_os("MUSCULO_DATA") else {
        println!("mixed sizes: skipped, MUSCULO_DATA is not set");
        return;
    };
    let folder = Path::new(&folder).join("anatomy");
    println!(
        "pair                        faces      margin mm  candidates k=6, k=18  exact  pairs us"
    );
    for (a, b) in [
        ("vhf_left_thigh/bone_pelvis", "vhf_left_thigh/muscle_psoas_major"),
        ("vhf_left_joints/cartilage_tibia_medial", "vhf_left_thigh/bone_tibia"),
    ] {
        let (Some(a), Some(b)) = (Mesh::read(&folder, a), Mesh::read(&folder, b)) else {
            println!("{a} and {b}: skipped, not both there");
            continue;
        };
        for margin in [0.0, 0.1, 1.0, 5.0] {
            line(&a, &b, margin);
        }
    }
}

fn line(a: &Mesh, b: &Mesh, margin: f64) {
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
    let faces = format!("{}, {}", a.triangles.len(), b.triangles.len());
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

/// A surface as its file holds it.
struct Mesh {
    name: String,
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Reads little-endian PLY with float coordinates and faces of three; `None` where it is not.
    fn read(folder: &Path, name: &str) -> Option<Self> {
        let bytes = std::fs::read(folder.join(name).with_extension("ply")).ok()?;
        let end = b"end_header\n";
        let start = bytes.windows(end.len()).position(|window| window == end)? + end.len();
        let header = std::str::from_utf8(&bytes[..start]).ok()?;
        let count = |element: &str| {
            let line = header.lines().find_map(|line| line.strip_prefix(element))?;
            line.trim().parse::<usize>().ok()
        };
        let (vertices, faces) = (count("element vertex")?, count("element face")?);
        let (points, rest) = bytes[start..].split_at_checked(12 * vertices)?;
        let word = |bytes: &[u8]| bytes.try_into().map(u32::from_le_bytes);
        let coordinates: Vec<f64> = points
            .chunks_exact(4)
            .map(|bytes| word(bytes).map(|bits| f64::from(f32::from_bits(bits))))
            .collect::<Result<_, _>>()
            .ok()?;
        let triangle = |face: &[u8]| {
            Some([word(&face[1..5]).ok()?, word(&face[5..9]).ok()?, word(&face[9..13]).ok()?])
        };
        Some(Self {
            name: name.rsplit('/').next()?.to_owned(),
            points: coordinates.chunks_exact(3).map(DVec3::from_slice).collect(),
            triangles: rest.chunks_exact(13).take(faces).map(triangle).collect::<Option<_>>()?,
        })
    }

    fn tree<const S: usize>(&self) -> DopTree<S> {
        DopTree::build(Leaves::Triangles(&self.triangles), &self.points).expect("a valid mesh")
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|i| self.points[i as usize])
    }
}
