//! Sequence of coarser surfaces, and the choice among them.

use std::sync::Arc;

use glam::DVec3;
use proximity::SurfaceTree;
use surface::TriangleSurface;
use surface::progress::Progress;

use crate::coarse_map::CoarseMap;
use crate::collapsed::Collapsed;
use crate::map_builder::{MapBuilder, Mapped};
use crate::order::{Collapse, Collapses, Order};
use crate::surfaces::{Coarse, Full};
use crate::{DecimateError, ReducedSurface};

/// Edge collapses of a surface into its own vertices, in order of cost: every prefix of the
/// sequence is a coarser surface.
#[derive(Clone, Debug)]
pub struct Decimation {
    full: SurfaceTree,
    collapses: Collapses,
}

/// Shares of the allowed deviation that prefixes of the sequence may take. More find one that passes on
/// worse surfaces.
const SHARES: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];

/// Largest number of surfaces that are tried beyond a prefix: two or three pass, mostly.
const MAX_ROUNDS: u32 = 8;

/// Surface after some collapses, or the vertices of the full surface where it deviates too much.
enum Tried {
    Within(ReducedSurface),
    Beyond(Vec<u32>),
}

impl Decimation {
    /// Collapses edges as far as topology and shape allow.
    ///
    /// # Errors
    ///
    /// As [`up_to`](Self::up_to).
    pub fn new(full: SurfaceTree, progress: Progress<'_>) -> Result<Self, DecimateError> {
        Self::up_to(full, f64::INFINITY, progress)
    }

    /// Collapses edges as far as surfaces within a deviation (length, `> 0`, may be infinite) need.
    ///
    /// [`within`](Self::within) finds the same surfaces then for deviations up to it, and may find
    /// finer ones for others.
    ///
    /// # Errors
    ///
    /// - [`DecimateError::Surface`] for a surface that is not closed, manifold and oriented.
    /// - [`DecimateError::RepeatedVertex`] or [`DecimateError::TooSmall`] for one that
    ///   encloses nothing.
    /// - [`DecimateError::MaxDeviation`] for a deviation that is not positive.
    /// - [`DecimateError::Interrupted`] when the progress handler ends the call.
    pub fn up_to(
        full: SurfaceTree,
        max_deviation: f64,
        progress: Progress<'_>,
    ) -> Result<Self, DecimateError> {
        check(full.surface())?;
        if max_deviation.is_nan() || max_deviation <= 0.0 {
            return Err(DecimateError::MaxDeviation { value: max_deviation });
        }
        let x = full.positions().as_slice();
        let max_cost = max_deviation * max_deviation;
        let collapses = Collapses::find(full.surface().faces(), x, max_cost, progress)?;
        Ok(Self { full, collapses })
    }

    /// Returns the full surface.
    #[must_use]
    pub fn full(&self) -> &SurfaceTree {
        &self.full
    }

    /// Finds a coarse surface that is proved to deviate from the full one by at most
    /// `max_deviation` (length, `> 0`, finite), as [`ReducedSurface::deviation`] says.
    ///
    /// Returns the full surface, with bound 0, where every coarser one that is tried deviates more.
    ///
    /// # Errors
    ///
    /// - [`DecimateError::MaxDeviation`] for a deviation out of range.
    /// - [`DecimateError::Interrupted`] when the progress handler ends the call.
    pub fn within(
        &self,
        max_deviation: f64,
        progress: Progress<'_>,
    ) -> Result<ReducedSurface, DecimateError> {
        if !max_deviation.is_finite() || max_deviation <= 0.0 {
            return Err(DecimateError::MaxDeviation { value: max_deviation });
        }

        // A prefix that goes as far as allowed, half as far, and so on, until one passes.
        let max_cost = max_deviation * max_deviation;
        let (mut failed, mut done) = (Vec::new(), 0.0);
        let (mut base, mut coarsest) = (&self.collapses.list[..0], self.unreduced());
        for share in SHARES {
            let collapses = self.collapses.within(share * share * max_cost);
            let part = progress.part(done, 0.5 + 0.5 * done);
            done = 0.5 + 0.5 * done;
            match self.reduced(collapses, max_deviation, part)? {
                Tried::Within(reduced) => {
                    (base, coarsest) = (collapses, reduced);
                    break;
                }
                Tried::Beyond(vertices) => failed.extend(vertices),
            }
        }
        let part = progress.part(done, 1.0);
        Ok(self.beyond(base, failed, max_deviation, part)?.unwrap_or(coarsest))
    }

    /// Continues a prefix as far as allowed, but around the vertices where maps have failed; `None`
    /// where none have, or they fail in ever more places.
    fn beyond(
        &self,
        base: &[Collapse],
        mut failed: Vec<u32>,
        max_deviation: f64,
        progress: Progress<'_>,
    ) -> Result<Option<ReducedSurface>, DecimateError> {
        if failed.is_empty() {
            return Ok(None);
        }
        let (faces, x) = (self.full.surface().faces(), self.full.positions().as_slice());
        let Collapsed { moved_into, kept, .. } = Collapsed::new(x.len(), faces, base);
        let mut start = Order::new(faces, x);
        start.repeat(base);

        let mut done = 0.0;
        for _ in 0..MAX_ROUNDS {
            // Around the last failures, the faces stay as the prefix has left them.
            for vertex in failed.drain(..) {
                start.keep_around(moved_into[vertex as usize]);
            }
            let mut collapses = base.to_vec();
            start.clone().append(&kept, max_deviation * max_deviation, &mut collapses);

            let part = progress.part(done, 0.5 + 0.5 * done);
            done = 0.5 + 0.5 * done;
            match self.reduced(&collapses, max_deviation, part)? {
                Tried::Within(reduced) => return Ok(Some(reduced)),
                Tried::Beyond(vertices) => failed = vertices,
            }
        }
        Ok(None)
    }

    /// Returns the surface after some collapses, if it is proved to deviate by no more than
    /// `max_deviation`.
    fn reduced(
        &self,
        collapses: &[Collapse],
        max_deviation: f64,
        progress: Progress<'_>,
    ) -> Result<Tried, DecimateError> {
        if collapses.is_empty() {
            return Ok(Tried::Within(self.unreduced()));
        }
        let (full, x) = (self.full.surface(), self.full.positions().as_slice());
        let Collapsed { moved_into, kept, faces } =
            Collapsed::new(x.len(), full.faces(), collapses);
        let surface = TriangleSurface::new(kept.len(), faces)?;
        let kept_x: Vec<DVec3> = kept.iter().map(|&vertex| x[vertex as usize]).collect();

        // The map proves the deviation.
        let coarse = Coarse { surface: &surface, x: &kept_x };
        let full = Full { surface: full, x, kept: &kept, moved_into: &moved_into };
        let map = match MapBuilder::build(full, coarse, max_deviation, progress)? {
            Mapped::Whole(map) => map,
            Mapped::Failed(vertices) => return Ok(Tried::Beyond(vertices)),
        };
        let deviation = map.max_shift(x, &kept_x);
        if deviation > max_deviation {
            return Ok(Tried::Beyond(Vec::new()));
        }
        let reduced = ReducedSurface { surface: Arc::new(surface), kept, deviation, map };
        Ok(Tried::Within(reduced))
    }

    /// Returns the full surface, which deviates by nothing.
    fn unreduced(&self) -> ReducedSurface {
        let surface = self.full.shared_surface();
        let kept = (0..).take(surface.vertex_count()).collect();
        let map = CoarseMap::default();
        ReducedSurface { surface, kept, deviation: 0.0, map }
    }
}

/// Checks that a surface is closed, manifold and oriented, and encloses something.
pub(crate) fn check(surface: &TriangleSurface) -> Result<(), DecimateError> {
    for (face, &[a, b, c]) in surface.faces().iter().enumerate() {
        if a == b || b == c || c == a {
            let vertex = if b == c { b } else { a };
            return Err(DecimateError::RepeatedVertex { face, vertex });
        }
    }
    surface.require_closed()?;
    surface.require_manifold()?;
    surface.require_oriented()?;
    let faces = surface.faces().len();
    if faces < 4 { Err(DecimateError::TooSmall { faces }) } else { Ok(()) }
}
