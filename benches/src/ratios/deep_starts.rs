//! Steps of bodies that begin deep in each other.

use std::error::Error;

use fixtures::shapes::icosphere;
use glam::{DQuat, DVec3};
use musculo_collide::{
    BodyId, BodyKind, CheckParams, PathMove, Progress, RigidBodyPath, RigidPath, Scene, SceneError,
    ccd,
};

use crate::measure::{Report, as_f64, nanoseconds};

/// Balls of 1,280 faces, whose centers are a fraction of their radius apart.
const BALLS: u32 = 14;
const RADIUS: f64 = 20.0;
const SPREAD: f64 = 6.0;

/// Steps, in each of which a ball turns and shifts.
const STEPS: u32 = 5;
const TURN: f64 = 0.05;
const SHIFT: f64 = 0.4;

/// Reports the time of all steps: each is swept, and the state that it leads to is checked with all
/// measures.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    let (mut scene, ids) = balls()?;
    let (mut overlaps, mut new, mut failed) = (0, 0, None);
    let time = nanoseconds(|| {
        for step in 0..STEPS {
            match walk(&mut scene, &ids, step) {
                Ok([overlapping, contacts]) => {
                    overlaps += overlapping;
                    new += contacts;
                }
                Err(error) => failed = Some(error),
            }
        }
        overlaps
    });
    if let Some(error) = failed {
        return Err(error.into());
    }
    report.cost("deep starts: overlapping pairs", as_f64(overlaps), "pairs", f64::INFINITY);
    report.cost("deep starts: contacts on the way", as_f64(new), "", f64::INFINITY);
    report.cost("deep starts: 5 steps of 14 bodies", time * 1e-9, "s", 2.0);
    Ok(())
}

/// Returns the balls, in fixed places.
fn balls() -> Result<(Scene, Vec<BodyId>), SceneError> {
    let (mut scene, mut ids) = (Scene::new(), Vec::new());
    for ball in 0..BALLS {
        let center = SPREAD * (turn(ball, 2.4) * DVec3::X);
        let mesh = icosphere(RADIUS, 3).translated(center);
        let name = format!("ball_{ball}");
        ids.push(scene.add(name, BodyKind::Rigid, mesh.surface(), mesh.positions)?);
    }
    Ok((scene, ids))
}

/// Returns a rotation that differs from ball to ball.
fn turn(ball: u32, angle: f64) -> DQuat {
    let number = f64::from(ball + 1);
    DQuat::from_rotation_y(1.7 * number) * DQuat::from_rotation_z(angle * number)
}

/// Sweeps and checks one step; returns the pairs that overlap after it, and its contacts.
fn walk(scene: &mut Scene, ids: &[BodyId], step: u32) -> Result<[usize; 2], SceneError> {
    let mut paths = Vec::new();
    for (ball, &id) in (0..).zip(ids) {
        let from = scene.body(id).positions().to_vec();
        let center = from.iter().copied().sum::<DVec3>() / as_f64(from.len());
        let shift = SHIFT * (turn(ball + 7 * step, 1.1) * DVec3::Y);
        let rotation = DQuat::from_axis_angle(turn(ball, 0.8) * DVec3::Z, TURN);
        let translation = center + shift - rotation * center;
        paths.push((from, RigidPath::new(rotation, translation, center)));
    }

    let mut arcs = Vec::new();
    for (from, path) in &paths {
        arcs.push(RigidBodyPath { from, path: *path });
    }
    let mut moves = Vec::new();
    for (&body, path) in ids.iter().zip(&arcs) {
        moves.push(PathMove { body, path });
    }
    let swept = scene.sweep_paths(&moves, &ccd::CcdParams::EXACT, Progress::none())?;

    // All measures of the state, as the program reports them.
    for (&id, (from, path)) in ids.iter().zip(&paths) {
        let place = path.place(1.0);
        let x: Vec<DVec3> = from.iter().map(|&x| place.transform_point(x)).collect();
        scene.move_body(id, &x)?;
    }
    let reports = scene.check(&CheckParams::new(0.0), Progress::none())?;
    let overlapping = reports.iter().filter(|report| report.overlaps).count();
    Ok([overlapping, swept.pairs.iter().map(|pair| pair.contacts.len()).sum()])
}
