//! Boundary of a surface as a chain of edges, and caps that close it.
//!
//! An edge along which as many faces run one way as the other is no boundary, whatever their
//! number; the rest, with their multiplicities, form closed loops. Fanning each connected
//! piece to an apex near its center closes the surface: surface and caps together enclose every
//! point a whole number of times.

use std::collections::BTreeMap;

use glam::DVec3;
use surface::{NO_EDGE, Positions, TriangleSurface, UnionFind, triangle};

/// Offset of the apex of a cap from the center of its edges, in radii of the cap.
///
/// On an edge of a triangle its solid angle is nothing but rounding. Fanned to their center, the
/// edges of a surface along the axes would lead through nodes. These numbers are in no simple ratio
/// to each other nor to coordinates.
const APEX: DVec3 = DVec3::new(0.014_142_135_6, 0.022_360_679_8, 0.017_320_508_1);

/// Triangles that close a connected piece of the boundary.
#[derive(Debug)]
pub(super) struct Cap {
    /// Triangles with their multiplicities, whose last corner is the apex; they run along the
    /// boundary against the surface.
    pub(super) triangles: Vec<([DVec3; 3], i32)>,
    /// Center of the edges, and of a ball around all triangles.
    pub(super) center: DVec3,
    /// Radius of that ball.
    pub(super) radius: f64,
    /// Area, each triangle counted by its multiplicity.
    pub(super) area: f64,
}

impl Cap {
    /// Fans the edges of a connected piece to an apex near their center.
    fn new(edges: &[([DVec3; 2], i32)]) -> Self {
        let mut center = DVec3::ZERO;
        for ([a, b], _) in edges {
            center = center + *a + *b;
        }
        center *= 0.5 / crate::num::coordinate(edges.len());

        let mut cap = Self { triangles: Vec::new(), center, radius: 0.0, area: 0.0 };
        for ([a, b], _) in edges {
            cap.radius = cap.radius.max(a.distance(center)).max(b.distance(center));
        }
        let apex = center + cap.radius * APEX;
        for &([a, b], times) in edges {
            let corners = [b, a, apex];
            cap.area += triangle::area(corners) * f64::from(times.abs());
            cap.triangles.push((corners, times));
        }
        cap
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
        // Faces that run along an edge in opposite directions cancel.
        let mut excess = vec![0_i32; surface.edges().len()];
        for (corners, edges) in surface.faces().iter().zip(surface.face_edges()) {
            for (k, &edge) in edges.iter().enumerate() {
                if edge != NO_EDGE {
                    let is_forward = corners[k] < corners[(k + 1) % 3];
                    excess[edge as usize] += if is_forward { 1 } else { -1 };
                }
            }
        }

        let mut edges = Vec::new();
        for (&ends, excess) in surface.edges().iter().zip(excess) {
            if excess != 0 {
                edges.push((ends, excess));
            }
        }
        Self { edges: welded(edges, x) }
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
        edges_of.values().map(|edges| Cap::new(edges)).collect()
    }
}

/// Takes vertices at equal positions for one, and sums the edges that then coincide.
fn welded(edges: Vec<([u32; 2], i32)>, x: Positions<'_>) -> Vec<([u32; 2], i32)> {
    // The smallest vertex at each position stands for all of them.
    let mut smallest_at = BTreeMap::new();
    for vertex in edges.iter().flat_map(|(ends, _)| *ends) {
        let smallest = smallest_at.entry(position_bits(x.at(vertex))).or_insert(vertex);
        *smallest = vertex.min(*smallest);
    }

    let mut sums: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for (ends, times) in edges {
        let [a, b] = ends.map(|vertex| smallest_at[&position_bits(x.at(vertex))]);
        if a != b {
            let (ends, times) = if a < b { ([a, b], times) } else { ([b, a], -times) };
            *sums.entry(ends).or_default() += times;
        }
    }
    sums.into_iter().filter(|(_, times)| *times != 0).collect()
}

/// Returns equal bits for equal positions.
fn position_bits(p: DVec3) -> [u64; 3] {
    // Adding zero makes one of the two zeros, which differ in bits only.
    (p + DVec3::ZERO).to_array().map(f64::to_bits)
}
