//! Simplex surfaces (2-simplex meshes): every vertex has three neighbors.
//!
//! A simplex surface is the dual of a triangulation: one vertex per triangle, one
//! polygon per vertex, and as many edges. Three neighbors give every vertex a frame
//! and one curvature, which makes such surfaces convenient to deform.
//!
//! Source: H. Delingette, "General Object Reconstruction Based on Simplex
//! Meshes", International Journal of Computer Vision 32(2), 1999, section 2.

use glam::DVec3;

use crate::csr::Csr;
use crate::triangle_surface::{MAX_COUNT, check_count};
use crate::{Positions, SimplexError, SurfaceError, TriangleSurface};

/// Placeholder for a neighbor or a polygon that a vertex on the border lacks.
pub const NO_NEIGHBOR: u32 = u32::MAX;

/// Vertices and oriented polygons, of which at most three meet at a vertex: the
/// connectivity, without positions.
///
/// ```
/// use surface::{SimplexSurface, TriangleSurface};
///
/// let tetrahedron = TriangleSurface::new(4, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])?;
/// let dual = SimplexSurface::dual_of(&tetrahedron)?;
/// assert_eq!((dual.vertex_count(), dual.polygon_count()), (4, 4));
/// assert_eq!(dual.polygon(0), [0, 1, 3]);
/// assert_eq!(dual.dual()?, tetrahedron);
/// # Ok::<(), surface::SimplexError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SimplexSurface {
    polygons: Csr,
    neighbors: Vec<[u32; 3]>,
    vertex_polygons: Vec<[u32; 3]>,
}

impl SimplexSurface {
    /// Finds the neighbors of `vertex_count` vertices in `polygons`.
    ///
    /// Polygons run counter-clockwise from outside. Three of them meet at an interior
    /// vertex, two or one on the border.
    ///
    /// # Errors
    ///
    /// - [`SimplexError::Surface`] when 32-bit indices cannot number the vertices
    ///   or the corners of the polygons.
    /// - [`SimplexError::ShortPolygon`] and [`SimplexError::VertexOutOfRange`]
    ///   with the first such polygon.
    /// - [`SimplexError::NotSimplex`] with the first vertex whose polygons are
    ///   none, more than three, or not consecutive around it.
    pub fn new(vertex_count: usize, polygons: &[Vec<u32>]) -> Result<Self, SimplexError> {
        let corners = polygons.iter().map(Vec::len).fold(0, usize::saturating_add);
        check_count("vertices", vertex_count, MAX_COUNT)?;
        check_count("corners of polygons", corners, MAX_COUNT)?;
        check_polygons(vertex_count, polygons)?;
        Self::with_polygons(vertex_count, Csr::from_rows(polygons))
    }

    /// Returns the dual of a triangulation: vertex `k` is dual to face `k`; polygon `k` is
    /// dual to vertex `k`, and begins with its first face.
    ///
    /// # Errors
    ///
    /// - [`SimplexError::Surface`] for a surface that is not closed, manifold and
    ///   oriented.
    /// - [`SimplexError::ShortPolygon`] for a vertex with fewer than three faces.
    /// - [`SimplexError::NotSimplex`] for a face that repeats a vertex.
    pub fn dual_of(surface: &TriangleSurface) -> Result<Self, SimplexError> {
        surface.require_closed()?;
        surface.require_manifold()?;
        surface.require_oriented()?;
        if let Some(face) = surface.faces_with_repeats().next() {
            return Err(SimplexError::NotSimplex { vertex: face as usize, polygons: 3 });
        }
        let rings: Vec<Vec<u32>> = surface.vertices().map(|v| ring(surface, v)).collect();
        Self::new(surface.faces().len(), &rings)
    }

    /// Returns the triangulation whose dual this is: face `k` is dual to vertex `k`, and
    /// begins with its smallest corner.
    ///
    /// Exactly the triangulation that [`dual_of`](Self::dual_of) was given, up to
    /// the corner at which each face begins.
    ///
    /// # Errors
    ///
    /// - [`SimplexError::Border`] with the first vertex of fewer than three
    ///   polygons.
    /// - [`SimplexError::Surface`] as [`TriangleSurface::new`].
    pub fn dual(&self) -> Result<TriangleSurface, SimplexError> {
        for (vertex, polygons) in self.vertex_polygons.iter().enumerate() {
            if let Some(polygons) = polygons.iter().position(|p| *p == NO_NEIGHBOR) {
                return Err(SimplexError::Border { vertex, polygons });
            }
        }
        Ok(TriangleSurface::new(self.polygon_count(), self.vertex_polygons.clone())?)
    }

    /// Checks that `x` holds one finite position per vertex.
    ///
    /// # Errors
    ///
    /// As [`TriangleSurface::positions`].
    pub fn positions<'a>(&self, x: &'a [DVec3]) -> Result<Positions<'a>, SurfaceError> {
        Positions::new(self.vertex_count(), x)
    }

    /// Returns |V|.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.neighbors.len()
    }

    /// Returns |P|, the number of polygons.
    #[must_use]
    pub fn polygon_count(&self) -> usize {
        self.polygons.iter().len()
    }

    /// Returns the vertices of a polygon, counter-clockwise from outside.
    ///
    /// # Panics
    ///
    /// When there is no such polygon.
    #[must_use]
    pub fn polygon(&self, polygon: u32) -> &[u32] {
        self.polygons.row(polygon)
    }

    /// Returns the neighbors of the vertices, |V| × 3, counter-clockwise from outside;
    /// [`NO_NEIGHBOR`] last where a vertex on the border has two.
    #[must_use]
    pub fn neighbors(&self) -> &[[u32; 3]] {
        &self.neighbors
    }

    /// Returns the polygons at the vertices, |V| × 3: the `k`th lies between the `k`th
    /// neighbor and the next. The smallest is first at an interior vertex, and
    /// [`NO_NEIGHBOR`] last on the border.
    #[must_use]
    pub fn vertex_polygons(&self) -> &[[u32; 3]] {
        &self.vertex_polygons
    }

    pub(crate) fn polygons(&self) -> &Csr {
        &self.polygons
    }

    fn with_polygons(vertex_count: usize, polygons: Csr) -> Result<Self, SimplexError> {
        // Each polygon is a sector about each of its vertices.
        let mut sectors = vec![Sectors::NONE; vertex_count];
        for (k, polygon) in (0..).zip(polygons.iter()) {
            for (j, &vertex) in polygon.iter().enumerate() {
                let next = polygon[(j + 1) % polygon.len()];
                let previous = polygon[(j + polygon.len() - 1) % polygon.len()];
                sectors[vertex as usize].push(Sector { polygon: k, from: next, to: previous });
            }
        }

        // Neighbors follow from the sectors in order.
        let mut neighbors = Vec::with_capacity(vertex_count);
        let mut vertex_polygons = Vec::with_capacity(vertex_count);
        for (vertex, sectors) in sectors.iter().enumerate() {
            let not_simplex = SimplexError::NotSimplex { vertex, polygons: sectors.count };
            let [first, second, third] = sectors.in_order().ok_or(not_simplex)?;
            neighbors.push([first.from, first.to, second.to]);
            vertex_polygons.push([first.polygon, second.polygon, third.polygon]);
        }
        Ok(Self { polygons, neighbors, vertex_polygons })
    }
}

/// Sector of a polygon about one of its vertices: counter-clockwise from the next vertex
/// to the previous one.
#[derive(Clone, Copy, Debug)]
struct Sector {
    polygon: u32,
    from: u32,
    to: u32,
}

const NO_SECTOR: Sector = Sector { polygon: NO_NEIGHBOR, from: NO_NEIGHBOR, to: NO_NEIGHBOR };

/// Sectors about one vertex; only the number is kept of more than three.
#[derive(Clone, Copy, Debug)]
struct Sectors {
    first: [Sector; 3],
    count: usize,
}

impl Sectors {
    const NONE: Self = Self { first: [NO_SECTOR; 3], count: 0 };

    fn push(&mut self, sector: Sector) {
        if let Some(place) = self.first.get_mut(self.count) {
            *place = sector;
        }
        self.count += 1;
    }

    /// Returns the sectors counter-clockwise; `None` unless three close a ring, or two or
    /// one are consecutive and open.
    fn in_order(&self) -> Option<[Sector; 3]> {
        let (mut order, count) = (self.first, self.count);
        if !(1..=3).contains(&count) || order[..count].iter().any(|s| s.from == s.to) {
            return None;
        }

        // A ring begins with the sector given first, an open chain with the one that
        // follows no other.
        if count == 2 && order[1].to == order[0].from {
            order.swap(0, 1);
        }
        if count == 3 && order[1].from != order[0].to {
            order.swap(1, 2);
        }
        let consecutive = order[..count].windows(2).all(|pair| pair[0].to == pair[1].from);

        let closes = order[count - 1].to == order[0].from;
        let whole = closes == (count == 3);
        let repeats = count == 3 && order[1].polygon == order[2].polygon;
        (consecutive && whole && !repeats).then_some(order)
    }
}

/// Returns the faces about a vertex of a closed oriented manifold, counter-clockwise from
/// the first; empty where there is none.
fn ring(surface: &TriangleSurface, vertex: u32) -> Vec<u32> {
    let faces = surface.vertex_faces(vertex);
    let Some(&first) = faces.first() else { return Vec::new() };
    let mut ring = vec![first];

    while ring.len() < faces.len() {
        // The next face is across the edge that ends at the vertex.
        let face = ring[ring.len() - 1];
        let [a, b, _] = surface.faces()[face as usize];
        let [ab, bc, ca] = surface.face_edges()[face as usize];
        let edge = if a == vertex {
            ca
        } else if b == vertex {
            ab
        } else {
            bc
        };
        match surface.edge_faces(edge).iter().find(|other| **other != face) {
            Some(&next) if next != first => ring.push(next),
            _ => break,
        }
    }
    ring
}

fn check_polygons(vertex_count: usize, polygons: &[Vec<u32>]) -> Result<(), SimplexError> {
    for (polygon, vertices) in polygons.iter().enumerate() {
        let len = vertices.len();
        if len < 3 {
            return Err(SimplexError::ShortPolygon { polygon, len });
        }
        if let Some(&vertex) = vertices.iter().find(|v| **v as usize >= vertex_count) {
            return Err(SimplexError::VertexOutOfRange { polygon, vertex, vertex_count });
        }
    }
    Ok(())
}
