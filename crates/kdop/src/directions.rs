//! Directions of a k-DOP, and projection onto them.
//!
//! Source: J. T. Klosowski et al., "Efficient Collision Detection Using Bounding Volume Hierarchies
//! of k-DOPs", IEEE TVCG 4(1), 1998, section 3: axes, the diagonals of faces and those of the cube.
//! The directions are not normalized. With components of 0 and ±1 a projection is a sum, and for
//! the axes and the diagonals of faces it is one operation, which makes its rounding monotone.

use glam::DVec3;

/// Coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Along +x.
    X = 0,
    /// Along +y.
    Y = 1,
    /// Along +z.
    Z = 2,
}

const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];
const FACE_DIAGONALS: [DVec3; 6] = [
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(1.0, -1.0, 0.0),
    DVec3::new(1.0, 0.0, 1.0),
    DVec3::new(1.0, 0.0, -1.0),
    DVec3::new(0.0, 1.0, 1.0),
    DVec3::new(0.0, 1.0, -1.0),
];
const CUBE_DIAGONALS: [DVec3; 4] = [
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(1.0, -1.0, -1.0),
];

/// √2 = 1.41421356237309504880… rounded up.
const SQRT_2_UP: f64 = std::f64::consts::SQRT_2;
/// √3 = 1.73205080756887729352… rounded up.
const SQRT_3_UP: f64 = 1.732_050_807_568_877_4;

/// Returns direction `k < S` of a k-DOP with `S` directions, not normalized.
///
/// `S` is 3 (the axes), 7 (then the diagonals of the cube), 9 (the axes, then the diagonals of the
/// faces: x+y, x−y, x+z, x−z, y+z, y−z) or 13 (all of them, in the order axes, faces, cube).
///
/// # Panics
///
/// When `k >= S`. Another `S` does not compile.
#[must_use]
pub fn direction<const S: usize>(k: usize) -> DVec3 {
    const { assert!(matches!(S, 3 | 7 | 9 | 13), "a k-DOP has 3, 7, 9 or 13 directions") };
    assert!(k < S, "direction {k} of a k-DOP with {S}");
    match (S, k) {
        (_, 0..3) => AXES[k],
        (7, _) => CUBE_DIAGONALS[k - 3],
        (_, 3..9) => FACE_DIAGONALS[k - 3],
        _ => CUBE_DIAGONALS[k - 9],
    }
}

/// Returns the length of [`direction`] `k`: 1, √2 or √3, rounded up.
///
/// Inflation by a length `r` moves the bounds along direction `k` by `r` times this.
///
/// # Panics
///
/// When `k >= S`.
#[must_use]
pub fn norm<const S: usize>(k: usize) -> f64 {
    // Squared lengths are exact.
    match direction::<S>(k).length_squared() {
        1.0 => 1.0,
        2.0 => SQRT_2_UP,
        _ => SQRT_3_UP,
    }
}

/// Returns true if a projection onto any of the directions rounds once, hence monotonically.
pub(crate) const fn is_monotone<const S: usize>() -> bool {
    matches!(S, 3 | 9)
}

/// Computes `n_k · p` for every direction.
#[inline(always)]
pub(crate) fn project<const S: usize>(p: DVec3) -> [f64; S] {
    // Sums of x and y are shared between directions; `S` is constant, so unused ones vanish.
    let DVec3 { x, y, z } = p;
    let (s, d) = (x + y, x - y);
    let all = match S {
        7 => [x, y, z, s + z, s - z, d + z, d - z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        _ => [x, y, z, s, d, x + z, x - z, y + z, y - z, s + z, s - z, d + z, d - z],
    };
    std::array::from_fn(|k| all[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn projects_as_listed<const S: usize>() {
        let p = DVec3::new(3.0, -7.0, 11.0);
        for (k, &projected) in project::<S>(p).iter().enumerate() {
            let exact = direction::<S>(k).dot(p);
            assert!((projected - exact).abs() < 1e-12, "direction {k} of {S}: {projected}");

            let length = direction::<S>(k).length();
            assert!((norm::<S>(k) - length).abs() < 1e-15, "norm {k} of {S}");
            assert!(norm::<S>(k).powi(2) >= length.powi(2).round(), "rounded up");
        }
    }

    #[test]
    fn projections_agree_with_the_directions() {
        projects_as_listed::<3>();
        projects_as_listed::<7>();
        projects_as_listed::<9>();
        projects_as_listed::<13>();
    }
}
