//! A closed surface while its edges collapse.

use glam::DVec3;

/// Cosine of the most that a face may turn in one collapse: 66°.
///
/// Larger, and coarse surfaces keep faces that only the curvature asks for to be
/// turned; smaller, and faces fold over step by step.
const MIN_COSINE: f64 = 0.4;

/// Least shape of a face that a collapse may make, where one is 1 for an equal-sided
/// triangle and 0 for a needle.
///
/// Smaller, and needles appear whose normals mean nothing; larger, and flat parts
/// keep vertices that they do not need.
const MIN_SHAPE: f64 = 0.06;

/// Faces that vertices vanish from, and which of them meet at each vertex.
pub(crate) struct Mesh<'a> {
    pub(crate) x: &'a [DVec3],
    pub(crate) faces: Vec<[u32; 3]>,
    stars: Vec<Vec<u32>>,
    /// For each vertex the last question in which it was marked.
    marks: Vec<u32>,
    question: u32,
}

impl<'a> Mesh<'a> {
    pub(crate) fn new(faces: &[[u32; 3]], x: &'a [DVec3]) -> Self {
        let mut stars = vec![Vec::new(); x.len()];
        for (face, corners) in (0_u32..).zip(faces) {
            for &vertex in corners {
                stars[vertex as usize].push(face);
            }
        }
        Self { x, faces: faces.to_vec(), stars, marks: vec![0; x.len()], question: 0 }
    }

    /// Vertices that share an edge with `v`, each once, into `out`.
    pub(crate) fn neighbors(&self, v: u32, out: &mut Vec<u32>) {
        out.clear();
        out.extend(self.stars[v as usize].iter().map(|f| after(self.faces[*f as usize], v)));
    }

    /// Whether `v` may move into its neighbor `u`: the surface stays a closed
    /// manifold, and no face turns over or becomes a needle.
    pub(crate) fn may_collapse(&mut self, v: u32, u: u32) -> bool {
        self.keeps_topology(v, u) && self.keeps_shape(v, u)
    }

    /// The link condition: the ends of the edge have the two neighbors in common
    /// that its faces show, and are not half of a tetrahedron.
    ///
    /// Source: T. K. Dey, H. Edelsbrunner, S. Guha and D. V. Nekhayev, "Topology
    /// Preserving Edge Contraction", Publ. Inst. Math. 66, 1999.
    fn keeps_topology(&mut self, v: u32, u: u32) -> bool {
        let (star_v, star_u) = (&self.stars[v as usize], &self.stars[u as usize]);
        if star_v.len() == 3 && star_u.len() == 3 {
            return false;
        }
        self.question += 1;
        for &face in star_v {
            self.marks[after(self.faces[face as usize], v) as usize] = self.question;
        }
        let is_common =
            |f: &u32| self.marks[after(self.faces[*f as usize], u) as usize] == self.question;
        star_u.iter().filter(|f| is_common(f)).count() == 2
    }

    fn keeps_shape(&self, v: u32, u: u32) -> bool {
        let to = self.x[u as usize];
        self.stars[v as usize].iter().all(|&face| {
            let corners = self.faces[face as usize];
            if corners.contains(&u) {
                return true; // it vanishes
            }
            let old = corners.map(|w| self.x[w as usize]);
            let new = corners.map(|w| if w == v { to } else { self.x[w as usize] });
            let (before, after) = (normal(old), normal(new));
            let length = (before.length_squared() * after.length_squared()).sqrt();
            before.dot(after) >= MIN_COSINE * length
                && shape(new, after) >= MIN_SHAPE.min(shape(old, before))
        })
    }

    /// Moves `v` into its neighbor `u`: the two faces at their edge vanish.
    pub(crate) fn collapse(&mut self, v: u32, u: u32) {
        let star = std::mem::take(&mut self.stars[v as usize]);
        for face in star {
            let corners = self.faces[face as usize];
            if corners.contains(&u) {
                for w in corners.into_iter().filter(|w| *w != v) {
                    self.stars[w as usize].retain(|f| *f != face);
                }
            } else {
                self.faces[face as usize] = corners.map(|w| if w == v { u } else { w });
                self.stars[u as usize].push(face);
            }
        }
    }
}

/// The corner that follows `v` around a face that has it.
fn after([a, b, c]: [u32; 3], v: u32) -> u32 {
    if a == v {
        b
    } else if b == v {
        c
    } else {
        a
    }
}

/// Twice the area, outward.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Area over the sum of the edges' squares, 1 for equal sides; 0 without edges.
fn shape([a, b, c]: [DVec3; 3], normal: DVec3) -> f64 {
    let squares = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    let equal_sided = 2.0 * 3.0_f64.sqrt();
    if squares > 0.0 { equal_sided * normal.length() / squares } else { 0.0 }
}
