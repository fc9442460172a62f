//! Exact band: exact distances near the surface, and beyond it exact distances to the face
//! that is closest to the nearest node of the band.

mod carry;
mod layers;
mod measure;
mod narrow;
mod quasi;
mod regions;
mod rows;
mod sides;
mod slab;
mod spread;

use surface::progress::Progress;

pub(crate) use self::carry::bytes_per_node;
pub(crate) use self::quasi::{MAX_CORRECTION, quasi_interpolate};
use crate::FieldError;
use crate::memory::zeroed;
use crate::units::GridSurface;

/// Parameters of the exact band, in spacings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BandParams {
    pub(crate) band: f64,
    pub(crate) truncation: Option<f64>,
}

/// Squared distances in spacings and faces, one per node.
#[derive(Debug)]
struct Nearest {
    /// Squared distance of a band node, [`ON_SURFACE`] in place of 0, which other nodes have.
    squared: Vec<f32>,
    /// One more than the number of the nearest face; 0 where none is found.
    face: Vec<u32>,
}

/// Squared distance of a band node on the surface: equal to 0, with other bits.
const ON_SURFACE: f32 = -0.0;

/// Computes the squared distances of all nodes, in spacings; infinite beyond the truncation.
pub(crate) fn squared_distances(
    surface: &GridSurface<'_>,
    dims: [usize; 3],
    params: BandParams,
    progress: Progress<'_>,
) -> Result<Vec<f32>, FieldError> {
    let count = dims.iter().product();
    let mut nearest = Nearest { squared: zeroed(count)?, face: zeroed(count)? };
    regions::fill(surface, dims, params.band, &mut nearest, progress.part(0.0, 0.4))?;

    carry::carry(&mut nearest.face, dims, params, progress.part(0.4, 0.7))?;
    measure::measure(surface, &mut nearest, dims, progress.part(0.7, 1.0))?;
    Ok(nearest.squared)
}
