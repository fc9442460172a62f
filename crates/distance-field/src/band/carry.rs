//! Faces carried beyond the band: each node takes the face of the nearest band node.
//!
//! That face is nearly always the node's own closest: one measurement per node instead of a
//! search. Where two faces compete, near medial planes and edges, distances may be too large. On
//! the way from a node to its closest point, at √3/2 less than the half width of the band from
//! that point, there is a node of the band within √3/2: so the nearest one and its face are
//! farther than the closest point by at most √3 spacings.

use surface::progress::Progress;

use super::BandParams;
use super::spread::{MAX_REACH, MAX_SHORT_REACH, spread};
use crate::FieldError;
use crate::memory::zeroed;
use crate::num::{coordinate, floor_index};
use crate::transform::feature_transform;

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
    face: &mut [u32],
    dims: [usize; 3],
    params: BandParams,
    progress: Progress<'_>,
) -> Result<(), FieldError> {
    // Over a short reach a search is faster than the transform, and takes half its memory.
    match reach(params) {
        Some(reach) if reach <= MAX_SHORT_REACH => {
            spread::<u8>(face, &mut zeroed(face.len())?, dims, reach, progress)?;
        }
        Some(reach) => spread::<i16>(face, &mut zeroed(face.len())?, dims, reach, progress)?,
        None => drop(feature_transform(face, dims, progress)?),
    }
    Ok(())
}
