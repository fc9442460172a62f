//! Divisions of triangles, of which each part is nearer to one face.

use glam::DVec3;
use surface::triangle::{self, radius_about_center};
use surface::{TriangleFeature, closest_on_triangle};

/// Parts of a triangle, which cover it, for a [search](crate::MaximumSearch) for its farthest point from a
/// surface.
///
/// ```
/// use proximity::TriangleDivision;
/// use proximity::glam::DVec3;
///
/// // A triangle over two faces is cut where these meet.
/// let face = [DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y];
/// let corners = [(0.3, 0.3), (0.9, 0.3), (0.6, -0.3)].map(|(x, y)| DVec3::new(x, y, 0.01));
/// let squared = [1e-4, 1e-4, 0.0901];
/// let division = TriangleDivision::at_edge(corners, squared, face).ok_or("a corner is far beyond")?;
/// let points = division.points(corners);
/// for part in division.parts() {
///     let heights = part.map(|number| points[number].y);
///     assert!(heights.iter().all(|y| *y > -1e-15) || heights.iter().all(|y| *y < 1e-15));
/// }
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct TriangleDivision {
    /// Points on the edges of the triangle; those that no part has repeat another.
    added: [DVec3; 3],
    parts: &'static [[usize; 3]],
}

/// Parts of a triangle of which an edge is halved, by that edge.
const HALVES: [[[usize; 3]; 2]; 3] =
    [[[0, 3, 2], [3, 1, 2]], [[1, 3, 0], [3, 2, 0]], [[2, 3, 1], [3, 0, 1]]];

/// Quarters of a triangle, between the middles of its edges.
const QUARTERS: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

/// Parts of a triangle of which a corner is cut off, by that corner and by the diagonal of the rest: from the first
/// point of the cut, or from the second.
const CUT_OFF: [[[[usize; 3]; 3]; 2]; 3] = [
    [[[0, 3, 4], [3, 1, 2], [3, 2, 4]], [[0, 3, 4], [3, 1, 4], [4, 1, 2]]],
    [[[1, 3, 4], [3, 2, 0], [3, 0, 4]], [[1, 3, 4], [3, 2, 4], [4, 2, 0]]],
    [[[2, 3, 4], [3, 0, 1], [3, 1, 4]], [[2, 3, 4], [3, 0, 4], [4, 0, 1]]],
];

/// Radius of the largest triangle that is cut \[radii of the face\]. Below, triangles are divided evenly more often;
/// above, what is left of large ones is long and thin.
const MAX_CUT_RADIUS: f64 = 2.0;

/// Share of the squared distance of a corner that it is beyond the face, to be cut. Below, parts without area are
/// cut off; above, triangles are divided evenly more often.
const MIN_BEYOND: f64 = 0.1;

impl TriangleDivision {
    /// Divides a triangle in four of its shape.
    #[must_use]
    pub fn in_quarters([a, b, c]: [DVec3; 3]) -> Self {
        Self { added: [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)], parts: &QUARTERS }
    }

    /// Divides a triangle in two at the middle of its longest edge.
    #[must_use]
    pub fn in_halves([a, b, c]: [DVec3; 3]) -> Self {
        let [ab, bc, ca] = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
        let (longest, middle) = if ab >= bc && ab >= ca {
            (0, 0.5 * (a + b))
        } else if bc >= ca {
            (1, 0.5 * (b + c))
        } else {
            (2, 0.5 * (c + a))
        };
        Self { added: [middle; 3], parts: &HALVES[longest] }
    }

    /// Cuts a triangle at the edge of a face beyond which its farthest corner is, by the squared distances of its
    /// corners from the face; `None` where that corner is not far beyond, or the triangle much larger than the face.
    ///
    /// The center of the triangle is near the face. The distance from a face is nearly linear over it, and grows
    /// fast beyond its edges.
    #[must_use]
    pub fn at_edge(corners: [DVec3; 3], squared: [f64; 3], face: [DVec3; 3]) -> Option<Self> {
        let (center, radius) = radius_about_center(corners);
        if radius > MAX_CUT_RADIUS * radius_about_center(face).1 {
            return None;
        }

        // Beyond a corner of the face, the edge there that is farther.
        let normal = triangle::normal(face);
        let beyond = |edge: usize, point: DVec3| {
            let (from, to) = (face[edge], face[(edge + 1) % 3]);
            (point - from).dot((to - from).cross(normal).normalize_or_zero())
        };
        let farthest = place_of_largest(squared);
        let edge = match closest_on_triangle(corners[farthest], face).feature {
            TriangleFeature::Face => return None,
            TriangleFeature::Edge(edge) => edge,
            TriangleFeature::Corner(edge) => {
                let other = (edge + 2) % 3;
                let [height, of_other] = [edge, other].map(|edge| beyond(edge, corners[farthest]));
                if height >= of_other { edge } else { other }
            }
        };

        // Only where the center is over the face, and the corner far beyond.
        let heights = corners.map(|corner| beyond(edge, corner));
        let height = heights[farthest];
        if beyond(edge, center) >= 0.0 || height * height.abs() <= MIN_BEYOND * squared[farthest] {
            return None;
        }

        // One corner is on one side, and two are on the other.
        let is_beyond = heights.map(|height| height > 0.0);
        let count = is_beyond.iter().filter(|is_beyond| **is_beyond).count();
        let lone = is_beyond.iter().position(|is_beyond| *is_beyond == (count == 1))?;
        let cut = |to: usize| {
            let share = heights[lone] / (heights[lone] - heights[to]);
            corners[lone].lerp(corners[to], share)
        };
        let [next, last] = [(lone + 1) % 3, (lone + 2) % 3];
        let [p, q] = [cut(next), cut(last)];
        let is_from_second = q.distance_squared(corners[next]) < p.distance_squared(corners[last]);
        Some(Self { added: [p, q, q], parts: &CUT_OFF[lone][usize::from(is_from_second)] })
    }

    /// Returns the parts, by the numbers of their corners among the [points](Self::points).
    #[must_use]
    pub const fn parts(&self) -> &'static [[usize; 3]] {
        self.parts
    }

    /// Returns the points that are added to the corners; those that no part has repeat another.
    #[must_use]
    pub const fn added(&self) -> [DVec3; 3] {
        self.added
    }

    /// Returns the corners of the triangle, then the points that are added.
    #[must_use]
    pub fn points(&self, corners: [DVec3; 3]) -> [DVec3; 6] {
        Self::joined(corners, self.added)
    }

    /// Returns values of the corners of a triangle, then those of the points that are added.
    #[must_use]
    pub fn joined<T>([a, b, c]: [T; 3], [d, e, f]: [T; 3]) -> [T; 6] {
        [a, b, c, d, e, f]
    }
}

/// Returns the place of the largest of three values, of equal ones the first.
fn place_of_largest([a, b, c]: [f64; 3]) -> usize {
    if a >= b && a >= c { 0 } else { 1 + usize::from(c > b) }
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;

    use super::*;

    /// Cuts a triangle by the distances of its corners from a face.
    fn cut(corners: [DVec3; 3], face: [DVec3; 3]) -> Option<TriangleDivision> {
        let squared = corners.map(|x| closest_on_triangle(x, face).point.distance_squared(x));
        TriangleDivision::at_edge(corners, squared, face)
    }

    /// Returns the parts by their corners.
    fn parts(corners: [DVec3; 3], division: TriangleDivision) -> Vec<[DVec3; 3]> {
        let points = division.points(corners);
        division.parts.iter().map(|part| part.map(|place| points[place])).collect()
    }

    /// A face in the plane of x and y, and triangles above it that are about as large.
    #[test]
    fn parts_cover_a_triangle_and_face_the_same_way() {
        let face = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut random = Random(3);
        let mut cuts = 0;
        for _ in 0..2000 {
            let mut point = || DVec3::new(random.unit(), random.unit(), 0.1 * random.unit());
            let corners = [0.0; 3].map(|_| 1.4 * point() - DVec3::new(0.4, 0.4, 0.0));
            let normal = triangle::normal(corners);
            let cut = cut(corners, face);
            cuts += usize::from(cut.is_some());
            let others =
                [TriangleDivision::in_halves(corners), TriangleDivision::in_quarters(corners)];
            for division in others.into_iter().chain(cut) {
                let mut sum = DVec3::ZERO;
                for part in parts(corners, division) {
                    let of_part = triangle::normal(part);
                    assert!(of_part.dot(normal) >= -1e-15, "{part:?} of {corners:?}");
                    sum += of_part;
                }
                assert!(sum.distance(normal) < 1e-14, "{corners:?}");
            }
        }
        assert!(cuts > 200, "{cuts}");
    }

    #[test]
    fn a_triangle_is_cut_at_the_edge_that_its_farthest_corner_is_beyond() {
        let face = [DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y];
        for turns in 0..3 {
            let mut corners = [(0.3, 0.3), (0.9, 0.3), (0.6, -0.4)];
            corners.rotate_left(turns);
            let corners = corners.map(|(x, y)| DVec3::new(x, y, 0.01));
            let division = cut(corners, face);
            for part in parts(corners, division.expect("it is far beyond")) {
                let [over, beyond] =
                    [1.0, -1.0].map(|side| part.iter().all(|x| side * x.y > -1e-15));
                assert!(over || beyond, "{part:?}");
            }
        }
    }

    #[test]
    fn triangles_over_a_face_and_large_ones_are_not_cut() {
        let face = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let over = [(0.1, 0.1), (0.4, 0.1), (0.1, 0.4)].map(|(x, y)| DVec3::new(x, y, 0.2));
        let large = [(0.3, 9.0), (-8.0, -4.0), (8.7, -4.0)].map(|(x, y)| DVec3::new(x, y, 0.2));
        // So high above the face that it matters little what is beyond.
        let high = [(0.3, 0.3), (0.5, 0.3), (0.4, -0.1)].map(|(x, y)| DVec3::new(x, y, 3.0));
        for corners in [over, large, high] {
            assert!(cut(corners, face).is_none(), "{corners:?}");
        }
    }
}
