//! Deviation of a coarse surface after its body has deformed.
//!
//! A rigid motion of both surfaces keeps the distance between them. If every vertex is now within δ
//! of where one rigid motion takes it from rest, then so is every point of either surface, since
//! faces are convex; the surfaces deviate by at most 2 δ more than at rest. This holds for any
//! rigid motion: a better fit of it gives a smaller bound.

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};
use scene::Body;

use crate::cost::count;

/// Bound on how a body has deformed since its coarse surface was built.
#[derive(Clone, Debug)]
pub(crate) struct Deformation {
    /// Positions at which the coarse surface was built, about their mean.
    rest: Vec<DVec3>,
    /// Largest distance of a vertex from its place after a rigid motion.
    pub(crate) max_distance: f64,
}

/// Squarings of the matrix whose powers tend to the best rotation. Fewer make the bound larger, not
/// wrong, for bodies that are nearly symmetric.
const SQUARINGS: u32 = 20;

impl Deformation {
    /// Begins where a body is.
    pub(crate) fn begin(body: &Body) -> Self {
        let center = mean(body.positions());
        let rest = body.positions().iter().map(|x| *x - center).collect();
        Self { rest, max_distance: 0.0 }
    }

    /// Bounds the deformation where the body is now.
    pub(crate) fn follow(&mut self, body: &Body) {
        // Products of rest and present positions determine the rotation that fits best.
        let center = mean(body.positions());
        let mut products = DMat3::ZERO;
        for (&rest, &now) in self.rest.iter().zip(body.positions()) {
            let now = now - center;
            products += DMat3::from_cols(now * rest.x, now * rest.y, now * rest.z);
        }
        let rotation = DMat3::from_quat(fit(&products));

        // Whatever the rotation is, what vertices are off it bounds the deformation.
        let mut max_squared: f64 = 0.0;
        for (&rest, &now) in self.rest.iter().zip(body.positions()) {
            max_squared = max_squared.max((rotation * rest).distance_squared(now - center));
        }
        self.max_distance = max_squared.sqrt();
    }

    /// Returns the memory, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.rest[..])
    }
}

fn mean(x: &[DVec3]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for &x in x {
        sum += x;
    }
    sum / count(x.len().max(1))
}

/// Finds the rotation that takes rest positions nearest to the present ones.
///
/// It is the eigenvector of the largest eigenvalue of a symmetric matrix of the sums of products:
/// a column of a high power of that matrix, shifted by its norm.
///
/// Source: B. K. P. Horn, "Closed-form solution of absolute orientation using unit quaternions",
/// Journal of the Optical Society of America A 4(4), 1987. Differs in the power by squaring.
fn fit(products: &DMat3) -> DQuat {
    // Column k holds the sums of present positions by coordinate k of rest.
    let [x, y, z] = [products.x_axis, products.y_axis, products.z_axis];
    let columns = [
        DVec4::new(x.x - y.y - z.z, y.x + x.y, z.x + x.z, y.z - z.y),
        DVec4::new(y.x + x.y, y.y - x.x - z.z, z.y + y.z, z.x - x.z),
        DVec4::new(z.x + x.z, z.y + y.z, z.z - x.x - y.y, x.y - y.x),
        DVec4::new(y.z - z.y, z.x - x.z, x.y - y.x, x.x + y.y + z.z),
    ];
    let norm = |columns: &[DVec4; 4]| {
        columns.iter().fold(0.0, |norm: f64, column| norm.max(column.abs().element_sum()))
    };
    let shift = norm(&columns);
    if shift <= 0.0 {
        return DQuat::IDENTITY;
    }

    let [a, b, c, d] = columns;
    let mut power = DMat4::from_cols(a, b, c, d) + DMat4::from_diagonal(DVec4::splat(shift));
    for _ in 0..SQUARINGS {
        let scale = 1.0 / norm(&power.to_cols_array_2d().map(DVec4::from_array));
        power = (power * scale) * (power * scale);
    }

    // All columns tend to multiples of it.
    let mut longest = power.col(0);
    for column in [power.col(1), power.col(2), power.col(3)] {
        if column.length_squared() > longest.length_squared() {
            longest = column;
        }
    }
    longest.try_normalize().map_or(DQuat::IDENTITY, DQuat::from_vec4)
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::ellipsoid;
    use scene::{BodyKind, Scene};

    use super::*;

    #[test]
    fn a_rigid_motion_is_no_deformation_and_a_bend_is() {
        let mesh = ellipsoid(DVec3::new(10.0, 15.0, 60.0), 3);
        let mut scene = Scene::new();
        let id = scene
            .add("muscle", BodyKind::Deformable, mesh.surface(), mesh.positions.clone())
            .expect("a body");
        let mut deformation = Deformation::begin(scene.body(id));

        // Turned step by step, as in a motion.
        for step in 1..=40 {
            let turn = DQuat::from_axis_angle(DVec3::ONE.normalize(), 0.03 * f64::from(step));
            let x: Vec<DVec3> =
                mesh.positions.iter().map(|p| turn * *p + f64::from(step) * DVec3::X).collect();
            scene.move_body(id, &x).expect("a move");
            deformation.follow(scene.body(id));
            assert!(deformation.max_distance < 1e-6, "{step}: {}", deformation.max_distance);
        }

        // Bent by 3 at both ends, of which a motion of the whole takes less than half.
        let bend = |p: &DVec3| *p + DVec3::X * 3.0 * (p.z / 60.0).powi(2);
        let x: Vec<DVec3> = mesh.positions.iter().map(bend).collect();
        scene.move_body(id, &x).expect("a move");
        deformation.follow(scene.body(id));
        assert!((1.5..8.0).contains(&deformation.max_distance), "{}", deformation.max_distance);
    }
}
