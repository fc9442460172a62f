//! Random inputs of fixed seeds.

use arbitrary::{Result, Unstructured};
use arbtest::arbtest;
use glam::DVec3;

/// Checks a property on `count` random inputs, the same in every run.
pub(crate) fn check(count: u64, property: impl Fn(&mut Unstructured<'_>) -> Result<()>) {
    for i in 0..count {
        // The lower half of a seed is the number of random bytes.
        let random = i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
        arbtest(&property).seed(random << 32 | 1024).run();
    }
}

/// Draws a point of the cube from `-size` to `size`.
pub(crate) fn point(u: &mut Unstructured<'_>, size: f64) -> Result<DVec3> {
    let mut coordinate = || Ok(size * (f64::from(u.arbitrary::<i16>()?) / 32768.0));
    Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?))
}
