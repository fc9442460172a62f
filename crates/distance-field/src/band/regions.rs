//! Exact distances in the band, by the characteristics of faces, edges and vertices.
//!
//! A node's closest point lies in a face, on an edge or at a vertex, and then the node lies
//! in the prism over that face, in the wedge between the normals of the edge's faces or in
//! the cone between those of the vertex's. These regions hardly overlap: visiting the nodes
//! of each costs little more than visiting the band once, where splatting the box of each
//! face visits most nodes dozens of times.
//!
//! The regions need no closed or oriented surface. Whatever its faces, a node whose closest
//! point is inside an edge is on the outer side of every face at that edge; leaving out a
//! condition, or widening one against rounding, only makes a region larger, and every region
//! measures true distances to its own element. So no node of the band is skipped, and none
//! gets a distance that is too short by more than twice [`WIDENING`].
//!
//! Source: S. Mauch, "Efficient Algorithms for Solving Static Hamilton–Jacobi Equations",
//! PhD thesis, California Institute of Technology, 2003, chapter on the closest point
//! transform. Differs in taking any list of faces, and in its search of the nodes in a region:
//! those of small elements are searched four at a time, layer by layer ([`narrow`]), and all others
//! by clipping rows of nodes against the sides of a region ([`rows`]).
//!
//! [`narrow`]: super::narrow
//! [`rows`]: super::rows
//! [`WIDENING`]: super::sides::WIDENING

use std::cmp::Reverse;

use glam::DVec3;
use surface::parallel;
use surface::progress::{Interrupted, Progress};

use super::Nearest;
use super::narrow::{cones, prisms, wedges};
use super::slab::{Nodes, Slab};
use crate::num::nodes_within;
use crate::units::GridSurface;

/// Maximum number of planes of nodes per task.
const SLAB: usize = 32;

/// Elements between two progress reports.
const REPORT: usize = 1024;

/// Computes squared distances and faces of every node within `band` spacings of the surface.
///
/// Among faces at the same distance the first wins, whatever the order of work.
pub(super) fn fill(
    surface: &GridSurface<'_>,
    dims: [usize; 3],
    band: f64,
    nearest: &mut Nearest,
    progress: Progress<'_>,
) -> Result<(), Interrupted> {
    // An even number of slabs: of three, one of two threads would have two.
    let count = dims[2].div_ceil(SLAB).next_multiple_of(2);
    let (plane, height) = (dims[0] * dims[1], dims[2].div_ceil(count));
    let bins = Bins::new(surface, dims[2], height, band);
    let nodes = plane * height;
    let parts = nearest.squared.chunks_mut(nodes).zip(nearest.face.chunks_mut(nodes));
    let mut slabs = Vec::new();
    for (number, (squared, face)) in parts.enumerate() {
        let planes = number * height..number * height + squared.len() / plane;
        slabs.push(Slab::new(number, dims, planes, band, Nodes { squared, face }));
    }

    // The most work first, so that no thread is left with it at the end.
    slabs.sort_by_key(|slab| Reverse(bins.load(slab.number)));
    let steps = progress.steps(slabs.iter().map(|slab| bins.load(slab.number)).sum());
    parallel::try_for_each_mut(&mut slabs, |_, slab| {
        let regions: [fn(&GridSurface<'_>, &[u32], &mut Slab<'_>); 3] = [prisms, wedges, cones];
        for (kind, region) in bins.kinds.iter().zip(regions) {
            for elements in kind[slab.number].chunks(REPORT) {
                steps.advance(elements.len())?;
                region(surface, elements, slab);
            }
        }
        Ok(())
    })
}

/// Elements near each slab.
struct Bins {
    /// Faces, edges and vertices: of each kind, one list per slab.
    kinds: Vec<Vec<Vec<u32>>>,
}

impl Bins {
    /// Lists the elements near each slab of `height` planes.
    fn new(grid: &GridSurface<'_>, planes: usize, height: usize, band: f64) -> Self {
        let GridSurface { surface, x, .. } = grid;
        let size = [planes, height];
        let kinds = parallel::map(3, |kind| match kind {
            0 => bin(surface.faces().iter().map(|face| heights(x, face)), size, band),
            1 => bin(surface.edges().iter().map(|edge| heights(x, edge)), size, band),
            _ => bin(x.iter().map(|p| [p.z, p.z]), size, band),
        });
        Self { kinds }
    }

    /// Returns the number of elements near a slab.
    fn load(&self, slab: usize) -> usize {
        self.kinds.iter().map(|kind| kind[slab].len()).sum()
    }
}

/// Returns the lowest and the highest z of some vertices.
fn heights(x: &[DVec3], vertices: &[u32]) -> [f64; 2] {
    let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
    for &vertex in vertices {
        let z = x[vertex as usize].z;
        (lowest, highest) = (lowest.min(z), highest.max(z));
    }
    [lowest, highest]
}

/// Lists the elements that come within the band of each slab, by the numbers of all planes and of
/// those of a slab.
fn bin(
    heights: impl Iterator<Item = [f64; 2]>,
    [planes, height]: [usize; 2],
    band: f64,
) -> Vec<Vec<u32>> {
    let mut bins = vec![Vec::new(); planes.div_ceil(height)];
    for (element, [lower, upper]) in (0_u32..).zip(heights) {
        let near = nodes_within(lower - band, upper + band, planes);
        if !near.is_empty() {
            for bin in &mut bins[near.start / height..=(near.end - 1) / height] {
                bin.push(element);
            }
        }
    }
    bins
}

#[cfg(test)]
mod tests {
    use fixtures::Mesh;
    use fixtures::femur::femur;
    use fixtures::generate::cases;

    use super::*;
    use crate::FieldGrid;
    use crate::band::rows::{cone, prism, wedge};

    /// Computes the band around a mesh with small elements four at a time, and with the rows of
    /// all elements clipped.
    fn both_ways(mesh: &Mesh, band: f64) -> [Vec<f32>; 2] {
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).expect("finite");
        let bounds = surface::Aabb::of_points(mesh.positions.iter().copied());
        let dims = (bounds.max - bounds.min + 2.0 * band).to_array();
        let dims = dims.map(|side| crate::num::floor_index(side) + 2);
        let grid = FieldGrid::new(bounds.min - band, 1.0, dims).expect("small");
        let grid_surface = GridSurface::new(&surface, x, &grid);

        let count = dims.iter().product();
        let [mut fast, mut slow] =
            [(); 2].map(|()| Nearest { squared: vec![0.0; count], face: vec![0; count] });
        fill(&grid_surface, dims, band, &mut fast, Progress::none()).expect("not interrupted");
        let nodes = Nodes { squared: &mut slow.squared, face: &mut slow.face };
        let mut slab = Slab::new(0, dims, 0..dims[2], band, nodes);
        let kinds = [surface.faces().len(), surface.edges().len(), mesh.positions.len()];
        let regions: [fn(&GridSurface<'_>, u32, &mut Slab<'_>); 3] = [prism, wedge, cone];
        for (count, region) in kinds.into_iter().zip(regions) {
            for element in (0_u32..).take(count) {
                region(&grid_surface, element, &mut slab);
            }
        }
        [fast, slow].map(|Nearest { squared, face }| {
            let found = squared.into_iter().zip(face);
            found.map(|(squared, face)| if face == 0 { f32::NAN } else { squared.sqrt() }).collect()
        })
    }

    fn assert_equal(mesh: &Mesh, band: f64) {
        let [fast, slow] = both_ways(mesh, band);
        for (node, (fast, slow)) in fast.into_iter().zip(slow).enumerate() {
            // At the rim of the band, rounding decides.
            let is_rim = [fast, slow].iter().any(|d| f64::from(*d) > band - 1e-5);
            let is_equal = (fast - slow).abs() < 4e-6 || (fast.is_nan() && slow.is_nan());
            assert!(is_rim || is_equal, "{node}: {fast} {slow} of {band}");
        }
    }

    #[test]
    fn small_elements_are_near_the_nodes_that_rows_find() {
        for (cell, scale) in [(8.0, 0.1), (8.0, 0.3), (5.0, 0.4)] {
            for band in [1.75, 3.0, 5.5] {
                assert_equal(&femur(cell).mapped(|p| scale * p), band);
            }
        }
    }

    #[test]
    fn small_elements_of_any_shape_are_near_the_nodes_that_rows_find() {
        cases(31, 300, |u| {
            let size = u.int_in_range(1..=60_i32)?;
            let mut coordinate = || Ok(f64::from(u.int_in_range(0..=size)?) / 10.0);
            let mut mesh = Mesh::default();
            for _ in 0..6 {
                mesh.positions.push(DVec3::new(coordinate()?, coordinate()?, coordinate()?));
            }
            for _ in 0..u.int_in_range(1..=10)? {
                let mut corner = || u.int_in_range(0..=5_u32);
                mesh.faces.push([corner()?, corner()?, corner()?]);
            }
            assert_equal(&mesh, 3.0);
            Ok(())
        });
    }
}
