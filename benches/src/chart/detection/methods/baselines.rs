//! Methods of `baselines`, one pair of surfaces after the other.

use baselines::average_case::{AverageCaseParams, AverageCaseTree};
use baselines::layered_depth::{self, LayeredDepthParams};
use baselines::selected_pairs::{SelectedPairs, SelectedPairsParams};
use baselines::spatial_hash::{self, SpatialHashParams};
use baselines::{PairFindings, PlacedSurface, VertexInside};
use surface::mean_edge;

use super::super::score::Answer;
use super::super::task::{Task, both_directions};
use super::{Built, Detector, Failure};
use crate::measure::as_f64;

/// Distance up to which random pairs are followed \[mm\].
const MARGIN: f64 = 5.0;

/// A pair of surfaces in a frame.
struct PlacedPair<'a> {
    frame: usize,
    /// Number in the list of pairs.
    number: usize,
    bodies: [usize; 2],
    surfaces: [PlacedSurface<'a>; 2],
}

type Detect<'a> = Box<dyn FnMut(&PlacedPair<'_>) -> Result<PairFindings, Failure> + 'a>;

/// Detection in all pairs of a task, one after the other.
pub(super) struct PairByPair<'a> {
    task: &'a Task<'a>,
    detect: Detect<'a>,
    found: Vec<PairFindings>,
}

impl<'a> PairByPair<'a> {
    fn new(
        task: &'a Task<'a>,
        detect: impl FnMut(&PlacedPair<'_>) -> Result<PairFindings, Failure> + 'a,
    ) -> Self {
        Self { task, detect: Box::new(detect), found: Vec::new() }
    }
}

/// Sets up spatial hashing with cells of a number of mean edges.
pub(super) fn spatial_hash<'a>(task: &'a Task<'a>, edges: f64) -> PairByPair<'a> {
    let bodies = &task.moving.bodies;
    let edge_lengths = bodies.iter().map(|body| mean_edge(body.surface(), body.positions()));
    let cell_size = edges * edge_lengths.sum::<f64>() / as_f64(bodies.len());
    let params = SpatialHashParams::new(cell_size);
    PairByPair::new(task, move |pair| {
        let [a, b] = pair.surfaces;
        Ok(spatial_hash::detect(a, b, &params)?)
    })
}

/// Sets up layered depth images with a number of pixels along the longer side.
pub(super) fn layered_depth<'a>(task: &'a Task<'a>, resolution: u32) -> PairByPair<'a> {
    let params = LayeredDepthParams { resolution };
    PairByPair::new(task, move |pair| {
        let [a, b] = pair.surfaces;
        Ok(layered_depth::detect(a, b, &params)?)
    })
}

/// Sets up random pairs of faces with a budget of tests per step, kept from frame to frame.
pub(super) fn selected_pairs<'a>(task: &'a Task<'a>, max_tests: u64) -> PairByPair<'a> {
    let params = SelectedPairsParams { max_tests, ..SelectedPairsParams::new(MARGIN) };
    let mut followed: Vec<SelectedPairs> =
        (1..).take(task.pairs.len()).map(SelectedPairs::new).collect();
    PairByPair::new(task, move |pair| {
        let [a, b] = pair.surfaces;
        Ok(followed[pair.number].step(a, b, &params)?)
    })
}

/// Sets up average-case trees that accept collisions from a probability on.
///
/// # Errors
///
/// When the method refuses the bone.
pub(super) fn average_case<'a>(task: &'a Task<'a>, acceptance: f64) -> Built<'a> {
    let params = AverageCaseParams { acceptance, ..AverageCaseParams::DEFAULT };
    let mut trees = vec![None; task.moving.bodies.len()];
    trees[0] = Some(AverageCaseTree::new(placed(task, 0, 0)?, &params)?);
    let mut detection = AverageCase { task, params, trees, frame: None };
    Ok(Box::new(PairByPair::new(task, move |pair| detection.detect(pair))))
}

/// Average-case trees: the bone's is kept, a muscle's is valid in one frame only.
struct AverageCase<'a> {
    task: &'a Task<'a>,
    params: AverageCaseParams,
    /// Trees per body, of those in pairs.
    trees: Vec<Option<AverageCaseTree>>,
    /// Frame of the muscles' trees.
    frame: Option<usize>,
}

impl AverageCase<'_> {
    fn detect(&mut self, pair: &PlacedPair<'_>) -> Result<PairFindings, Failure> {
        // Trees of muscles are built once per frame.
        if self.frame != Some(pair.frame) {
            self.frame = Some(pair.frame);
            for muscle in self.task.muscles() {
                let placed = placed(self.task, pair.frame, muscle)?;
                self.trees[muscle] = Some(AverageCaseTree::new(placed, &self.params)?);
            }
        }

        let [Some(tree_a), Some(tree_b)] = pair.bodies.map(|body| self.trees[body].as_ref()) else {
            return Err("a body of a pair has no tree".into());
        };
        let [a, b] = pair.surfaces;
        Ok(tree_a.detect(a, tree_b, b, &self.params)?)
    }
}

/// Returns the surface of a body in a frame.
fn placed<'a>(task: &Task<'a>, frame: usize, body: usize) -> Result<PlacedSurface<'a>, Failure> {
    let surface = task.moving.bodies[body].surface();
    Ok(PlacedSurface { surface, x: surface.positions(task.positions(frame, body))? })
}

impl Detector for PairByPair<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        self.found.clear();
        for (number, &bodies) in self.task.pairs.iter().enumerate() {
            let [a, b] = bodies;
            let surfaces = [placed(self.task, frame, a)?, placed(self.task, frame, b)?];
            self.found.push((self.detect)(&PlacedPair { frame, number, bodies, surfaces })?);
        }
        Ok(())
    }

    /// Returns vertices where the method finds them, else crossings, else overlaps.
    fn answer(&self) -> Answer {
        // A method computes one of the three for all pairs.
        let (mut vertices, mut crossings) = (Vec::new(), Vec::new());
        let mut overlaps = std::collections::BTreeSet::new();
        for (&pair, found) in self.task.pairs.iter().zip(&self.found) {
            if let Some(inside) = &found.inside {
                for (direction, inside) in both_directions(pair).into_iter().zip(inside) {
                    let depth = |inside: &VertexInside| (inside.vertex, inside.depth);
                    vertices.push((direction, inside.iter().map(depth).collect()));
                }
            } else if let Some(faces) = &found.crossing_faces {
                crossings.push((pair, faces.clone()));
            } else if found.overlap {
                overlaps.insert(pair);
            }
        }
        match (vertices.is_empty(), crossings.is_empty()) {
            (false, _) => Answer::Vertices(vertices),
            (true, false) => Answer::Crossings(crossings),
            (true, true) => Answer::Overlaps(overlaps),
        }
    }
}
