//! Random leaves, and their overlapping pairs by brute force in f64.

use arbitrary::{Result, Unstructured};
use arbtest::arbtest;
use glam::DVec3;
use kdop::{direction, norm};

/// Checks a property on `count` random inputs, the same in every run.
pub(crate) fn check(count: u64, property: impl Fn(&mut Unstructured<'_>) -> Result<()>) {
    for i in 0..count {
        // The lower half of a seed is the number of random bytes.
        let size = 64 << (i % 8);
        let random = i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
        arbtest(&property).seed(random << 32 | size).run();
    }
}

/// Points, and the triangles, edges or points that are made of them.
#[derive(Clone, Debug)]
pub(crate) struct Soup {
    pub(crate) points: Vec<DVec3>,
    pub(crate) leaves: Vec<[u32; 3]>,
}

/// Position and scale of a soup.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Distance from the origin.
    pub(crate) offset: DVec3,
    /// Length of the unit that coordinates are whole multiples of.
    pub(crate) unit: f64,
}

impl Frame {
    /// The same scale at the origin.
    pub(crate) fn at_origin(self) -> Self {
        Self { offset: DVec3::ZERO, ..self }
    }
}

/// Draws a frame: near the origin or up to a million units away, of ordinary or extreme scale.
pub(crate) fn frame(u: &mut Unstructured<'_>) -> Result<Frame> {
    let unit = *u.choose(&[1.0, 1.0, 1.0, 0.1, 1e-3, 1e6, 1e300, 1e-40, 1e-300])?;
    let far = *u.choose(&[0.0, 0.0, 1.0, 1e3, 1e6])?;
    let toward = |u: &mut Unstructured<'_>| Ok(f64::from(u.int_in_range(-1_i8..=1)?));
    let offset = DVec3::new(toward(u)?, toward(u)?, toward(u)?) * far * unit;
    Ok(Frame { offset, unit })
}

/// Draws a point on a coarse lattice, often a few ulps off it, so that ties and near ties abound.
pub(crate) fn point(u: &mut Unstructured<'_>, frame: Frame, spread: i8) -> Result<DVec3> {
    let mut coordinate = |offset: f64| {
        let whole = f64::from(u.int_in_range(-spread..=spread)?);
        let ulps = f64::from(u.int_in_range(-2_i8..=2)?);
        Ok((offset + whole * frame.unit) * (1.0 + ulps * f64::EPSILON))
    };
    Ok(DVec3::new(
        coordinate(frame.offset.x)?,
        coordinate(frame.offset.y)?,
        coordinate(frame.offset.z)?,
    ))
}

/// Draws up to a hundred leaves: slivers, folded ones, repeated corners, large ones among small
/// ones.
pub(crate) fn soup(u: &mut Unstructured<'_>, frame: Frame) -> Result<Soup> {
    let count = u.int_in_range(0_u32..=100)?;
    let spread = *u.choose(&[0, 2, 5, 20])?;
    let mut points = Vec::new();
    let mut leaves = Vec::new();
    for _ in 0..count {
        let size = if u.ratio(1, 10)? { spread } else { 1.min(spread) };
        let first = point(u, frame, spread)?;
        let number = u32::try_from(points.len()).unwrap_or(0);
        points.push(first);
        for _ in 0..2 {
            points.push(first + point(u, frame.at_origin(), size)?);
        }

        let corner =
            |u: &mut Unstructured<'_>| u.int_in_range(number.saturating_sub(6)..=number + 2);
        leaves.push([corner(u)?, corner(u)?, corner(u)?]);
    }
    Ok(Soup { points, leaves })
}

/// Lower and upper bound along every direction, in f64.
pub(crate) type Bounds<const S: usize> = [[f64; 2]; S];

/// Computes the bounds of a leaf over all states of its points and their radii.
pub(crate) fn bounds<const S: usize>(
    leaf: [u32; 3],
    states: &[(&[DVec3], Option<&[f64]>)],
) -> Bounds<S> {
    std::array::from_fn(|k| {
        let mut interval = [f64::INFINITY, f64::NEG_INFINITY];
        for (points, radii) in states {
            for corner in leaf {
                let at = project::<S>(points[corner as usize], k);
                let radius = radii.map_or(0.0, |radii| radii[corner as usize] * norm::<S>(k));
                interval = [interval[0].min(at - radius), interval[1].max(at + radius)];
            }
        }
        interval
    })
}

/// Computes the bounds of all leaves of a soup at rest.
pub(crate) fn bounds_at_rest<const S: usize>(soup: &Soup) -> Vec<Bounds<S>> {
    soup.leaves.iter().map(|&leaf| bounds(leaf, &[(&soup.points, None)])).collect()
}

/// Computes one projection, with the additions in the order of the coordinates.
fn project<const S: usize>(p: DVec3, k: usize) -> f64 {
    let n = direction::<S>(k);
    let terms = [n.x * p.x, n.y * p.y, n.z * p.z];
    terms.into_iter().zip(n.to_array()).filter(|(_, n)| *n != 0.0).map(|(term, _)| term).sum()
}

/// Returns true if two leaves are within `margin` along every direction.
fn overlap<const S: usize>(a: &Bounds<S>, b: &Bounds<S>, margin: f64) -> bool {
    (0..S).all(|k| {
        let margin = margin * norm::<S>(k);
        a[k][0] - margin <= b[k][1] && b[k][0] - margin <= a[k][1]
    })
}

/// Finds all pairs that must be reported.
pub(crate) fn brute_force<const S: usize>(
    a: &[Bounds<S>],
    b: &[Bounds<S>],
    margin: f64,
) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    for (i, a) in (0..).zip(a) {
        pairs.extend((0..).zip(b).filter(|(_, b)| overlap(a, b, margin)).map(|(j, _)| (i, j)));
    }
    pairs
}
