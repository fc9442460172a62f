//! The boundary of a surface as a chain of edges, and caps that close it.
//!
//! An edge along which as many faces run one way as the other is no boundary,
//! whatever their number; what is left over, with its multiplicity, is made of
//! closed loops. Fanning each connected piece to its centre closes the surface:
//! surface and caps together enclose every point a whole number of times.

use std::collections::BTreeMap;

use glam::DVec3;
use surface::{NO_EDGE, Positions, TriangleSurface};

/// A connected piece of the boundary, closed by triangles.
#[derive(Debug)]
pub(crate) struct Cap {
    /// Corners and multiplicity: the cap runs along the boundary against the surface.
    pub(crate) triangles: Vec<([DVec3; 3], i32)>,
    /// Middle of a ball that holds all of them.
    pub(crate) center: DVec3,
    /// Radius of that ball.
    pub(crate) radius: f64,
    /// Area, each triangle counted as often as its multiplicity says.
    pub(crate) area: f64,
}

impl Cap {
    /// Times that all its triangles are counted, together.
    pub(crate) fn multiplicity(&self) -> f64 {
        self.triangles.iter().map(|(_, n)| f64::from(n.abs())).sum()
    }
}

/// Directed edges with the times that faces run along them, more than against them.
#[derive(Debug)]
pub(crate) struct Chain {
    edges: Vec<([u32; 2], i32)>,
}

impl Chain {
    /// Vertices at one and the same position count as one.
    pub(crate) fn new(surface: &TriangleSurface, x: Positions<'_>) -> Self {
        let mut left_over = vec![0_i32; surface.edges().len()];
        for (corners, edges) in surface.faces().iter().zip(surface.face_edges()) {
            for (k, &edge) in edges.iter().enumerate().filter(|(_, e)| **e != NO_EDGE) {
                let forward = corners[k] < corners[(k + 1) % 3];
                left_over[edge as usize] += if forward { 1 } else { -1 };
            }
        }
        let pairs = surface.edges().iter().copied().zip(left_over);
        let edges: Vec<_> = pairs.filter(|(_, n)| *n != 0).collect();
        Self { edges: welded(edges, x) }
    }

    /// Edges of the boundary.
    pub(crate) fn len(&self) -> usize {
        self.edges.len()
    }

    /// One cap for each connected piece, in the order of its first edge.
    pub(crate) fn caps(&self, x: Positions<'_>) -> Vec<Cap> {
        let mut pieces = Pieces::default();
        for &([a, b], _) in &self.edges {
            pieces.join(a, b);
        }
        let mut by_piece: BTreeMap<u32, Vec<([DVec3; 2], i32)>> = BTreeMap::new();
        for &([a, b], n) in &self.edges {
            by_piece.entry(pieces.find(a)).or_default().push(([x.at(a), x.at(b)], n));
        }
        by_piece.into_values().map(|edges| cap(&edges)).collect()
    }
}

/// Takes vertices at one position for one and sums the edges that then coincide.
fn welded(edges: Vec<([u32; 2], i32)>, x: Positions<'_>) -> Vec<([u32; 2], i32)> {
    let mut vertices: Vec<u32> = edges.iter().flat_map(|(ends, _)| *ends).collect();
    // Adding zero makes one of the two zeros, which differ in bits only.
    let key = |v: u32| (x.at(v) + DVec3::ZERO).to_array().map(f64::to_bits);
    vertices.sort_unstable_by_key(|&v| (key(v), v));
    vertices.dedup();
    let mut first = BTreeMap::new();
    let mut representative = 0;
    for (i, &v) in vertices.iter().enumerate() {
        if i == 0 || key(vertices[i - 1]) != key(v) {
            representative = v;
        }
        first.insert(v, representative);
    }
    let mut sums: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for ([a, b], n) in edges {
        let [a, b] = [first[&a], first[&b]];
        if a != b {
            let (ends, n) = if a < b { ([a, b], n) } else { ([b, a], -n) };
            *sums.entry(ends).or_default() += n;
        }
    }
    sums.into_iter().filter(|(_, n)| *n != 0).collect()
}

/// Connected sets of vertices, each named by its least.
#[derive(Default)]
struct Pieces {
    parent: BTreeMap<u32, u32>,
}

impl Pieces {
    fn find(&mut self, v: u32) -> u32 {
        let mut root = v;
        while let Some(&up) = self.parent.get(&root) {
            root = up;
        }
        if root != v {
            self.parent.insert(v, root);
        }
        root
    }

    fn join(&mut self, a: u32, b: u32) {
        let [a, b] = [self.find(a), self.find(b)];
        if a != b {
            self.parent.insert(a.max(b), a.min(b));
        }
    }
}

fn cap(edges: &[([DVec3; 2], i32)]) -> Cap {
    let ends = || edges.iter().flat_map(|(ends, _)| *ends);
    let weight = 0.5 / crate::num::coordinate(edges.len());
    let center = weight * ends().sum::<DVec3>();
    let radius = ends().map(|p| p.distance(center)).fold(0.0, f64::max);
    let triangles: Vec<_> = edges.iter().map(|&([a, b], n)| ([b, a, center], n)).collect();
    let doubled = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
    let area = triangles.iter().map(|&(t, n)| 0.5 * doubled(t) * f64::from(n.abs())).sum();
    Cap { triangles, center, radius, area }
}
