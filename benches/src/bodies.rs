//! Closed bodies: read from files, how deep a point is in one, and time of the processor.
//!
//! Functions panic where a file is not what it should be: programs call them.

use std::path::{Path, PathBuf};

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use surface::{Pseudonormals, TriangleSurface, closest_on_triangle};

use crate::ratio::amount;

/// A closed surface where it is.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its connectivity.
    pub surface: TriangleSurface,
    /// Its vertices.
    pub x: Vec<DVec3>,
}

impl Body {
    /// Mean of the vertices.
    #[must_use]
    pub fn middle(&self) -> DVec3 {
        self.x.iter().sum::<DVec3>() / amount(self.x.len())
    }

    /// Corners of a face.
    #[must_use]
    pub fn corners(&self, face: u32) -> [DVec3; 3] {
        self.surface.faces()[face as usize].map(|vertex| self.x[vertex as usize])
    }
}

/// How deep points are in a body: the closest point by a tree over its faces, the side by the
/// normal there.
#[derive(Debug)]
pub struct Depth<'a> {
    body: &'a Body,
    normals: Pseudonormals,
    tree: Tree,
}

impl<'a> Depth<'a> {
    /// Looks at a body.
    ///
    /// # Panics
    ///
    /// When its vertices are not finite.
    #[must_use]
    pub fn new(body: &'a Body) -> Self {
        let x = body.surface.positions(&body.x).expect("finite positions");
        let leaves = Leaves::Triangles(body.surface.faces());
        let tree = Tree::build(leaves, &body.x).expect("finite positions");
        Self { body, normals: Pseudonormals::new(&body.surface, x), tree }
    }

    /// Depth of a point, negative outside; `-within` where the surface is not nearer than that.
    #[must_use]
    pub fn at(&self, p: DVec3, within: f64, workspace: &mut Workspace) -> f64 {
        let mut best = (within, -within);
        self.tree.nearest(p, within, workspace, |face, _| {
            let foot = closest_on_triangle(p, self.body.corners(face));
            let distance = foot.point.distance(p);
            if distance < best.0 {
                let signed = self.normals.signed_distance(&self.body.surface, p, face, &foot);
                best = (distance, -signed);
            }
            best.0
        });
        best.1
    }
}

/// The folder of the bodies, if the environment names one.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("MUSCULO_DATA")?).join("anatomy/vhf_left_thigh");
    folder.is_dir().then_some(folder)
}

/// Names of all muscles, in order.
///
/// # Panics
///
/// When the folder cannot be read.
#[must_use]
pub fn muscles(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder can be read");
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| Some(name.strip_prefix("muscle_")?.strip_suffix(".ply")?.to_owned()))
        .collect();
    names.sort_unstable();
    names
}

/// Reads a muscle.
///
/// # Panics
///
/// As [`body`].
#[must_use]
pub fn muscle(folder: &Path, name: &str) -> Body {
    body(folder, &format!("muscle_{name}"))
}

/// Reads a body: a binary little-endian PLY file of single precision.
///
/// # Panics
///
/// When the file cannot be read or is not such a file.
#[must_use]
pub fn body(folder: &Path, name: &str) -> Body {
    let path = folder.join(format!("{name}.ply"));
    let bytes = std::fs::read(path).expect("the body's file can be read");
    let mark = b"end_header\n";
    let end = bytes.windows(mark.len()).position(|w| w == mark).expect("a header") + mark.len();
    let header = std::str::from_utf8(&bytes[..end]).expect("a header in text");
    let count = |what: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(what)).expect("a count");
        line.trim().parse().expect("a number")
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let word = |at: usize| -> [u8; 4] { bytes[at..at + 4].try_into().expect("four bytes") };
    let point =
        |at: usize| DVec3::from([0, 4, 8].map(|k| f64::from(f32::from_le_bytes(word(at + k)))));
    let x = (0..vertices).map(|i| point(end + 12 * i)).collect();
    let start = end + 12 * vertices;
    let face = |i: usize| [1, 5, 9].map(|k| u32::from_le_bytes(word(start + 13 * i + k)));
    let surface = TriangleSurface::new(vertices, (0..faces).map(face).collect());
    Body { surface: surface.expect("valid indices"), x }
}

/// Time the processor has spent on this thread \[s\]: other programs do not count.
#[must_use]
pub fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = stat.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    nanoseconds.unwrap_or(0.0) * 1e-9
}
