//! Surfaces against surfaces: exactly, or on fewer of their vertices.

use decimate::{Decimation, ReducedSurface};
use glam::DVec3;
use kdop::Workspace;
use musculo_collide::{BodyId, CheckParams, PairReport, Scene, VertexReport};
use proximity::{ClosestPoint, SurfaceTree};
use surface::progress::Progress;

use super::super::score::Answer;
use super::super::task::{Direction, Task, both_directions, ignore_other_pairs, kind};
use super::{Built, Detector, Failure};
use crate::bodies::points_inside;

const CHECK: CheckParams = CheckParams::without_measures(0.0);

/// Exact detection between full surfaces.
pub(super) struct ExactSurfaces<'a> {
    task: &'a Task<'a>,
    scene: Scene,
    ids: Vec<BodyId>,
    muscles: Vec<usize>,
    reports: Vec<PairReport>,
}

/// Sets up a scene of full surfaces.
///
/// # Errors
///
/// When the scene refuses a body.
pub(super) fn exact<'a>(task: &'a Task<'a>) -> Built<'a> {
    let (mut scene, ids) = task.scene()?;
    let reports = scene.check(&CHECK, Progress::none())?;
    Ok(Box::new(ExactSurfaces { task, scene, ids, muscles: task.muscles(), reports }))
}

impl Detector for ExactSurfaces<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        for &muscle in &self.muscles {
            self.scene.move_body(self.ids[muscle], self.task.positions(frame, muscle))?;
        }
        self.reports = self.scene.check(&CHECK, Progress::none())?;
        Ok(())
    }

    fn answer(&self) -> Answer {
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

fn depths(report: &VertexReport) -> Vec<(u32, f64)> {
    let mut depths = Vec::new();
    for near in &report.near {
        if near.gap < 0.0 {
            depths.push((near.vertex, -near.gap));
        }
    }
    depths
}

/// Exact detection between reduced surfaces.
pub(super) struct ReducedSurfaces<'a> {
    task: &'a Task<'a>,
    scene: Scene,
    ids: Vec<BodyId>,
    muscles: Vec<usize>,
    reduced: Vec<ReducedSurface>,
    /// Positions of the body that moves.
    x: Vec<DVec3>,
    frame: usize,
}

/// Reduces all surfaces within a deviation.
///
/// # Errors
///
/// When a surface cannot be reduced, or the scene refuses it.
pub(super) fn reduced<'a>(task: &'a Task<'a>, deviation: f64) -> Built<'a> {
    let mut scene = Scene::new();
    let (mut reduced, mut ids, mut x) = (Vec::new(), Vec::new(), Vec::new());
    for (number, body) in task.moving.bodies.iter().enumerate() {
        let coarse =
            Decimation::new(body.clone(), Progress::none())?.within(deviation, Progress::none())?;
        coarse.gather(body.positions().as_slice(), &mut x);
        let name = &task.moving.names[number];
        ids.push(scene.add(name, kind(number), (*coarse.surface).clone(), x.clone())?);
        reduced.push(coarse);
    }
    ignore_other_pairs(&mut scene, &ids, &task.pairs);
    scene.check(&CHECK, Progress::none())?;
    let muscles = task.muscles();
    Ok(Box::new(ReducedSurfaces { task, scene, ids, muscles, reduced, x, frame: 0 }))
}

impl Detector for ReducedSurfaces<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        for &muscle in &self.muscles {
            self.reduced[muscle].gather(self.task.positions(frame, muscle), &mut self.x);
            self.scene.move_body(self.ids[muscle], &self.x)?;
        }
        self.scene.check(&CHECK, Progress::none())?;
        self.frame = frame;
        Ok(())
    }

    /// Returns the depths of all vertices: each is placed at its closest point of the reduced
    /// surface at rest, and is as deep as that point is in the other reduced surface.
    fn answer(&self) -> Answer {
        let mut directions = Vec::new();
        for direction in self.task.pairs.iter().copied().flat_map(both_directions) {
            directions.push((direction, self.inside(direction)));
        }
        Answer::Vertices(directions)
    }
}

impl ReducedSurfaces<'_> {
    fn inside(&self, Direction { vertices, against }: Direction) -> Vec<(u32, f64)> {
        // Three surfaces: at rest, where vertices are placed, and both bodies in this frame.
        let full = &self.task.moving.bodies[vertices];
        let rest = self.tree(vertices, full.positions().as_slice());
        let now = self.tree(vertices, self.task.positions(self.frame, vertices));
        let other = self.tree(against, self.task.positions(self.frame, against));
        let (Ok(rest), Ok(now), Ok(other)) = (rest, now, other) else { return Vec::new() };

        // Each vertex moves with its closest point.
        let workspace = &mut Workspace::default();
        let mut placed = Vec::new();
        for &p in full.positions().as_slice() {
            let closest = rest.closest_point(p, f64::INFINITY, None, workspace);
            placed.push(closest.map_or(p, |closest| moved(&closest, &now)));
        }
        points_inside(&placed, &other).into_iter().collect()
    }

    /// Returns a reduced surface at positions of the full one.
    fn tree(&self, body: usize, full_positions: &[DVec3]) -> Result<SurfaceTree, Failure> {
        let mut x = Vec::new();
        self.reduced[body].gather(full_positions, &mut x);
        Ok(SurfaceTree::new(self.reduced[body].surface.clone(), x)?)
    }
}

/// Returns where a point of a surface is after the surface has moved.
fn moved(closest: &ClosestPoint, now: &SurfaceTree) -> DVec3 {
    let corners = now.corners(closest.face);
    let [u, v, w] = closest.foot.barycentric;
    u * corners[0] + v * corners[1] + w * corners[2]
}
