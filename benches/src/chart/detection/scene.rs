//! Moving bodies: a bone, and muscles that shorten and are pressed on it.

use std::path::Path;

use fixtures::thigh::ThighBody;
use fixtures::{arithmetic, thigh};
use glam::DVec3;
use proximity::SurfaceTree;

use crate::bodies::{self, bounds, mean};

/// Frames of the motion, which repeats after the last.
pub(super) const FRAMES: u32 = 8;

/// Maximum distance by which muscles are pressed toward the bone \[mm\].
pub(super) const PRESS: f64 = 3.0;

/// Maximum share by which muscles are shortened; they thicken, so that their volume stays.
pub(super) const SHORTENING: f64 = 0.06;

/// Bodies with their states; lengths in mm.
#[derive(Debug)]
pub(super) struct MovingBodies {
    /// Title for the caption.
    pub(super) title: String,
    /// Names, the bone first.
    pub(super) names: Vec<String>,
    /// Bodies at rest, in the order of the names.
    pub(super) bodies: Vec<SurfaceTree>,
    /// Positions per frame and body.
    pub(super) frames: Vec<Vec<Vec<DVec3>>>,
}

impl MovingBodies {
    /// Returns the bone and the six muscles of the fixture scene.
    #[must_use]
    pub(super) fn fixture() -> Self {
        let mut named = Vec::new();
        for ThighBody { name, mesh, .. } in thigh::thigh().bodies {
            if name != "fascia_lata" {
                named.push((name.to_owned(), bodies::body(mesh)));
            }
        }
        Self::new("generated thigh (fixtures/thigh)", named)
    }

    /// Reads a femur and five muscles around it.
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
        let mut named = vec![("femur".to_owned(), read("bone_femur"))];
        named.extend(muscles.map(|name| (name.to_owned(), read(&format!("muscle_{name}")))));
        Self::new("thigh of the Visible Human Female, simplified", named)
    }

    fn new(title: &str, named: Vec<(String, SurfaceTree)>) -> Self {
        let (names, bodies): (Vec<String>, Vec<SurfaceTree>) = named.into_iter().unzip();
        let faces: usize = bodies.iter().map(|body| body.surface().faces().len()).sum();
        let title = format!("{title}: {} bodies, {faces} faces", bodies.len());
        let frames = (0..FRAMES).map(|frame| state(&bodies, frame)).collect();
        Self { title, names, bodies, frames }
    }
}

/// Returns the positions of all bodies in a frame.
fn state(bodies: &[SurfaceTree], frame: u32) -> Vec<Vec<DVec3>> {
    // Back and forth, as the cosine of the frame.
    let turned = arithmetic::circle(f64::from(frame) / f64::from(FRAMES));
    let progress = 0.5 * (1.0 - turned.x);
    let length = 1.0 - SHORTENING * progress;
    let bone = bodies[0].positions().as_slice();
    let bone_axis = long_axis(&bodies[0]);

    // Muscles shorten along the bone, thicken across, and are pressed toward it.
    let mut positions = vec![bone.to_vec()];
    for muscle in &bodies[1..] {
        let muscle = muscle.positions().as_slice();
        let center = mean(muscle);
        let toward = (mean(bone) - center).reject_from(bone_axis).normalize_or_zero();
        let place = |p: &DVec3| {
            let arm = *p - center;
            let along = arm.project_onto(bone_axis);
            center + length * along + (arm - along) / length.sqrt() + PRESS * progress * toward
        };
        positions.push(muscle.iter().map(place).collect());
    }
    positions
}

/// Returns the coordinate axis along which a body is longest.
fn long_axis(body: &SurfaceTree) -> DVec3 {
    let sides = bounds(body).sides();
    DVec3::AXES[sides.max_position()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn muscles_go_to_the_bone_and_back() {
        let moving = MovingBodies::fixture();
        let rest: Vec<&[DVec3]> =
            moving.bodies.iter().map(|body| body.positions().as_slice()).collect();
        let max_displacement = |frame: &[Vec<DVec3>], body: usize| {
            let distances = frame[body].iter().zip(rest[body]).map(|(x, y)| x.distance(*y));
            distances.fold(0.0, f64::max)
        };
        for body in 1..rest.len() {
            assert!(max_displacement(&moving.frames[0], body) < 1e-9, "body {body} starts at rest");
            assert!(max_displacement(&moving.frames[4], body) > PRESS, "body {body} is pressed");
        }
        assert!(moving.frames.iter().all(|frame| frame[0] == rest[0]), "the bone stays");
    }
}
