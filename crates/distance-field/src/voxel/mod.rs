//! Voxel method of the source: voxelization, Euclidean distance transform, flood fill.
//!
//! Distances are those from the nearest voxel's center: they err by half a spacing, and
//! directions by 20°, whatever the spacing.
//!
//! A flood from outside does not reach a closed cavity either. Unlike the source, each region that
//! it does not reach is therefore tested at a node deep in it, and is outside where the surface does
//! not enclose that. Regions that leak through the surface stay inside.
//!
//! Source: B. Gilles, "Anatomical and kinematical modelling of the musculoskeletal system
//! from MRI", PhD thesis, University of Geneva, 2007, section 4.7.2.

mod flood;
mod regions;
mod voxelize;

use surface::progress::{Interrupted, Progress};
use surface::{SurfaceError, TriangleSurface};

use crate::memory::zeroed;
use crate::transform::{FAR, feature_transform};
use crate::units::GridSurface;
use crate::voxel::regions::EnclosedRegions;
use crate::{FieldError, Voxelization};

/// Bytes per node that a build holds at once: voxel, squared distance and state of the flood.
pub(crate) const BYTES_PER_NODE: f64 = 1.0 + 4.0 + 1.0;

/// Distances and inside of the voxel method.
pub(crate) struct VoxelField {
    /// Squared distances of all nodes from the nearest voxel of the surface, in spacings.
    pub(crate) squared: Vec<f32>,
    /// Per node, true if the flood does not reach it, nor is it part of a cavity.
    pub(crate) inside: Vec<bool>,
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
        let mut voxels = zeroed(dims.iter().product())?;
        voxelize::voxelize(surface, dims, voxelization, &mut voxels, progress.part(0.0, 0.3))?;
        let surface_voxels = count(&voxels);
        let inside = flood::enclosed(&voxels, dims, progress.part(0.3, 0.5))?;

        // The voxels are the labels of the transform, which overwrites them.
        let squared = feature_transform(&mut voxels, dims, progress.part(0.5, 1.0))?;
        let squared = squared.into_iter().map(square_as_float).collect();
        Ok(Self { squared, inside, surface_voxels })
    }

    /// Takes the cavities from the inside: the regions of it whose nodes are outside by
    /// `are_outside`, which returns one flag per node of its list.
    pub(crate) fn remove_cavities(
        &mut self,
        dims: [usize; 3],
        are_outside: impl Fn(&[usize]) -> Result<Vec<bool>, Interrupted>,
    ) -> Result<(), Interrupted> {
        // Where there are too many regions to count, all of them stay inside.
        let Some(regions) = EnclosedRegions::new(&self.inside, dims) else { return Ok(()) };
        let mut is_cavity = are_outside(&regions.deep_nodes(&self.squared))?;
        if !is_cavity.contains(&true) {
            return Ok(());
        }

        // Where voxels leak, a region is partly enclosed: it stays inside, lest solid parts are lost.
        let (nodes, region_of) = regions.middles(&is_cavity);
        for (region, is_outside) in region_of.into_iter().zip(are_outside(&nodes)?) {
            is_cavity[region] &= is_outside;
        }
        regions.remove(&is_cavity, &mut self.inside);
        Ok(())
    }
}

/// Counts the nodes that are true.
pub(crate) fn count(nodes: &[bool]) -> usize {
    nodes.iter().map(|&is_on| usize::from(is_on)).sum()
}

#[expect(clippy::cast_precision_loss, reason = "24 bits hold squares up to 4096 spacings")]
fn square_as_float(squared: u32) -> f32 {
    if squared == FAR { f32::INFINITY } else { squared as f32 }
}

/// Checks that every edge has an even number of faces, so that no path leads around the
/// surface.
fn check_closed(surface: &TriangleSurface) -> Result<(), FieldError> {
    let mut first = None;
    let mut count = 0;
    for (edge, &ends) in (0..).zip(surface.edges()) {
        if surface.edge_faces(edge).len() % 2 == 1 {
            first = first.or(Some((edge, ends)));
            count += 1;
        }
    }
    let Some((edge, [from, to])) = first else {
        return Ok(());
    };
    let face = surface.edge_faces(edge)[0];
    Err(FieldError::NotClosed { source: SurfaceError::Open { count, from, to, face } })
}
