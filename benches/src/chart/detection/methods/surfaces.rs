//! Surfaces against surfaces: exactly, as they are or on fewer of their vertices.

use decimate::{Decimation, ReducedSurface};
use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use musculo_collide::{BodyId, BodyKind, CheckParams, PairReport, Scene};
use surface::{Barycentric, closest_on_triangle};

use super::super::question::{Question, Way, ignore_others};
use super::super::score::Told;
use super::{Detector, Failure};
use crate::bodies::{Body, Depth};

/// Surfaces as they are.
pub(super) struct Exact<'a> {
    question: &'a Question<'a>,
    scene: Scene,
    ids: Vec<BodyId>,
    muscles: Vec<usize>,
    reports: Vec<PairReport>,
}

pub(super) fn exact<'a>(question: &'a Question<'a>) -> Result<Exact<'a>, Failure> {
    let (mut scene, ids) = question.scene()?;
    let reports = scene.check(&CheckParams { margin: 0.0 })?;
    Ok(Exact { question, scene, ids, muscles: question.muscles(), reports })
}

impl Detector for Exact<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        for &muscle in &self.muscles {
            self.scene.move_body(self.ids[muscle], &self.question.moving.frames[frame][muscle])?;
        }
        self.reports = self.scene.check(&CheckParams { margin: 0.0 })?;
        Ok(())
    }

    fn told(&self) -> Told {
        let told = |[a, b]: &[usize; 2]| {
            let of_pair =
                |report: &&PairReport| [report.a, report.b] == [self.ids[*a], self.ids[*b]];
            let report = self.reports.iter().find(of_pair);
            let of = |half: Option<&musculo_collide::VertexReport>| {
                let near = half.into_iter().flat_map(|half| &half.near);
                near.filter(|near| near.gap < 0.0).map(|near| (near.vertex, -near.gap)).collect()
            };
            [
                ([*a, *b], of(report.map(|report| &report.a_against_b))),
                ([*b, *a], of(report.map(|report| &report.b_against_a))),
            ]
        };
        Told::Vertices(self.question.pairs.iter().flat_map(told).collect())
    }
}

/// Surfaces on some of their vertices.
pub(super) struct Fewer<'a> {
    question: &'a Question<'a>,
    scene: Scene,
    ids: Vec<BodyId>,
    muscles: Vec<usize>,
    reduced: Vec<ReducedSurface>,
    x: Vec<DVec3>,
    frame: usize,
}

pub(super) fn reduced<'a>(question: &'a Question<'a>, within: f64) -> Result<Fewer<'a>, Failure> {
    let mut scene = Scene::new();
    let (mut reduced, mut ids) = (Vec::new(), Vec::new());
    let (mut x, muscles) = (Vec::new(), question.muscles());
    for (number, body) in question.moving.bodies.iter().enumerate() {
        let at = body.surface.positions(&body.x)?;
        let coarse = Decimation::new(&body.surface, at)?.within(within)?;
        coarse.gather(&body.x, &mut x);
        let kind = if number == 0 { BodyKind::Rigid } else { BodyKind::Deformable };
        let name = &question.moving.names[number];
        ids.push(scene.add(name, kind, coarse.surface.clone(), x.clone())?);
        reduced.push(coarse);
    }
    ignore_others(&mut scene, &ids, &question.pairs);
    scene.check(&CheckParams { margin: 0.0 })?;
    Ok(Fewer { question, scene, ids, muscles, reduced, x, frame: 0 })
}

impl Detector for Fewer<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        for &muscle in &self.muscles {
            self.reduced[muscle].gather(&self.question.moving.frames[frame][muscle], &mut self.x);
            self.scene.move_body(self.ids[muscle], &self.x)?;
        }
        self.scene.check(&CheckParams { margin: 0.0 })?;
        self.frame = frame;
        Ok(())
    }

    /// A vertex stands where its nearest point of the reduced surface went, and is as deep as that
    /// is in the other reduced surface.
    fn told(&self) -> Told {
        let bodies: Vec<Body> = (0..self.reduced.len()).map(|body| self.now(body)).collect();
        let depths: Vec<Depth<'_>> = bodies.iter().map(Depth::new).collect();
        let ways = self.question.pairs.iter().flat_map(|&[a, b]| [[a, b], [b, a]]);
        let told = |way: Way| (way, self.inside(way, &bodies, &depths[way[1]]));
        Told::Vertices(ways.map(told).collect())
    }
}

impl Fewer<'_> {
    fn now(&self, body: usize) -> Body {
        let mut x = Vec::new();
        self.reduced[body].gather(&self.question.moving.frames[self.frame][body], &mut x);
        Body { surface: self.reduced[body].surface.clone(), x }
    }

    fn inside(&self, [a, b]: Way, bodies: &[Body], depth: &Depth<'_>) -> Vec<(u32, f64)> {
        let mut workspace = Workspace::default();
        let ties = self.ties(a);
        let (low, high) = box_of(&bodies[b]);
        let place = |(face, weights): &(u32, Barycentric)| {
            let corners = bodies[a].corners(*face);
            (0..3).map(|k| weights[k] * corners[k]).sum::<DVec3>()
        };
        let placed = (0..).zip(ties.iter().map(place));
        let near = placed.filter(|(_, p)| p.cmpge(low).all() && p.cmple(high).all());
        let depths = near.map(|(vertex, p)| (vertex, depth.at(p, f64::INFINITY, &mut workspace)));
        depths.filter(|(_, depth)| *depth > 0.0).collect()
    }

    /// For each vertex of a full surface, the nearest point of the reduced one at rest.
    fn ties(&self, body: usize) -> Vec<(u32, Barycentric)> {
        let full = &self.question.moving.bodies[body];
        let mut x = Vec::new();
        self.reduced[body].gather(&full.x, &mut x);
        let coarse = Body { surface: self.reduced[body].surface.clone(), x };
        let leaves = Leaves::Triangles(coarse.surface.faces());
        let Ok(tree) = Tree::build(leaves, &coarse.x) else { return Vec::new() };
        let mut workspace = Workspace::default();
        let tie = |p: &DVec3| {
            let mut best = (f64::INFINITY, (0, [1.0, 0.0, 0.0]));
            tree.nearest(*p, f64::INFINITY, &mut workspace, |face, _| {
                let foot = closest_on_triangle(*p, coarse.corners(face));
                let distance = foot.point.distance(*p);
                if distance < best.0 {
                    best = (distance, (face, foot.barycentric));
                }
                best.0
            });
            best.1
        };
        full.x.iter().map(tie).collect()
    }
}

fn box_of(body: &Body) -> (DVec3, DVec3) {
    let low = body.x.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = body.x.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    (low, high)
}
