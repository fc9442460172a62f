//! A body with as few of its vertices as a tolerance allows.

use decimate::{DecimateError, Decimation, ReducedSurface};
use glam::DVec3;
use kdop::Workspace;
use surface::{Barycentric, closest_on_triangle};

use super::count;
use proximity::{ProximityError, SurfaceTree};
use scene::{Body, BodyKind};

/// A coarser surface on some of a body's vertices, which follows the body.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) shape: SurfaceTree,
    /// Vertices of the body that it has, ascending.
    pub(super) kept: Vec<u32>,
    /// Where each of the body's vertices was on the coarser surface, by vertex.
    ties: Vec<Tie>,
    /// The body's vertices face after face of the coarser surface, and where the
    /// vertices of each face begin.
    tied: Vec<u32>,
    starts: Vec<u32>,
    /// No point of either surface was farther from the other, when it was built.
    pub(super) deviation: f64,
}

/// A point of a coarser surface.
#[derive(Clone, Copy, Debug)]
struct Tie {
    face: u32,
    weights: Barycentric,
}

/// The share of its vertices above which a body is rather taken as it is.
const WORTHWHILE: f64 = 0.7;

impl Level {
    /// The coarsest level within `deviation` of the body; none where that would
    /// save little.
    pub(super) fn of(
        body: &Body,
        decimation: &Decimation,
        deviation: f64,
    ) -> Result<Option<Self>, DecimateError> {
        let ReducedSurface { surface, kept, deviation } = decimation.within(deviation)?;
        let all = body.positions();
        if count(kept.len()) > WORTHWHILE * count(all.len()) {
            return Ok(None);
        }
        let positions = kept.iter().map(|&vertex| all[vertex as usize]).collect();
        let Ok(shape) = SurfaceTree::new(surface, positions) else { return Ok(None) };
        let is_open = body.kind() == BodyKind::Open;
        let shape = if is_open { shape.declared_open() } else { shape };
        let ties = ties(&shape, all);
        let (tied, starts) = by_face(&ties, shape.surface().faces().len());
        Ok(Some(Self { shape, kept, ties, tied, starts, deviation: deviation.largest() }))
    }

    /// The body's vertices that were nearest to a face of the coarser surface.
    pub(super) fn tied_to(&self, face: u32) -> &[u32] {
        let [from, to] = [face, face + 1].map(|face| self.starts[face as usize] as usize);
        &self.tied[from..to]
    }

    /// Goes where the body is.
    pub(super) fn follow(&mut self, body: &Body) -> Result<(), ProximityError> {
        let all = body.positions();
        self.shape.set_positions(self.kept.iter().map(|&vertex| all[vertex as usize]))
    }

    /// Bytes it holds.
    pub(super) fn bytes(&self) -> usize {
        let by_face = size_of_val(&self.tied[..]) + size_of_val(&self.starts[..]);
        self.shape.bytes() + size_of_val(&self.kept[..]) + size_of_val(&self.ties[..]) + by_face
    }

    /// Carries displacements of the kept vertices, among `moved` of all
    /// vertices, over to the others.
    pub(super) fn spread(&self, moved: &mut [DVec3]) {
        let faces = self.shape.surface().faces();
        let of_kept: Vec<DVec3> = self.kept.iter().map(|&vertex| moved[vertex as usize]).collect();
        for (x, tie) in moved.iter_mut().zip(&self.ties) {
            let corners = faces[tie.face as usize].map(|corner| of_kept[corner as usize]);
            *x = (0..3).map(|k| tie.weights[k] * corners[k]).sum();
        }
    }
}

fn ties(shape: &SurfaceTree, points: &[DVec3]) -> Vec<Tie> {
    let mut traversal = Workspace::default();
    points.iter().map(|&point| tie(shape, point, &mut traversal)).collect()
}

/// Vertices by the faces they are tied to, and where those of each face begin.
fn by_face(ties: &[Tie], faces: usize) -> (Vec<u32>, Vec<u32>) {
    let mut tied: Vec<u32> = (0..).take(ties.len()).collect();
    tied.sort_by_key(|&vertex| ties[vertex as usize].face);
    let begin = |face: u32| tied.partition_point(|&vertex| ties[vertex as usize].face < face);
    let starts = (0..).take(faces + 1).map(|face| u32::try_from(begin(face)).unwrap_or(u32::MAX));
    let starts = starts.collect();
    (tied, starts)
}

fn tie(shape: &SurfaceTree, point: DVec3, traversal: &mut Workspace) -> Tie {
    let mut best = Tie { face: 0, weights: [1.0, 0.0, 0.0] };
    let mut least = f64::INFINITY;
    shape.tree().nearest(point, f64::INFINITY, traversal, |face, _| {
        let foot = closest_on_triangle(point, shape.corners(face));
        let distance = foot.point.distance(point);
        if distance < least {
            (least, best) = (distance, Tie { face, weights: foot.barycentric });
        }
        least
    });
    best
}
