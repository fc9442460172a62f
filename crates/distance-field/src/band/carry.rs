//! Faces carried beyond the band: each node takes the face of the nearest band node.
//!
//! That face is nearly always the node's own closest: one measurement per node instead of a
//! search, which errs by hundredths of a spacing only where two faces compete.

use surface::progress::Progress;

use super::spread::{MAX_REACH, seed_closeness, spread};
use super::{BandParams, Nearest};
use crate::FieldError;
use crate::memory::zeroed;
use crate::num::{coordinate, floor_index};
use crate::transform::feature_transform;

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
    if let Some(reach) = reach(params) {
        let mut closeness = zeroed(nearest.face.len())?;
        spread(&mut nearest.face, &mut closeness, dims, reach, progress)?;
        return Ok(Carried::Bounded { closeness, seed: seed_closeness(reach) });
    }

    let squared = feature_transform(&mut nearest.face, dims, progress)?;
    Ok(Carried::Everywhere { squared })
}
