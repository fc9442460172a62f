//! Broad phase: candidate pairs by sweep and prune over axis-aligned boxes.
//!
//! Source: D. Baraff, *Dynamic Simulation of Non-Penetrating Rigid Bodies*, PhD thesis, Cornell
//! University, 1992, section 2.3. Differs in sorting along one axis only, the one along which the
//! boxes are spread the most, from scratch.

use glam::DVec3;
use surface::{Aabb, TotalF64};

use crate::{BodyId, PairId};

/// Finds the pairs of boxes, by number, that come within `margin` of each other, in ascending
/// order. No pair is missed through rounding; empty boxes meet none.
pub(crate) fn overlapping_pairs(boxes: &[Aabb], margin: f64) -> Vec<PairId> {
    let mut sweep = SweepAndPrune { boxes: boxes.to_vec(), ..SweepAndPrune::default() };
    sweep.find_pairs(margin);
    sweep.pairs
}

/// Sweep and prune in memory that is reused.
#[derive(Debug, Default)]
pub(crate) struct SweepAndPrune {
    /// Boxes by number, to be set; then inflated.
    pub(crate) boxes: Vec<Aabb>,
    /// Starts of boxes along the axis, with their numbers.
    order: Vec<(TotalF64, u32)>,
    /// Boxes that begin before the present one and may still reach it.
    active: Vec<u32>,
    /// Pairs found.
    pub(crate) pairs: Vec<PairId>,
}

impl SweepAndPrune {
    /// Finds the pairs of boxes within `margin`: see [`overlapping_pairs`].
    pub(crate) fn find_pairs(&mut self, margin: f64) {
        let Self { boxes, order, active, pairs } = self;
        let axis = axis_of_spread(boxes);
        order.clear();
        for (number, bounds) in (0..).zip(boxes.iter_mut()) {
            *bounds = inflate(*bounds, margin);
            if !bounds.is_empty() {
                order.push((TotalF64(bounds.min[axis]), number));
            }
        }
        order.sort_unstable();

        // Along the axis, each box against those that have not ended.
        active.clear();
        pairs.clear();
        for &(_, number) in &*order {
            let bounds = boxes[number as usize];
            active.retain(|&other| boxes[other as usize].max[axis] >= bounds.min[axis]);
            for &other in &*active {
                if bounds.overlaps(boxes[other as usize]) {
                    pairs.push(PairId::new(BodyId(number), BodyId(other)));
                }
            }
            active.push(number);
        }
        pairs.sort_unstable();
    }
}

/// Moves a box outward by half of the margin, and by more than distances are rounded.
fn inflate(bounds: Aabb, margin: f64) -> Aabb {
    /// Rounding of a distance between two points, in units of their largest coordinate, with room
    /// to spare.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;
    let size = bounds.min.abs().max(bounds.max.abs()).max_element();
    bounds.inflate(0.5 * margin * (1.0 + ROUNDING) + ROUNDING * size)
}

/// Returns the axis along which the centers of boxes vary the most.
fn axis_of_spread(boxes: &[Aabb]) -> usize {
    let (mut sum, mut sum_of_squares, mut count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for bounds in boxes {
        if bounds.is_empty() {
            continue;
        }
        let center = bounds.center();
        sum += center;
        sum_of_squares += center * center;
        count += 1.0;
    }
    let variance = sum_of_squares - sum * sum / f64::max(count, 1.0);
    variance.max_position()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that look random, in `0.0..1.0`.
    fn numbers() -> impl Iterator<Item = f64> {
        let mut state = 1_u64;
        std::iter::repeat_with(move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            f64::from(u32::try_from(state >> 32).unwrap_or(0)) / f64::from(u32::MAX)
        })
    }

    #[test]
    fn finds_the_pairs_that_comparing_all_finds() {
        let mut numbers = numbers();
        let mut vector = |size: f64| {
            let mut next = || size * numbers.next().unwrap();
            DVec3::new(next(), next(), next())
        };
        for margin in [0.0, 0.5, 3.0] {
            let mut boxes = vec![Aabb::EMPTY];
            for _ in 0..200 {
                let min = vector(20.0).round();
                boxes.push(Aabb { min, max: min + vector(3.0).round() });
            }
            let mut slow = Vec::new();
            for (i, a) in (0..).zip(&boxes) {
                for (j, b) in (0..i).zip(&boxes) {
                    if a.inflate(margin).overlaps(*b) {
                        slow.push(PairId::new(BodyId(i), BodyId(j)));
                    }
                }
            }
            slow.sort_unstable();
            assert!(slow.len() > 50, "{}", slow.len());
            assert_eq!(overlapping_pairs(&boxes, margin), slow, "margin {margin}");
        }
    }
}
