//! More balls where the surface is missed the most: one each in the middle of edges
//! whose primitives are off by the largest sums of squares.
//!
//! To split what is at an edge changes nothing of the union. The [fit](super::refit)
//! then moves the new balls to where they are of use, and others go in exchange that
//! are [missed less](super::thin).

use std::collections::{BTreeMap, BTreeSet};

use super::collapse::joints;
use crate::{Ball, MedialError, MedialSurface, index};

/// `medial` with up to `count` balls more, where primitives are off by these `squares`.
pub(super) fn split(
    medial: &MedialSurface,
    squares: &[f64],
    count: usize,
) -> Result<MedialSurface, MedialError> {
    let at_edges = at_edges(medial);
    let mut balls = medial.balls().to_vec();
    let mut primitives = medial.primitives().to_vec();
    for edge in farthest_off(medial, &at_edges, squares, count) {
        let middle = index(balls.len());
        let [a, b] = edge.map(|ball| medial.balls()[ball as usize]);
        balls.push(Ball::new(a.center.midpoint(b.center), a.radius.midpoint(b.radius)));
        let half = |whole: [u32; 3], end: u32| whole.map(|b| if b == end { middle } else { b });
        for &primitive in &at_edges[&edge] {
            let whole = primitives[primitive as usize];
            primitives[primitive as usize] = half(whole, edge[0]);
            primitives.push(half(whole, edge[1]));
        }
    }
    let same: Vec<u32> = (0..index(balls.len())).collect();
    let (cones, slabs) = joints(&primitives, &same);
    MedialSurface::new(balls, cones, slabs)
}

/// The primitives at each edge.
fn at_edges(medial: &MedialSurface) -> BTreeMap<[u32; 2], BTreeSet<u32>> {
    let mut at_edges = BTreeMap::<_, BTreeSet<u32>>::new();
    for (primitive, &[a, b, c]) in (0_u32..).zip(medial.primitives()) {
        for [i, j] in [[a, b], [b, c], [c, a]].into_iter().filter(|[i, j]| i != j) {
            at_edges.entry([i.min(j), i.max(j)]).or_default().insert(primitive);
        }
    }
    at_edges
}

/// Up to `count` edges of which no two have primitives with a ball in common, those
/// with the largest squares at them first.
fn farthest_off(
    medial: &MedialSurface,
    at_edges: &BTreeMap<[u32; 2], BTreeSet<u32>>,
    squares: &[f64],
    count: usize,
) -> Vec<[u32; 2]> {
    let off = |at: &BTreeSet<u32>| at.iter().map(|&p| squares[p as usize]).sum::<f64>();
    let mut edges: Vec<(f64, [u32; 2])> =
        at_edges.iter().map(|(&edge, at)| (off(at), edge)).collect();
    edges.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut touched = BTreeSet::new();
    let mut apart = |edge: &[u32; 2]| {
        let around = at_edges[edge].iter().flat_map(|&p| medial.primitives()[p as usize]);
        let is_apart = around.clone().all(|ball| !touched.contains(&ball));
        if is_apart {
            touched.extend(around);
        }
        is_apart
    };
    edges.into_iter().map(|(_, edge)| edge).filter(|edge| apart(edge)).take(count).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use kdop::Workspace;

    use super::*;
    use crate::PrimitiveTree;

    /// Two slabs and a cone: the slabs' common edge is the farthest off, what is beside it
    /// is not touched, and no distance changes.
    #[test]
    fn the_edge_that_is_farthest_off_is_split() {
        let ball = |x: f64, y: f64| Ball::new(DVec3::new(x, y, 0.0), 1.0 + 0.1 * x);
        let balls =
            vec![ball(0.0, 0.0), ball(9.0, 0.0), ball(0.0, 9.0), ball(9.0, 9.0), ball(20.0, 9.0)];
        let slabs = vec![[0, 1, 2], [1, 2, 3]];
        let medial = MedialSurface::new(balls, vec![[3, 4]], slabs).unwrap();
        let more = split(&medial, &[2.0, 3.0, 4.0], 2).unwrap();
        assert_eq!(more.balls().len(), 6);
        assert_eq!(more.balls()[5].center, DVec3::new(4.5, 4.5, 0.0));
        assert_eq!(more.slabs(), [[0, 1, 5], [0, 2, 5], [1, 3, 5], [2, 3, 5]]);
        assert_eq!(more.cones().collect::<Vec<_>>(), [[3, 4]]);
        let workspace = &mut Workspace::default();
        let trees = [&medial, &more].map(|medial| (PrimitiveTree::new(medial).unwrap(), medial));
        for k in 0..60_u32 {
            let p = DVec3::new(f64::from(k) / 3.0, 4.0 + f64::from(k % 7), 5.0);
            let [before, after] = trees
                .each_ref()
                .map(|(tree, medial)| tree.nearest(medial, p, workspace).foot.distance);
            assert!((before - after).abs() < 1e-12, "{before} became {after}");
        }
        let both = split(&medial, &[0.5, 0.5, 4.0], 2).unwrap();
        assert_eq!(both.balls()[5].center, DVec3::new(14.5, 9.0, 0.0));
        assert_eq!(both.balls().len(), 7, "a side of the first slab is apart from the cone");
    }
}
