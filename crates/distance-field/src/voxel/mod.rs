//! Voxel method of the source: voxelization, Euclidean distance transform, flood fill.
//!
//! Distances are those from the nearest voxel's center: they err by half a spacing, and
//! directions by 20°, whatever the spacing.
//!
//! Source: B. Gilles, "Anatomical and kinematical modelling of the musculoskeletal system
//! from MRI", PhD thesis, University of Geneva, 2007, section 4.7.2.

mod flood;
mod voxelize;

use surface::progress::Progress;
use surface::{SurfaceError, TriangleSurface, parallel};

use crate::memory::zeroed;
use crate::sign::Inside;
use crate::transform::{FAR, feature_transform};
use crate::units::GridSurface;
use crate::{FieldError, Voxelization};

/// Bytes per node that a build holds at once: voxel, squared distance and state of the flood.
pub(crate) const BYTES_PER_NODE: f64 = 1.0 + 4.0 + 1.0;

/// Distances and inside of the voxel method.
pub(crate) struct VoxelField {
    /// Squared distances of all nodes from the nearest voxel of the surface, in spacings.
    pub(crate) squared: Vec<f32>,
    pub(crate) inside: Inside,
    /// Number of voxels that the surface switches on.
    pub(crate) surface_voxels: usize,
}

impl VoxelField {
    /// Builds distances and inside of a closed surface.
    pub(crate) fn new(
        surface: &GridSurface<'_>,
        dims: [usize; 3],
        voxelization: Voxelization,
        progress: Progress<'_>,
    ) -> Result<Self, FieldError> {
        check_closed(surface.surface)?;
        let count = dims.iter().product();
        let mut voxels = zeroed(count)?;
        voxelize::voxelize(surface, dims, voxelization, &mut voxels, progress.part(0.0, 0.3))?;

        let mut squared = zeroed(count)?;
        let plane = dims[0] * dims[1];
        let planes = squared.chunks_mut(plane).zip(voxels.chunks(plane)).collect();
        parallel::for_each(planes, |_, (squared, voxels): (&mut [u32], &[bool])| {
            for (squared, &is_on) in squared.iter_mut().zip(voxels) {
                *squared = if is_on { 0 } else { FAR };
            }
        });
        // Voxels have no labels.
        let mut labels = vec![(); count];
        feature_transform(&mut labels, &mut squared, dims, progress.part(0.3, 0.8))?;
        let squared = squared.into_iter().map(square_as_float).collect();

        let enclosed = flood::enclosed(&voxels, dims, progress.part(0.8, 1.0))?;
        let inside = Inside::from_mask(&enclosed, dims[0]);
        let surface_voxels = voxels.iter().filter(|is_on| **is_on).count();
        Ok(Self { squared, inside, surface_voxels })
    }
}

#[expect(clippy::cast_precision_loss, reason = "24 bits hold squares up to 4096 spacings")]
fn square_as_float(squared: u32) -> f32 {
    if squared == FAR { f32::INFINITY } else { squared as f32 }
}

/// Checks that every edge has an even number of faces, so that no path leads around the
/// surface.
fn check_closed(surface: &TriangleSurface) -> Result<(), FieldError> {
    let is_open = |edge: &u32| surface.edge_faces(*edge).len() % 2 == 1;
    let mut open = (0..).take(surface.edges().len()).filter(is_open);
    let Some(first) = open.next() else {
        return Ok(());
    };
    let [from, to] = surface.edges()[first as usize];
    let face = surface.edge_faces(first)[0];
    let source = SurfaceError::Open { count: 1 + open.count(), from, to, face };
    Err(FieldError::NotClosed { source })
}
