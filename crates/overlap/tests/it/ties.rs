//! Pairs of bodies on a grid of small whole numbers, full of ties, against bodies that are really
//! moved, swapped, and far from the origin.

use fixtures::Mesh;
use fixtures::shapes::cube;
use glam::DVec3;
use overlap::{Overlap, OverlapDetector};
use proximity::SurfaceTree;

/// Pairs of bodies.
const PAIRS: u32 = 100_000;

/// The move that the infinitesimal stands for: exact beside whole numbers of this size.
const MOVE: DVec3 = DVec3::new(1.0 / 65_536.0, 1.0 / 8_589_934_592.0, 1.0 / 562_949_953_421_312.0);

/// Loops shorter than this are points once nothing is moved.
const SHORT: f64 = 1e-2;

/// Deterministic stream of small whole numbers.
struct Whole(u64);

impl Whole {
    fn next(&mut self, below: u64) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let value = u32::try_from((self.0 >> 33) % below).expect("31 bits");
        f64::from(value)
    }

    fn point(&mut self, below: u64) -> DVec3 {
        DVec3::new(self.next(below), self.next(below), self.next(below))
    }

    /// A box or a tetrahedron with whole corners.
    fn body(&mut self) -> Mesh {
        if self.next(2) < 1.0 {
            let lower = self.point(4);
            let size = self.point(3) + DVec3::ONE;
            return cube(2.0).scaled(size).translated(2.0 * lower + size).scaled(DVec3::splat(0.5));
        }
        loop {
            let positions = vec![self.point(6), self.point(6), self.point(6), self.point(6)];
            let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
            let mesh = Mesh { positions, faces };
            let volume = mesh.volume();
            if volume > 0.0 {
                return mesh;
            } else if volume < 0.0 {
                return mesh.flipped();
            }
        }
    }
}

fn tree(mesh: &Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("whole numbers are finite")
}

/// Measures a pair, and counts its loops that are longer than a point.
fn measure(detector: &mut OverlapDetector, a: &SurfaceTree, b: &SurfaceTree) -> (Overlap, usize) {
    let overlap = detector.measure(a, b);
    let mut loops = 0;
    for chain in detector.curve() {
        assert!(chain.is_closed, "closed bodies cross in loops");
        let next = chain.points.iter().cycle().skip(1);
        let length: f64 = chain.points.iter().zip(next).map(|(p, q)| p.distance(*q)).sum();
        loops += usize::from(length > SHORT);
    }
    (overlap, loops)
}

#[test]
#[expect(clippy::print_stdout, reason = "the share of ties")]
fn whole_number_pairs_are_those_of_moved_bodies() {
    let mut whole = Whole(1);
    let mut detector = OverlapDetector::default();
    let mut ties = 0;
    for pair in 0..PAIRS {
        let (a, b) = (whole.body(), whole.body());
        let [of_a, of_b, moved] = [&a, &b, &a.clone().translated(MOVE)].map(tree);
        let (overlap, loops) = measure(&mut detector, &of_a, &of_b);
        let (moved, moved_loops) = measure(&mut detector, &moved, &of_b);
        let (swapped, _) = measure(&mut detector, &of_b, &of_a);
        ties += u32::from(overlap.has_ties);

        let [total, moved, swapped] = [overlap.total, moved.total, swapped.total];
        let volume = total.volume.unwrap();
        assert_eq!(loops, moved_loops, "{pair}: {a:?} {b:?}");
        assert!((volume - moved.volume.unwrap()).abs() < 1e-2, "{pair}: {a:?} {b:?}");
        assert!((volume - swapped.volume.unwrap()).abs() < 1e-13, "{pair}: {a:?} {b:?}");
        let areas = [total.area_of_a_inside_b, total.area_of_b_inside_a];
        let other = [swapped.area_of_b_inside_a, swapped.area_of_a_inside_b];
        for (area, other) in areas.into_iter().zip(other) {
            assert!((area.unwrap() - other.unwrap()).abs() < 1e-12, "{pair}: {a:?} {b:?}");
            assert!(area.unwrap() > -1e-12, "{pair}: {a:?} {b:?}");
        }
    }
    println!("{PAIRS} pairs, {ties} of them with ties");
    assert!(ties > PAIRS / 4);
}

#[test]
fn far_from_the_origin_nothing_changes() {
    let far = DVec3::new(1.0, 1.0, 1.0) * f64::from(1 << 20);
    let mut whole = Whole(2);
    let mut detector = OverlapDetector::default();
    for pair in 0..2_000 {
        let (a, b) = (whole.body(), whole.body());
        let (here, loops) = measure(&mut detector, &tree(&a), &tree(&b));
        let moved = [&a, &b].map(|mesh| mesh.clone().translated(far));
        let (there, far_loops) = measure(&mut detector, &tree(&moved[0]), &tree(&moved[1]));
        let near = |p: Option<f64>, q: Option<f64>, relative: f64| {
            (p.unwrap() - q.unwrap()).abs() <= relative * p.unwrap().abs().max(1.0)
        };
        assert_eq!(loops, far_loops, "{pair}");
        assert!(near(here.total.volume, there.total.volume, 1e-10), "{pair}");
        assert!(near(here.total.area_of_a_inside_b, there.total.area_of_a_inside_b, 1e-12));
        assert!(near(here.total.area_of_b_inside_a, there.total.area_of_b_inside_a, 1e-12));
    }
}
