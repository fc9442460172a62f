//! Closed surface under edge collapses.

use glam::DVec3;
use surface::{closest_on_triangle, triangle};

/// Cosine of the largest angle by which a collapse may rotate a face: 66°.
///
/// Larger, and coarse surfaces keep faces whose rotation the curvature requires; smaller, and
/// faces fold over step by step.
const MIN_COSINE: f64 = 0.4;

/// Smallest [`shape`] of a face that a collapse may make.
///
/// Smaller, and needles appear whose normals are meaningless; larger, and flat parts keep
/// vertices that they do not need.
const MIN_SHAPE: f64 = 0.06;

/// Faces that lose vertices, with the star of each vertex.
#[derive(Clone)]
pub(crate) struct Mesh<'a> {
    x: &'a [DVec3],
    faces: Vec<[u32; 3]>,
    /// Faces at each vertex.
    stars: Vec<Vec<u32>>,
    /// Per face, the vertices that were removed near it: each is at the nearest face of those around
    /// the last collapse there.
    removed: Vec<Vec<u32>>,
    /// Stamp of the last query that marked a vertex.
    marks: Vec<u32>,
    stamp: u32,
}

impl<'a> Mesh<'a> {
    pub(crate) fn new(faces: &[[u32; 3]], x: &'a [DVec3]) -> Self {
        let mut stars = vec![Vec::new(); x.len()];
        for (face, corners) in (0_u32..).zip(faces) {
            for &vertex in corners {
                stars[vertex as usize].push(face);
            }
        }
        let removed = vec![Vec::new(); faces.len()];
        Self { x, faces: faces.to_vec(), stars, removed, marks: vec![0; x.len()], stamp: 0 }
    }

    /// Returns the vertices that share an edge with `v`, each once.
    pub(crate) fn neighbors(&self, v: u32) -> impl Iterator<Item = u32> {
        self.stars[v as usize].iter().map(move |&face| self.after(face, v))
    }

    /// Returns true if `v` may move into its neighbor `u`: the surface stays a closed
    /// manifold, and no face turns over or becomes a needle.
    pub(crate) fn may_collapse(&mut self, v: u32, u: u32) -> bool {
        self.keeps_topology(v, u) && self.keeps_shape(v, u)
    }

    /// Checks the link condition: the ends of the edge have exactly two common neighbors, and
    /// are not part of a tetrahedron.
    ///
    /// Source: T. K. Dey, H. Edelsbrunner, S. Guha and D. V. Nekhayev, "Topology Preserving
    /// Edge Contraction", Publ. Inst. Math. 66, 1999.
    fn keeps_topology(&mut self, v: u32, u: u32) -> bool {
        let (star_v, star_u) = (&self.stars[v as usize], &self.stars[u as usize]);
        if star_v.len() == 3 && star_u.len() == 3 {
            return false;
        }

        // Mark the neighbors of one end, and count the marks around the other.
        self.stamp += 1;
        for &face in star_v {
            let neighbor = self.after(face, v);
            self.marks[neighbor as usize] = self.stamp;
        }
        let mut common = 0;
        for neighbor in self.neighbors(u) {
            common += usize::from(self.marks[neighbor as usize] == self.stamp);
        }
        common == 2
    }

    /// Checks that no face at `v` turns over or becomes a needle when `v` moves to `u`.
    fn keeps_shape(&self, v: u32, u: u32) -> bool {
        let to = self.x[u as usize];
        for &face in &self.stars[v as usize] {
            let corners = self.faces[face as usize];
            if corners.contains(&u) {
                continue; // it vanishes
            }
            // Compare the face before and after the move.
            let old = corners.map(|w| self.x[w as usize]);
            let new = corners.map(|w| if w == v { to } else { self.x[w as usize] });
            let (before, after) = (triangle::normal(old), triangle::normal(new));
            let length = (before.length_squared() * after.length_squared()).sqrt();

            if before.dot(after) < MIN_COSINE * length {
                return false;
            }
            let new_shape = shape(new, after);
            if new_shape < MIN_SHAPE && new_shape < shape(old, before) {
                return false;
            }
        }
        true
    }

    /// Computes the largest squared distance of a removed vertex from the faces that a collapse
    /// leaves around it, that of `v` included.
    pub(crate) fn squared_deviation(&self, v: u32, u: u32) -> f64 {
        let mut max_squared = self.nearest_after(v, u, v, 0.0).1;
        for &face in &self.stars[v as usize] {
            for &vertex in &self.removed[face as usize] {
                max_squared = max_squared.max(self.nearest_after(v, u, vertex, max_squared).1);
            }
        }
        max_squared
    }

    /// Finds the face nearest to a removed vertex among those around `v` after its move to `u`, with
    /// the squared distance, or one within a squared distance that suffices.
    fn nearest_after(&self, v: u32, u: u32, vertex: u32, sufficient: f64) -> (u32, f64) {
        let (to, p) = (self.x[u as usize], self.x[vertex as usize]);
        let mut nearest = (u32::MAX, f64::INFINITY);
        for &face in &self.stars[v as usize] {
            let corners = self.faces[face as usize];
            if corners.contains(&u) {
                continue; // it vanishes
            }
            let corners = corners.map(|w| if w == v { to } else { self.x[w as usize] });
            let squared = closest_on_triangle(p, corners).point.distance_squared(p);
            if squared < nearest.1 {
                nearest = (face, squared);
                if squared <= sufficient {
                    break;
                }
            }
        }
        nearest
    }

    /// Moves `v` into its neighbor `u`, and vertices that were removed near it to the nearest of the
    /// faces that are left.
    pub(crate) fn collapse(&mut self, v: u32, u: u32) {
        let mut removed = vec![v];
        for &face in &self.stars[v as usize] {
            removed.extend_from_slice(&self.removed[face as usize]);
        }
        let nearest: Vec<u32> =
            removed.iter().map(|&vertex| self.nearest_after(v, u, vertex, 0.0).0).collect();
        for &face in &self.stars[v as usize] {
            self.removed[face as usize].clear();
        }
        for (vertex, face) in removed.into_iter().zip(nearest) {
            self.removed[face as usize].push(vertex);
        }
        self.contract(v, u);
    }

    /// Moves `v` into its neighbor `u`. The two faces at their edge vanish.
    pub(crate) fn contract(&mut self, v: u32, u: u32) {
        for face in std::mem::take(&mut self.stars[v as usize]) {
            let corners = self.faces[face as usize];
            if corners.contains(&u) {
                for w in corners {
                    self.stars[w as usize].retain(|f| *f != face);
                }
            } else {
                self.faces[face as usize] = corners.map(|w| if w == v { u } else { w });
                self.stars[u as usize].push(face);
            }
        }
    }

    /// Returns the corner that follows `v` around a face that has it.
    fn after(&self, face: u32, v: u32) -> u32 {
        match self.faces[face as usize] {
            [a, b, _] if a == v => b,
            [_, b, c] if b == v => c,
            [a, ..] => a,
        }
    }
}

/// Computes the ratio of area to the sum of the squared edges: 1 for an equilateral triangle,
/// 0 for a needle or a point.
fn shape([a, b, c]: [DVec3; 3], normal: DVec3) -> f64 {
    let squares = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    let equilateral = 2.0 * 3.0_f64.sqrt();
    if squares > 0.0 { equilateral * normal.length() / squares } else { 0.0 }
}
