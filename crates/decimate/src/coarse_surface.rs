//! Reduced surface that follows the deformation of the full one.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use proximity::{ContactSurface, NoInside, ParticleNumbers, ProximityError, SurfaceTree};
use surface::{Term, TriangleSurface};

use crate::{DecimateError, ReducedSurface, coarse_map};

/// Reduced surface for collision queries, which follows the deformation of the full one.
///
/// Every vertex of the full surface is attached to a near point on the reduced one, so that
/// displacements of the reduced surface carry over to the full one (linear skinning), and the
/// deviation is bounded anew wherever it moves.
///
/// ```
/// use decimate::{CoarseSurface, Decimation};
/// use proximity::SurfaceTree;
/// use surface::glam::DVec3;
/// use surface::progress::Progress;
///
/// let ball = fixtures::shapes::icosphere(30.0, 4);
/// let full = SurfaceTree::new(ball.surface(), ball.positions.clone())?;
/// let decimation = Decimation::new(full, Progress::none())?;
/// let reduced = decimation.within(0.5, Progress::none())?;
/// let mut coarse = CoarseSurface::new(reduced, decimation.full())?;
///
/// // It follows the full surface.
/// let lifted: Vec<DVec3> = ball.positions.iter().map(|p| *p + DVec3::Z).collect();
/// coarse.follow(&lifted)?;
/// assert!(coarse.deviation() <= 0.5);
///
/// // The full surface yields with it.
/// let mut displacements = vec![DVec3::ZERO; lifted.len()];
/// for &vertex in &coarse.reduced().kept {
///     displacements[vertex as usize] = DVec3::X;
/// }
/// coarse.spread(&mut displacements);
/// assert!(displacements.iter().all(|by| by.distance(DVec3::X) < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CoarseSurface {
    reduced: ReducedSurface,
    tree: SurfaceTree,
    /// Proved deviation at the present positions, and where it was computed last.
    deviation: f64,
    deviation_at_bound: f64,
    /// Positions of the kept vertices that are tried.
    gathered: Vec<DVec3>,
}

impl CoarseSurface {
    /// Builds a tree over a reduced surface of a full one, at the positions of the full one, and bounds
    /// its deviation there. It is declared open where the full one is.
    ///
    /// # Errors
    ///
    /// [`DecimateError::Proximity`] where the tree cannot be built.
    ///
    /// # Panics
    ///
    /// When `reduced` is of another surface with more vertices.
    pub fn new(reduced: ReducedSurface, full: &SurfaceTree) -> Result<Self, DecimateError> {
        let mut gathered = Vec::new();
        reduced.gather(full.positions().as_slice(), &mut gathered);
        let mut tree = SurfaceTree::new(Arc::clone(&reduced.surface), gathered.clone())?;
        if full.has_inside() == Err(NoInside::DeclaredOpen) {
            tree = tree.declared_open();
        }
        let deviation = reduced.deviation_at(full.positions().as_slice(), &gathered);
        Ok(Self { reduced, tree, deviation, deviation_at_bound: deviation, gathered })
    }

    /// Returns the reduced surface.
    #[must_use]
    pub fn reduced(&self) -> &ReducedSurface {
        &self.reduced
    }

    /// Returns the reduced surface at its present positions.
    #[must_use]
    pub fn tree(&self) -> &SurfaceTree {
        &self.tree
    }

    /// Returns the proved bound on its deviation from the full surface at the present
    /// positions, as [`ReducedSurface::deviation`] is at those of the decimation.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// Moves it to new positions of the full surface, and bounds its deviation there. Allocates
    /// nothing.
    ///
    /// # Errors
    ///
    /// [`ProximityError::Surface`] where a position is not finite, or too far away to be compared;
    /// nothing has then changed. Vertices without faces do not count.
    ///
    /// # Panics
    ///
    /// When there are fewer positions than the full surface has vertices.
    pub fn follow(&mut self, full: &[DVec3]) -> Result<(), ProximityError> {
        self.follow_within(full, f64::INFINITY)?;
        Ok(())
    }

    /// Moves it to new positions of the full surface as [`follow`](Self::follow) does, if it deviates
    /// by no more than `max_deviation` there. Returns false where it deviates more, and stays where
    /// it was: that takes a part of the time.
    ///
    /// # Errors
    ///
    /// As [`follow`](Self::follow).
    ///
    /// # Panics
    ///
    /// As [`follow`](Self::follow).
    pub fn follow_within(
        &mut self,
        full: &[DVec3],
        max_deviation: f64,
    ) -> Result<bool, ProximityError> {
        self.reduced.gather(full, &mut self.gathered);
        let map = &self.reduced.map;
        let Some(deviation) = map.max_shift_within(full, &self.gathered, max_deviation) else {
            return Ok(false);
        };
        if deviation.is_infinite() {
            TriangleSurface::new(full.len(), Vec::new())?.positions(full)?;
        }
        self.tree.set_positions(self.gathered.iter().copied())?;
        self.deviation_at_bound = deviation;
        self.deviation = deviation;
        Ok(true)
    }

    /// Moves it to positions that the full surface has reached as one body, by a turn and a shift of
    /// `reference`, as those at which its deviation was bounded last. The deviation is then the same
    /// but for rounding: this takes the time of the reduced surface alone.
    ///
    /// # Errors
    ///
    /// As [`follow`](Self::follow).
    ///
    /// # Panics
    ///
    /// As [`follow`](Self::follow).
    pub fn follow_rigidly(
        &mut self,
        full: &[DVec3],
        reference: &[DVec3],
    ) -> Result<(), ProximityError> {
        self.move_to(full)?;

        // Both poses were rounded at the size of the reference, which may be far from them.
        let kept = self.tree.positions().as_slice().iter();
        let of_kept = self.reduced.kept.iter().map(|&vertex| &reference[vertex as usize]);
        let rounding = coarse_map::rounding(kept.chain(of_kept));
        self.deviation = self.deviation_at_bound + 2.0 * rounding;
        Ok(())
    }

    fn move_to(&mut self, full: &[DVec3]) -> Result<(), ProximityError> {
        let positions = self.reduced.kept.iter().map(|&vertex| full[vertex as usize]);
        self.tree.set_positions(positions)
    }

    /// Carries displacements of the kept vertices over to all vertices of the full surface.
    ///
    /// # Panics
    ///
    /// When there are fewer displacements than the full surface has vertices.
    pub fn spread(&self, displacements: &mut [DVec3]) {
        self.reduced.map.spread(displacements, &self.reduced.kept);
    }

    /// Returns the kept vertices that a vertex of the full surface moves with, and their weights;
    /// a kept vertex, or one without faces, moves with itself alone.
    #[must_use]
    pub fn leaders(&self, vertex: u32) -> [(u32, f64); 3] {
        let Some(image) = self.reduced.map.image(vertex) else {
            return [(vertex, 1.0), (vertex, 0.0), (vertex, 0.0)];
        };
        image.map(|(corner, weight)| (self.reduced.kept[corner as usize], weight))
    }

    /// Lists the particles of the full surface's vertices that move with others, each with these and their weights.
    pub fn followers(&self, particles: Range<u32>) -> impl Iterator<Item = (u32, [Term; 3])> {
        let first = particles.start;
        particles.filter_map(move |particle| {
            // Vertices that lead themselves were kept, or have no faces.
            let leaders = self.leaders(particle - first);
            let term = |(leader, weight)| Term { particle: first + leader, weight };
            (leaders[0].0 != particle - first).then(|| (particle, leaders.map(term)))
        })
    }

    /// Returns this surface as that of the contacts of a body: they are of the vertices that it has kept.
    #[must_use]
    pub fn contact_surface<'a>(&'a self, full: ContactSurface<'a>) -> ContactSurface<'a> {
        let particles = ParticleNumbers { kept: Some(&self.reduced.kept), ..full.particles };
        let (surface, positions) = (self.tree.surface(), self.tree.positions());
        ContactSurface { surface, positions, particles, ..full }
    }

    /// Returns its memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.tree.bytes()
            + size_of_val(&self.reduced.kept[..])
            + size_of_val(&self.gathered[..])
            + self.reduced.map.bytes()
    }
}
