//! Added balls: one each in the middle of the edges whose primitives have the largest sums of
//! squared errors.
//!
//! Splitting the primitives at an edge does not change the union. The next [fit](super::fit) moves
//! the new balls to better places, and others are [removed](super::removal) in exchange.

use std::collections::{BTreeMap, BTreeSet};

use surface::TotalF64;

use super::connectivity::joined;
use crate::{MedialError, MedialSurface, index};

/// Primitives at each edge.
type EdgePrimitives = BTreeMap<[u32; 2], BTreeSet<u32>>;

/// Returns `medial` with up to `count` balls more, where primitives have the largest `squares`.
pub(super) fn split(
    medial: &MedialSurface,
    squares: &[f64],
    count: usize,
) -> Result<MedialSurface, MedialError> {
    let at_edges = edge_primitives(medial);
    let mut balls = medial.balls().to_vec();
    let mut primitives = medial.primitives().to_vec();
    for edge in worst_edges(medial, &at_edges, squares, count) {
        let middle = index(balls.len());
        let [a, b] = edge.map(|ball| medial.balls()[ball as usize]);
        balls.push(a.midpoint(b));

        // Two halves of each primitive.
        for &primitive in &at_edges[&edge] {
            let whole = primitives[primitive as usize];
            primitives[primitive as usize] = with_ball(whole, edge[0], middle);
            primitives.push(with_ball(whole, edge[1], middle));
        }
    }
    joined(balls, primitives.into_iter())
}

/// Returns a primitive with one ball replaced by another.
fn with_ball(primitive: [u32; 3], old: u32, new: u32) -> [u32; 3] {
    primitive.map(|ball| if ball == old { new } else { ball })
}

fn edge_primitives(medial: &MedialSurface) -> EdgePrimitives {
    let mut at_edges = EdgePrimitives::new();
    for (primitive, &[a, b, c]) in (0_u32..).zip(medial.primitives()) {
        for [i, j] in [[a, b], [b, c], [c, a]] {
            if i != j {
                at_edges.entry([i.min(j), i.max(j)]).or_default().insert(primitive);
            }
        }
    }
    at_edges
}

/// Selects up to `count` edges of which no two have primitives with a ball in common, those with the
/// largest squares first.
fn worst_edges(
    medial: &MedialSurface,
    at_edges: &EdgePrimitives,
    squares: &[f64],
    count: usize,
) -> Vec<[u32; 2]> {
    // The largest errors first.
    let mut edges = Vec::with_capacity(at_edges.len());
    for (&edge, primitives) in at_edges {
        let error: f64 = primitives.iter().map(|&primitive| squares[primitive as usize]).sum();
        edges.push((TotalF64(-error), edge));
    }
    edges.sort_unstable();

    // Neighbors of a split edge stay whole.
    let mut touched = BTreeSet::new();
    let mut selected = Vec::new();
    for (_, edge) in edges {
        let primitives = at_edges[&edge].iter();
        let around = primitives.flat_map(|&primitive| medial.primitives()[primitive as usize]);
        if selected.len() < count && around.clone().all(|ball| !touched.contains(&ball)) {
            touched.extend(around);
            selected.push(edge);
        }
    }
    selected
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use kdop::Workspace;

    use super::*;
    use crate::{Ball, PrimitiveTree};

    /// Two slabs and a cone: the slabs' common edge has the largest error, primitives beside it stay
    /// whole, and no distance changes.
    #[test]
    fn the_edge_with_the_largest_error_is_split() {
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
        let trees = [&medial, &more].map(|medial| PrimitiveTree::new(medial).unwrap());
        for k in 0..60_u32 {
            let p = DVec3::new(f64::from(k) / 3.0, 4.0 + f64::from(k % 7), 5.0);
            let before = trees[0].nearest(&medial, p, workspace).foot.distance;
            let after = trees[1].nearest(&more, p, workspace).foot.distance;
            assert!((before - after).abs() < 1e-12, "{before} became {after}");
        }

        let both = split(&medial, &[0.5, 0.5, 4.0], 2).unwrap();
        assert_eq!(both.balls()[5].center, DVec3::new(14.5, 9.0, 0.0));
        assert_eq!(both.balls().len(), 7, "a side of the first slab is apart from the cone");
    }
}
