//! Symmetric 4 × 4 matrices over the center and the radius of a ball.

use glam::DVec4;

/// Symmetric 4 × 4 matrix, by its upper triangle, row by row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Symmetric4(pub(crate) [f64; 10]);

/// Places of the diagonal: those of the center, then that of the radius.
pub(crate) const DIAGONAL: [usize; 4] = [0, 4, 7, 9];

impl Symmetric4 {
    /// Computes `v vᵀ`.
    pub(crate) fn outer(v: DVec4) -> Self {
        Self([
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
        ])
    }

    /// Returns the matrix times a number.
    pub(crate) fn scaled(self, scale: f64) -> Self {
        Self(self.0.map(|entry| scale * entry))
    }

    /// Adds `scale` times another matrix.
    pub(crate) fn add_scaled(&mut self, scale: f64, other: &Self) {
        for (entry, added) in self.0.iter_mut().zip(other.0) {
            *entry += scale * added;
        }
    }

    /// Computes the product with a vector.
    pub(crate) fn times(&self, v: DVec4) -> DVec4 {
        let [xx, xy, xz, xw, yy, yz, yw, zz, zw, ww] = self.0;
        DVec4::new(
            xx * v.x + xy * v.y + xz * v.z + xw * v.w,
            xy * v.x + yy * v.y + yz * v.z + yw * v.w,
            xz * v.x + yz * v.y + zz * v.z + zw * v.w,
            xw * v.x + yw * v.y + zw * v.z + ww * v.w,
        )
    }

    /// Solves a positive definite system by `L D Lᵀ`; `None` where a pivot vanishes.
    pub(crate) fn solve(&self, b: DVec4) -> Option<DVec4> {
        // Elimination.
        let [xx, xy, xz, xw, yy, yz, yw, zz, zw, ww] = self.0;
        let (lyx, lzx, lwx) = (xy / xx, xz / xx, xw / xx);
        let d1 = yy - lyx * xy;
        let (y1, y2) = (yz - lyx * xz, yw - lyx * xw);
        let (lzy, lwy) = (y1 / d1, y2 / d1);
        let d2 = zz - lzx * xz - lzy * y1;
        let z1 = zw - lzx * xw - lzy * y2;
        let lwz = z1 / d2;
        let d3 = ww - lwx * xw - lwy * y2 - lwz * z1;
        // A pivot that is NaN is not positive either.
        if ![xx, d1, d2, d3].into_iter().all(|pivot| pivot > 0.0) {
            return None;
        }

        // Forward substitution, then backward.
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
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;

    use super::*;

    #[test]
    fn a_solution_times_the_matrix_is_the_right_side() {
        let mut random = Random(3);
        let mut vector = || DVec4::from_array([0; 4].map(|_| 20.0 * random.unit() - 10.0));
        for _ in 0..1000 {
            let mut matrix = Symmetric4::default();
            for place in DIAGONAL {
                matrix.0[place] = 0.5;
            }
            for _ in 0..3 {
                matrix.add_scaled(1.0, &Symmetric4::outer(vector()));
            }
            let x = vector();
            let solved = matrix.solve(matrix.times(x)).unwrap();
            assert!((solved - x).length() < 1e-9, "{solved} is not {x}");
        }
    }
}
