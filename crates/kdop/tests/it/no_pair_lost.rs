//! No traversal loses a pair: trees against brute force in f64, over random, degenerate, nearly
//! coincident, huge and tiny leaves, at rest, moving, with radii and with margins.

use arbitrary::{Result, Unstructured};
use glam::{DAffine3, DQuat, DVec3};
use kdop::{Axis, Dop, DopTree, Extents, Leaves, RigidSweep, Workspace};

use crate::reference::{
    Frame, Soup, bounds, bounds_at_rest, brute_force, check, frame, point, soup,
};

/// Random inputs per property.
const INPUTS: u64 = 200;

fn build<const S: usize>(soup: &Soup) -> DopTree<S> {
    DopTree::build(Leaves::Triangles(&soup.leaves), &soup.points).expect("a valid soup")
}

fn pairs<const S: usize>(a: &DopTree<S>, b: &DopTree<S>, margin: f64) -> Vec<(u32, u32)> {
    let mut found = Vec::new();
    a.pairs(b, margin, &mut Workspace::new(), |i, j| found.push((i, j)));
    sorted(found)
}

fn self_pairs(tree: &DopTree<9>, margin: f64) -> Vec<(u32, u32)> {
    let mut found = Vec::new();
    tree.self_pairs(margin, &mut Workspace::new(), |i, j| found.push((i, j)));
    sorted(found)
}

/// Sorts what was reported, and checks that nothing was reported twice.
fn sorted<T: Ord + std::fmt::Debug>(mut found: Vec<T>) -> Vec<T> {
    let count = found.len();
    found.sort_unstable();
    found.dedup();
    assert_eq!(found.len(), count, "reported twice: {found:?}");
    found
}

fn assert_holds(found: &[(u32, u32)], wanted: &[(u32, u32)], scene: impl std::fmt::Debug) {
    let lost = wanted.iter().find(|pair| found.binary_search(pair).is_err());
    assert_eq!(lost, None, "lost, of {} in {scene:?}", wanted.len());
}

fn two_soups(u: &mut Unstructured<'_>) -> Result<(Frame, Soup, Soup)> {
    let frame = frame(u)?;
    Ok((frame, soup(u, frame)?, soup(u, frame)?))
}

fn pairs_at_rest<const S: usize>() {
    check(INPUTS, |u| {
        let (frame, a, b) = two_soups(u)?;
        let (tree_a, tree_b) = (build::<S>(&a), build::<S>(&b));
        tree_a.validate().expect("a valid tree");
        let found = pairs(&tree_a, &tree_b, 0.0);
        let wanted = brute_force(&bounds_at_rest::<S>(&a), &bounds_at_rest(&b), 0.0);
        assert_holds(&found, &wanted, frame);

        // Nor is much added: every reported pair overlaps when bounds are rounded to f32.
        let dop = |soup: &Soup, leaf: u32| {
            let corners = soup.leaves[leaf as usize].map(|p| soup.points[p as usize]);
            Dop::<S>::from_points(&corners)
        };
        for &(i, j) in &found {
            assert!(dop(&a, i).overlaps(&dop(&b, j)), "{i} {j} do not overlap");
        }
        Ok(())
    });
}

#[test]
fn pairs_at_rest_with_every_k() {
    pairs_at_rest::<3>();
    pairs_at_rest::<7>();
    pairs_at_rest::<9>();
    pairs_at_rest::<13>();
}

#[test]
fn pairs_within_a_margin() {
    check(INPUTS, |u| {
        let (frame, a, b) = two_soups(u)?;
        let margin = frame.unit * *u.choose(&[1e-9, 0.5, 1.0, 1.0 + 1e-15, 3.0, 1e6, 1e300])?;
        let found = pairs(&build::<9>(&a), &build(&b), margin);
        let wanted = brute_force(&bounds_at_rest::<9>(&a), &bounds_at_rest(&b), margin);
        assert_holds(&found, &wanted, (frame, margin));
        Ok(())
    });
}

/// Draws moved points for a soup, and radii for them.
fn motion(u: &mut Unstructured<'_>, frame: Frame, soup: &Soup) -> Result<(Soup, Vec<f64>)> {
    let mut moved = soup.clone();
    for p in &mut moved.points {
        *p += point(u, frame.at_origin(), 2)?;
    }
    let radius = |u: &mut Unstructured<'_>| Ok(frame.unit * f64::from(u.int_in_range(0_u8..=3)?));
    let radii = soup.points.iter().map(|_| radius(u)).collect::<Result<_>>()?;
    Ok((moved, radii))
}

#[test]
fn pairs_after_refits_in_any_order() {
    check(INPUTS, |u| {
        let (frame, a, b) = two_soups(u)?;
        let mut tree = build::<9>(&a);
        let tree_b = build(&b);
        let bounds_b = bounds_at_rest(&b);
        for _ in 0..u.int_in_range(1..=5)? {
            let (moved, radii) = motion(u, frame, &a)?;
            let (start, end) = (&a.points[..], &moved.points[..]);
            let radii = &radii[..];
            let (extents, states) = match u.int_in_range(0..=2)? {
                0 => (Extents::Points(end), vec![(end, None)]),
                1 => (Extents::Swept { start, end }, vec![(start, None), (end, None)]),
                _ => (Extents::Balls { centers: end, radii }, vec![(end, Some(radii))]),
            };
            tree.refit_from(extents).expect("finite points");
            tree.validate().expect("a valid tree");

            let bounds: Vec<_> = a.leaves.iter().map(|&l| bounds::<9>(l, &states)).collect();
            let wanted = brute_force(&bounds, &bounds_b, 0.0);
            assert_holds(&pairs(&tree, &tree_b, 0.0), &wanted, (frame, extents));
        }
        Ok(())
    });
}

#[test]
fn a_refit_tree_has_the_bounds_of_a_built_one() {
    check(INPUTS, |u| {
        let frame = frame(u)?;
        let a = soup(u, frame)?;
        let (moved, _) = motion(u, frame, &a)?;
        let mut tree = build::<9>(&a);
        tree.refit(&moved.points).expect("finite points");
        assert_eq!(tree.root(), build::<9>(&moved).root());
        Ok(())
    });
}

/// Finds by brute force the pairs of leaves that share no point.
fn separate_pairs(soup: &Soup, margin: f64) -> Vec<(u32, u32)> {
    let bounds = bounds_at_rest::<9>(soup);
    let mut wanted = brute_force(&bounds, &bounds, margin);
    wanted.retain(|&(i, j)| i < j && are_separate(soup, i, j));
    wanted
}

fn are_separate(soup: &Soup, i: u32, j: u32) -> bool {
    let (a, b) = (soup.leaves[i as usize], soup.leaves[j as usize]);
    a.iter().all(|p| !b.contains(p))
}

#[test]
fn self_pairs_share_no_point() {
    check(INPUTS, |u| {
        let frame = frame(u)?;
        let a = soup(u, frame)?;
        let margin = frame.unit * *u.choose(&[0.0, 0.0, 0.5, 1.0, 1e6])?;
        let found = self_pairs(&build(&a), margin);
        let allowed = |&(i, j): &(u32, u32)| i < j && are_separate(&a, i, j);
        assert!(found.iter().all(allowed), "neighbors in {found:?}");
        assert_holds(&found, &separate_pairs(&a, margin), (frame, margin));
        Ok(())
    });
}

/// Two fans of a thousand triangles each, about two hubs: too many leaves per point to be listed.
#[test]
fn self_pairs_of_fans() {
    let rim =
        |z: f64| (0..2000).map(move |i| DVec3::new(f64::from(i).cos(), f64::from(i).sin(), z));
    let points: Vec<DVec3> = [DVec3::ZERO, DVec3::Z * 0.5].into_iter().chain(rim(1.0)).collect();
    let fan = |hub: u32| (2..1001_u32).map(move |i| [hub, i + 1000 * hub - 1, i + 1000 * hub]);
    let leaves: Vec<_> = fan(0).map(|[h, a, b]| [h, a.max(2), b]).chain(fan(1)).collect();
    let soup = Soup { points, leaves };

    let found = self_pairs(&build(&soup), 0.0);
    assert!(found.iter().all(|&(i, j)| are_separate(&soup, i, j)), "pairs that share a hub");
    assert_holds(&found, &separate_pairs(&soup, 0.0), "fans");
}

/// A fan about one point and a few faces through it take no time by the square of the fan.
#[test]
fn self_pairs_of_a_large_fan_are_left_out_together() {
    let count = 20_000_u32;
    let mut points = vec![DVec3::ZERO];
    for i in 0..=count {
        let angle = 1e-3 * f64::from(i);
        points.push(DVec3::new(angle.cos(), angle.sin(), 1e-6 * f64::from(i)));
    }
    let mut leaves: Vec<[u32; 3]> = (1..=count).map(|i| [0, i, i + 1]).collect();
    for [x, y] in [[0.5, 0.0], [-0.4, 0.3], [0.01, -0.02]] {
        let first = u32::try_from(points.len()).expect("a small mesh");
        points.extend([-1.0, 1.0, 2.0].map(|z| DVec3::new(x, y + 0.01 * z, z)));
        leaves.push([first, first + 1, first + 2]);
    }
    let tree: DopTree<9> =
        DopTree::build(Leaves::Triangles(&leaves), &points).expect("a valid soup");

    let (mut workspace, mut found) = (Workspace::new(), Vec::new());
    tree.self_pairs(0.0, &mut workspace, |i, j| found.push((i, j)));
    let counters = workspace.counters();
    let tests = counters.bound_tests + counters.clusters;
    assert!(tests < 3 * u64::from(count), "{counters:?}");

    // Each of the three with the fan, and no two of the fan.
    let faces = Soup { points: points.clone(), leaves: leaves[count as usize..].to_vec() };
    let fan = Soup { points, leaves: leaves[..count as usize].to_vec() };
    let of_faces = pairs::<9>(&build(&fan), &build(&faces), 0.0);
    let expected: Vec<_> = of_faces.iter().map(|&(i, j)| (i, j + count)).collect();
    assert!(!expected.is_empty(), "faces cross the fan");
    assert_eq!(sorted(found), expected);
}

/// The exact middle of a segment, where projections of three terms round to either side of a
/// boundary of f32.
#[test]
fn a_point_on_a_segment_whose_sums_round_apart() {
    let e = f64::EPSILON / 2.0;
    let x = 1.0 + f64::from(f32::EPSILON) / 2.0;
    let point = [DVec3::new(x, e, e)];
    let segment = [DVec3::new(x + 2.0 * e, 0.0, 0.0), DVec3::new(x - 2.0 * e, 2.0 * e, 2.0 * e)];
    assert_eq!(segment[0] - point[0], point[0] - segment[1], "the exact middle");

    fn meet<const S: usize>(point: &[DVec3], segment: &[DVec3]) -> Vec<(u32, u32)> {
        let a = DopTree::<S>::build(Leaves::Points, point).unwrap();
        let b = DopTree::build(Leaves::Edges(&[[0, 1]]), segment).unwrap();
        pairs(&a, &b, 0.0)
    }
    assert_eq!(meet::<7>(&point, &segment), [(0, 0)]);
    assert_eq!(meet::<9>(&point, &segment), [(0, 0)]);
    assert_eq!(meet::<13>(&point, &segment), [(0, 0)]);
}

/// A tree is another one to itself: all pairs in both orders, as of its clone.
#[test]
fn pairs_of_a_tree_and_itself() {
    check(INPUTS, |u| {
        let frame = frame(u)?;
        let tree = build::<9>(&soup(u, frame)?);
        let margin = frame.unit * *u.choose(&[0.0, 0.5, 1e6])?;
        let (own, of_clone) = (pairs(&tree, &tree, margin), pairs(&tree, &tree.clone(), margin));
        assert!(own == of_clone, "{} of {} in {frame:?}", own.len(), of_clone.len());
        Ok(())
    });
}

/// A deep tree beside a shallow one, with many leaves at the same place.
#[test]
fn pairs_of_trees_of_unequal_depth() {
    check(INPUTS, |u| {
        let (frame, small, mut large) = two_soups(u)?;
        large.leaves = large.leaves.repeat(40);
        let (a, b) = (build::<9>(&small), build(&large));
        let wanted = brute_force(&bounds_at_rest::<9>(&small), &bounds_at_rest(&large), 0.0);
        assert_holds(&pairs(&a, &b, 0.0), &wanted, frame);

        let mut swapped: Vec<_> = pairs(&b, &a, 0.0).into_iter().map(|(i, j)| (j, i)).collect();
        swapped.sort_unstable();
        assert_holds(&swapped, &wanted, frame);
        Ok(())
    });
}

#[test]
fn pairs_of_edges_and_points() {
    check(INPUTS, |u| {
        let frame = frame(u)?;
        let a = soup(u, frame)?;
        let edges: Vec<[u32; 2]> = a.leaves.iter().map(|l| [l[0], l[1]]).collect();
        let edge_tree = DopTree::build(Leaves::Edges(&edges), &a.points).unwrap();
        let point_tree = DopTree::<9>::build(Leaves::Points, &a.points).unwrap();

        let of_leaf = |leaf: [u32; 3]| bounds::<9>(leaf, &[(&a.points, None)]);
        let of_edges: Vec<_> = edges.iter().map(|e| of_leaf([e[0], e[1], e[1]])).collect();
        let of_points: Vec<_> = (0..).zip(&a.points).map(|(i, _)| of_leaf([i; 3])).collect();
        let wanted = brute_force(&of_edges, &of_points, 0.0);
        assert_holds(&pairs(&edge_tree, &point_tree, 0.0), &wanted, frame);
        Ok(())
    });
}

#[test]
fn queries_and_rays() {
    check(INPUTS, |u| {
        let frame = frame(u)?;
        let a = soup(u, frame)?;
        let tree = build::<9>(&a);
        let leaf_bounds = bounds_at_rest::<9>(&a);
        let origin = point(u, frame, 5)?;
        let mut workspace = Workspace::new();
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let mut found = Vec::new();
            tree.ray(origin, axis, &mut workspace, |leaf| found.push((0, leaf)));
            // A ray that ends beyond everything.
            let mut ahead = origin;
            ahead[axis as usize] = f64::MAX;
            let ray = bounds::<9>([0, 1, 1], &[(&[origin, ahead], None)]);
            assert_holds(&sorted(found), &brute_force(&[ray], &leaf_bounds, 0.0), (frame, axis));
        }

        let mut found = Vec::new();
        tree.query(&Dop::from_points(&[origin]), &mut workspace, |leaf| found.push((0, leaf)));
        let at = bounds::<9>([0; 3], &[(&[origin], None)]);
        assert_holds(&sorted(found), &brute_force(&[at], &leaf_bounds, 0.0), frame);
        Ok(())
    });
}

#[test]
fn the_nearest_point_is_found() {
    check(INPUTS, |u| {
        let frame = frame(u)?;
        let a = soup(u, frame)?;
        let tree = DopTree::<9>::build(Leaves::Points, &a.points).expect("a valid soup");
        let from = point(u, frame, 30)?;
        // Scaled to a size whose square is a normal number.
        let distance = |leaf: u32| {
            let apart = a.points[leaf as usize] - from;
            let scale = apart.abs().max_element();
            if scale > 0.0 { (apart / scale).length() * scale } else { 0.0 }
        };

        let mut best = (f64::INFINITY, u32::MAX);
        let mut last = 0.0;
        tree.nearest(from, f64::INFINITY, &mut Workspace::new(), |leaf, bound| {
            let exact = distance(leaf);
            assert!(bound <= exact, "{bound:e} > {exact:e} in {frame:?}");
            assert!(bound >= last, "{bound:e} after {last:e}");
            last = bound;
            best = if (exact, leaf) < best { (exact, leaf) } else { best };
            best.0
        });

        let wanted = (0..).zip(&a.points).map(|(i, _)| (distance(i), i));
        let wanted = wanted.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let wanted = wanted.unwrap_or((f64::INFINITY, u32::MAX));
        assert_eq!(best, wanted, "{frame:?}");

        // The same without order, from any guess.
        let guess = u.choose_index(a.points.len()).map_or(0, |i| u32::try_from(i).unwrap());
        for within in [f64::INFINITY, if a.points.is_empty() { 0.0 } else { distance(guess) }] {
            let mut best = (f64::INFINITY, u32::MAX);
            tree.nearest_unordered(from, within, &mut Workspace::new(), |leaf| {
                let exact = distance(leaf);
                best = if (exact, leaf) < best { (exact, leaf) } else { best };
                best.0.min(within)
            });
            assert_eq!(best, wanted, "{frame:?} within {within:e}");
        }
        Ok(())
    });
}

/// Points of sizes at which squares of gaps underflow in single precision, more or fewer of them.
#[test]
fn the_nearest_of_tiny_points_is_found() {
    for size in [1e-18, 1e-20, 1e-21, 3e-22, 1e-22, 3e-23, 1e-23, 1e-30] {
        check(40, |u| {
            let mut point = || {
                let mut coordinate = || Ok(size * f64::from(u.arbitrary::<i16>()?) / 32768.0);
                Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?))
            };
            let points = (0..60).map(|_| point()).collect::<Result<Vec<_>>>()?;
            let tree = DopTree::<9>::build(Leaves::Points, &points).expect("finite points");
            let from = 3.0 * point()?;
            let mut nearest = f64::INFINITY;
            tree.nearest_unordered(from, nearest, &mut Workspace::new(), |leaf| {
                nearest = nearest.min(points[leaf as usize].distance(from));
                nearest
            });
            let wanted = points.iter().map(|p| p.distance(from)).fold(f64::INFINITY, f64::min);
            assert!(nearest <= wanted, "{nearest:e} for {wanted:e}");
            Ok(())
        });
    }
}

/// A rigid motion and its bounds: a turn about a center, which shifts.
fn turn(u: &mut Unstructured<'_>, frame: Frame) -> Result<(DVec3, DVec3, DVec3)> {
    let center = point(u, frame, 3)?;
    let shift = point(u, frame.at_origin(), 3)?;
    let angles = point(u, Frame { unit: 0.3, ..frame.at_origin() }, 3)?;
    Ok((center, shift, angles))
}

#[test]
fn pairs_of_a_tree_that_moves_rigidly() {
    const TIMES: u32 = 9;
    let found_pairs = std::cell::Cell::new(0);
    check(INPUTS, |u| {
        let (frame, a, b) = two_soups(u)?;
        let (center, shift, angles) = turn(u, frame)?;
        let at = |time: f64| {
            let turn = DQuat::from_scaled_axis(time * angles);
            let moved = center + time * shift;
            DAffine3::from_rotation_translation(turn, moved - turn * center)
        };
        let margin = frame.unit * *u.choose(&[0.0, 0.5, 3.0])?;
        let sweep = RigidSweep {
            ends: [at(0.0), at(1.0)],
            center,
            deviation: 0.0,
            deviation_per_length: angles.length_squared() / 8.0,
            margin,
        };
        let mut found = Vec::new();
        let (tree_a, tree_b) = (build::<9>(&a), build::<9>(&b));
        let mut workspace = Workspace::new();
        let near = tree_a.moving_pairs(&sweep, &tree_b, f64::INFINITY, &mut workspace);
        near.expect("any deviation is allowed").visit(|i, j| found.push((i, j)));
        let found = sorted(found);
        found_pairs.set(found_pairs.get() + found.len());

        // Bounds at any time are within those of the way.
        for k in 0..=TIMES {
            let map = at(f64::from(k) / f64::from(TIMES));
            let mut moved = a.clone();
            for p in &mut moved.points {
                *p = map.transform_point3(*p);
            }
            let rounded = frame.unit * 1e-12;
            let wanted = brute_force(
                &bounds_at_rest::<9>(&moved),
                &bounds_at_rest(&b),
                (margin - rounded).max(0.0),
            );
            assert_holds(&found, &wanted, (frame, k));
        }
        Ok(())
    });
    assert!(found_pairs.get() > 100, "few pairs meet: {}", found_pairs.get());
}

#[test]
fn coordinates_beyond_distinction_deviate_too_much_for_any_limit() {
    let far = DVec3::splat(1e30);
    let points = [far, 1.1 * far, DVec3::new(1e30, 0.0, 0.0)];
    let tree: DopTree<9> =
        DopTree::build(Leaves::Triangles(&[[0, 1, 2]]), &points).expect("finite");
    let sweep = RigidSweep {
        ends: [DAffine3::IDENTITY, DAffine3::IDENTITY],
        center: DVec3::ZERO,
        deviation: 0.0,
        deviation_per_length: 0.5,
        margin: 0.0,
    };
    let mut workspace = Workspace::new();
    assert!(tree.moving_pairs(&sweep, &tree, 1.0, &mut workspace).is_none());
    assert!(tree.moving_pairs(&sweep, &tree, f64::INFINITY, &mut workspace).is_some());
}

/// Projections of a translation onto diagonals exceed the largest number.
#[test]
fn pairs_whose_projections_overflow_are_not_lost() {
    let far = DVec3::new(1e308, 1e308, 0.0);
    let tree = |at: DVec3| DopTree::<9>::build(Leaves::Points, &[at]).expect("finite");
    let sweep = RigidSweep {
        ends: [DAffine3::from_translation(far); 2],
        center: DVec3::ZERO,
        deviation: 0.0,
        deviation_per_length: 0.0,
        margin: 0.0,
    };
    let (moving, other, mut workspace) = (tree(DVec3::ZERO), tree(far), Workspace::new());
    assert!(moving.moving_pairs(&sweep, &other, 1.0, &mut workspace).is_none());
    let mut found = 0;
    let near = moving.moving_pairs(&sweep, &other, f64::INFINITY, &mut workspace);
    near.expect("any deviation is allowed").visit(|_, _| found += 1);
    assert_eq!(found, 1);
}
