//! Motion of bodies between the frames of a plan.

use glam::DVec3;
use scene::{Body, Scene};
use surface::{Aabb, parallel};

/// Motion of a body since it was first followed.
#[derive(Debug)]
pub(crate) struct BodyMotion {
    /// Positions of the last frame.
    positions: Vec<DVec3>,
    /// Box around them.
    pub(crate) bounds: Aabb,
    /// Sum over the frames of the largest displacement of a vertex, rounded up.
    pub(crate) traveled: f64,
}

/// Bound on the depth of a pair when it was detected last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LastDepth {
    pub(crate) upper: f64,
    /// Ways of both bodies until then.
    pub(crate) traveled: [f64; 2],
}

impl BodyMotion {
    /// Begins to follow all bodies.
    pub(crate) fn begin(scene: &Scene) -> Vec<Self> {
        scene.bodies().iter().map(Self::new).collect()
    }

    fn new(body: &Body) -> Self {
        let positions = body.positions().to_vec();
        let bounds = Aabb::of_points(positions.iter().copied());
        Self { positions, bounds, traveled: 0.0 }
    }

    /// Follows all bodies to where they are.
    pub(crate) fn follow(motions: &mut [Self], scene: &Scene) {
        let bodies = scene.bodies();
        let followed = parallel::try_for_each_mut(motions, |number, motion| {
            motion.follow_body(&bodies[number]);
            Ok::<(), std::convert::Infallible>(())
        });
        match followed {
            Ok(()) => {}
            Err(never) => match never {},
        }
    }

    fn follow_body(&mut self, body: &Body) {
        let mut max_squared: f64 = 0.0;
        let mut bounds = Aabb::EMPTY;
        for (last, &now) in self.positions.iter_mut().zip(body.positions()) {
            max_squared = max_squared.max(last.distance_squared(now));
            bounds = bounds.with_point(now);
            *last = now;
        }
        self.bounds = bounds;

        // A way that is far shorter than all before it counts, too.
        if max_squared > 0.0 {
            let way = max_squared.sqrt() * (1.0 + 4.0 * f64::EPSILON);
            self.traveled = (self.traveled + way).next_up();
        }
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::BodyKind;

    use super::*;

    #[test]
    fn a_body_has_traveled_as_far_as_any_of_its_vertices() {
        let cube = shapes::cube(1.0);
        let mut scene = Scene::new();
        let added = scene.add("a", BodyKind::Deformable, cube.surface(), cube.positions.clone());
        let (body, mut x) = (added.expect("a cube"), cube.positions);
        let mut motions = BodyMotion::begin(&scene);
        for (vertex, expected) in [(0, 2.0), (7, 4.0), (3, 6.0)] {
            x[vertex] += 2.0 * DVec3::X;
            scene.move_body(body, &x).expect("finite");
            BodyMotion::follow(&mut motions, &scene);
            // Bounds on depths add it: never less than the way, which is exact here.
            let beyond = motions[0].traveled - expected;
            assert!((0.0..1e-12).contains(&beyond), "vertex {vertex}: {beyond}");
        }
    }
}
