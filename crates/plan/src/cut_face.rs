//! Part of a face inside another body, bounded by the polygon around it.
//!
//! Inside parts of a face are bordered by the segments in which faces of the other body cross it, and
//! by parts of its own edges between ends of these and inside corners. They lie in the convex hull
//! of all such points.

use glam::{DVec2, DVec3};
use surface::{closest_on_segment, triangle};

/// Distance from a plane, relative to the size of the faces, below which the side of a corner is
/// left open. It is far above the rounding of differences of coordinates.
const DOUBT: f64 = 1e-9;

/// Smallest sine between two faces, and smallest ratio of height to edge of a face, for which their
/// crossing is computed.
const MIN_SINE: f64 = 1e-6;

/// Convex polygon around the parts of a face inside another body, in memory that is reused.
#[derive(Debug, Default)]
pub(crate) struct CutFace {
    /// Ends of the segments in which other faces cross it, two by two, then corners.
    points: Vec<DVec3>,
    /// Per segment, the number of the face that crosses it.
    crossing: Vec<u32>,
    /// Bound on the rounding of the ends.
    rounding: f64,
    /// Points in the plane of the face, with their places.
    flat: Vec<(DVec2, usize)>,
    /// Corners of the polygon, in order.
    hull: Vec<(DVec2, usize)>,
}

/// Crossing of two triangles.
enum Crossing {
    Apart,
    /// Ends of the common segment, and a bound on their rounding.
    Segment([DVec3; 2], f64),
    /// They touch, or are too parallel or thin to tell.
    Doubtful,
}

impl CutFace {
    /// Finds the points around the inside parts of a face: the ends of its crossings with some
    /// faces, which come with their numbers, and inside corners; all corners where a crossing is
    /// doubtful.
    ///
    /// Returns the distance by which inside points may be off the polygon, at most `max_error`.
    pub(crate) fn find(
        &mut self,
        face: [DVec3; 3],
        is_inside: [bool; 3],
        crossed: impl Iterator<Item = (u32, [DVec3; 3])>,
        max_error: f64,
    ) -> f64 {
        self.points.clear();
        self.crossing.clear();
        self.rounding = 0.0;
        for (number, other) in crossed {
            match crossing(face, other) {
                Crossing::Apart => {}
                Crossing::Segment(ends, error) if error <= max_error => {
                    self.points.extend(ends);
                    self.crossing.push(number);
                    self.rounding = self.rounding.max(error);
                }
                Crossing::Segment(..) | Crossing::Doubtful => {
                    self.points.clear();
                    self.crossing.clear();
                    self.points.extend(face);
                    return 0.0;
                }
            }
        }
        for (corner, is_inside) in face.into_iter().zip(is_inside) {
            if is_inside {
                self.points.push(corner);
            }
        }
        self.rounding
    }

    /// Bounds the distance of a point of the polygon from the nearest of the points.
    ///
    /// A point of a triangle is within its longest edge over √3 of a corner.
    pub(crate) fn max_distance(&self) -> f64 {
        let [lower, upper] = self.bounds();
        if self.points.is_empty() { 0.0 } else { lower.distance(upper) / 3.0_f64.sqrt() }
    }

    /// Bounds the distance of a point of the polygon from the segment in its middle, in which another
    /// face crosses it; infinite where no segment is known.
    pub(crate) fn max_distance_to_crossing(&self) -> f64 {
        let [lower, upper] = self.bounds();
        let (mut middle, mut min_squared) = (None, f64::INFINITY);
        for ends in self.points.chunks_exact(2).take(self.crossing.len()) {
            // Of twice the distance.
            let squared = (ends[0] + ends[1]).distance_squared(lower + upper);
            if squared < min_squared {
                (middle, min_squared) = (Some([ends[0], ends[1]]), squared);
            }
        }

        // The distance from a segment is convex, so that corners are farthest.
        let Some(segment) = middle else { return f64::INFINITY };
        let mut max_squared: f64 = 0.0;
        for &point in &self.points {
            let foot = closest_on_segment(point, segment).point;
            max_squared = max_squared.max(foot.distance_squared(point));
        }

        // Ends are off by the rounding, and faces that are apart by twice that count as crossing.
        max_squared.sqrt() + 3.0 * self.rounding
    }

    fn bounds(&self) -> [DVec3; 2] {
        let (mut lower, mut upper) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &point in &self.points {
            (lower, upper) = (lower.min(point), upper.max(point));
        }
        [lower, upper]
    }

    /// Divides the polygon around the points into triangles, and returns their number: none where
    /// it has no area.
    pub(crate) fn divide(&mut self, normal: DVec3) -> usize {
        self.find_hull(normal);
        self.hull.len().saturating_sub(2)
    }

    /// Returns one of the triangles, and a face that crosses the polygon at one of its corners, if any.
    pub(crate) fn triangle(&self, number: usize) -> ([DVec3; 3], Option<u32>) {
        let places = [0, number + 1, number + 2].map(|k| self.hull[k].1);
        let at = |place: usize| self.crossing.get(place / 2).copied();
        let crossing = at(places[1]).or_else(|| at(places[2])).or_else(|| at(places[0]));
        (places.map(|place| self.points[place]), crossing)
    }

    /// Finds the convex hull of the points, seen along the largest component of a normal.
    ///
    /// Source: A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions",
    /// Information Processing Letters 9(5), 1979.
    fn find_hull(&mut self, normal: DVec3) {
        let axis = normal.abs().max_position();
        self.flat.clear();
        for (place, point) in self.points.iter().enumerate() {
            let seen = DVec2::new(point[(axis + 1) % 3], point[(axis + 2) % 3]);
            self.flat.push((seen, place));
        }
        self.flat.sort_by(|(p, _), (q, _)| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));

        // Lower chain from left to right, then the upper one back. No point is left out for rounding:
        // a turn must be to the right to drop one.
        let Self { flat, hull, .. } = self;
        hull.clear();
        for is_back in [false, true] {
            let start = hull.len();
            for k in 0..flat.len() {
                let next = flat[if is_back { flat.len() - 1 - k } else { k }];
                while hull.len() >= start + 2 {
                    let (p, q) = (hull[hull.len() - 2].0, hull[hull.len() - 1].0);
                    if (q - p).perp_dot(next.0 - q) > 0.0 {
                        break;
                    }
                    hull.pop();
                }
                hull.push(next);
            }
            hull.pop();
        }
    }
}

/// Computes the segment that two triangles share.
fn crossing(t: [DVec3; 3], other: [DVec3; 3]) -> Crossing {
    // Each has corners on both sides of the other's plane, beyond doubt.
    let [Some(normal), Some(other_normal)] = [t, other].map(safe_normal) else {
        return Crossing::Doubtful;
    };
    let size = max_edge(t).max(max_edge(other)).max(t[0].distance(other[0]));
    let doubt = DOUBT * size;
    let [of_t, of_other] = [(t, other_normal, other[0]), (other, normal, t[0])]
        .map(|(corners, normal, origin)| corners.map(|corner| normal.dot(corner - origin)));
    for heights in [of_t, of_other] {
        if heights.iter().all(|&h| h > doubt) || heights.iter().all(|&h| h < -doubt) {
            return Crossing::Apart;
        }
    }
    if of_t.iter().chain(&of_other).any(|h| h.abs() <= doubt) {
        return Crossing::Doubtful;
    }

    // Both meet the common line in an interval.
    let line = normal.cross(other_normal);
    if line.length_squared() < MIN_SINE * MIN_SINE {
        return Crossing::Doubtful;
    }
    let mut error: f64 = 0.0;
    let [p, q] = [(t, of_t), (other, of_other)].map(|(corners, heights)| {
        let (ends, slack) = passings(corners, heights, doubt);
        error = error.max(slack);
        if line.dot(ends[1] - ends[0]) >= 0.0 { ends } else { [ends[1], ends[0]] }
    });
    let begin = if line.dot(q[0] - p[0]) > 0.0 { q[0] } else { p[0] };
    let end = if line.dot(q[1] - p[1]) < 0.0 { q[1] } else { p[1] };
    let is_apart = line.dot(end - begin) < -2.0 * error * line.length();
    if is_apart { Crossing::Apart } else { Crossing::Segment([begin, end], error) }
}

/// Computes where the two edges of a triangle that cross a plane meet it, and a bound on the rounding.
fn passings(corners: [DVec3; 3], heights: [f64; 3], doubt: f64) -> ([DVec3; 2], f64) {
    let (mut ends, mut found, mut error) = ([DVec3::ZERO; 2], 0, 0.0_f64);
    for k in 0..3 {
        let (from, to) = (heights[k], heights[(k + 1) % 3]);
        if (from > 0.0) != (to > 0.0) && found < 2 {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            ends[found] = p.lerp(q, from / (from - to));
            error = error.max(doubt * p.distance(q) / (from - to).abs());
            found += 1;
        }
    }
    (ends, error)
}

/// Returns the unit normal of a triangle; `None` for one that is too thin to have a certain one.
fn safe_normal(corners: [DVec3; 3]) -> Option<DVec3> {
    let normal = triangle::normal(corners);
    let (length, longest) = (normal.length(), max_edge(corners));
    (length > MIN_SINE * longest * longest).then(|| normal / length)
}

fn max_edge([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a)).sqrt()
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;

    use super::*;

    #[test]
    fn polygons_hold_all_inside_points() {
        // A face through a random tetrahedron: every point of a lattice on the face that is inside
        // is in one of the triangles.
        let mut random = Random(7);
        let mut point = |scale: f64| {
            scale * DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0))
        };
        let (mut inside_points, mut bounded_points) = (0, 0);
        for _ in 0..300 {
            let face: [DVec3; 3] = std::array::from_fn(|_| point(1.0));
            let solid: [DVec3; 4] = std::array::from_fn(|_| point(1.5));
            let faces =
                [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|f| f.map(|k: usize| solid[k]));
            let contains = |p: DVec3| {
                let side = faces.map(|corners| triangle::triple_product(corners, p) > 0.0);
                side == [side[0]; 4]
            };
            let mut cut = CutFace::default();
            cut.find(face, face.map(contains), (0..).zip(faces), 1e-7);
            let count = cut.divide(triangle::normal(face));
            let triangles: Vec<_> = (0..count).map(|number| cut.triangle(number).0).collect();
            let by_crossing = cut.max_distance_to_crossing();
            for (i, j) in (0..20).flat_map(|i| (0..20 - i).map(move |j| (i, j))) {
                let (u, v) = (f64::from(i) / 20.0 + 0.01, f64::from(j) / 20.0 + 0.01);
                let p = face[0] + u * (face[1] - face[0]) + v * (face[2] - face[0]);
                if u + v > 1.0 || !contains(p) {
                    continue;
                }
                inside_points += 1;
                let to_face = |f: [DVec3; 3]| surface::closest_on_triangle(p, f).point.distance(p);
                let distance = faces.map(to_face).into_iter().fold(f64::INFINITY, f64::min);
                assert!(distance <= by_crossing, "{distance} beyond {by_crossing}");
                bounded_points += usize::from(by_crossing < cut.max_distance());
                let near =
                    triangles.iter().map(|&t| surface::closest_on_triangle(p, t).point.distance(p));
                let distance = near.fold(f64::INFINITY, f64::min);
                assert!(distance < 1e-7, "{distance} from {triangles:?}");
            }
        }
        assert!(inside_points > 1000, "{inside_points}");
        assert!(bounded_points > 1000, "{bounded_points}");
    }

    /// Corners may be off by the doubt: ends move by no more than the bound that comes with them.
    #[test]
    fn ends_of_crossings_are_within_their_rounding() {
        let mut random = Random(8);
        let mut point = || DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
        let mut compared = 0;
        for _ in 0..1000 {
            // Nearly parallel faces cross where rounding says.
            let t = [point(), point(), point()];
            let other = t.map(|corner| corner + 1e-3 * point());
            let Crossing::Segment(ends, error) = crossing(t, other) else { continue };
            let Some(normal) = safe_normal(other) else { continue };
            let moved = t.map(|corner| corner + 0.25 * DOUBT * max_edge(t) * normal);
            let Crossing::Segment(moved_ends, moved_error) = crossing(moved, other) else {
                continue;
            };
            compared += 1;
            for (end, moved) in ends.into_iter().zip(moved_ends) {
                let way = end.distance(moved);
                assert!(way <= 2.0 * error.max(moved_error), "{way} beyond {error}");
            }
        }
        assert!(compared > 100, "{compared}");
    }
}
