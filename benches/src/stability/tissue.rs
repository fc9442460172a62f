//! Soft bodies of the planted scenes: equal masses on springs to a shape.
//!
//! A free body is held by its own shape, which turns and moves with it: the springs carry no net
//! force and no net torque. An anchored body is held where it is told to be.
//!
//! Springs act with their whole force, so that a vertex that contact holds carries it all: a step
//! `h` of springs of stiffness over mass `k` is stable up to h² k = 4. Dampers are taken
//! implicitly.
//!
//! Source: M. Müller et al., "Meshless deformations based on shape matching", ACM TOG 24(3),
//! 2005, for the shape that moves with the body.

use std::ops::Range;

use glam::{DMat3, DQuat, DVec3};

use crate::measure::as_f64;

/// Newton steps to the rotation that fits best; each squares the error.
const TURNS: u32 = 6;

/// Place that the springs of a body pull to.
#[derive(Clone, Copy, Debug)]
pub enum Hold {
    /// The body's own shape, turned and moved to fit.
    Shape,
    /// A place per vertex and time \[s\], from that at rest.
    Place(fn(DVec3, f64) -> DVec3),
}

/// Soft body of equal masses.
#[derive(Clone, Debug)]
pub struct Tissue {
    /// Its particles among all.
    pub particles: Range<usize>,
    /// Vertices at rest.
    pub rest: Vec<DVec3>,
    /// Mass of a particle \[g\].
    pub mass: f64,
    /// Stiffness over mass of the springs \[1/s²\].
    pub stiffness: f64,
    /// Springs to what.
    pub hold: Hold,
    /// Rotation of the shape that fitted last.
    turn: DQuat,
    /// Places that springs pull to.
    goals: Vec<DVec3>,
}

impl Tissue {
    /// Returns a body of particles of 1 g at rest.
    #[must_use]
    pub fn new(particles: Range<usize>, rest: Vec<DVec3>, hold: Hold) -> Self {
        let goals = rest.clone();
        let turn = DQuat::IDENTITY;
        Self { particles, rest, mass: 1.0, stiffness: 0.0, hold, turn, goals }
    }

    /// Brings the goals to a state and a time; returns the energy of the springs.
    pub fn follow(&mut self, x: &[DVec3], time: f64) -> f64 {
        let x = &x[self.particles.clone()];
        match self.hold {
            Hold::Place(place) => {
                for (goal, rest) in self.goals.iter_mut().zip(&self.rest) {
                    *goal = place(*rest, time);
                }
            }
            Hold::Shape => self.fit(x),
        }

        let squares: f64 = x.iter().zip(&self.goals).map(|(x, g)| x.distance_squared(*g)).sum();
        0.5 * self.mass * self.stiffness * squares
    }

    /// Moves the goals of a free body to where they fit best.
    fn fit(&mut self, x: &[DVec3]) {
        let (center, rest_center) = (mean(x), mean(&self.rest));
        for _ in 0..TURNS {
            // Torque of the springs, and how it changes with the rotation.
            let (mut torque, mut fit) = (DVec3::ZERO, DMat3::ZERO);
            for (x, rest) in x.iter().zip(&self.rest) {
                let (turned, arm) = (self.turn * (*rest - rest_center), *x - center);
                torque += turned.cross(arm);
                fit += DMat3::from_cols(turned * arm.x, turned * arm.y, turned * arm.z);
            }

            // Newton step; where the change has no inverse, the last rotation stays.
            let trace = fit.x_axis.x + fit.y_axis.y + fit.z_axis.z;
            let change = DMat3::from_diagonal(DVec3::splat(trace)) - 0.5 * (fit + fit.transpose());
            let angle = change.inverse() * torque;
            if !angle.is_finite() {
                break;
            }
            self.turn = (DQuat::from_scaled_axis(angle) * self.turn).normalize();
        }

        // The goals share the body's center, so that the springs carry no net force.
        for (goal, rest) in self.goals.iter_mut().zip(&self.rest) {
            *goal = center + self.turn * (*rest - rest_center);
        }
    }

    /// Changes velocities by gravity and springs over a step `h` to `time`; returns the work
    /// that moving goals give.
    pub fn accelerate(
        &mut self,
        x: &[DVec3],
        v: &mut [DVec3],
        gravity: DVec3,
        [h, time]: [f64; 2],
    ) -> f64 {
        let own = self.particles.clone();
        for v in &mut v[own.clone()] {
            *v += h * gravity;
        }

        // Critical damping of what moves against the goals.
        let damping = 2.0 * self.stiffness.sqrt();
        let share = (1.0 + h * damping).recip();
        let (x, v) = (&x[own.clone()], &mut v[own]);
        match self.hold {
            Hold::Shape => {
                // Damping leaves the rigid motion alone, so that momentum is kept.
                let motion = RigidVelocity::fit(x, v);
                for ((x, v), goal) in x.iter().zip(v).zip(&self.goals) {
                    let rigid = motion.at(*x);
                    *v = rigid + share * (*v - rigid) + h * self.stiffness * (*goal - *x);
                }
                0.0
            }
            Hold::Place(place) => {
                let mut work = 0.0;
                for (i, (x, v)) in x.iter().zip(v).enumerate() {
                    let (goal, next) = (self.goals[i], place(self.rest[i], time));
                    let moves = (next - goal) / h;
                    let damped = share * (*v + h * damping * moves);
                    *v = damped + h * self.stiffness * (next - *x);

                    // What the move of the goal adds to the spring, and what the damper carries.
                    let squares = x.distance_squared(next) - x.distance_squared(goal);
                    let carried = h * damping * (moves - damped).dot(moves);
                    work += self.mass * (0.5 * self.stiffness * squares + carried);
                }
                work
            }
        }
    }

    /// Returns the center of the body.
    #[must_use]
    pub fn center(&self, x: &[DVec3]) -> DVec3 {
        mean(&x[self.particles.clone()])
    }

    /// Returns the largest distance of a vertex from its goal.
    #[must_use]
    pub fn farthest_from_goal(&self, x: &[DVec3]) -> f64 {
        let x = x[self.particles.clone()].iter();
        x.zip(&self.goals).map(|(x, goal)| x.distance(*goal)).fold(0.0, f64::max)
    }

    /// Forgets the rotation of the last state.
    pub fn reset(&mut self) {
        self.turn = DQuat::IDENTITY;
    }
}

/// Rigid motion with the momentum and the angular momentum of equal masses.
struct RigidVelocity {
    center: DVec3,
    velocity: DVec3,
    spin: DVec3,
}

impl RigidVelocity {
    fn fit(x: &[DVec3], v: &[DVec3]) -> Self {
        let (center, velocity) = (mean(x), mean(v));
        let (mut momentum, mut inertia) = (DVec3::ZERO, DMat3::ZERO);

        // Angular momentum about the center gives the spin, by the moment of inertia.
        for (x, v) in x.iter().zip(v) {
            let arm = *x - center;
            momentum += arm.cross(*v - velocity);
            let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
            inertia += DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer;
        }
        Self { center, velocity, spin: inertia.inverse() * momentum }
    }

    fn at(&self, x: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(x - self.center)
    }
}

/// Computes the mean of points.
fn mean(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / as_f64(points.len())
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::ellipsoid;

    use super::*;

    /// A dented and turned body with velocities.
    fn body() -> (Tissue, Vec<DVec3>, Vec<DVec3>) {
        let rest = ellipsoid(DVec3::new(9.0, 6.0, 4.0), 2).positions;
        let turn = DQuat::from_rotation_z(0.4) * DQuat::from_rotation_x(0.3);
        let x: Vec<DVec3> =
            rest.iter().map(|p| turn * *p + 0.1 * (DVec3::new(p.y, p.z, p.x) * *p)).collect();
        let v = rest.iter().map(|p| DVec3::new(p.y, p.x * p.z, 1.0)).collect();
        let mut tissue = Tissue::new(0..x.len(), rest, Hold::Shape);
        tissue.stiffness = 2e5;
        (tissue, x, v)
    }

    #[test]
    fn springs_to_the_shape_carry_no_force_and_no_torque() {
        let (mut tissue, x, mut v) = body();
        let momentum = |v: &[DVec3]| {
            let angular: DVec3 = x.iter().zip(v).map(|(x, v)| x.cross(*v)).sum();
            (v.iter().sum::<DVec3>(), angular)
        };
        let before = momentum(&v);
        let energy = tissue.follow(&x, 0.0);
        tissue.accelerate(&x, &mut v, DVec3::ZERO, [1e-3, 1e-3]);
        let after = momentum(&v);
        assert!(energy > 1e5, "{energy}");
        assert!((after.0 - before.0).length() < 1e-7, "{before:?}, {after:?}");
        assert!((after.1 - before.1).length() < 1e-6, "{before:?}, {after:?}");
    }

    #[test]
    fn a_dented_body_returns_to_its_shape_without_a_gain_of_energy() {
        let (mut tissue, mut x, mut v) = body();
        let (h, mut last) = (1e-3, f64::INFINITY);
        for _ in 0..100 {
            let kinetic: f64 = v.iter().map(|v| 0.5 * v.length_squared()).sum();
            let energy = kinetic + tissue.follow(&x, 0.0);
            assert!(energy <= last * (1.0 + 1e-9), "{energy} after {last}");
            last = energy;
            tissue.accelerate(&x, &mut v, DVec3::ZERO, [h, h]);
            for (x, v) in x.iter_mut().zip(&v) {
                *x += h * *v;
            }
        }
        assert!(tissue.farthest_from_goal(&x) < 0.05);
    }
}
