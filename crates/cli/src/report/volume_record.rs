//! Record of a volume mesh: its size and the quality of its elements.

use mesh_io::Volume;
use musculo_collide::volume_mesh::MeshQuality;
use serde::Serialize;

use super::text::counted;

/// Volume mesh as it was read.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct VolumeRecord {
    nodes: usize,
    elements: usize,
    #[serde(flatten)]
    quality: QualityRecord,
}

/// Quality of a mesh's elements.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct QualityRecord {
    /// Smallest scaled Jacobian of an element.
    pub(crate) min_scaled_jacobian: f64,
    /// Element that has it, by its number in the file.
    pub(crate) worst_element: u64,
    /// Number of elements that are inverted or flat.
    pub(crate) inverted_elements: usize,
}

impl VolumeRecord {
    pub(crate) fn new(volume: &Volume) -> Self {
        let quality = QualityRecord::new(&volume.mesh.quality(&volume.nodes), volume);
        Self { nodes: volume.nodes.len(), elements: volume.mesh.cells().len(), quality }
    }

    /// Describes inverted elements, if there are any.
    pub(super) fn defect(&self) -> Option<String> {
        let QualityRecord { inverted_elements, worst_element, min_scaled_jacobian } = self.quality;
        (inverted_elements > 0).then(|| {
            format!(
                "{} inverted or flat, the worst is {worst_element} with a scaled Jacobian of \
                 {min_scaled_jacobian:.3}",
                counted(inverted_elements, "element")
            )
        })
    }
}

impl QualityRecord {
    pub(crate) fn new(quality: &MeshQuality, volume: &Volume) -> Self {
        Self {
            min_scaled_jacobian: quality.min_scaled_jacobian,
            worst_element: volume.cell_numbers[quality.worst_cell],
            inverted_elements: quality.inverted,
        }
    }
}
