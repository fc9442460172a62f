//! Meshes from files, and time of the processor.

use std::path::{Path, PathBuf};

use benches::ratio::amount;
use glam::DVec3;
use surface::TriangleSurface;

/// A closed surface at rest.
pub(crate) struct Body {
    pub(crate) surface: TriangleSurface,
    pub(crate) x: Vec<DVec3>,
}

impl Body {
    /// Mean of the vertices.
    pub(crate) fn middle(&self) -> DVec3 {
        self.x.iter().sum::<DVec3>() / amount(self.x.len())
    }

    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.surface.faces()[face as usize].map(|vertex| self.x[vertex as usize])
    }
}

/// The folder of the bodies, if the environment names one.
pub(crate) fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("MUSCULO_DATA")?).join("anatomy/vhf_left_thigh");
    folder.is_dir().then_some(folder)
}

/// Names of all muscles, in order.
pub(crate) fn muscles(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder can be read");
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| Some(name.strip_prefix("muscle_")?.strip_suffix(".ply")?.to_owned()))
        .collect();
    names.sort_unstable();
    names
}

/// Reads a muscle: a binary little-endian PLY file of single precision.
pub(crate) fn muscle(folder: &Path, name: &str) -> Body {
    let path = folder.join(format!("muscle_{name}.ply"));
    let bytes = std::fs::read(path).expect("the muscle's file can be read");
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
pub(crate) fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = stat.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    nanoseconds.unwrap_or(0.0) * 1e-9
}
