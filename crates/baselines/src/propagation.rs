//! Vertices inside, and how deep, from where edges pass through faces.
//!
//! The inner end of an edge that leaves the other body is inside, and its depth
//! is a mean of the heights below the faces its edges pass, the closer the
//! heavier. From there both spread along edges that pass through nothing,
//! layer by layer: the depth of a vertex is what its neighbours' is, and the
//! way to them along their direction out. Where surfaces meet at a slant, as at
//! the rim of a lens, depths come out too large by a fourth or so.
//!
//! Source: B. Heidelberger, M. Teschner, R. Keiser, M. Müller and M. Gross,
//! "Consistent penetration depth estimation for deformable collision response",
//! VMV 2004, section 4.

use std::collections::BTreeMap;

use glam::DVec3;
use surface::{Meeting, segment_meets_triangle};

use crate::findings::{PlacedSurface, VertexInside, index};

/// Vertices of each body inside the other, for the faces that cross.
pub(crate) fn inside(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    crossing: &[[u32; 2]],
) -> [Vec<VertexInside>; 2] {
    let turned: Vec<[u32; 2]> = crossing.iter().map(|&[f, g]| [g, f]).collect();
    [inside_one(a, b, crossing), inside_one(b, a, &turned)]
}

/// A passage of an edge through a face.
struct Passage {
    point: DVec3,
    normal: DVec3,
}

/// What is known of a vertex: its depth, and the direction out.
#[derive(Clone, Copy)]
struct Deep {
    depth: f64,
    out: DVec3,
}

fn inside_one(
    body: PlacedSurface<'_>,
    other: PlacedSurface<'_>,
    crossing: &[[u32; 2]],
) -> Vec<VertexInside> {
    let passages = passages(body, other, crossing);
    let mut known: BTreeMap<u32, Deep> = border(body, &passages);
    let mut layer: Vec<u32> = known.keys().copied().collect();
    let neighbours = neighbours(body);
    while !layer.is_empty() {
        let mut next: Vec<u32> = Vec::new();
        for &vertex in &layer {
            let free =
                neighbours[vertex as usize].iter().filter(|(edge, _)| !passages.contains_key(edge));
            next.extend(free.map(|(_, to)| *to).filter(|to| !known.contains_key(to)));
        }
        next.sort_unstable();
        next.dedup();
        let found: Vec<(u32, Deep)> = next
            .iter()
            .map(|&vertex| (vertex, spread(body, vertex, &neighbours[vertex as usize], &known)))
            .collect();
        known.extend(found);
        layer = next;
    }
    known
        .into_iter()
        .map(|(vertex, deep)| VertexInside { vertex, depth: deep.depth.max(0.0) })
        .collect()
}

/// Where the edges of faces that cross pass through the others, by edge.
fn passages(
    body: PlacedSurface<'_>,
    other: PlacedSurface<'_>,
    crossing: &[[u32; 2]],
) -> BTreeMap<u32, Vec<Passage>> {
    let mut pairs: Vec<[u32; 2]> = crossing
        .iter()
        .flat_map(|&[f, g]| body.surface.face_edges()[f as usize].map(|edge| [edge, g]))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let mut passages: BTreeMap<u32, Vec<Passage>> = BTreeMap::new();
    for [edge, face] in pairs {
        let [p, q] = body.surface.edges()[edge as usize].map(|vertex| body.x.at(vertex));
        let [c0, c1, c2] = other.corners(face);
        if segment_meets_triangle([p, q], [c0, c1, c2]) == Meeting::Crossing {
            let normal = (c1 - c0).cross(c2 - c0).normalize_or_zero();
            let share = normal.dot(c0 - p) / normal.dot(q - p);
            let point = p.lerp(q, share.clamp(0.0, 1.0));
            passages.entry(edge).or_default().push(Passage { point, normal });
        }
    }
    passages
}

/// The vertices that edges tell to be inside, with means over these.
fn border(body: PlacedSurface<'_>, passages: &BTreeMap<u32, Vec<Passage>>) -> BTreeMap<u32, Deep> {
    let mut sums: BTreeMap<u32, (f64, Deep)> = BTreeMap::new();
    for (&edge, through) in passages {
        let [p, q] = body.surface.edges()[edge as usize];
        for (vertex, far) in [(p, q), (q, p)] {
            let (from, to) = (body.x.at(vertex), body.x.at(far));
            let first = through.iter().min_by(|x, y| {
                from.distance_squared(x.point).total_cmp(&from.distance_squared(y.point))
            });
            let Some(first) = first.filter(|passage| passage.normal.dot(to - from) > 0.0) else {
                continue;
            };
            let way = first.point - from;
            let weight = 1.0 / way.length_squared().max(f64::MIN_POSITIVE);
            let none = (0.0, Deep { depth: 0.0, out: DVec3::ZERO });
            let (weights, sum) = sums.entry(vertex).or_insert(none);
            *weights += weight;
            sum.depth += weight * way.dot(first.normal);
            sum.out += weight * first.normal;
        }
    }
    let mean = |(weights, sum): (f64, Deep)| Deep {
        depth: sum.depth / weights,
        out: sum.out.normalize_or_zero(),
    };
    sums.into_iter().map(|(vertex, sum)| (vertex, mean(sum))).collect()
}

/// The depth of a vertex from those of its neighbours that are known.
fn spread(
    body: PlacedSurface<'_>,
    vertex: u32,
    neighbours: &[(u32, u32)],
    known: &BTreeMap<u32, Deep>,
) -> Deep {
    let at = body.x.at(vertex);
    let (mut weights, mut depth, mut out) = (0.0, 0.0, DVec3::ZERO);
    for (to, deep) in neighbours.iter().filter_map(|(_, to)| Some((*to, known.get(to)?))) {
        let way = body.x.at(to) - at;
        let weight = 1.0 / way.length_squared().max(f64::MIN_POSITIVE);
        weights += weight;
        depth += weight * (way.dot(deep.out) + deep.depth);
        out += weight * deep.out;
    }
    Deep { depth: depth / weights, out: out.normalize_or_zero() }
}

/// The edges of each vertex and where they lead.
fn neighbours(body: PlacedSurface<'_>) -> Vec<Vec<(u32, u32)>> {
    let mut neighbours = vec![Vec::new(); body.surface.vertex_count()];
    for (edge, &[p, q]) in body.surface.edges().iter().enumerate() {
        neighbours[p as usize].push((index(edge), q));
        neighbours[q as usize].push((index(edge), p));
    }
    neighbours
}
