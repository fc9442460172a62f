//! Propagation of penetration depths from the edges that pass through faces.
//!
//! The inner end of an edge that leaves the other surface is inside. Its depth is the mean of its
//! heights below the faces that its edges pass, weighted by inverse squared distance. From these
//! border vertices, depths spread layer by layer along edges that pass through nothing: the depth
//! of a vertex is the mean of its neighbors' depths plus the way to them along their direction
//! out. Where surfaces meet at a slant, as at the rim of a lens, depths are a fourth too large.
//!
//! Source: B. Heidelberger, M. Teschner, R. Keiser, M. Müller and M. Gross, "Consistent
//! penetration depth estimation for deformable collision response", VMV 2004, section 4.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use surface::triangle::unit_normal;
use surface::{Meeting, TotalF64, segment_meets_triangle};

use crate::findings::{PlacedSurface, VertexInside, index};

/// Finds the vertices of each surface inside the other, from the faces that cross.
pub(crate) fn vertices_inside(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    crossing: &[[u32; 2]],
) -> [Vec<VertexInside>; 2] {
    let mut reversed = crossing.to_vec();
    for pair in &mut reversed {
        pair.reverse();
    }
    [of_one_surface(a, b, crossing), of_one_surface(b, a, &reversed)]
}

/// Point where an edge passes through a face.
struct Passage {
    point: DVec3,
    /// Unit normal of the face.
    normal: DVec3,
}

/// Depth of a vertex, and the direction out.
#[derive(Clone, Copy)]
struct Penetration {
    depth: f64,
    out: DVec3,
}

/// Weighted mean of penetrations.
#[derive(Clone, Copy, Default)]
struct WeightedMean {
    weight: f64,
    depth: f64,
    out: DVec3,
}

impl WeightedMean {
    /// Adds a penetration at a vector, weighted by the inverse square of its length.
    fn add(&mut self, arm: DVec3, depth: f64, out: DVec3) {
        let weight = 1.0 / arm.length_squared().max(f64::MIN_POSITIVE);
        self.weight += weight;
        self.depth += weight * depth;
        self.out += weight * out;
    }

    fn finish(self) -> Penetration {
        Penetration { depth: self.depth / self.weight, out: self.out.normalize_or_zero() }
    }
}

fn of_one_surface(
    body: PlacedSurface<'_>,
    other: PlacedSurface<'_>,
    crossing: &[[u32; 2]],
) -> Vec<VertexInside> {
    let passages = passages(body, other, crossing);
    let neighbors = neighbors(body);
    let mut known = border(body, &passages);
    let mut layer: Vec<u32> = known.keys().copied().collect();

    while !layer.is_empty() {
        // The next layer lies behind edges that pass through nothing.
        let mut next: Vec<u32> = Vec::new();
        for &vertex in &layer {
            for (edge, to) in &neighbors[vertex as usize] {
                if !passages.contains_key(edge) && !known.contains_key(to) {
                    next.push(*to);
                }
            }
        }
        next.sort_unstable();
        next.dedup();

        // All of it follows from earlier layers: its own vertices are added at once.
        let mut found = Vec::new();
        for &vertex in &next {
            let neighbors = &neighbors[vertex as usize];
            found.push((vertex, spread_from(body, vertex, neighbors, &known)));
        }
        known.extend(found);
        layer = next;
    }

    let mut inside = Vec::new();
    for (vertex, Penetration { depth, .. }) in known {
        inside.push(VertexInside { vertex, depth: depth.max(0.0) });
    }
    inside
}

/// Finds the passages of the edges of crossing faces through the other faces, by edge.
fn passages(
    body: PlacedSurface<'_>,
    other: PlacedSurface<'_>,
    crossing: &[[u32; 2]],
) -> BTreeMap<u32, Vec<Passage>> {
    // Two faces share an edge, which is tested once.
    let mut pairs = BTreeSet::new();
    for &[face, other] in crossing {
        for edge in body.surface.face_edges()[face as usize] {
            pairs.insert([edge, other]);
        }
    }

    let mut passages: BTreeMap<u32, Vec<Passage>> = BTreeMap::new();
    for [edge, face] in pairs {
        let [p, q] = body.surface.edges()[edge as usize].map(|vertex| body.x.at(vertex));
        let corners = other.corners(face);
        if segment_meets_triangle([p, q], corners) == Meeting::Crossing {
            let normal = unit_normal(corners);
            let share = normal.dot(corners[0] - p) / normal.dot(q - p);
            let point = p.lerp(q, share.clamp(0.0, 1.0));
            passages.entry(edge).or_default().push(Passage { point, normal });
        }
    }
    passages
}

/// Finds the vertices at the inner ends of edges, with means over their passages.
fn border(
    body: PlacedSurface<'_>,
    passages: &BTreeMap<u32, Vec<Passage>>,
) -> BTreeMap<u32, Penetration> {
    let mut means: BTreeMap<u32, WeightedMean> = BTreeMap::new();
    for (&edge, passages) in passages {
        let [p, q] = body.surface.edges()[edge as usize];
        for (vertex, far) in [(p, q), (q, p)] {
            let (from, to) = (body.x.at(vertex), body.x.at(far));
            let squared = |passage: &&Passage| TotalF64(from.distance_squared(passage.point));
            let Some(first) = passages.iter().min_by_key(squared) else { continue };

            // Inside, if the edge leaves the other surface at the first passage.
            if first.normal.dot(to - from) > 0.0 {
                let arm = first.point - from;
                means.entry(vertex).or_default().add(arm, arm.dot(first.normal), first.normal);
            }
        }
    }
    means.into_iter().map(|(vertex, mean)| (vertex, mean.finish())).collect()
}

/// Computes the penetration of a vertex from its neighbors with one.
fn spread_from(
    body: PlacedSurface<'_>,
    vertex: u32,
    neighbors: &[(u32, u32)],
    known: &BTreeMap<u32, Penetration>,
) -> Penetration {
    let mut mean = WeightedMean::default();
    for (_, to) in neighbors {
        if let Some(Penetration { depth, out }) = known.get(to) {
            let arm = body.x.at(*to) - body.x.at(vertex);
            mean.add(arm, arm.dot(*out) + depth, *out);
        }
    }
    mean.finish()
}

/// Returns the edges of each vertex with the vertices at their other ends.
fn neighbors(body: PlacedSurface<'_>) -> Vec<Vec<(u32, u32)>> {
    let mut neighbors = vec![Vec::new(); body.surface.vertex_count()];
    for (edge, &[p, q]) in body.surface.edges().iter().enumerate() {
        neighbors[p as usize].push((index(edge), q));
        neighbors[q as usize].push((index(edge), p));
    }
    neighbors
}
