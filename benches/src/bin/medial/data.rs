//! Meshes from files, and time of the processor.

use std::path::{Path, PathBuf};

use benches::ratio::amount;
use fixtures::data;
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

    /// Least and greatest corner of the box around it.
    pub(crate) fn bounds(&self) -> [DVec3; 2] {
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.x.iter().fold(empty, |[low, high], p| [low.min(*p), high.max(*p)])
    }

    /// Diagonal of that box.
    pub(crate) fn extent(&self) -> f64 {
        let [low, high] = self.bounds();
        low.distance(high)
    }

    /// The same body elsewhere.
    pub(crate) fn moved(&self, by: DVec3) -> Self {
        let x = self.x.iter().map(|p| *p + by).collect();
        Self { surface: self.surface.clone(), x }
    }

    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.surface.faces()[face as usize].map(|vertex| self.x[vertex as usize])
    }
}

/// The folder of the bodies, if the environment names one.
pub(crate) fn folder() -> Option<PathBuf> {
    Some(data::anatomy("medial surfaces of muscles")?.join("vhf_left_thigh"))
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

/// Reads a muscle.
pub(crate) fn muscle(folder: &Path, name: &str) -> Body {
    let mesh = data::mesh(&folder.join(format!("muscle_{name}.ply")));
    Body { surface: mesh.surface(), x: mesh.positions }
}

/// Time the processor has spent on this thread \[s\]: other programs do not count.
pub(crate) fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = stat.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    nanoseconds.unwrap_or(0.0) * 1e-9
}
