//! Faces carried beyond the band: each node takes the face of the nearest band node.
//!
//! That face is nearly always the node's own closest: one measurement per node instead of a
//! search, which errs by hundredths of a spacing only where two faces compete.

use glam::DVec3;
use surface::parallel;
use surface::progress::{Interrupted, Progress};

use super::spread::{MAX_REACH, seed_closeness, spread};
use super::{BandParams, Nearest};
use crate::FieldError;
use crate::memory::zeroed;
use crate::num::{coordinate, floor_index, single};
use crate::transform::{FAR, feature_transform};
use crate::units::GridSurface;

/// Distances over which faces were carried, which tell band nodes from other nodes.
pub(super) enum Carried {
    /// Within a reach: closeness of the nodes, and that of band nodes.
    Bounded { closeness: Vec<i16>, seed: i16 },
    /// Everywhere: squared distances from the nearest band node.
    Everywhere { squared: Vec<u32> },
}

impl Carried {
    /// Returns true if a node is beyond the band and has a face.
    #[inline]
    pub(super) fn is_carried(&self, node: usize) -> bool {
        match self {
            Self::Bounded { closeness, seed } => closeness[node] > 0 && closeness[node] != *seed,
            Self::Everywhere { squared } => squared[node] > 0,
        }
    }
}

/// Returns the bytes per node that a build holds at once: value, face and distance carried.
pub(crate) fn bytes_per_node(params: BandParams) -> f64 {
    if reach(params).is_some() { 4.0 + 4.0 + 2.0 } else { 4.0 + 4.0 + 4.0 }
}

/// Returns the distance over which faces are to be carried, in spacings, where that is
/// bounded and short.
///
/// A node within the truncation has, on the way to its closest point, a band node this far
/// from it: half a cell's diagonal is lost at either end.
fn reach(params: BandParams) -> Option<usize> {
    let reach = (params.truncation? - params.band + 3.0_f64.sqrt()).ceil().max(0.0);
    (reach <= coordinate(MAX_REACH)).then(|| floor_index(reach))
}

/// Carries faces to all nodes that may be within the truncation, or to all.
pub(super) fn carry(
    nearest: &mut Nearest,
    dims: [usize; 3],
    params: BandParams,
    progress: Progress<'_>,
) -> Result<Carried, FieldError> {
    let count = nearest.face.len();
    if let Some(reach) = reach(params) {
        let mut closeness = zeroed(count)?;
        spread(&mut nearest.face, &mut closeness, dims, reach, progress)?;
        return Ok(Carried::Bounded { closeness, seed: seed_closeness(reach) });
    }

    let mut squared = zeroed(count)?;
    let plane = dims[0] * dims[1];
    let planes = squared.chunks_mut(plane).zip(nearest.face.chunks(plane)).collect();
    parallel::for_each(planes, |_, (squared, faces): (&mut [u32], &[u32])| {
        for (squared, &face) in squared.iter_mut().zip(faces) {
            *squared = if face == 0 { FAR } else { 0 };
        }
    });
    feature_transform(&mut nearest.face, &mut squared, dims, progress)?;
    Ok(Carried::Everywhere { squared })
}

/// Relaxes the distances of carried nodes, once: each also tries the faces of its six
/// neighbors.
pub(super) fn relax(
    surface: &GridSurface<'_>,
    nearest: &mut Nearest,
    carried: &Carried,
    dims: [usize; 3],
    progress: Progress<'_>,
) -> Result<(), Interrupted> {
    let [nx, ny, _] = dims;
    let faces = &nearest.face;
    let mut planes: Vec<_> = nearest.squared.chunks_mut(nx * ny).collect();
    let steps = progress.steps(planes.len());
    parallel::try_for_each_mut(&mut planes, |k, plane| {
        steps.advance(1)?;
        for (n, squared) in plane.iter_mut().enumerate() {
            let node = n + k * nx * ny;
            if !carried.is_carried(node) {
                continue;
            }
            let here = [n % nx, n / nx, k];
            let p = DVec3::from_array(here.map(coordinate));
            for face in neighbors(here, dims).map(|neighbor| faces[neighbor]) {
                if face != 0 && face != faces[node] {
                    *squared = squared.min(single(surface.squared_distance(p, face - 1)));
                }
            }
        }
        Ok(())
    })
}

/// Returns the nodes next to a node along the axes.
fn neighbors(node: [usize; 3], dims: [usize; 3]) -> impl Iterator<Item = usize> {
    let strides = [1, dims[0], dims[0] * dims[1]];
    let here = node[0] + strides[1] * node[1] + strides[2] * node[2];
    (0..3).flat_map(move |axis| {
        let below = (node[axis] > 0).then(|| here - strides[axis]);
        let above = (node[axis] + 1 < dims[axis]).then(|| here + strides[axis]);
        below.into_iter().chain(above)
    })
}
