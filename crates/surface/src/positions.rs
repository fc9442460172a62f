//! Positions of a surface's vertices, checked once.
//!
//! Kernels take these instead of bare slices, so that they carry no checks and
//! no value that is not a number can reach them.

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

/// Two successive states of one surface: |V| finite positions at the start and
/// at the end of a step, between which each vertex moves on a straight line.
///
/// Made by [`TriangleSurface::motion`].
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    x0: Positions<'a>,
    x1: Positions<'a>,
}

impl<'a> Positions<'a> {
    pub(crate) fn check(vertex_count: usize, x: &'a [DVec3]) -> Result<Self, SurfaceError> {
        if x.len() != vertex_count {
            return Err(SurfaceError::PositionCount { expected: vertex_count, got: x.len() });
        }
        match x.iter().position(|p| !p.is_finite()) {
            Some(vertex) => {
                let DVec3 { x, y, z } = x[vertex];
                Err(SurfaceError::NotFinite { vertex, x, y, z })
            }
            None => Ok(Self(x)),
        }
    }

    /// All positions, one a vertex.
    #[must_use]
    pub fn as_slice(self) -> &'a [DVec3] {
        self.0
    }

    /// Position of one vertex.
    ///
    /// # Panics
    ///
    /// When `vertex` is not below the surface's vertex count.
    #[must_use]
    pub fn at(self, vertex: u32) -> DVec3 {
        self.0[vertex as usize]
    }

    /// Positions of a face's three corners.
    ///
    /// # Panics
    ///
    /// When an index is not below the surface's vertex count.
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
        let (expected, mut got) = (self.0.len(), 0);
        for p in x.clone() {
            if !p.is_finite() {
                let DVec3 { x, y, z } = p;
                return Err(SurfaceError::NotFinite { vertex: got, x, y, z });
            }
            got += 1;
        }
        if got != expected {
            return Err(SurfaceError::PositionCount { expected, got });
        }

        for (old, new) in self.0.iter_mut().zip(x) {
            *old = new;
        }
        Ok(())
    }
}

impl<'a> Motion<'a> {
    /// Positions at the start of the step.
    #[must_use]
    pub fn start(self) -> Positions<'a> {
        self.x0
    }

    /// Positions at the end of the step.
    #[must_use]
    pub fn end(self) -> Positions<'a> {
        self.x1
    }
}

impl TriangleSurface {
    /// Checks that `x` holds one finite position for each vertex.
    ///
    /// # Errors
    ///
    /// - [`SurfaceError::PositionCount`] when the length is another.
    /// - [`SurfaceError::NotFinite`] with the first vertex that is not finite.
    pub fn positions<'a>(&self, x: &'a [DVec3]) -> Result<Positions<'a>, SurfaceError> {
        Positions::check(self.vertex_count(), x)
    }

    /// Takes over positions, checked as [`Self::positions`] does.
    ///
    /// # Errors
    ///
    /// As [`Self::positions`].
    pub fn own_positions(&self, x: Vec<DVec3>) -> Result<PositionBuffer, SurfaceError> {
        self.positions(&x)?;
        Ok(PositionBuffer(x))
    }

    /// Checks both ends of a step as [`Self::positions`] does.
    ///
    /// # Errors
    ///
    /// As [`Self::positions`], for whichever end fails first.
    pub fn motion<'a>(&self, x0: &'a [DVec3], x1: &'a [DVec3]) -> Result<Motion<'a>, SurfaceError> {
        Ok(Motion { x0: self.positions(x0)?, x1: self.positions(x1)? })
    }
}
