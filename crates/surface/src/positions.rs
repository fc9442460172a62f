//! Positions of a surface's vertices, with the proof that geometry can be computed with
//! them.
//!
//! Kernels take these instead of bare slices, so that they need no checks: no value that is
//! not a number can reach them, and no product overflows.

use glam::DVec3;

use crate::range::{MAX_COORDINATE, MIN_SIZE};
use crate::{SurfaceError, TriangleSurface};

/// |V| positions of one surface's vertices, in the caller's length unit, finite and in range.
///
/// Made by [`TriangleSurface::positions`] and [`SimplexSurface::positions`].
///
/// [`SimplexSurface::positions`]: crate::SimplexSurface::positions
#[derive(Clone, Copy, Debug)]
pub struct Positions<'a>(&'a [DVec3]);

/// Owned [`Positions`]: |V| positions of one surface's vertices, finite and in range.
///
/// Made by [`TriangleSurface::own_positions`].
#[derive(Clone, Debug, PartialEq)]
pub struct PositionBuffer(Vec<DVec3>);

impl<'a> Positions<'a> {
    pub(crate) fn new(vertex_count: usize, x: &'a [DVec3]) -> Result<Self, SurfaceError> {
        check(vertex_count, x.iter().copied())?;
        Ok(Self(x))
    }

    /// Returns all positions, one per vertex.
    #[inline]
    #[must_use]
    pub fn as_slice(self) -> &'a [DVec3] {
        self.0
    }

    /// Returns the position of one vertex.
    ///
    /// # Panics
    ///
    /// When `vertex` is not below the surface's vertex count.
    #[inline]
    #[must_use]
    pub fn at(self, vertex: u32) -> DVec3 {
        self.0[vertex as usize]
    }

    /// Returns the positions of a face's three corners.
    ///
    /// # Panics
    ///
    /// When an index is not below the surface's vertex count.
    #[inline]
    #[must_use]
    pub fn corners(self, [a, b, c]: [u32; 3]) -> [DVec3; 3] {
        // Written out: a map over the array may stay a call for each.
        [self.at(a), self.at(b), self.at(c)]
    }
}

impl PositionBuffer {
    /// Returns the positions, with the proof that they are finite and in range.
    #[must_use]
    pub fn as_positions(&self) -> Positions<'_> {
        Positions(&self.0)
    }

    /// Replaces all positions.
    ///
    /// The iterator is run twice: values are checked before the first is written.
    ///
    /// # Errors
    ///
    /// As [`TriangleSurface::positions`]; the old positions are then kept.
    pub fn overwrite(
        &mut self,
        x: impl Iterator<Item = DVec3> + Clone,
    ) -> Result<(), SurfaceError> {
        check(self.0.len(), x.clone())?;
        for (old, new) in self.0.iter_mut().zip(x) {
            *old = new;
        }
        Ok(())
    }
}

impl TriangleSurface {
    /// Checks that `x` holds one position per vertex, finite and in range.
    ///
    /// # Errors
    ///
    /// - [`SurfaceError::PositionCount`] when the length differs.
    /// - [`SurfaceError::NotFinite`] with the first vertex that is not finite.
    /// - [`SurfaceError::TooLarge`] with the first vertex beyond [`MAX_COORDINATE`].
    /// - [`SurfaceError::TooSmall`] where no coordinate reaches [`MIN_SIZE`], and not all are
    ///   zero.
    pub fn positions<'a>(&self, x: &'a [DVec3]) -> Result<Positions<'a>, SurfaceError> {
        Positions::new(self.vertex_count(), x)
    }

    /// Takes ownership of positions, checked as by [`Self::positions`].
    ///
    /// # Errors
    ///
    /// As [`Self::positions`].
    pub fn own_positions(&self, x: Vec<DVec3>) -> Result<PositionBuffer, SurfaceError> {
        self.positions(&x)?;
        Ok(PositionBuffer(x))
    }
}

/// Checks that there are `expected` positions, all finite and in range.
fn check(expected: usize, x: impl Iterator<Item = DVec3> + Clone) -> Result<(), SurfaceError> {
    // No branch per vertex; the first one that is out of range is looked up where there is any.
    let (mut got, mut largest, mut are_in_range) = (0, DVec3::ZERO, true);
    for at in x.clone() {
        are_in_range &= is_in_range(at);
        let size = at.abs();
        largest = DVec3::select(size.cmpgt(largest), size, largest);
        got += 1;
    }
    if !are_in_range && let Some((vertex, at)) = x.enumerate().find(|(_, at)| !is_in_range(*at)) {
        return Err(out_of_range(vertex, at));
    }

    if got != expected {
        return Err(SurfaceError::PositionCount { expected, got });
    }
    let largest = largest.max_element();
    if largest > 0.0 && largest < MIN_SIZE {
        return Err(SurfaceError::TooSmall { largest });
    }
    Ok(())
}

/// Returns true unless a coordinate is too large or not a number.
#[inline(always)]
fn is_in_range(at: DVec3) -> bool {
    at.abs().cmple(DVec3::splat(MAX_COORDINATE)).all()
}

/// Returns the error of a position with a coordinate that is not finite or too large.
fn out_of_range(vertex: usize, at: DVec3) -> SurfaceError {
    if !at.is_finite() {
        return SurfaceError::NotFinite { vertex, at };
    }
    let coordinates = at.to_array().into_iter();
    let value = coordinates.fold(0.0, |max: f64, c| if c.abs() > max.abs() { c } else { max });
    SurfaceError::TooLarge { vertex, value }
}

/// Returns the bits of a position, the same for −0 as for 0.
pub(crate) fn place_bits(at: DVec3) -> [u64; 3] {
    (at + DVec3::ZERO).to_array().map(f64::to_bits)
}
