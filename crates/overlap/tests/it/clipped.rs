//! Measures of convex bodies anywhere, beside those of their faces, clipped by all planes.

use fixtures::generate::{cases, convex};
use fixtures::{Mesh, damage, reference, shapes};
use glam::DVec3;
use overlap::{OverlapDetector, OverlapMeasures};
use proximity::SurfaceTree;

/// Bound on the rounding of measures, relative to the power of a length of 40.
const ROUNDING: f64 = 1e-11;
const SIZE: f64 = 40.0;

fn tree(mesh: &Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("a tree")
}

/// Corners of a polygon, each with true where the edge that begins there is on a plane that has
/// clipped it.
type Polygon = Vec<(DVec3, bool)>;

/// Returns the part of a polygon behind a plane.
fn behind(polygon: &Polygon, point: DVec3, normal: DVec3) -> Polygon {
    let mut kept = Polygon::new();
    for (i, &(from, is_cut)) in polygon.iter().enumerate() {
        let (to, _) = polygon[(i + 1) % polygon.len()];
        let [height, next] = [from, to].map(|corner| normal.dot(corner - point));
        let crossing = || from + height / (height - next) * (to - from);
        match (height <= 0.0, next <= 0.0) {
            (true, true) => kept.push((from, is_cut)),
            // Here the polygon leaves along the plane, and there it comes back.
            (true, false) => kept.extend([(from, is_cut), (crossing(), true)]),
            (false, true) => kept.push((crossing(), is_cut)),
            (false, false) => {}
        }
    }
    kept
}

/// Measures of the faces of one convex body within another.
#[derive(Default)]
struct Clipped {
    area: f64,
    area_vector: DVec3,
    volume: f64,
    first_moment: DVec3,
    curve_length: f64,
}

impl Clipped {
    fn of(body: &Mesh, other: &Mesh) -> Self {
        let mut sums = Self::default();
        for face in 0..body.faces.len() {
            let mut polygon: Polygon = body.corners(face).map(|corner| (corner, false)).to_vec();
            for plane in 0..other.faces.len() {
                polygon = behind(&polygon, other.corners(plane)[0], other.normal(plane));
            }
            sums.add(&polygon);
        }
        sums
    }

    fn add(&mut self, polygon: &Polygon) {
        let mut doubled = DVec3::ZERO;
        for (i, &(q, is_cut)) in polygon.iter().enumerate() {
            let ((p, _), (r, _)) = (polygon[0], polygon[(i + 1) % polygon.len()]);
            doubled += (q - p).cross(r - p);
            // The tetrahedron between a triangle of the fan and the origin.
            let volume = p.dot(q.cross(r)) / 6.0;
            self.volume += volume;
            self.first_moment += volume * (p + q + r) / 4.0;
            if is_cut {
                self.curve_length += q.distance(r);
            }
        }
        self.area += 0.5 * doubled.length();
        self.area_vector += 0.5 * doubled;
    }
}

/// Checks all measures of two closed convex bodies; returns the volume.
fn check(total: &OverlapMeasures, a: &Mesh, b: &Mesh) -> f64 {
    let [of_a, of_b] = [Clipped::of(a, b), Clipped::of(b, a)];
    let close = |found: f64, expected: f64, power: i32| {
        assert!(
            (found - expected).abs() < ROUNDING * SIZE.powi(power),
            "{found}, {expected}: {total:?}"
        );
    };
    let volume = of_a.volume + of_b.volume;
    close(total.volume.expect("closed bodies"), volume, 3);
    close(total.area_of_a_inside_b.expect("closed bodies"), of_a.area, 2);
    close(total.area_of_b_inside_a.expect("closed bodies"), of_b.area, 2);
    close(total.curve_length, of_a.curve_length, 1);
    close(total.curve_length, of_b.curve_length, 1);
    let moment = of_a.first_moment + of_b.first_moment;
    let found = total.centroid.map_or(DVec3::ZERO, |centroid| volume * centroid);
    assert!(found.distance(moment) < ROUNDING * SIZE.powi(4), "{found}, {moment}: {total:?}");
    let along = total.normal.dot(of_a.area_vector);
    close(along, of_a.area_vector.length(), 2);

    let inside = [reference::vertices_inside(a, b).len(), reference::vertices_inside(b, a).len()];
    assert_eq!(total.inside_vertices, inside, "{total:?}");
    volume
}

#[test]
fn convex_bodies_measure_what_their_clipped_faces_do() {
    let (mut detector, mut overlaps, mut within) = (OverlapDetector::default(), 0, 0);
    cases(8, 60, |u| {
        let (a, b) = (convex(u)?, convex(u)?);
        let distance = f64::from(u.int_in_range(0_u16..=400)?) / 10.0;
        let b = b.translated(distance * DVec3::new(0.6, -0.64, 0.48));
        let found = detector.measure(&tree(&a), &tree(&b));
        let volume = check(&found.total, &a, &b);
        let swapped = detector.measure(&tree(&b), &tree(&a));
        check(&swapped.total, &b, &a);

        overlaps += usize::from(volume > 1.0);
        within += usize::from(volume > 1.0 && found.regions.is_empty());
        Ok(())
    });
    assert!(overlaps > 30, "{overlaps} overlap, {within} wholly");
}

/// A sheet through a ball ends within it along one side: its curve is one arc, in the plane.
#[test]
fn a_curve_ends_where_an_open_surface_does() {
    let ball = shapes::icosphere(10.0, 3).rotated(DVec3::new(1.0, 2.0, 3.0), 0.1);
    let sheet = |x: f64| Mesh {
        positions: [(-30.0, -30.0), (x, -30.0), (x, 30.0), (-30.0, 30.0)]
            .map(|(x, y)| DVec3::new(x, y, 0.3))
            .to_vec(),
        faces: vec![[0, 1, 2], [0, 2, 3]],
    };
    let mut detector = OverlapDetector::default();
    for (x, counts) in [(30.0, [1, 0]), (2.0, [0, 1]), (-12.0, [0, 0])] {
        let found = detector.measure(&tree(&ball), &tree(&sheet(x)));
        let total = &found.total;
        assert_eq!([total.curve_loops, total.curve_arcs], counts, "to {x}");
        assert_eq!((total.volume, total.centroid, total.area_of_a_inside_b), (None, None, None));

        // What is inside the ball is a part of its section.
        let strip = sheet(x);
        let clipped = Clipped::of(&strip, &ball);
        let area = total.area_of_b_inside_a.expect("the ball is closed");
        assert!((area - clipped.area).abs() < 1e-9, "{area}, {}", clipped.area);
        assert!((total.curve_length - clipped.curve_length).abs() < 1e-9, "{total:?}");
    }

    // A hole elsewhere changes nothing but what needs an inside.
    let open = damage::hole(ball.clone(), -10.0 * DVec3::X, 3.0);
    let cube = shapes::cube(6.0).translated(DVec3::new(9.0, 0.4, 0.3));
    let [whole, part] = [ball, open].map(|body| detector.measure(&tree(&body), &tree(&cube)).total);
    let [part_area, whole_area] =
        [part, whole].map(|total| total.area_of_a_inside_b.expect("closed"));
    assert!((part_area - whole_area).abs() < 1e-12, "{part_area}, {whole_area}");
    assert!((part.curve_length - whole.curve_length).abs() < 1e-12, "{part:?}, {whole:?}");
    assert_eq!(part.curve_loops, whole.curve_loops);
    assert_eq!((part.volume, part.area_of_b_inside_a, part.centroid), (None, None, None));
}
