//! Boundary of a surface as a chain of edges, and caps that close it.
//!
//! An edge along which as many faces run one way as the other is no boundary, whatever their
//! number; the rest, with their multiplicities, form closed loops. Fanning each connected
//! piece to its center closes the surface: surface and caps together enclose every point a
//! whole number of times.

use std::collections::BTreeMap;

use glam::DVec3;
use surface::{NO_EDGE, Positions, TriangleSurface, UnionFind, triangle};

/// Triangles that close a connected piece of the boundary.
#[derive(Debug)]
pub(super) struct Cap {
    /// Triangles with their multiplicities; they run along the boundary against the surface.
    pub(super) triangles: Vec<([DVec3; 3], i32)>,
    /// Center of a ball around all of them.
    pub(super) center: DVec3,
    /// Radius of that ball.
    pub(super) radius: f64,
    /// Area, each triangle counted by its multiplicity.
    pub(super) area: f64,
}

impl Cap {
    /// Fans the edges of a connected piece to their center.
    fn new(edges: &[([DVec3; 2], i32)]) -> Self {
        let ends = || edges.iter().flat_map(|(ends, _)| *ends);
        let center = 0.5 / crate::num::coordinate(edges.len()) * ends().sum::<DVec3>();
        let radius = ends().map(|p| p.distance(center)).fold(0.0, f64::max);

        let (mut triangles, mut area) = (Vec::with_capacity(edges.len()), 0.0);
        for &([a, b], times) in edges {
            let corners = [b, a, center];
            area += triangle::area(corners) * f64::from(times.abs());
            triangles.push((corners, times));
        }
        Self { triangles, center, radius, area }
    }

    /// Returns the sum of the multiplicities.
    pub(super) fn multiplicity(&self) -> f64 {
        self.triangles.iter().map(|(_, times)| f64::from(times.abs())).sum()
    }
}

/// Boundary chain: directed edges, each with the number of faces that run along it in excess
/// of those that run against it.
#[derive(Debug)]
pub(super) struct Chain {
    edges: Vec<([u32; 2], i32)>,
}

impl Chain {
    /// Computes the boundary chain of a surface, vertices at equal positions taken for one.
    pub(super) fn new(surface: &TriangleSurface, x: Positions<'_>) -> Self {
        let mut excess = vec![0_i32; surface.edges().len()];
        for (corners, edges) in surface.faces().iter().zip(surface.face_edges()) {
            for (k, &edge) in edges.iter().enumerate().filter(|(_, edge)| **edge != NO_EDGE) {
                let is_forward = corners[k] < corners[(k + 1) % 3];
                excess[edge as usize] += if is_forward { 1 } else { -1 };
            }
        }
        let edges = surface.edges().iter().copied().zip(excess);
        Self { edges: welded(edges.filter(|(_, excess)| *excess != 0).collect(), x) }
    }

    /// Returns the number of edges.
    pub(super) fn len(&self) -> usize {
        self.edges.len()
    }

    /// Computes one cap per connected piece, in the order of their smallest vertices.
    pub(super) fn caps(&self, x: Positions<'_>) -> Vec<Cap> {
        if self.edges.is_empty() {
            return Vec::new();
        }
        let mut pieces = UnionFind::new(x.as_slice().len());
        for &([a, b], _) in &self.edges {
            pieces.join(a, b);
        }

        let mut edges_of: BTreeMap<u32, Vec<_>> = BTreeMap::new();
        for &([a, b], times) in &self.edges {
            edges_of.entry(pieces.find(a)).or_default().push(([x.at(a), x.at(b)], times));
        }
        edges_of.into_values().map(|edges| Cap::new(&edges)).collect()
    }
}

/// Takes vertices at equal positions for one, and sums the edges that then coincide.
fn welded(edges: Vec<([u32; 2], i32)>, x: Positions<'_>) -> Vec<([u32; 2], i32)> {
    if edges.is_empty() {
        return edges;
    }
    // Adding zero makes one of the two zeros, which differ in bits only.
    let key = |vertex: u32| (x.at(vertex) + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut vertices: Vec<u32> = edges.iter().flat_map(|(ends, _)| *ends).collect();
    vertices.sort_unstable_by_key(|&vertex| (key(vertex), vertex));
    vertices.dedup();

    let mut representatives = vec![0; x.as_slice().len()];
    for same in vertices.chunk_by(|&a, &b| key(a) == key(b)) {
        for &vertex in same {
            representatives[vertex as usize] = same[0];
        }
    }

    let mut sums: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for (ends, times) in edges {
        let [a, b] = ends.map(|vertex| representatives[vertex as usize]);
        if a != b {
            let (ends, times) = if a < b { ([a, b], times) } else { ([b, a], -times) };
            *sums.entry(ends).or_default() += times;
        }
    }
    sums.into_iter().filter(|(_, times)| *times != 0).collect()
}
