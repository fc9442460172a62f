//! Brackets on depths, against planted ones.

use fixtures::shapes::{capsule, icosphere, octasphere, plate};
use glam::DVec3;

use super::*;

fn tree(mesh: &fixtures::Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("a tree")
}

/// Finds a depth within a tolerance; returns true as well if it was searched for.
fn find(bodies: [&SurfaceTree; 2], deviations: [f64; 2], tolerance: f64) -> (FoundDepth, bool) {
    let mut found = PairProximity::default();
    found.compute(bodies[0], bodies[1], 0.0).expect("few faces are near");
    let mut operations = OperationCounts::default();
    let compared = Compared { bodies, deviations };
    let depth = SurfaceDepth::default().find(&found, compared, tolerance, &mut operations);
    (depth, operations.split_pieces > 0.0)
}

/// Brackets a depth at a width; returns true as well if it was searched for.
fn depth(bodies: [&SurfaceTree; 2], width: f64) -> (DepthBracket, bool) {
    let (found, is_searched) = find(bodies, [0.0; 2], width);
    (found.bracket, is_searched)
}

#[test]
fn brackets_hold_the_depth_at_every_width() {
    // A rod in a box: the end of its cap is 8 deep, the corners of the box are not.
    let rod = capsule(2.0, 30.0, 16);
    let lowest = rod.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let rod = tree(&rod.translated(DVec3::new(12.0, 3.0, -8.0 - lowest)));
    let muscle = plate(DVec3::new(60.0, 60.0, 40.0), [1, 1]).translated(DVec3::Z * -20.0);
    let muscle = tree(&muscle);
    for width in [50.0, 2.0, 0.5, 0.1, 0.01] {
        let (bracket, _) = depth([&rod, &muscle], width);
        assert!(bracket.upper - bracket.lower <= width, "{width}: {bracket:?}");
        let contains = bracket.lower <= 8.0 + 1e-9 && bracket.upper >= 8.0 - 1e-9;
        assert!(contains, "{width}: {bracket:?}");
    }

    // Surfaces that stand for others: a vertex of the rod stays where it is, and the box may be
    // shallower there; elsewhere both may be deeper.
    for tolerance in [2.0, 0.5, 0.31] {
        for deviations in [[0.2, 0.1], [0.1, 0.2], [0.0, 0.3], [0.3, 0.0]] {
            let (FoundDepth { depth, bracket }, _) = find([&rod, &muscle], deviations, tolerance);
            let [least, greatest] = [8.0 - deviations[1], 8.3];
            let contains = bracket.lower <= least + 1e-9 && bracket.upper >= greatest - 1e-9;
            assert!(contains, "{deviations:?} within {tolerance}: {bracket:?}");
            let error = (depth - bracket.lower).max(bracket.upper - depth);
            assert!(error <= tolerance + 1e-9, "{depth} within {tolerance} of {bracket:?}");
        }
    }
}

#[test]
fn vertices_of_fine_surfaces_take_no_search() {
    let [a, b] = [0.0, 58.0].map(|x| tree(&icosphere(30.0, 5).translated(DVec3::X * x)));
    let (coarse, is_searched) = depth([&a, &b], 2.0);
    assert!(!is_searched, "{coarse:?}");
    let (fine, is_searched) = depth([&a, &b], 1e-5);
    assert!(is_searched, "{fine:?}");
    assert!(coarse.lower <= fine.upper && fine.lower <= coarse.upper);
}

#[test]
fn a_bar_through_two_blocks_is_as_deep_as_their_middles() {
    // Each side of the bar is inside at two places, and outside between them.
    let block = plate(DVec3::new(10.0, 20.0, 20.0), [1, 1]);
    let [left, right] = [-15.0, 15.0].map(|x| block.clone().translated(DVec3::X * x));
    let blocks = tree(&left.joined(&right));
    let bar = tree(&plate(DVec3::new(80.0, 1.0, 1.0), [1, 1]));
    for width in [4.0, 1.0, 0.1] {
        for bodies in [[&bar, &blocks], [&blocks, &bar]] {
            let (bracket, is_searched) = depth(bodies, width);
            let contains = bracket.lower <= 5.0 + 1e-9 && 5.0 - 1e-9 <= bracket.upper;
            assert!(is_searched && contains, "{width}: {bracket:?}");
        }
    }
}

/// Two divisions of a ball are equally deep in each other nearly everywhere, and by much less than their faces are
/// long.
#[test]
fn surfaces_that_nearly_coincide_take_few_divisions() {
    let a = tree(&icosphere(1.0, 3));
    let b = tree(&octasphere(1.0, 4).rotated(DVec3::new(1.0, 2.0, 3.0), 0.4));
    let mut found = PairProximity::default();
    found.compute(&a, &b, 0.0).expect("few faces are near");
    let mut operations = OperationCounts::default();
    let compared = Compared { bodies: [&a, &b], deviations: [0.0; 2] };
    let depth = SurfaceDepth::default().find(&found, compared, 5e-4, &mut operations);
    let DepthBracket { lower, upper } = depth.bracket;
    assert!(lower > 1e-3 && upper - lower <= 5e-4, "{depth:?}");
    assert!(operations.split_pieces < 30_000.0, "{}", operations.split_pieces);
}
