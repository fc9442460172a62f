//! Clipped faces and depths, region by region.

use fixtures::Mesh;
use fixtures::shapes::{cube, icosphere};
use glam::DVec3;
use overlap::{ClippedFace, DepthParams, Overlap, OverlapDetector};
use proximity::SurfaceTree;
use surface::progress::Progress;
use surface::triangle;

fn tree(mesh: &Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("planted bodies are finite")
}

/// A box between two corners.
fn between(lower: [f64; 3], upper: [f64; 3]) -> Mesh {
    let [lower, upper] = [lower, upper].map(DVec3::from);
    cube(1.0).scaled(upper - lower).translated(0.5 * (lower + upper))
}

/// A box with a spike of 0.5 and one of 0.25 through its top face, and a slab above that face.
fn spikes_and_slab() -> [Mesh; 2] {
    let spike = |x: f64, height: f64| between([x, 1.0, 2.0], [x + 1.0, 2.0, 4.0 + height]);
    let base = between([0.0, 0.0, 0.0], [6.0, 3.0, 1.0]);
    let slab = between([-1.0, -1.0, 4.0], [7.0, 4.0, 9.0]);
    [base.joined(&spike(1.0, 0.25)).joined(&spike(4.0, 0.5)), slab]
}

/// Area of the parts of some faces that belong to a region.
fn area(parts: &[ClippedFace], body: &SurfaceTree, region: u32) -> f64 {
    let mut sum = 0.0;
    for part in parts.iter().filter(|part| part.region == region) {
        let triangles = part.triangles(triangle::normal(body.corners(part.face)));
        sum += triangles.into_iter().map(triangle::area).sum::<f64>();
    }
    sum
}

fn measure(a: &SurfaceTree, b: &SurfaceTree) -> (OverlapDetector, Overlap) {
    let mut detector = OverlapDetector::default();
    let overlap = detector.measure(a, b);
    (detector, overlap)
}

/// Parts of a region have its area; every part belongs to a region that is reported.
fn check_areas(a: &Mesh, b: &Mesh) -> Overlap {
    let bodies = [tree(a), tree(b)];
    let (detector, overlap) = measure(&bodies[0], &bodies[1]);
    for side in 0..2 {
        let parts = detector.patches(side, &bodies[side]);
        for (region, measures) in (0..).zip(&overlap.regions) {
            let measured = [measures.area_of_a_inside_b, measures.area_of_b_inside_a][side];
            let measured = measured.expect("closed");
            let clipped = area(&parts, &bodies[side], region);
            assert!((clipped - measured).abs() < 1e-11, "{side} {region}: {clipped} {measures:?}");
        }
        let is_reported = |part: &ClippedFace| (part.region as usize) < overlap.regions.len();
        assert!(parts.iter().all(is_reported), "{side}: {parts:?}");
    }
    overlap
}

#[test]
fn parts_of_a_region_have_its_area() {
    let [base, slab] = spikes_and_slab();
    let overlap = check_areas(&base, &slab);
    let volumes: Vec<f64> = overlap.regions.iter().filter_map(|region| region.volume).collect();
    assert!(volumes.len() == 2 && (volumes[0] - 0.5).abs() + (volumes[1] - 0.25).abs() < 1e-14);
    let counts: Vec<[usize; 2]> =
        overlap.regions.iter().map(|region| region.inside_vertices).collect();
    assert_eq!(counts, [[4, 0]; 2]);
    assert_eq!(overlap.total.inside_vertices, [8, 0]);

    let ball = icosphere(2.0, 3);
    check_areas(&ball, &ball.clone().translated(DVec3::new(1.0, 0.5, 0.25)));
    check_areas(&ball, &icosphere(0.5, 1).translated(DVec3::Y * 0.5));
}

/// The part of the wall around a cavity and that around the solid are of one region.
#[test]
fn a_cavity_belongs_to_the_region_around_it() {
    let hollow = between([-4.0; 3], [4.0; 3]).joined(&between([-1.0; 3], [1.0; 3]).flipped());
    let overlap = check_areas(&hollow, &between([-9.0; 3], [9.0; 3]));
    assert_eq!(overlap.regions.len(), 1);
    // The slab cuts the wall and the cavity in one face each: a part with a hole.
    check_areas(&hollow, &between([-9.0, -9.0, 0.0], [9.0, 9.0, 9.0]));
}

/// Two boxes within one that has a cavity, which is in the larger of them: boxes of regions are those of
/// their own points, wherever the origin is.
#[test]
fn a_cavity_belongs_to_the_region_that_holds_it() {
    let within = between([1.0; 3], [5.0; 3]).joined(&between([6.0; 3], [7.5; 3]));
    let around = between([0.5; 3], [8.0; 3]).joined(&between([2.0; 3], [3.0; 3]).flipped());
    for mirror in [1.0, -1.0] {
        let [a, b] = [&within, &around].map(|mesh| {
            let mesh = mesh.clone().scaled(DVec3::splat(mirror));
            tree(&if mirror < 0.0 { mesh.flipped() } else { mesh })
        });
        let overlap = OverlapDetector::default().measure(&a, &b);
        let mut volumes: Vec<f64> =
            overlap.regions.iter().map(|region| region.volume.expect("closed")).collect();
        volumes.sort_by(f64::total_cmp);
        let exact = [1.5 * 1.5 * 1.5, 64.0 - 1.0];
        assert_eq!(volumes.len(), 2, "{volumes:?}");
        for (volume, exact) in volumes.iter().zip(exact) {
            assert!((volume - exact).abs() < 1e-12, "{volumes:?}");
        }
    }
}

/// A bar whose corners are all inside a body, which has a cavity about the middle of one of its edges.
#[test]
fn a_face_with_a_notch_is_one_part() {
    let bar = between([0.0; 3], [4.0, 1.0, 1.0]);
    let cavity = between([1.5, -0.5, 0.5], [2.5, 0.5, 1.5]);
    let around = between([-1.0; 3], [5.0, 2.0, 2.0]).joined(&cavity.flipped());
    let overlap = check_areas(&bar, &around);
    assert!((overlap.total.volume.expect("closed") - 3.75).abs() < 1e-14, "{overlap:?}");
}

/// The same bar about a shaft that pierces one of its triangles, and reaches none of its edges.
#[test]
fn a_pierced_face_is_one_part() {
    let bar = between([0.0; 3], [4.0, 1.0, 1.0]);
    let shaft = between([2.0, 0.1, 0.5], [2.2, 0.2, 1.5]);
    let around = between([-1.0; 3], [5.0, 2.0, 2.0]).joined(&shaft.flipped());
    let overlap = check_areas(&bar, &around);
    assert!((overlap.total.volume.expect("closed") - 3.99).abs() < 1e-14, "{overlap:?}");
}

/// A face without area from a vertex inside to another body far away.
#[test]
fn a_face_that_repeats_a_vertex_leads_nowhere() {
    let block = between([-1.0; 3], [1.0; 3]);
    let blocks = block.clone().joined(&block.translated(100.0 * DVec3::X));
    let around = tree(&between([-2.0; 3], [2.0; 3]));
    for vertex in 0..8 {
        let mut linked = blocks.clone();
        linked.faces.push([vertex, vertex, vertex + 8]);
        let body = tree(&linked);
        let (mut detector, overlap) = measure(&body, &around);
        assert!((overlap.total.volume.expect("closed") - 8.0).abs() < 1e-12, "{overlap:?}");
        assert_eq!(detector.patches(0, &body).len(), 12, "{vertex}");

        let [depth, _] = detector.depths([&body, &around], &DepthParams::with_floor(1e-6));
        let depth = depth.expect("a block is inside");
        assert!(depth.lower <= 1.0 && (depth.upper - 1.0).abs() < 1e-5, "{depth:?}");
    }
}

#[test]
fn each_region_has_a_depth_of_its_own() {
    let [base, slab] = spikes_and_slab();
    let bodies = [tree(&base), tree(&slab)];
    let (mut detector, _) = measure(&bodies[0], &bodies[1]);
    let bodies = bodies.each_ref();
    let params = DepthParams { relative_tolerance: 0.0, tolerance: 1e-6, max_queries: 100_000 };
    for (region, exact) in [(0, 0.5), (1, 0.25)] {
        let depths = detector.depths_in_region(region, bodies, &params, Progress::none());
        let [of_base, of_slab] = depths.expect("no interruption");
        let depth = of_base.expect("a spike is inside");
        assert!(depth.lower <= exact && exact <= depth.upper + 1e-15, "{region}: {depth:?}");
        // The bottom of the slab inside a spike: as deep as the spike's walls are far, 0.5.
        let depth = of_slab.expect("the slab's face is inside the spike");
        let nearest = f64::min(0.5, exact);
        let holds = depth.lower <= nearest + 1e-12 && nearest <= depth.upper + 1e-12;
        assert!(holds, "{region}: {depth:?}");
    }
    let [of_base, _] = detector.depths(bodies, &params);
    assert!(of_base.is_some_and(|depth| depth.lower <= 0.5 && depth.upper >= 0.5));
    let nothing = detector.depths_in_region(2, bodies, &params, Progress::none());
    assert_eq!(nothing, Ok([None; 2]));
}
