//! Topology of a union of balls: parts, tunnels and cavities, counted on a grid.
//!
//! The connectivity of the primitives does not give the topology of the volume: slabs that lie in
//! each other leave pockets in the complex that are none in the union. So the union itself is
//! sampled at grid points, which are joined along the axes. The Euler number of the squares and
//! cubes between them, with the parts of inside and outside, gives the rest.
//!
//! Necks, gaps and holes narrower than a grid cell count as they are on the grid.

mod grid;

use surface::progress::Progress;
use surface::{Positions, TriangleSurface, inspect};

use self::grid::Grid;
use crate::{MedialError, MedialSurface};

/// Share of the time after which grid points are marked.
const FILLED: f64 = 0.77;

/// Share of the time after which parts of the inside are counted.
const INSIDE_COUNTED: f64 = 0.79;

/// Share of the time after which parts of the outside are counted.
const OUTSIDE_COUNTED: f64 = 0.81;

/// Topology of a volume, by its Betti numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Topology {
    /// Number of connected parts.
    pub components: usize,
    /// Number of independent tunnels: one for a ring.
    pub tunnels: i64,
    /// Number of enclosed spaces that are outside.
    pub cavities: usize,
}

impl Topology {
    /// Computes the topology of the union of balls of a medial surface, on a grid with this
    /// `spacing`.
    ///
    /// # Errors
    ///
    /// - [`MedialError::Parameter`] for a spacing that is not positive and finite.
    /// - [`MedialError::TooMany`] for a spacing that is too fine for the size, before anything is
    ///   allocated.
    /// - [`MedialError::Interrupted`] by `progress`.
    pub fn of_union(
        medial: &MedialSurface,
        spacing: f64,
        progress: Progress<'_>,
    ) -> Result<Self, MedialError> {
        if !spacing.is_finite() || spacing <= 0.0 {
            let range = "positive and finite";
            return Err(MedialError::Parameter { name: "spacing", value: spacing, range });
        }
        let mut grid = Grid::around(medial.bounds(), spacing)?;
        grid.fill(medial, progress.part(0.0, FILLED))?;

        let components = grid.component_count(progress.part(FILLED, INSIDE_COUNTED))?;
        let outside = progress.part(INSIDE_COUNTED, OUTSIDE_COUNTED);
        let cavities = grid.outside_component_count(outside)?.saturating_sub(1);
        let euler = grid.euler_number(progress.part(OUTSIDE_COUNTED, 1.0))?;
        let tunnels = signed(components) + signed(cavities) - euler;
        Ok(Self { components, tunnels, cavities })
    }

    /// Computes the topology of the volume inside a closed manifold surface whose parts are not
    /// inside each other.
    ///
    /// # Errors
    ///
    /// [`MedialError::Surface`] for a surface that is open or not manifold.
    pub fn of_inside(surface: &TriangleSurface, x: Positions<'_>) -> Result<Self, MedialError> {
        surface.require_closed()?;
        surface.require_manifold()?;
        let inspection = inspect(surface, x);
        let components = inspection.components;
        let tunnels = signed(components) - inspection.euler / 2;
        Ok(Self { components, tunnels, cavities: 0 })
    }
}

#[expect(clippy::cast_possible_wrap, reason = "counts stay below 2^28")]
fn signed(count: usize) -> i64 {
    count as i64
}
