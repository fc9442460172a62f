//! Detection task: vertices inside other bodies, for some pairs in every frame, with the exact
//! answers.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use musculo_collide::{BodyId, BodyKind, CheckParams, PairReport, Scene, SceneError, VertexReport};

use super::scene::MovingBodies;

/// Pairs of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PairGroup {
    /// The bone with each muscle.
    Bone,
    /// Muscles with each other.
    Muscles,
}

impl PairGroup {
    pub(super) const fn title(self) -> &'static str {
        match self {
            Self::Bone => "bone and muscles",
            Self::Muscles => "muscles with each other",
        }
    }
}

/// Vertices of one body against another body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Direction {
    /// Body of the vertices.
    pub(super) vertices: usize,
    /// The other body.
    pub(super) against: usize,
}

/// Returns both directions of a pair.
pub(super) const fn both_directions([a, b]: [usize; 2]) -> [Direction; 2] {
    [Direction { vertices: a, against: b }, Direction { vertices: b, against: a }]
}

/// Distance from the other body up to which the exact gaps of vertices are computed \[mm\].
pub(super) const TRUTH_MARGIN: f64 = 4.0;

/// Width of the brackets on exact depths of surfaces \[mm\].
const TRUTH_WIDTH: f64 = 1e-3;

/// Pairs of bodies, and the exact answers.
#[derive(Debug)]
pub(super) struct Task<'a> {
    /// The bodies.
    pub(super) moving: &'a MovingBodies,
    /// Group of the pairs.
    pub(super) group: PairGroup,
    /// Pairs that overlap in some frame, the lower number first.
    pub(super) pairs: Vec<[usize; 2]>,
    /// Exact answers per frame.
    pub(super) truth: Vec<FrameTruth>,
}

/// Exact answers in one frame.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameTruth {
    /// Signed distances of vertices that are inside or within [`TRUTH_MARGIN`] \[mm\].
    pub(super) gaps: BTreeMap<Direction, BTreeMap<u32, f64>>,
    /// Faces that cross.
    pub(super) crossings: BTreeMap<[usize; 2], BTreeSet<[u32; 2]>>,
    /// Depths of the surfaces of pairs that overlap \[mm\].
    pub(super) depths: BTreeMap<[usize; 2], f64>,
    /// Pairs that overlap.
    pub(super) overlaps: BTreeSet<[usize; 2]>,
}

impl<'a> Task<'a> {
    /// Finds the pairs of a group that overlap, and the exact answers.
    ///
    /// # Errors
    ///
    /// As [`Scene::check`].
    pub(super) fn new(moving: &'a MovingBodies, group: PairGroup) -> Result<Self, SceneError> {
        let count = moving.bodies.len();
        let mut pairs = Vec::new();
        for a in 0..count {
            for b in a + 1..count {
                if (a == 0) == (group == PairGroup::Bone) {
                    pairs.push([a, b]);
                }
            }
        }

        // Pairs without an overlap in any frame are left out.
        let (mut scene, ids) = scene_of(moving, &pairs)?;
        let mut truth = Vec::new();
        for frame in &moving.frames {
            truth.push(FrameTruth::new(&mut scene, &ids, frame)?);
        }
        pairs.retain(|pair| truth.iter().any(|truth| truth.overlaps.contains(pair)));
        Ok(Self { moving, group, pairs, truth })
    }

    /// Returns the muscles of the pairs, ascending.
    #[must_use]
    pub(super) fn muscles(&self) -> Vec<usize> {
        let mut bodies: BTreeSet<usize> = self.pairs.iter().flatten().copied().collect();
        bodies.remove(&0);
        bodies.into_iter().collect()
    }

    /// Returns the positions of a body in a frame.
    #[must_use]
    pub(super) fn positions(&self, frame: usize, body: usize) -> &'a [DVec3] {
        &self.moving.frames[frame][body]
    }

    /// Sets up a scene of the bodies at rest, which checks only the pairs.
    ///
    /// # Errors
    ///
    /// As [`Scene::add`].
    pub(super) fn scene(&self) -> Result<(Scene, Vec<BodyId>), SceneError> {
        scene_of(self.moving, &self.pairs)
    }
}

fn scene_of(
    moving: &MovingBodies,
    pairs: &[[usize; 2]],
) -> Result<(Scene, Vec<BodyId>), SceneError> {
    let mut scene = Scene::new();
    let mut ids = Vec::new();
    for (number, (name, body)) in moving.names.iter().zip(&moving.bodies).enumerate() {
        let (surface, x) = (body.surface().clone(), body.positions().as_slice().to_vec());
        ids.push(scene.add(name, kind(number), surface, x)?);
    }
    ignore_other_pairs(&mut scene, &ids, pairs);
    Ok((scene, ids))
}

/// Returns the kind of a body: the first is the bone.
pub(super) const fn kind(number: usize) -> BodyKind {
    if number == 0 { BodyKind::Rigid } else { BodyKind::Deformable }
}

/// Excludes all pairs from a scene but the given ones.
pub(super) fn ignore_other_pairs(scene: &mut Scene, ids: &[BodyId], pairs: &[[usize; 2]]) {
    for a in 0..ids.len() {
        for b in a + 1..ids.len() {
            if !pairs.contains(&[a, b]) {
                scene.ignore(ids[a], ids[b]);
            }
        }
    }
}

impl FrameTruth {
    fn new(scene: &mut Scene, ids: &[BodyId], frame: &[Vec<DVec3>]) -> Result<Self, SceneError> {
        for (&id, x) in ids.iter().zip(frame) {
            scene.move_body(id, x)?;
        }

        // Gaps in both directions, crossings and overlaps of each pair.
        let mut truth = Self::default();
        for report in scene.check(
            &CheckParams::without_measures(TRUTH_MARGIN),
            musculo_collide::Progress::none(),
        )? {
            let PairReport { pair, overlaps, a_against_b, b_against_a, crossing_faces, .. } =
                report;
            let pair = pair.bodies().map(|id| id.index());
            let [forward, backward] = both_directions(pair);
            truth.gaps.insert(forward, gaps(&a_against_b));
            truth.gaps.insert(backward, gaps(&b_against_a));
            truth.crossings.insert(pair, crossing_faces.into_iter().collect());
            if overlaps {
                truth.overlaps.insert(pair);
            }
        }

        // Depths of surfaces, to far less than any method's error.
        let params = CheckParams { depth_tolerance: Some(TRUTH_WIDTH), ..CheckParams::new(0.0) };
        for report in scene.check(&params, musculo_collide::Progress::none())? {
            if let Some(depth) = report.max_depth() {
                truth.depths.insert(report.pair.bodies().map(|id| id.index()), depth.lower);
            }
        }
        Ok(truth)
    }
}

fn gaps(report: &VertexReport) -> BTreeMap<u32, f64> {
    report.near.iter().map(|near| (near.vertex, near.gap)).collect()
}
