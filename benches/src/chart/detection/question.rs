//! What methods are asked: who is in whom, between some pairs, in every frame; and the exact
//! answers.

use std::collections::{BTreeMap, BTreeSet};

use musculo_collide::{BodyId, BodyKind, CheckParams, PairReport, Scene, SceneError, VertexReport};

use super::scene::Moving;

/// Which pairs of bodies are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pairs {
    /// The bone with each muscle.
    Bone,
    /// Muscles with each other.
    Muscles,
}

/// Vertices of the first body against the second.
pub(super) type Way = [usize; 2];

/// How far from the other body the true gaps of vertices are known \[mm\].
pub(super) const REACH: f64 = 4.0;

/// Pairs of bodies, and the truth about them.
#[derive(Debug)]
pub(super) struct Question<'a> {
    /// The bodies.
    pub(super) moving: &'a Moving,
    /// Which these are.
    pub(super) of: Pairs,
    /// Pairs that overlap in some frame, the lower number first.
    pub(super) pairs: Vec<[usize; 2]>,
    /// By frame.
    pub(super) truth: Vec<Truth>,
}

/// What is so in one frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Truth {
    /// Signed distances of vertices that are inside or within [`REACH`] \[mm\].
    pub(super) gaps: BTreeMap<Way, BTreeMap<u32, f64>>,
    /// Faces that cross.
    pub(super) crossings: BTreeMap<[usize; 2], BTreeSet<[u32; 2]>>,
    /// Who overlaps whom.
    pub(super) overlaps: BTreeSet<[usize; 2]>,
}

impl<'a> Question<'a> {
    /// Finds the pairs and the truth about them.
    ///
    /// # Errors
    ///
    /// As [`Scene::check`].
    pub(super) fn new(moving: &'a Moving, of: Pairs) -> Result<Self, SceneError> {
        let count = moving.bodies.len();
        let all = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
        let of_kind = |pair: &[usize; 2]| (pair[0] == 0) == (of == Pairs::Bone);
        let candidates: Vec<[usize; 2]> = all.filter(of_kind).collect();
        let (mut scene, ids) = scene_of(moving, &candidates)?;
        let truth = moving.frames.iter().map(|frame| truth(&mut scene, &ids, frame));
        let truth = truth.collect::<Result<Vec<_>, SceneError>>()?;
        let meets = |pair: &[usize; 2]| truth.iter().any(|truth| truth.overlaps.contains(pair));
        let pairs = candidates.into_iter().filter(meets).collect();
        Ok(Self { moving, of, pairs, truth })
    }

    /// Muscles of the pairs, ascending.
    #[must_use]
    pub(super) fn muscles(&self) -> Vec<usize> {
        let all: BTreeSet<usize> = self.pairs.iter().flatten().copied().collect();
        all.into_iter().filter(|body| *body > 0).collect()
    }

    /// A scene of the bodies at rest in which only the pairs are looked at.
    ///
    /// # Errors
    ///
    /// As [`Scene::add`].
    pub(super) fn scene(&self) -> Result<(Scene, Vec<BodyId>), SceneError> {
        scene_of(self.moving, &self.pairs)
    }
}

fn scene_of(moving: &Moving, pairs: &[[usize; 2]]) -> Result<(Scene, Vec<BodyId>), SceneError> {
    let mut scene = Scene::new();
    let mut ids = Vec::new();
    for (number, (name, body)) in moving.names.iter().zip(&moving.bodies).enumerate() {
        let kind = if number == 0 { BodyKind::Rigid } else { BodyKind::Deformable };
        ids.push(scene.add(name, kind, body.surface.clone(), body.x.clone())?);
    }
    ignore_others(&mut scene, &ids, pairs);
    Ok((scene, ids))
}

/// Leaves all pairs out but some.
pub(super) fn ignore_others(scene: &mut Scene, ids: &[BodyId], pairs: &[[usize; 2]]) {
    for a in 0..ids.len() {
        for b in a + 1..ids.len() {
            if !pairs.contains(&[a, b]) {
                scene.ignore(ids[a], ids[b]);
            }
        }
    }
}

fn truth(
    scene: &mut Scene,
    ids: &[BodyId],
    frame: &[Vec<glam::DVec3>],
) -> Result<Truth, SceneError> {
    for (&id, x) in ids.iter().zip(frame) {
        scene.move_body(id, x)?;
    }
    let mut truth = Truth::default();
    for report in scene.check(&CheckParams { margin: REACH })? {
        let PairReport { a, b, overlaps, a_against_b, b_against_a, crossing_faces, .. } = report;
        let pair = [a.index(), b.index()];
        truth.gaps.insert(pair, gaps(&a_against_b));
        truth.gaps.insert([pair[1], pair[0]], gaps(&b_against_a));
        truth.crossings.insert(pair, crossing_faces.into_iter().collect());
        if overlaps {
            truth.overlaps.insert(pair);
        }
    }
    Ok(truth)
}

fn gaps(report: &VertexReport) -> BTreeMap<u32, f64> {
    report.near.iter().map(|near| (near.vertex, near.gap)).collect()
}
