//! Reduced surface that follows the deformation of the full one.

use std::sync::Arc;

use glam::DVec3;
use kdop::Workspace;
use proximity::{NoInside, ProximityError, SurfaceTree};
use surface::progress::{Interrupted, Progress};
use surface::{Barycentric, Csr, parallel};

use crate::{DecimateError, ReducedSurface};

/// Reduced surface for collision queries, which follows the deformation of the full one.
///
/// Every vertex of the full surface is attached to its closest point on the reduced one, so
/// that displacements of the reduced surface carry over to the full one (linear skinning).
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
/// let mut coarse = CoarseSurface::new(reduced, decimation.full(), Progress::none())?;
///
/// // It follows the full surface.
/// let lifted: Vec<DVec3> = ball.positions.iter().map(|p| *p + DVec3::Z).collect();
/// coarse.follow(&lifted)?;
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
    /// Per vertex of the full surface, its point of attachment.
    attachments: Vec<Attachment>,
    /// Per face, the vertices of the full surface that are attached to it.
    attached: Csr,
}

/// Point of a coarse surface.
#[derive(Clone, Copy, Debug)]
struct Attachment {
    face: u32,
    weights: Barycentric,
}

/// Vertices between two polls for interruption: some milliseconds. Fewer cost time; more delay the
/// end of an interrupted call.
const POLL_INTERVAL: usize = 1024;

impl CoarseSurface {
    /// Attaches a full surface to a reduced one of it, which is declared open where the full
    /// one is.
    ///
    /// # Errors
    ///
    /// - [`DecimateError::Proximity`] where a tree over the reduced surface cannot be built.
    /// - [`DecimateError::Interrupted`] when the progress handler ends the call.
    ///
    /// # Panics
    ///
    /// When `reduced` is of another surface with more vertices.
    pub fn new(
        reduced: ReducedSurface,
        full: &SurfaceTree,
        progress: Progress<'_>,
    ) -> Result<Self, DecimateError> {
        let x = full.positions().as_slice();
        let mut positions = Vec::new();
        reduced.gather(x, &mut positions);
        let mut tree = SurfaceTree::new(Arc::clone(&reduced.surface), positions)?;
        if full.has_inside() == Err(NoInside::DeclaredOpen) {
            tree = tree.declared_open();
        }

        // Polls every few vertices: on a large surface, each takes microseconds.
        let steps = progress.steps(x.len());
        let pieces: Vec<&[DVec3]> = x.chunks(POLL_INTERVAL).collect();
        let attached = parallel::map_slice_with(&pieces, Workspace::default, |workspace, piece| {
            steps.advance(piece.len())?;
            Ok::<_, Interrupted>(attach_all(&tree, piece, workspace))
        });
        let attachments = attached.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
        let faces = attachments.iter().map(|attachment| attachment.face);
        let pairs: Vec<(u32, u32)> = faces.zip(0..).collect();
        let attached = Csr::new(reduced.surface.faces().len(), &pairs);
        Ok(Self { reduced, tree, attachments, attached })
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

    /// Moves it to new positions of the full surface. Allocates nothing.
    ///
    /// # Errors
    ///
    /// [`ProximityError::Surface`] where a position is not finite; nothing has then changed.
    ///
    /// # Panics
    ///
    /// When there are fewer positions than the full surface has vertices.
    pub fn follow(&mut self, full: &[DVec3]) -> Result<(), ProximityError> {
        let positions = self.reduced.kept.iter().map(|&vertex| full[vertex as usize]);
        self.tree.set_positions(positions)
    }

    /// Carries displacements of the kept vertices over to all vertices of the full surface.
    ///
    /// # Panics
    ///
    /// When there are fewer displacements than the full surface has vertices.
    pub fn spread(&self, displacements: &mut [DVec3]) {
        let mut kept = Vec::new();
        self.reduced.gather(displacements, &mut kept);
        let faces = self.reduced.surface.faces();
        for (displacement, attachment) in displacements.iter_mut().zip(&self.attachments) {
            let [a, b, c] = faces[attachment.face as usize].map(|corner| kept[corner as usize]);
            let [u, v, w] = attachment.weights;
            *displacement = u * a + v * b + w * c;
        }
    }

    /// Returns the kept vertices that a vertex of the full surface moves with, and their weights;
    /// a kept vertex moves with itself alone.
    ///
    /// # Panics
    ///
    /// When there is no such vertex.
    #[must_use]
    pub fn leaders(&self, vertex: u32) -> [(u32, f64); 3] {
        let Attachment { face, weights } = self.attachments[vertex as usize];
        let corners = self.reduced.surface.faces()[face as usize];
        [0, 1, 2].map(|k| (self.reduced.kept[corners[k] as usize], weights[k]))
    }

    /// Returns the vertices of the full surface that are attached to a face, ascending.
    ///
    /// # Panics
    ///
    /// When there is no such face.
    #[must_use]
    pub fn attached_to(&self, face: u32) -> &[u32] {
        self.attached.row(face)
    }

    /// Returns its memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.tree.bytes()
            + size_of_val(&self.reduced.kept[..])
            + size_of_val(&self.attachments[..])
            + self.attached.bytes()
    }
}

/// Finds the closest point of a surface with faces, for each of several points.
fn attach_all(tree: &SurfaceTree, points: &[DVec3], workspace: &mut Workspace) -> Vec<Attachment> {
    let mut attachments = Vec::with_capacity(points.len());
    for &point in points {
        attachments.push(match tree.closest_point(point, f64::INFINITY, None, workspace) {
            Some(closest) => Attachment { face: closest.face, weights: closest.foot.barycentric },
            None => Attachment { face: 0, weights: [1.0, 0.0, 0.0] },
        });
    }
    attachments
}
