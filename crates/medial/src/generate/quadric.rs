//! How far a ball is from touching a set of planes: a quadratic in its center
//! and radius.
//!
//! Source: J.-M. Thiery, É. Guy and T. Boubekeur, "Sphere-Meshes: Shape
//! Approximation using Spherical Quadric Error Metrics", ACM TOG 32(6), 2013.

use glam::{DVec3, DVec4, Vec4Swizzles as _};

use crate::Ball;

/// `sᵀ A s − 2 bᵀ s + c` over `s = (center, radius)`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    /// Upper triangle of A, row by row.
    a: [f64; 10],
    b: DVec4,
    c: f64,
}

impl Quadric {
    /// `weight (n·(p − center) − radius)²`: how far the ball is from touching
    /// the plane through `p` with outward normal `n`, from inside.
    pub(super) fn plane(p: DVec3, n: DVec3, weight: f64) -> Self {
        let v = n.extend(1.0);
        let height = n.dot(p);
        let a = outer(v).map(|entry| weight * entry);
        Self { a, b: weight * height * v, c: weight * height * height }
    }

    /// `weight |s − ball|²`.
    pub(super) fn near(ball: Ball, weight: f64) -> Self {
        let s = ball.center.extend(ball.radius);
        let w = weight;
        let a = [w, 0.0, 0.0, 0.0, w, 0.0, 0.0, w, 0.0, w];
        Self { a, b: w * s, c: w * s.length_squared() }
    }

    pub(super) fn add(&mut self, other: &Self) {
        for (mine, theirs) in self.a.iter_mut().zip(other.a) {
            *mine += theirs;
        }
        self.b += other.b;
        self.c += other.c;
    }

    pub(super) fn sum(&self, other: &Self) -> Self {
        let mut sum = *self;
        sum.add(other);
        sum
    }

    pub(super) fn value(&self, ball: Ball) -> f64 {
        let s = ball.center.extend(ball.radius);
        (s.dot(self.times(s)) - 2.0 * self.b.dot(s) + self.c).max(0.0)
    }

    /// The ball with the least value and a radius that is not negative, or
    /// `None` where the quadric does not fix one.
    pub(super) fn minimum(&self) -> Option<Ball> {
        let s = solve(&self.a, self.b)?;
        Some(Ball::new(s.xyz(), s.w.max(0.0)))
    }

    fn times(&self, s: DVec4) -> DVec4 {
        let [xx, xy, xz, xw, yy, yz, yw, zz, zw, ww] = self.a;
        DVec4::new(
            xx * s.x + xy * s.y + xz * s.z + xw * s.w,
            xy * s.x + yy * s.y + yz * s.z + yw * s.w,
            xz * s.x + yz * s.y + zz * s.z + zw * s.w,
            xw * s.x + yw * s.y + zw * s.z + ww * s.w,
        )
    }
}

/// Upper triangle of `v vᵀ`, row by row.
pub(crate) fn outer(v: DVec4) -> [f64; 10] {
    [
        v.x * v.x,
        v.x * v.y,
        v.x * v.z,
        v.x * v.w,
        v.y * v.y,
        v.y * v.z,
        v.y * v.w,
        v.z * v.z,
        v.z * v.w,
        v.w * v.w,
    ]
}

/// Solves a symmetric positive definite 4 × 4 system by `L D Lᵀ`, or `None`
/// where a pivot vanishes.
pub(crate) fn solve(upper: &[f64; 10], b: DVec4) -> Option<DVec4> {
    let [xx, xy, xz, xw, yy, yz, yw, zz, zw, ww] = *upper;
    let (lyx, lzx, lwx) = (xy / xx, xz / xx, xw / xx);
    let d1 = yy - lyx * xy;
    let (y1, y2) = (yz - lyx * xz, yw - lyx * xw);
    let (lzy, lwy) = (y1 / d1, y2 / d1);
    let d2 = zz - lzx * xz - lzy * y1;
    let z1 = zw - lzx * xw - lzy * y2;
    let lwz = z1 / d2;
    let d3 = ww - lwx * xw - lwy * y2 - lwz * z1;
    // A NaN pivot is not positive either.
    if ![xx, d1, d2, d3].into_iter().all(|pivot| pivot > 0.0) {
        return None;
    }
    let fx = b.x;
    let fy = b.y - lyx * fx;
    let fz = b.z - lzx * fx - lzy * fy;
    let fw = b.w - lwx * fx - lwy * fy - lwz * fz;
    let w = fw / d3;
    let z = fz / d2 - lwz * w;
    let y = fy / d1 - lzy * z - lwy * w;
    let x = fx / xx - lyx * y - lzx * z - lwx * w;
    Some(DVec4::new(x, y, z, w))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ball_in_a_corner_touches_its_planes() {
        // Inscribed ball of the tetrahedron under the plane x + y + z = 1.
        let mut quadric = Quadric::default();
        for axis in DVec3::AXES {
            quadric.add(&Quadric::plane(DVec3::ZERO, -axis, 1.0));
        }
        quadric.add(&Quadric::plane(DVec3::X, DVec3::ONE.normalize(), 1.0));
        let ball = quadric.minimum().unwrap();
        let radius = 1.0 / (3.0 + 3.0_f64.sqrt());
        assert!((ball.radius - radius).abs() < 1e-14, "{ball:?}");
        assert!((ball.center - radius).length() < 1e-14, "{ball:?}");
        assert!(quadric.value(ball) < 1e-14);
    }

    #[test]
    fn solves_what_multiplication_undoes() {
        arbtest::arbtest(|u| {
            let mut quadric = Quadric::near(Ball::default(), 0.5);
            let mut number = || Ok(f64::from(u.int_in_range(-1000_i32..=1000)?) / 100.0);
            for _ in 0..3 {
                let n = DVec3::new(number()?, number()?, number()?);
                quadric.add(&Quadric::plane(DVec3::ZERO, n, 1.0));
            }
            let s = DVec4::new(number()?, number()?, number()?, number()?);
            let solved = solve(&quadric.a, quadric.times(s)).unwrap();
            assert!((solved - s).length() < 1e-9, "{solved} is not {s}");
            Ok(())
        });
    }

    #[test]
    fn planes_alone_may_fix_no_ball() {
        assert!(Quadric::plane(DVec3::ZERO, DVec3::X, 1.0).minimum().is_none());
    }
}
