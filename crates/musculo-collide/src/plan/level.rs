//! A body with as few of its vertices as a tolerance allows.

use decimate::{DecimateError, Decimation, Reduced};
use glam::DVec3;
use kdop::{TreeError, Workspace};
use surface::{Barycentric, closest_on_triangle};

use super::count;
use crate::scene::Body;
use crate::shape::Shape;

/// A coarser surface on some of a body's vertices, which follows the body.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) shape: Shape,
    /// Vertices of the body that it has, ascending.
    pub(super) kept: Vec<u32>,
    /// Where each of the body's vertices was on the coarser surface, by vertex.
    ties: Vec<Tie>,
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
        let Reduced { surface, kept, deviation } = decimation.within(deviation)?;
        let all = body.positions();
        if count(kept.len()) > WORTHWHILE * count(all.len()) {
            return Ok(None);
        }
        let positions = kept.iter().map(|&vertex| all[vertex as usize]).collect();
        let mut shape = Shape::new(body.kind(), surface, positions);
        shape.bound_state().map_err(DecimateError::from)?;
        let ties = ties(&shape, all);
        Ok(Some(Self { shape, kept, ties, deviation: deviation.largest() }))
    }

    /// Goes where the body is.
    pub(super) fn follow(&mut self, body: &Body) -> Result<(), TreeError> {
        let all = body.positions();
        for (x, &vertex) in self.shape.positions_mut().iter_mut().zip(&self.kept) {
            *x = all[vertex as usize];
        }
        self.shape.bound_state()
    }

    /// Bytes it holds.
    pub(super) fn bytes(&self) -> usize {
        self.shape.bytes() + size_of_val(&self.kept[..]) + size_of_val(&self.ties[..])
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

fn ties(shape: &Shape, points: &[DVec3]) -> Vec<Tie> {
    let mut traversal = Workspace::default();
    points.iter().map(|&point| tie(shape, point, &mut traversal)).collect()
}

fn tie(shape: &Shape, point: DVec3, traversal: &mut Workspace) -> Tie {
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
