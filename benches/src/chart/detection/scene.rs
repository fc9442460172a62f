//! Bodies that move: a bone, and muscles that shorten and are pressed on it.

use std::path::Path;

use fixtures::{arithmetic, thigh};
use glam::DVec3;

use crate::bodies::{self, Body};

/// Frames of the motion; after the last comes the first.
pub(super) const FRAMES: u32 = 8;

/// How far muscles are pressed towards the bone at most \[mm\].
pub(super) const PRESS: f64 = 3.0;

/// By what share muscles are shortened at most; they thicken, so that their volume stays.
pub(super) const SHORTENING: f64 = 0.06;

/// Bodies in one length unit, the millimetre, and their states.
#[derive(Debug)]
pub(super) struct Moving {
    /// What it shows, for the caption.
    pub(super) title: String,
    /// Names, the bone first.
    pub(super) names: Vec<String>,
    /// At rest, in the order of the names.
    pub(super) bodies: Vec<Body>,
    /// By frame and body.
    pub(super) frames: Vec<Vec<Vec<DVec3>>>,
}

impl Moving {
    /// The bone and the six muscles of the fixture scene.
    #[must_use]
    pub(super) fn fixture() -> Self {
        let scene = thigh::thigh();
        let kept = scene.bodies.into_iter().filter(|body| body.name != "fascia_lata");
        let body = |body: thigh::ThighBody| {
            let surface = body.mesh.surface();
            (body.name.to_owned(), Body { surface, x: body.mesh.positions })
        };
        Self::new("generated thigh (fixtures/thigh)", kept.map(body).collect())
    }

    /// A femur and five muscles about it, from files.
    #[must_use]
    pub(super) fn anatomy(folder: &Path) -> Self {
        let muscles = [
            "vastus_intermedius",
            "vastus_lateralis",
            "adductor_brevis",
            "adductor_magnus",
            "biceps_femoris_short",
        ];
        let read = |name: &str| bodies::read(&folder.join(format!("{name}.ply")));
        let mut all = vec![("femur".to_owned(), read("bone_femur"))];
        all.extend(muscles.map(|name| (name.to_owned(), read(&format!("muscle_{name}")))));
        Self::new("thigh of the Visible Human Female, simplified", all)
    }

    fn new(title: &str, all: Vec<(String, Body)>) -> Self {
        let (names, bodies): (Vec<String>, Vec<Body>) = all.into_iter().unzip();
        let faces: usize = bodies.iter().map(|body| body.surface.faces().len()).sum();
        let title = format!("{title}: {} bodies, {faces} faces", bodies.len());
        let frames = (0..FRAMES).map(|frame| state(&bodies, frame)).collect();
        Self { title, names, bodies, frames }
    }
}

fn state(bodies: &[Body], frame: u32) -> Vec<Vec<DVec3>> {
    let turned = arithmetic::circle(f64::from(frame) / f64::from(FRAMES));
    let way = 0.5 * (1.0 - turned.x);
    let bone = &bodies[0];
    let along = long_axis(bone);
    let pressed = |body: &Body| {
        let middle = body.middle();
        let towards = (bone.middle() - middle).reject_from(along).normalize_or_zero();
        let length = 1.0 - SHORTENING * way;
        let place = |p: &DVec3| {
            let arm = *p - middle;
            let up = arm.project_onto(along);
            middle + length * up + (arm - up) / length.sqrt() + PRESS * way * towards
        };
        body.x.iter().map(place).collect()
    };
    let muscles = bodies[1..].iter().map(pressed);
    std::iter::once(bone.x.clone()).chain(muscles).collect()
}

/// The coordinate axis along which a body is longest.
fn long_axis(body: &Body) -> DVec3 {
    let low = body.x.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = body.x.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let sides = high - low;
    let longest = |axis: &DVec3, other: &DVec3| sides.dot(*axis).total_cmp(&sides.dot(*other));
    DVec3::AXES.into_iter().max_by(longest).unwrap_or(DVec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn muscles_go_to_the_bone_and_back() {
        let moving = Moving::fixture();
        let rest: Vec<Vec<DVec3>> = moving.bodies.iter().map(|body| body.x.clone()).collect();
        let farthest = |frame: &[Vec<DVec3>], body: usize| {
            let ways = frame[body].iter().zip(&rest[body]).map(|(x, y)| x.distance(*y));
            ways.fold(0.0, f64::max)
        };
        for body in 1..rest.len() {
            assert!(farthest(&moving.frames[0], body) < 1e-9, "body {body} starts at rest");
            assert!(farthest(&moving.frames[4], body) > PRESS, "body {body} is pressed");
        }
        assert!(moving.frames.iter().all(|frame| frame[0] == rest[0]), "the bone stays");
    }
}
