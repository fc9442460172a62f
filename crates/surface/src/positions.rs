//! Positions of a surface's vertices, with the proof that they are finite.
//!
//! Kernels take these instead of bare slices, so that they need no checks and no value
//! that is not a number can reach them.

use glam::DVec3;

use crate::{SurfaceError, TriangleSurface};

/// |V| finite positions of one surface's vertices, in the caller's length unit.
///
/// Made by [`TriangleSurface::positions`] and [`SimplexSurface::positions`].
///
/// [`SimplexSurface::positions`]: crate::SimplexSurface::positions
#[derive(Clone, Copy, Debug)]
pub struct Positions<'a>(&'a [DVec3]);

/// Owned [`Positions`]: |V| finite positions of one surface's vertices.
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
    pub fn corners(self, face: [u32; 3]) -> [DVec3; 3] {
        face.map(|vertex| self.at(vertex))
    }
}

impl PositionBuffer {
    /// Returns the positions, with the proof that they are finite.
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
    /// Checks that `x` holds one finite position per vertex.
    ///
    /// # Errors
    ///
    /// - [`SurfaceError::PositionCount`] when the length differs.
    /// - [`SurfaceError::NotFinite`] with the first vertex that is not finite.
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

/// Checks that there are `expected` positions, all finite.
fn check(expected: usize, x: impl Iterator<Item = DVec3>) -> Result<(), SurfaceError> {
    let mut got = 0;
    for at in x {
        if !at.is_finite() {
            return Err(SurfaceError::NotFinite { vertex: got, at });
        }
        got += 1;
    }
    if got == expected { Ok(()) } else { Err(SurfaceError::PositionCount { expected, got }) }
}
