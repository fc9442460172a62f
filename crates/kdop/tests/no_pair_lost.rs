//! No traversal loses a pair: trees against brute force in f64, over random, degenerate, nearly
//! coincident, huge and tiny leaves, at rest, moving, with radii and with margins.

mod common;

use arbitrary::{Result, Unstructured};
use arbtest::arbtest;
use common::{Soup, Terrain, at_rest, brute_force, point, reference, soup, terrain};
use glam::DVec3;
use kdop::{Axis, Dop, DopTree, Extents, Leaves, Workspace};

fn build<const S: usize>(soup: &Soup) -> DopTree<S> {
    DopTree::build(Leaves::Triangles(&soup.leaves), &soup.points).expect("a valid soup")
}

fn pairs<const S: usize>(a: &DopTree<S>, b: &DopTree<S>, margin: f64) -> Vec<(u32, u32)> {
    let mut found = Vec::new();
    a.pairs(b, margin, &mut Workspace::new(), |i, j| found.push((i, j)));
    sorted(found)
}

/// In order, each once.
fn sorted<T: Ord + std::fmt::Debug>(mut found: Vec<T>) -> Vec<T> {
    let count = found.len();
    found.sort_unstable();
    found.dedup();
    assert_eq!(found.len(), count, "reported twice: {found:?}");
    found
}

fn assert_holds(found: &[(u32, u32)], wanted: &[(u32, u32)], what: impl std::fmt::Debug) {
    let lost = wanted.iter().find(|pair| found.binary_search(pair).is_err());
    assert_eq!(lost, None, "lost, of {} in {what:?}", wanted.len());
}

fn two_soups(u: &mut Unstructured<'_>) -> Result<(Terrain, Soup, Soup)> {
    let terrain = terrain(u)?;
    Ok((terrain, soup(u, terrain)?, soup(u, terrain)?))
}

fn pairs_at_rest<const S: usize>() {
    arbtest(|u| {
        let (terrain, a, b) = two_soups(u)?;
        let (tree_a, tree_b) = (build::<S>(&a), build::<S>(&b));
        tree_a.validate().expect("a whole tree");
        let found = pairs(&tree_a, &tree_b, 0.0);
        let (bounds_a, bounds_b) = (at_rest::<S>(&a), at_rest(&b));
        assert_holds(&found, &brute_force(&bounds_a, &bounds_b, 0.0), terrain);
        // Nor is much added: what is found overlaps when bounds are rounded to f32.
        let bound = |soup: &Soup, leaf: u32| {
            let corners = soup.leaves[leaf as usize].map(|p| soup.points[p as usize]);
            Dop::<S>::from_points(&corners)
        };
        for &(i, j) in &found {
            assert!(bound(&a, i).overlaps(&bound(&b, j)), "{i} {j} do not overlap");
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
    arbtest(|u| {
        let (terrain, a, b) = two_soups(u)?;
        let margin = terrain.unit * *u.choose(&[1e-9, 0.5, 1.0, 1.0 + 1e-15, 3.0, 1e6, 1e300])?;
        let found = pairs(&build::<9>(&a), &build(&b), margin);
        let wanted = brute_force(&at_rest::<9>(&a), &at_rest(&b), margin);
        assert_holds(&found, &wanted, (terrain, margin));
        Ok(())
    });
}

/// Moved points for a soup, and radii for them.
fn motion(u: &mut Unstructured<'_>, terrain: Terrain, soup: &Soup) -> Result<(Soup, Vec<f64>)> {
    let step = Terrain { offset: DVec3::ZERO, ..terrain };
    let mut moved = soup.clone();
    for p in &mut moved.points {
        *p += point(u, step, 2)?;
    }
    let radius = |u: &mut Unstructured<'_>| Ok(terrain.unit * f64::from(u.int_in_range(0_u8..=3)?));
    let radii = soup.points.iter().map(|_| radius(u)).collect::<Result<_>>()?;
    Ok((moved, radii))
}

#[test]
fn pairs_after_refits_in_any_order() {
    arbtest(|u| {
        let (terrain, a, b) = two_soups(u)?;
        let mut tree = build::<9>(&a);
        let tree_b = build(&b);
        let bounds_b = at_rest(&b);
        for _ in 0..u.int_in_range(1..=5)? {
            let (moved, radii) = motion(u, terrain, &a)?;
            let (x0, x1) = (&a.points[..], &moved.points[..]);
            let (r0, r1) = (&radii[..], &vec![terrain.unit; radii.len()][..]);
            type States<'a> = Vec<(&'a [DVec3], Option<&'a [f64]>)>;
            let (extents, states): (Extents<'_>, States<'_>) = match u.int_in_range(0..=4)? {
                0 => (Extents::points(x1), vec![(x1, None)]),
                1 => (Extents::swept(x0, x1), vec![(x0, None), (x1, None)]),
                2 => (Extents::balls(x1, r0), vec![(x1, Some(r0))]),
                3 => {
                    let both = vec![(x0, Some(r0)), (x1, Some(r1))];
                    (Extents::swept_balls((x0, r0), (x1, r1)), both)
                }
                _ => (Extents::points(x1).inflated(terrain.unit), vec![(x1, Some(r1))]),
            };
            tree.refit_from(extents).expect("finite points");
            tree.validate().expect("a whole tree");
            let bounds: Vec<_> = a.leaves.iter().map(|&l| reference::<9>(l, &states)).collect();
            let wanted = brute_force(&bounds, &bounds_b, 0.0);
            assert_holds(&pairs(&tree, &tree_b, 0.0), &wanted, (terrain, extents));
        }
        Ok(())
    });
}

#[test]
fn a_refit_equals_a_build_in_bounds() {
    arbtest(|u| {
        let terrain = terrain(u)?;
        let a = soup(u, terrain)?;
        let (moved, _) = motion(u, terrain, &a)?;
        let mut tree = build::<9>(&a);
        tree.refit(&moved.points).expect("finite points");
        assert_eq!(tree.root(), build::<9>(&moved).root());
        Ok(())
    });
}

#[test]
fn self_pairs_without_neighbours() {
    arbtest(|u| {
        let terrain = terrain(u)?;
        let a = soup(u, terrain)?;
        let margin = terrain.unit * *u.choose(&[0.0, 0.0, 0.5, 1.0, 1e6])?;
        let mut found = Vec::new();
        build::<9>(&a).self_pairs(margin, &mut Workspace::new(), |i, j| found.push((i, j)));
        let found = sorted(found);
        let apart = |i: u32, j: u32| {
            let (a, b) = (a.leaves[i as usize], a.leaves[j as usize]);
            a.iter().all(|p| !b.contains(p))
        };
        assert!(found.iter().all(|&(i, j)| i < j && apart(i, j)), "neighbours in {found:?}");
        let bounds = at_rest::<9>(&a);
        let mut wanted = brute_force(&bounds, &bounds, margin);
        wanted.retain(|&(i, j)| i < j && apart(i, j));
        assert_holds(&found, &wanted, (terrain, margin));
        Ok(())
    });
}

/// Sums of three terms are rounded twice, so two projections of one point may fall on either side
/// of a boundary of f32. A point that is the exact middle of a segment, planted there.
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

/// Culling by normals leaves out neighbours in flat clusters alone: of what it reports nothing is
/// new, and where two sheets pass through each other nothing is lost.
#[test]
fn flat_neighbours_are_left_out() {
    let grid = |z: f64, tilt: f64| {
        let point = move |i: u32| {
            let (x, y) = (f64::from(i % 21), f64::from(i / 21));
            DVec3::new(x, y, z + tilt * (x - 10.0) + 0.1 * (1.3 * x + y).sin())
        };
        (0..441).map(point)
    };
    let points: Vec<DVec3> = grid(0.0, 0.0).chain(grid(0.0, 0.4)).collect();
    let cell = |i: u32| [[i, i + 1, i + 22], [i, i + 22, i + 21]];
    let sheet = |first: u32| (0..420).filter(|i| i % 21 != 20).flat_map(move |i| cell(first + i));
    let leaves: Vec<_> = sheet(0).chain(sheet(441)).collect();
    let tree = build::<9>(&Soup { points: points.clone(), leaves: leaves.clone() });
    let (mut all, mut culled) = (Vec::new(), Vec::new());
    let mut workspace = Workspace::new();
    tree.self_pairs(1.2, &mut workspace, |i, j| all.push((i, j)));
    let visit = |i, j| culled.push((i, j));
    tree.self_pairs_unless_flat(&points, 1.2, &mut workspace, visit).unwrap();
    let (all, culled) = (sorted(all), sorted(culled));
    assert!(culled.len() < all.len(), "{} of {}", culled.len(), all.len());
    assert!(culled.iter().all(|pair| all.binary_search(pair).is_ok()), "a new pair");
    let between = |&&(i, j): &&(u32, u32)| (i < 800) != (j < 800);
    assert!(all.iter().filter(between).count() > 100, "the sheets cross");
    assert!(all.iter().filter(between).eq(culled.iter().filter(between)), "a crossing is lost");
    let short = tree.self_pairs_unless_flat(&points[1..], 0.3, &mut workspace, |_, _| ());
    assert_eq!(short, Err(kdop::TreeError::WrongLength { expected: 882, given: 881 }));
}

/// A point that everything shares leaves nothing; two such points leave what is between them.
#[test]
fn fans_about_one_point() {
    let rim =
        |z: f64| (0..2000).map(move |i| DVec3::new(f64::from(i).cos(), f64::from(i).sin(), z));
    let points: Vec<DVec3> = [DVec3::ZERO, DVec3::Z * 0.5].into_iter().chain(rim(1.0)).collect();
    let fan = |hub: u32| (2..1001_u32).map(move |i| [hub, i + 1000 * hub - 1, i + 1000 * hub]);
    let leaves: Vec<_> = fan(0).map(|[h, a, b]| [h, a.max(2), b]).chain(fan(1)).collect();
    let soup = Soup { points, leaves };
    let mut found = Vec::new();
    build::<9>(&soup).self_pairs(0.0, &mut Workspace::new(), |i, j| found.push((i, j)));
    let found = sorted(found);
    let bounds = at_rest::<9>(&soup);
    let mut wanted = brute_force(&bounds, &bounds, 0.0);
    let apart = |i: u32, j: u32| {
        soup.leaves[i as usize].iter().all(|p| !soup.leaves[j as usize].contains(p))
    };
    wanted.retain(|&(i, j)| i < j && apart(i, j));
    assert!(found.iter().all(|&(i, j)| apart(i, j)), "pairs that share a hub");
    assert_holds(&found, &wanted, "fans");
}

#[test]
fn unequal_depths() {
    arbtest(|u| {
        let terrain = terrain(u)?;
        let (small, mut large) = (soup(u, terrain)?, soup(u, terrain)?);
        // Many times over: a deep tree beside a shallow one, and level leaves in plenty.
        large.leaves = large.leaves.repeat(40);
        let (a, b) = (build::<9>(&small), build(&large));
        let wanted = brute_force(&at_rest::<9>(&small), &at_rest(&large), 0.0);
        assert_holds(&pairs(&a, &b, 0.0), &wanted, terrain);
        let mut swapped = pairs(&b, &a, 0.0);
        for pair in &mut swapped {
            *pair = (pair.1, pair.0);
        }
        swapped.sort_unstable();
        assert_holds(&swapped, &wanted, terrain);
        Ok(())
    });
}

#[test]
fn boxes_edges_and_points() {
    arbtest(|u| {
        let terrain = terrain(u)?;
        let a = soup(u, terrain)?;
        let boxes: Vec<[DVec3; 2]> =
            a.points.chunks(3).map(|c| [c[0].min(c[1]), c[0].max(c[1])]).collect();
        let corners: Vec<DVec3> = boxes
            .iter()
            .flat_map(|[lo, hi]| (0..8).map(|i| DVec3::select(mask(i), *hi, *lo)))
            .collect();
        let boxed = DopTree::<9>::build_from(Leaves::Points, Extents::boxes(&boxes)).unwrap();
        boxed.validate().expect("a whole tree");
        let bounds: Vec<_> = corners
            .chunks(8)
            .map(|c| {
                let all = [[0, 1, 2], [3, 4, 5], [6, 7, 7]].map(|l| reference(l, &[(c, None)]));
                all.into_iter().reduce(join).expect("three parts")
            })
            .collect();
        let edges: Vec<[u32; 2]> = a.leaves.iter().map(|l| [l[0], l[1]]).collect();
        let edged = DopTree::build(Leaves::Edges(&edges), &a.points).unwrap();
        let points = DopTree::build(Leaves::Points, &a.points).unwrap();
        let at = |leaf: [u32; 3]| reference::<9>(leaf, &[(&a.points, None)]);
        let of_edges: Vec<_> = edges.iter().map(|e| at([e[0], e[1], e[1]])).collect();
        let of_points: Vec<_> = (0..).zip(&a.points).map(|(i, _)| at([i; 3])).collect();
        assert_holds(&pairs(&boxed, &edged, 0.0), &brute_force(&bounds, &of_edges, 0.0), terrain);
        assert_holds(&pairs(&edged, &points, 0.0), &brute_force(&of_edges, &of_points, 0.0), ());
        Ok(())
    });
}

fn mask(i: usize) -> glam::BVec3 {
    glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0)
}

fn join(a: [[f64; 2]; 9], b: [[f64; 2]; 9]) -> [[f64; 2]; 9] {
    std::array::from_fn(|k| [a[k][0].min(b[k][0]), a[k][1].max(b[k][1])])
}

#[test]
fn queries_and_rays() {
    arbtest(|u| {
        let terrain = terrain(u)?;
        let a = soup(u, terrain)?;
        let tree = build::<9>(&a);
        let bounds = at_rest::<9>(&a);
        let origin = point(u, terrain, 5)?;
        let mut workspace = Workspace::new();
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let mut found = Vec::new();
            tree.ray(origin, axis, &mut workspace, |leaf| found.push((0, leaf)));
            // A ray that ends beyond everything.
            let mut ahead = origin;
            ahead[axis as usize] = f64::MAX;
            let ray = reference::<9>([0, 1, 1], &[(&[origin, ahead], None)]);
            assert_holds(&sorted(found), &brute_force(&[ray], &bounds, 0.0), (terrain, axis));
        }
        let mut found = Vec::new();
        tree.query(&Dop::from_points(&[origin]), &mut workspace, |leaf| found.push((0, leaf)));
        let at = reference::<9>([0; 3], &[(&[origin], None)]);
        assert_holds(&sorted(found), &brute_force(&[at], &bounds, 0.0), terrain);
        Ok(())
    });
}

#[test]
fn the_nearest_point_is_found() {
    arbtest(|u| {
        let terrain = terrain(u)?;
        let a = soup(u, terrain)?;
        let tree = DopTree::<9>::build(Leaves::Points, &a.points).expect("a valid soup");
        let from = point(u, terrain, 30)?;
        // Scaled to a size whose square can be taken.
        let distance = |leaf: u32| {
            let apart = a.points[leaf as usize] - from;
            let scale = apart.abs().max_element();
            if scale > 0.0 { (apart / scale).length() * scale } else { 0.0 }
        };
        let mut best = (f64::INFINITY, u32::MAX);
        let mut last = 0.0;
        tree.nearest(from, f64::INFINITY, &mut Workspace::new(), |leaf, bound| {
            let exact = distance(leaf);
            assert!(bound <= exact, "{bound:e} > {exact:e} in {terrain:?}");
            assert!(bound >= last, "{bound:e} after {last:e}");
            last = bound;
            best = if (exact, leaf) < best { (exact, leaf) } else { best };
            best.0
        });
        let wanted = (0..).zip(&a.points).map(|(i, _)| (distance(i), i));
        let wanted = wanted.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        assert_eq!(best, wanted.unwrap_or((f64::INFINITY, u32::MAX)), "{terrain:?}");
        Ok(())
    });
}
