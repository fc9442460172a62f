//! Triangulation of a face's part: outer loops with holes, by ear clipping.

use std::fmt;
use std::ops::Range;

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Triangulation of one part after another, in memory that is reused.
#[derive(Default)]
pub(crate) struct Triangulation {
    /// Points of all loops, in space and in the plane of the face.
    points: Vec<DVec3>,
    flat: Vec<DVec2>,
    loops: Vec<FlatLoop>,
    /// An outer loop with its holes.
    ring_points: Vec<DVec3>,
    ring: Vec<[f64; 2]>,
    hole_starts: Vec<u32>,
    corners: Vec<u32>,
    earcut: Earcut<f64>,
}

/// A loop in the plane of the face.
#[derive(Clone, Debug)]
struct FlatLoop {
    points: Range<usize>,
    /// Area of the polygon, negative for a hole.
    area: f64,
}

impl Triangulation {
    /// Appends the triangles of a part, counter-clockwise like its outer loops.
    ///
    /// `normal` is the face's, of any length.
    pub(crate) fn add<'p>(
        &mut self,
        loops: impl ExactSizeIterator<Item = &'p [DVec3]>,
        normal: DVec3,
        triangles: &mut Vec<[DVec3; 3]>,
    ) {
        let is_single = loops.len() == 1;
        self.points.clear();
        self.flat.clear();
        self.loops.clear();
        let frame = Frame::new(normal);
        for points in loops {
            if let (true, &[a, b, c]) = (is_single, points) {
                triangles.push([a, b, c]);
                return;
            }
            self.add_loop(points, &frame);
        }

        // Each outer loop takes the holes that it is the smallest loop around.
        for outer in 0..self.loops.len() {
            if self.loops[outer].area > 0.0 {
                self.clip_ears(outer, triangles);
            }
        }
    }

    /// Adds a loop in the plane of the face, which has two coordinates.
    fn add_loop(&mut self, points: &[DVec3], frame: &Frame) {
        let start = self.flat.len();
        for &point in points {
            self.points.push(point);
            self.flat.push(frame.project(point));
        }

        let flat = &self.flat[start..];
        let mut twice_area = 0.0;
        for ends in flat.windows(2) {
            twice_area += (ends[0] - flat[0]).perp_dot(ends[1] - flat[0]);
        }
        self.loops.push(FlatLoop { points: start..self.flat.len(), area: 0.5 * twice_area });
    }

    /// Triangulates an outer loop with its holes.
    fn clip_ears(&mut self, outer: usize, triangles: &mut Vec<[DVec3; 3]>) {
        self.ring_points.clear();
        self.ring.clear();
        self.hole_starts.clear();
        self.add_to_ring(outer);
        for hole in 0..self.loops.len() {
            let FlatLoop { points, area } = &self.loops[hole];
            if *area < 0.0 && self.smallest_around(self.flat[points.start]) == Some(outer) {
                self.hole_starts.push(crate::curve::index(self.ring.len()));
                self.add_to_ring(hole);
            }
        }

        let Self { ring_points, ring, hole_starts, corners, earcut, .. } = self;
        earcut.earcut_slice(ring, hole_starts, corners);
        for corners in corners.chunks_exact(3) {
            let [a, b, c] = [corners[0], corners[1], corners[2]];
            triangles.push([a, b, c].map(|corner| ring_points[corner as usize]));
        }
    }

    fn add_to_ring(&mut self, number: usize) {
        let range = self.loops[number].points.clone();
        self.ring_points.extend_from_slice(&self.points[range.clone()]);
        self.ring.extend(self.flat[range].iter().map(DVec2::to_array));
    }

    /// Returns the number of the smallest outer loop that holds a point.
    fn smallest_around(&self, point: DVec2) -> Option<usize> {
        let mut smallest: Option<usize> = None;
        for (i, outer) in self.loops.iter().enumerate() {
            let is_smaller = smallest.is_none_or(|j| outer.area < self.loops[j].area);
            if outer.area > 0.0 && is_smaller && holds(&self.flat[outer.points.clone()], point) {
                smallest = Some(i);
            }
        }
        smallest
    }
}

impl fmt::Debug for Triangulation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Triangulation").field("loops", &self.loops).finish_non_exhaustive()
    }
}

/// Returns true if a point is inside a polygon, by the parity of crossings.
fn holds(polygon: &[DVec2], p: DVec2) -> bool {
    let mut inside = false;
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let passes_height = (a.y > p.y) != (b.y > p.y);
        if passes_height && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    inside
}

/// Two axes across a normal.
struct Frame {
    x: DVec3,
    y: DVec3,
}

impl Frame {
    fn new(normal: DVec3) -> Self {
        let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
        Self { x, y }
    }

    fn project(&self, p: DVec3) -> DVec2 {
        DVec2::new(self.x.dot(p), self.y.dot(p))
    }
}
