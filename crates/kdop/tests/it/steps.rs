//! Pairs of leaves during a step, against brute force at several times and at both ends.

use arbitrary::{Result, Unstructured};
use glam::DVec3;
use kdop::{DopTree, Leaves, StepTree, Workspace};

use crate::reference::{
    Bounds, Frame, Soup, bounds_at_rest, brute_force, check, frame, point, soup,
};

/// Random inputs.
const INPUTS: u64 = 200;

/// Times at which leaves are compared.
const TIMES: [f64; 6] = [0.0, 0.1, 0.3, 0.5, 0.85, 1.0];

/// Leaves at both ends of a step, with the trees of both.
struct Moving {
    ends: [Soup; 2],
    trees: [DopTree<9>; 2],
}

impl Moving {
    /// Draws leaves that move by `common`, and each point by a little more.
    fn draw(u: &mut Unstructured<'_>, frame: Frame, common: DVec3) -> Result<Self> {
        let start = soup(u, frame)?;
        let mut end = start.clone();
        for p in &mut end.points {
            *p += common + point(u, frame.at_origin(), 1)?;
        }
        let tree: DopTree<9> =
            DopTree::build(Leaves::Triangles(&start.leaves), &start.points).expect("a valid soup");
        let mut moved = tree.clone();
        moved.refit(&end.points).expect("finite points");
        Ok(Self { ends: [start, end], trees: [tree, moved] })
    }

    fn tree(&self) -> StepTree<'_> {
        StepTree::new(&self.trees[0], &self.trees[1]).expect("one arrangement")
    }

    fn at(&self, time: f64) -> Soup {
        let [start, end] = &self.ends;
        let points = start.points.iter().zip(&end.points).map(|(a, b)| a.lerp(*b, time)).collect();
        Soup { points, leaves: start.leaves.clone() }
    }

    /// Returns the bounds of all leaves at both ends.
    fn bounds(&self) -> [Vec<Bounds<9>>; 2] {
        [0, 1].map(|end: usize| bounds_at_rest(&self.ends[end]))
    }
}

/// Returns true if the first bound is above the second along direction `k`, as trees store them.
#[expect(clippy::cast_possible_truncation, reason = "trees store bounds in single precision")]
fn is_above(a: &Bounds<9>, b: &Bounds<9>, k: usize) -> bool {
    a[k][0] as f32 > b[k][1] as f32
}

/// Returns true if one leaf is above the other along a direction at both ends of a step.
fn are_apart(a: [&Bounds<9>; 2], b: [&Bounds<9>; 2]) -> bool {
    (0..9).any(|k| {
        let is_above = |a: [&Bounds<9>; 2], b: [&Bounds<9>; 2]| {
            is_above(a[0], b[0], k) && is_above(a[1], b[1], k)
        };
        is_above(a, b) || is_above(b, a)
    })
}

/// Returns true if the ways of two leaves overlap along every direction.
fn ways_overlap(a: [&Bounds<9>; 2], b: [&Bounds<9>; 2]) -> bool {
    (0..9).all(|k| {
        let way = |ends: [&Bounds<9>; 2]| {
            [ends[0][k][0].min(ends[1][k][0]), ends[0][k][1].max(ends[1][k][1])]
        };
        let (a, b) = (way(a), way(b));
        a[0] <= b[1] && b[0] <= a[1]
    })
}

#[test]
fn no_pair_of_a_step_is_lost_and_few_are_added() {
    let (mut found_pairs, mut swept_pairs) = (0, 0);
    let totals = std::cell::RefCell::new((&mut found_pairs, &mut swept_pairs));
    check(INPUTS, |u| {
        let frame = frame(u)?;
        let common = point(u, frame.at_origin(), 9)?;
        let is_together = u.ratio(1, 2)?;
        let own = if is_together { common } else { -common };
        let (a, b) = (Moving::draw(u, frame, common)?, Moving::draw(u, frame, own)?);
        let margin = frame.unit * *u.choose(&[0.0, 0.0, 0.5, 2.0])?;

        let mut found = Vec::new();
        a.tree().pairs(&b.tree(), margin, &mut Workspace::new(), |i, j| found.push((i, j)));
        found.sort_unstable();
        let reported = found.len();
        found.dedup();
        assert_eq!(found.len(), reported, "reported twice");

        // At each time, but for the rounding of positions on the way.
        let size = frame.offset.abs().max_element() + 60.0 * frame.unit;
        for time in TIMES {
            let [at_a, at_b] = [&a, &b].map(|moving| bounds_at_rest::<9>(&moving.at(time)));
            for pair in brute_force(&at_a, &at_b, margin - 64.0 * f64::EPSILON * size) {
                assert!(found.binary_search(&pair).is_ok(), "{pair:?} at {time}, {frame:?}");
            }
        }

        // Without a margin, what is reported is what both ends do not separate.
        if margin == 0.0 {
            let is_fine = is_together && (1e-3..=1e6).contains(&frame.unit);
            let is_counted = is_fine && frame.offset.abs().max_element() <= 1e3 * frame.unit;
            let ([a0, a1], [b0, b1]) = (a.bounds(), b.bounds());
            for (i, of_a) in (0_u32..).zip(a0.iter().zip(&a1).map(|(start, end)| [start, end])) {
                for (j, of_b) in (0_u32..).zip(b0.iter().zip(&b1).map(|(start, end)| [start, end]))
                {
                    let is_found = found.binary_search(&(i, j)).is_ok();
                    assert_eq!(is_found, !are_apart(of_a, of_b), "{i} {j} {frame:?}");
                    *totals.borrow_mut().1 += usize::from(is_counted && ways_overlap(of_a, of_b));
                }
            }
            *totals.borrow_mut().0 += if is_counted { found.len() } else { 0 };
        }
        Ok(())
    });
    assert!(found_pairs > 1000, "{found_pairs} pairs");

    // Side by side, few of the leaves whose ways overlap come near each other.
    assert!(3 * found_pairs < 2 * swept_pairs, "{found_pairs} of {swept_pairs} whose ways overlap");
}

/// Trees of other leaves are no step.
#[test]
fn both_ends_have_one_arrangement() {
    let build = |points: &[DVec3]| DopTree::<9>::build(Leaves::Points, points).expect("points");
    let [two, three] = [2, 3].map(|n: u32| build(&vec![DVec3::ZERO; n as usize]));
    assert!(StepTree::new(&two, &three).is_none());
    assert!(StepTree::new(&two, &two.clone()).is_some());
}

/// Faces of the same numbers, but on other points, are other leaves.
#[test]
fn both_ends_have_the_same_corners() {
    let points: Vec<DVec3> = (0..6).map(|k| DVec3::X * f64::from(k)).collect();
    let build = |faces: &[[u32; 3]]| {
        DopTree::<9>::build(Leaves::Triangles(faces), &points).expect("points")
    };
    let start = build(&[[0, 1, 2], [3, 4, 5]]);
    assert!(StepTree::new(&start, &build(&[[0, 1, 2], [3, 4, 5]])).is_some());
    for other in [[[0, 1, 2], [2, 4, 5]], [[0, 1, 1], [3, 4, 5]]] {
        assert!(StepTree::new(&start, &build(&other)).is_none(), "{other:?}");
    }
}
