//! Inspection report of a surface: its defects, each with the place of the first, and its
//! measures.
//!
//! Nothing is repaired and nothing is refused. An operation that needs a property checks
//! it by `require_closed`, `require_manifold` and `require_oriented` of
//! [`TriangleSurface`].

use std::fmt;

use glam::DVec3;

use crate::positions::place_bits;
use crate::predicates::projection_axis;
use crate::{Aabb, Positions, TriangleSurface, mean_edge, triangle};

/// Kind of defect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Defect {
    /// An edge with one face.
    BoundaryEdge,
    /// An edge with one face whose ends are exactly where those of another one are: its vertices are not
    /// welded.
    UnweldedEdge,
    /// An edge with more than two faces.
    NonManifoldEdge,
    /// A direction of an edge that more than one face runs along: neighbors with opposite
    /// orientation.
    MisorientedEdge,
    /// A vertex whose faces are not all connected by edges at it.
    NonManifoldVertex,
    /// A vertex without a face.
    IsolatedVertex,
    /// A vertex with exactly the position of an earlier one.
    DuplicateVertex,
    /// A face that refers to one vertex more than once.
    RepeatedCorner,
    /// A face of three vertices whose positions are exactly collinear.
    ZeroArea,
    /// A face of the same three vertices as an earlier one, in any order.
    DuplicateFace,
}

/// Element of a surface: a vertex, an edge by its ends, or a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Element {
    /// Number of a vertex.
    Vertex(u32),
    /// Vertices that an edge runs from and to.
    Edge([u32; 2]),
    /// Number of a face.
    Face(u32),
}

/// Occurrences of one kind of defect.
///
/// Displays as, for example, `3 boundary edges, the first from vertex 4 to 7 at
/// (1, 2, 0.5)`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Finding {
    /// The kind.
    pub defect: Defect,
    /// Number of occurrences, `>= 1`.
    pub count: usize,
    /// The first element with it, in ascending order.
    pub first: Element,
    /// Position of the vertex, or center of the edge or face.
    pub at: DVec3,
}

/// Report of [`inspect`], in the caller's length unit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inspection {
    /// |V|.
    pub vertices: usize,
    /// |E|.
    pub edges: usize,
    /// |F|.
    pub faces: usize,
    /// The kinds of defects that occur, in the order of [`Defect`].
    #[cfg_attr(feature = "serde", serde(rename = "defects"))]
    pub findings: Vec<Finding>,
    /// Connected components; vertices without a face are none.
    pub components: usize,
    /// Euler characteristic |V| − |E| + |F|, isolated vertices included: 2 for each closed
    /// component without handles.
    #[cfg_attr(feature = "serde", serde(rename = "euler_number"))]
    pub euler: i64,
    /// Enclosed volume, positive where the faces point outward. For a surface that is not
    /// closed: that of the cone over it from its box's center.
    pub volume: f64,
    /// Sum of the faces' areas.
    pub area: f64,
    /// Box around the vertices; `None` without any.
    pub bounds: Option<Aabb>,
    /// Mean length of the edges; 0 without any.
    pub mean_edge: f64,
}

/// Computes a surface's defects and measures.
///
/// ```
/// use surface::{Defect, Element, TriangleSurface, glam::DVec3, inspect};
///
/// // A tetrahedron that lacks a face.
/// let open = TriangleSurface::new(4, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3]])?;
/// let x = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let report = inspect(&open, open.positions(&x)?);
/// assert_eq!(report.count(Defect::BoundaryEdge), 3);
/// assert_eq!(report.findings[0].first, Element::Edge([0, 2]));
/// assert!(!report.closed() && report.manifold() && report.oriented());
/// # Ok::<(), surface::SurfaceError>(())
/// ```
///
/// # Panics
///
/// When `x` was checked against a surface with fewer vertices.
#[must_use]
pub fn inspect(surface: &TriangleSurface, x: Positions<'_>) -> Inspection {
    let bounds = surface.bounds(x);
    let bounds = (!bounds.is_empty()).then_some(bounds);

    // About the center of the box, the cone's volumes lose the fewest digits.
    let (volume, area) = volume_and_area(surface, x, bounds.map_or(DVec3::ZERO, Aabb::center));
    let (vertices, edges) = (surface.vertex_count(), surface.edges().len());
    let faces = surface.faces().len();

    Inspection {
        vertices,
        edges,
        faces,
        findings: findings(surface, x),
        components: surface.component_roots().len(),
        euler: signed(vertices) - signed(edges) + signed(faces),
        volume,
        area,
        bounds,
        mean_edge: mean_edge(surface, x),
    }
}

impl Inspection {
    /// Returns the number of occurrences of a kind of defect.
    #[must_use]
    pub fn count(&self, defect: Defect) -> usize {
        self.findings.iter().find(|finding| finding.defect == defect).map_or(0, |f| f.count)
    }

    /// Returns true if no edge has one face only.
    #[must_use]
    pub fn closed(&self) -> bool {
        self.count(Defect::BoundaryEdge) == 0
    }

    /// Returns true if no edge has more than two faces, and the faces at each vertex are
    /// connected by edges.
    #[must_use]
    pub fn manifold(&self) -> bool {
        self.count(Defect::NonManifoldEdge) == 0 && self.count(Defect::NonManifoldVertex) == 0
    }

    /// Returns true if neighboring faces have the same orientation.
    #[must_use]
    pub fn oriented(&self) -> bool {
        self.count(Defect::MisorientedEdge) == 0
    }
}

impl Defect {
    /// Returns the name in a sentence, in the singular or the plural.
    fn words(self, count: usize) -> &'static str {
        let (one, many) = match self {
            Self::BoundaryEdge => ("boundary edge", "boundary edges"),
            Self::UnweldedEdge => (
                "boundary edge in the place of another (vertices are not welded: merge those at one place)",
                "boundary edges in the place of others (vertices are not welded: merge those at one place)",
            ),
            Self::NonManifoldEdge => ("non-manifold edge", "non-manifold edges"),
            Self::MisorientedEdge => ("misoriented edge", "misoriented edges"),
            Self::NonManifoldVertex => ("non-manifold vertex", "non-manifold vertices"),
            Self::IsolatedVertex => ("isolated vertex", "isolated vertices"),
            Self::DuplicateVertex => ("duplicate vertex", "duplicate vertices"),
            Self::RepeatedCorner => ("face that repeats a vertex", "faces that repeat a vertex"),
            Self::ZeroArea => ("face without area", "faces without area"),
            Self::DuplicateFace => ("duplicate face", "duplicate faces"),
        };
        if count == 1 { one } else { many }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { defect, count, first, at } = self;
        let which = if *count == 1 { "" } else { "the first " };
        write!(f, "{count} {}, {which}", defect.words(*count))?;
        match first {
            Element::Vertex(vertex) => write!(f, "vertex {vertex}")?,
            Element::Edge([from, to]) => write!(f, "from vertex {from} to {to}")?,
            Element::Face(face) => write!(f, "face {face}")?,
        }
        write!(f, " at ({}, {}, {})", at.x, at.y, at.z)
    }
}

fn findings(surface: &TriangleSurface, x: Positions<'_>) -> Vec<Finding> {
    use Element::{Edge, Face, Vertex};

    let ends = |edge: u32| Edge(surface.edges()[edge as usize]);
    let mut report = Report { surface, x, findings: Vec::new() };

    report.add(Defect::BoundaryEdge, surface.boundary_edges().map(ends));
    report.add(Defect::UnweldedEdge, surface.unwelded_edges(x).into_iter().map(ends));
    report.add(Defect::NonManifoldEdge, surface.non_manifold_edges().map(ends));
    report.add(Defect::MisorientedEdge, surface.repeated_half_edges().map(Edge));
    report.add(Defect::NonManifoldVertex, surface.non_manifold_vertices().map(Vertex));
    report.add(Defect::IsolatedVertex, surface.isolated_vertices().map(Vertex));
    report.add(Defect::DuplicateVertex, duplicate_vertices(surface, x).map(Vertex));
    report.add(Defect::RepeatedCorner, surface.faces_with_repeats().map(Face));
    report.add(Defect::ZeroArea, faces_without_area(surface, x).map(Face));
    // Where edges and vertices are manifold, faces of the same corners are a surface by themselves.
    let is_non_manifold = |finding: &Finding| {
        matches!(finding.defect, Defect::NonManifoldEdge | Defect::NonManifoldVertex)
    };
    let max_faces = if report.findings.iter().any(is_non_manifold) { usize::MAX } else { 2 };
    report.add(Defect::DuplicateFace, surface.duplicate_faces(max_faces).map(Face));
    report.findings
}

/// Findings on a surface, under construction.
struct Report<'a> {
    surface: &'a TriangleSurface,
    x: Positions<'a>,
    findings: Vec<Finding>,
}

impl Report<'_> {
    /// Adds a kind of defect, unless it has no offenders.
    fn add(&mut self, defect: Defect, mut offenders: impl Iterator<Item = Element>) {
        let Some(first) = offenders.next() else { return };
        let (count, at) = (1 + offenders.count(), center(self.surface, self.x, first));
        self.findings.push(Finding { defect, count, first, at });
    }
}

/// Computes the center of an element.
fn center(surface: &TriangleSurface, x: Positions<'_>, element: Element) -> DVec3 {
    match element {
        Element::Vertex(vertex) => x.at(vertex),
        Element::Edge([from, to]) => x.at(from).midpoint(x.at(to)),
        Element::Face(face) => {
            x.corners(surface.faces()[face as usize]).into_iter().sum::<DVec3>() / 3.0
        }
    }
}

/// Finds the vertices with the position of an earlier one.
fn duplicate_vertices(surface: &TriangleSurface, x: Positions<'_>) -> impl Iterator<Item = u32> {
    // The high half of a key is mixed from the position, the low half is the vertex.
    let mut keys: Vec<u64> = Vec::with_capacity(surface.vertex_count());
    for vertex in surface.vertices() {
        let mixed = mixed_bits(place_bits(x.at(vertex)));
        keys.push(mixed >> 32 << 32 | u64::from(vertex));
    }
    keys.sort_unstable();

    // Few positions share the half of a key: only these are compared themselves.
    let mut duplicates = Vec::new();
    let mut group: Vec<u32> = Vec::new();
    for keys in keys.chunk_by(|p, q| p >> 32 == q >> 32) {
        if keys.len() == 1 {
            continue;
        }
        group.clear();
        group.extend(keys.iter().map(|&key| low_half(key)));
        group.sort_unstable_by_key(|&vertex| (place_bits(x.at(vertex)), vertex));
        for pair in group.windows(2) {
            if place_bits(x.at(pair[0])) == place_bits(x.at(pair[1])) {
                duplicates.push(pair[1]);
            }
        }
    }
    duplicates.sort_unstable();
    duplicates.into_iter()
}

#[expect(clippy::cast_possible_truncation, reason = "the low half is the number of the vertex")]
fn low_half(key: u64) -> u32 {
    key as u32
}

/// Mixes three words into one, mostly without collisions.
fn mixed_bits([a, b, c]: [u64; 3]) -> u64 {
    /// An odd number whose bits are evenly mixed: 2⁶⁴ divided by the golden ratio.
    const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;

    let mixed = a.wrapping_mul(FACTOR).rotate_left(23) ^ b;
    let mixed = mixed.wrapping_mul(FACTOR).rotate_left(23) ^ c;
    mixed.wrapping_mul(FACTOR)
}

fn faces_without_area(surface: &TriangleSurface, x: Positions<'_>) -> impl Iterator<Item = u32> {
    surface.face_numbers().filter(move |face| {
        let [a, b, c] = surface.faces()[*face as usize];
        let whole = a != b && b != c && c != a;
        whole && projection_axis(x.corners([a, b, c])).is_none()
    })
}

/// Computes the volume of the cone over the faces with apex `center`, and their area.
fn volume_and_area(surface: &TriangleSurface, x: Positions<'_>, center: DVec3) -> (f64, f64) {
    let (mut volume, mut area) = (0.0, 0.0);
    for &face in surface.faces() {
        let corners = x.corners(face);
        let normal = triangle::normal(corners);
        volume += (corners[0] - center).dot(normal);
        area += normal.length();
    }
    (volume / 6.0, area / 2.0)
}

#[expect(clippy::cast_possible_wrap, reason = "there are fewer than 2^33 elements")]
fn signed(count: usize) -> i64 {
    count as i64
}
