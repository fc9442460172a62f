//! Spatial hashing and layered depth images: all is made anew in every frame.

use baselines::{BaselineError, PairFindings, PlacedSurface, layered_depth, spatial_hash};

use super::super::question::{Question, Way};
use super::super::score::Told;
use super::{Detector, Failure};
use crate::bodies;
use crate::ratio::amount;

/// A way to look at two bodies that keeps nothing from frame to frame.
type Look =
    Box<dyn Fn(PlacedSurface<'_>, PlacedSurface<'_>) -> Result<PairFindings, BaselineError>>;

/// The pairs, looked at one by one.
pub(super) struct Anew<'a> {
    question: &'a Question<'a>,
    look: Look,
    found: Vec<PairFindings>,
}

/// Faces that cross, by cells of so many mean edges.
pub(super) fn hash<'a>(question: &'a Question<'a>, edges: f64) -> Result<Anew<'a>, Failure> {
    let lengths: f64 = question.moving.bodies.iter().map(mean_edge).sum();
    let cell_size = edges * lengths / amount(question.moving.bodies.len());
    let params =
        spatial_hash::SpatialHashParams { cell_size, ..spatial_hash::SpatialHashParams::DEFAULT };
    let look: Look = Box::new(move |a, b| spatial_hash::detect(a, b, &params));
    Ok(Anew { question, look, found: Vec::new() })
}

/// Layers along rays through so many pixels.
pub(super) fn layered<'a>(
    question: &'a Question<'a>,
    resolution: u32,
) -> Result<Anew<'a>, Failure> {
    let params = layered_depth::LayeredDepthParams { resolution, axis: None };
    let look: Look = Box::new(move |a, b| layered_depth::detect(a, b, &params));
    Ok(Anew { question, look, found: Vec::new() })
}

fn mean_edge(body: &bodies::Body) -> f64 {
    let faces = body.surface.faces();
    let side = |face: &[u32; 3], k: usize| {
        body.x[face[k] as usize].distance(body.x[face[(k + 1) % 3] as usize])
    };
    let sum: f64 = faces.iter().map(|face| (0..3).map(|k| side(face, k)).sum::<f64>()).sum();
    sum / amount(3 * faces.len())
}

/// A body of the question in one frame.
pub(super) fn body_at<'a>(
    question: &'a Question<'a>,
    frame: usize,
    body: usize,
) -> Result<PlacedSurface<'a>, Failure> {
    let surface = &question.moving.bodies[body].surface;
    Ok(PlacedSurface { surface, x: surface.positions(&question.moving.frames[frame][body])? })
}

impl Detector for Anew<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        self.found.clear();
        for &[a, b] in &self.question.pairs {
            let [a, b] = [body_at(self.question, frame, a)?, body_at(self.question, frame, b)?];
            self.found.push((self.look)(a, b)?);
        }
        Ok(())
    }

    fn told(&self) -> Told {
        let told = |(&[a, b], found): (&[usize; 2], &PairFindings)| -> Vec<(Way, Vec<(u32, f64)>)> {
            let of = |half: usize| {
                let inside = found.inside.iter().flat_map(|inside| &inside[half]);
                inside.map(|inside| (inside.vertex, inside.depth)).collect()
            };
            vec![([a, b], of(0)), ([b, a], of(1))]
        };
        Told::Vertices(self.question.pairs.iter().zip(&self.found).flat_map(told).collect())
    }
}
