//! Soups of leaves, and what overlaps among them by brute force in f64.

use arbitrary::{Result, Unstructured};
use glam::DVec3;
use kdop::{direction, norm};

/// Points and the triangles, edges or points that are made of them.
#[derive(Clone, Debug)]
pub(crate) struct Soup {
    pub(crate) points: Vec<DVec3>,
    pub(crate) leaves: Vec<[u32; 3]>,
}

/// What the points of a soup are like.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terrain {
    /// Where the soup lies: its distance from the origin.
    pub(crate) offset: DVec3,
    /// Length of the unit that coordinates are whole multiples of.
    pub(crate) unit: f64,
}

/// A terrain: near the origin or up to a million units away; huge and tiny ones too.
pub(crate) fn terrain(u: &mut Unstructured<'_>) -> Result<Terrain> {
    let unit = *u.choose(&[1.0, 1.0, 1.0, 0.1, 1e-3, 1e6, 1e300, 1e-40, 1e-300])?;
    let far = *u.choose(&[0.0, 0.0, 1.0, 1e3, 1e6])?;
    let toward = |u: &mut Unstructured<'_>| Ok(f64::from(u.int_in_range(-1_i8..=1)?));
    let offset = DVec3::new(toward(u)?, toward(u)?, toward(u)?) * far * unit;
    Ok(Terrain { offset, unit })
}

/// A point on a coarse lattice, often a few ulps off it: ties and near ties abound.
pub(crate) fn point(u: &mut Unstructured<'_>, terrain: Terrain, spread: i8) -> Result<DVec3> {
    let mut coordinate = |offset: f64| {
        let whole = f64::from(u.int_in_range(-spread..=spread)?);
        let ulps = f64::from(u.int_in_range(-2_i8..=2)?);
        Ok((offset + whole * terrain.unit) * (1.0 + ulps * f64::EPSILON))
    };
    Ok(DVec3::new(
        coordinate(terrain.offset.x)?,
        coordinate(terrain.offset.y)?,
        coordinate(terrain.offset.z)?,
    ))
}

/// Up to a hundred leaves: slivers, folded ones, repeated corners, large ones among small ones.
pub(crate) fn soup(u: &mut Unstructured<'_>, terrain: Terrain) -> Result<Soup> {
    let count = u.int_in_range(0_u32..=100)?;
    let spread = *u.choose(&[0, 2, 5, 20])?;
    let mut points = Vec::new();
    let mut leaves = Vec::new();
    for _ in 0..count {
        let reach = if u.ratio(1, 10)? { spread } else { 1.min(spread) };
        let first = point(u, terrain, spread)?;
        let known = u32::try_from(points.len()).unwrap_or(0);
        points.push(first);
        for _ in 0..2 {
            points.push(first + point(u, Terrain { offset: DVec3::ZERO, ..terrain }, reach)?);
        }
        let corner = |u: &mut Unstructured<'_>| u.int_in_range(known.saturating_sub(6)..=known + 2);
        leaves.push([corner(u)?, corner(u)?, corner(u)?]);
    }
    Ok(Soup { points, leaves })
}

/// Bounds of a leaf along every direction, in f64: the reference.
pub(crate) fn reference<const S: usize>(
    leaf: [u32; 3],
    states: &[(&[DVec3], Option<&[f64]>)],
) -> [[f64; 2]; S] {
    std::array::from_fn(|k| {
        let mut interval = [f64::INFINITY, f64::NEG_INFINITY];
        for (points, radii) in states {
            for corner in leaf {
                let at = project::<S>(points[corner as usize], k);
                let reach = radii.map_or(0.0, |radii| radii[corner as usize] * norm::<S>(k));
                interval = [interval[0].min(at - reach), interval[1].max(at + reach)];
            }
        }
        interval
    })
}

/// One projection, with the additions in the order of the coordinates.
fn project<const S: usize>(p: DVec3, k: usize) -> f64 {
    let n = direction::<S>(k);
    let terms = [n.x * p.x, n.y * p.y, n.z * p.z];
    terms.into_iter().zip(n.to_array()).filter(|(_, n)| *n != 0.0).map(|(term, _)| term).sum()
}

/// Whether two leaves are closer than `margin` along every direction.
pub(crate) fn overlaps<const S: usize>(a: &[[f64; 2]; S], b: &[[f64; 2]; S], margin: f64) -> bool {
    (0..S).all(|k| {
        let reach = margin * norm::<S>(k);
        a[k][0] - reach <= b[k][1] && b[k][0] - reach <= a[k][1]
    })
}

/// All pairs that must be found.
pub(crate) fn brute_force<const S: usize>(
    a: &[[[f64; 2]; S]],
    b: &[[[f64; 2]; S]],
    margin: f64,
) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    for (i, a) in (0..).zip(a) {
        pairs.extend((0..).zip(b).filter(|(_, b)| overlaps(a, b, margin)).map(|(j, _)| (i, j)));
    }
    pairs
}

/// The extents of a soup at rest, for the reference.
pub(crate) fn at_rest<const S: usize>(soup: &Soup) -> Vec<[[f64; 2]; S]> {
    soup.leaves.iter().map(|&leaf| reference(leaf, &[(&soup.points, None)])).collect()
}
