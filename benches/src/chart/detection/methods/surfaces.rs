//! Surfaces against surfaces: exactly, or on fewer of their vertices.

use std::collections::BTreeMap;

use decimate::{Decimation, ReducedSurface};
use glam::DVec3;
use kdop::Workspace;
use musculo_collide::{BodyId, CheckParams, PairReport, Scene, VertexReport};
use proximity::SurfaceTree;
use surface::Barycentric;
use surface::progress::Progress;

use super::super::score::Answer;
use super::super::task::{Direction, Task, both_directions, ignore_other_pairs, kind};
use super::{Built, Detector, Failure};

const CHECK: CheckParams = CheckParams::without_measures(0.0);

/// Exact detection between full surfaces: of vertices, or with all measures of overlaps.
pub(super) struct ExactSurfaces<'a> {
    task: &'a Task<'a>,
    scene: Scene,
    ids: Vec<BodyId>,
    muscles: Vec<usize>,
    check: CheckParams,
    reports: Vec<PairReport>,
}

/// Sets up a scene of full surfaces, for the depths of vertices.
///
/// # Errors
///
/// When the scene refuses a body.
pub(super) fn exact<'a>(task: &'a Task<'a>) -> Built<'a> {
    checked(task, CHECK)
}

/// Sets up a scene of full surfaces, for measures of overlaps with depths in brackets of a width.
///
/// # Errors
///
/// When the scene refuses a body.
pub(super) fn measured<'a>(task: &'a Task<'a>, width: f64) -> Built<'a> {
    checked(task, CheckParams { depth_tolerance: Some(width), ..CheckParams::new(0.0) })
}

fn checked<'a>(task: &'a Task<'a>, check: CheckParams) -> Built<'a> {
    let (mut scene, ids) = task.scene()?;
    let reports = scene.check(&check, Progress::none())?;
    Ok(Box::new(ExactSurfaces { task, scene, ids, muscles: task.muscles(), check, reports }))
}

impl Detector for ExactSurfaces<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        for &muscle in &self.muscles {
            self.scene.move_body(self.ids[muscle], self.task.positions(frame, muscle))?;
        }
        self.reports = self.scene.check(&self.check, Progress::none())?;
        Ok(())
    }

    fn answer(&self) -> Answer {
        if self.check.measures {
            return self.measured_depths();
        }
        let mut directions = Vec::new();
        for &pair in &self.task.pairs {
            let ids = pair.map(|body| self.ids[body]);
            let [forward, backward] = both_directions(pair);
            // A pair that is not within the margin has no report, and no vertex inside.
            for report in self.reports.iter().filter(|report| report.pair.bodies() == ids) {
                directions.push((forward, depths(&report.a_against_b)));
                directions.push((backward, depths(&report.b_against_a)));
            }
        }
        Answer::Vertices(directions)
    }
}

impl ExactSurfaces<'_> {
    /// Returns the depths of the surfaces of pairs that overlap.
    fn measured_depths(&self) -> Answer {
        let mut depths = BTreeMap::new();
        for report in self.reports.iter().filter(|report| report.overlaps) {
            let depth = report.max_depth().map_or(0.0, |depth| depth.lower);
            depths.insert(report.pair.bodies().map(BodyId::index), depth);
        }
        Answer::Depths(depths)
    }
}

fn depths(report: &VertexReport) -> Vec<(u32, f64)> {
    let mut depths = Vec::new();
    for near in &report.near {
        if near.gap < 0.0 {
            depths.push((near.vertex, -near.gap));
        }
    }
    depths
}

/// Exact detection between reduced surfaces, whose depths all vertices take over.
pub(super) struct ReducedSurfaces<'a> {
    task: &'a Task<'a>,
    scene: Scene,
    ids: Vec<BodyId>,
    muscles: Vec<usize>,
    reduced: Vec<ReducedSurface>,
    /// Places of all vertices on the reduced surfaces, per body.
    places: Vec<Vec<Place>>,
    /// Positions of the body that moves.
    x: Vec<DVec3>,
    found: Vec<(Direction, Vec<(u32, f64)>)>,
    transfer: Transfer,
}

/// Closest point of a reduced surface to a vertex at rest, with which the vertex moves.
#[derive(Clone, Copy)]
struct Place {
    face: u32,
    barycentric: Barycentric,
}

/// Sides of the faces of a reduced surface, in memory that is reused.
#[derive(Default)]
struct Transfer {
    is_cut: Vec<bool>,
    is_inside: Vec<bool>,
    workspace: Workspace,
}

/// Reduces all surfaces within a deviation.
///
/// # Errors
///
/// When a surface cannot be reduced, or the scene refuses it.
pub(super) fn reduced<'a>(task: &'a Task<'a>, deviation: f64) -> Built<'a> {
    let mut scene = Scene::new();
    let (mut reduced, mut places) = (Vec::new(), Vec::new());
    let (mut ids, mut x) = (Vec::new(), Vec::new());
    for (number, body) in task.moving.bodies.iter().enumerate() {
        let coarse =
            Decimation::new(body.clone(), Progress::none())?.within(deviation, Progress::none())?;
        coarse.gather(body.positions().as_slice(), &mut x);
        let name = &task.moving.names[number];
        ids.push(scene.add(name, kind(number), (*coarse.surface).clone(), x.clone())?);
        places.push(places_on(&SurfaceTree::new(coarse.surface.clone(), x.clone())?, body));
        reduced.push(coarse);
    }
    ignore_other_pairs(&mut scene, &ids, &task.pairs);
    scene.check(&CHECK, Progress::none())?;
    let (muscles, found, transfer) = (task.muscles(), Vec::new(), Transfer::default());
    Ok(Box::new(ReducedSurfaces { task, scene, ids, muscles, reduced, places, x, found, transfer }))
}

/// Finds the closest points of a reduced surface to the vertices of the full one.
fn places_on(reduced: &SurfaceTree, full: &SurfaceTree) -> Vec<Place> {
    let workspace = &mut Workspace::default();
    let mut places = Vec::new();
    for &p in full.positions().as_slice() {
        if let Some(closest) = reduced.closest_point(p, f64::INFINITY, None, workspace) {
            places.push(Place { face: closest.face, barycentric: closest.foot.barycentric });
        }
    }
    places
}

impl Detector for ReducedSurfaces<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        for &muscle in &self.muscles {
            self.reduced[muscle].gather(self.task.positions(frame, muscle), &mut self.x);
            self.scene.move_body(self.ids[muscle], &self.x)?;
        }
        let reports = self.scene.check(&CHECK, Progress::none())?;

        // What the reduced surfaces found is carried over to all vertices.
        self.found.clear();
        for &pair in &self.task.pairs {
            let ids = pair.map(|body| self.ids[body]);
            for report in reports.iter().filter(|report| report.pair.bodies() == ids) {
                let [forward, backward] = both_directions(pair);
                let depths = self.depths(forward, report, 0);
                self.found.push((forward, depths));
                let depths = self.depths(backward, report, 1);
                self.found.push((backward, depths));
            }
        }
        Ok(())
    }

    fn answer(&self) -> Answer {
        Answer::Vertices(self.found.clone())
    }
}

impl ReducedSurfaces<'_> {
    /// Returns the depths of all vertices of one side of a pair: each is as deep as its place.
    fn depths(
        &mut self,
        Direction { vertices, against }: Direction,
        report: &PairReport,
        side: usize,
    ) -> Vec<(u32, f64)> {
        let Self { scene, ids, places, transfer, .. } = self;
        let trees = [vertices, against].map(|body| scene.body(ids[body]).tree());
        let [Some(own), Some(other)] = trees else { return Vec::new() };
        transfer.mark(own, report, side);

        // A face that crosses none is on one side, as its corners are.
        let (mut depths, mut hint) = (Vec::new(), None);
        for (vertex, place) in (0..).zip(&places[vertices]) {
            let face = place.face as usize;
            if transfer.is_cut[face] || transfer.is_inside[face] {
                let [u, v, w] = place.barycentric;
                let corners = own.corners(place.face);
                let point = u * corners[0] + v * corners[1] + w * corners[2];
                if !transfer.is_cut[face] || other.contains(point, &mut transfer.workspace) {
                    let workspace = &mut transfer.workspace;
                    let closest = other.closest_point(point, f64::INFINITY, hint, workspace);
                    hint = closest.map(|closest| closest.face);
                    depths.extend(closest.map(|closest| (vertex, closest.distance)));
                }
            }
        }
        depths
    }
}

impl Transfer {
    /// Notes which faces of one side of a pair cross the other surface, and which are inside.
    fn mark(&mut self, own: &SurfaceTree, report: &PairReport, side: usize) {
        let count = own.surface().faces().len();
        for flags in [&mut self.is_cut, &mut self.is_inside] {
            flags.clear();
            flags.resize(count, false);
        }
        for faces in &report.crossing_faces {
            self.is_cut[faces[side] as usize] = true;
        }
        let near = [&report.a_against_b, &report.b_against_a][side];
        for vertex in near.near.iter().filter(|near| near.gap < 0.0) {
            for &face in own.surface().vertex_faces(vertex.vertex) {
                self.is_inside[face as usize] = true;
            }
        }
    }
}
