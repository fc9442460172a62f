//! Simplex surfaces: every vertex has three neighbors.
//!
//! A simplex surface is the dual of a triangulation: a vertex for each triangle,
//! a polygon for each vertex, and as many edges. Three neighbors give every
//! vertex a frame and one curvature, which makes such surfaces convenient to
//! deform.
//!
//! Source: H. Delingette, "General Object Reconstruction Based on Simplex
//! Meshes", International Journal of Computer Vision 32(2), 1999, section 2.

use glam::DVec3;

use crate::rows::Rows;
use crate::{Positions, SimplexError, SurfaceError, TriangleSurface};

/// Stands for a neighbor or a polygon that a vertex on the border lacks.
pub const NO_NEIGHBOR: u32 = u32::MAX;

/// Vertices and oriented polygons of which at most three meet at a vertex: the
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
    polygons: Rows,
    neighbors: Vec<[u32; 3]>,
    vertex_polygons: Vec<[u32; 3]>,
}

impl SimplexSurface {
    /// Finds the neighbors that polygons give to `vertex_count` vertices.
    ///
    /// Polygons run counter-clockwise seen from outside. At a vertex inside of
    /// the surface three of them meet, on the border two or one.
    ///
    /// # Errors
    ///
    /// - [`SimplexError::Surface`] when 32-bit indices cannot number the vertices
    ///   or the corners of the polygons.
    /// - [`SimplexError::ShortPolygon`] and [`SimplexError::VertexOutOfRange`]
    ///   with the first such polygon.
    /// - [`SimplexError::NotSimplex`] with the first vertex whose polygons are
    ///   none, more than three, or do not follow one another about it.
    pub fn new(vertex_count: usize, polygons: &[Vec<u32>]) -> Result<Self, SimplexError> {
        check_counts(vertex_count, polygons)?;
        check_polygons(vertex_count, polygons)?;
        let rows = Rows::new(polygons.len(), || {
            (0..).zip(polygons).flat_map(|(k, polygon)| polygon.iter().map(move |v| (k, *v)))
        });
        Self::with_rows(vertex_count, rows)
    }

    /// The dual of a triangulation: vertex `k` stands for face `k`, polygon `k`
    /// for vertex `k`, and begins with its first face.
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

    /// The triangulation whose dual this is: face `k` stands for vertex `k`, and
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
        let lacks = |polygons: &[u32; 3]| polygons.contains(&NO_NEIGHBOR);
        if let Some(vertex) = self.vertex_polygons.iter().position(lacks) {
            let polygons = self.vertex_polygons[vertex].iter().filter(|p| **p != NO_NEIGHBOR);
            return Err(SimplexError::Border { vertex, polygons: polygons.count() });
        }
        Ok(TriangleSurface::new(self.polygon_count(), self.vertex_polygons.clone())?)
    }

    /// Checks that `x` holds one finite position for each vertex.
    ///
    /// # Errors
    ///
    /// As [`TriangleSurface::positions`].
    pub fn positions<'a>(&self, x: &'a [DVec3]) -> Result<Positions<'a>, SurfaceError> {
        Positions::check(self.vertex_count(), x)
    }

    /// |V|.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.neighbors.len()
    }

    /// |P|.
    #[must_use]
    pub fn polygon_count(&self) -> usize {
        self.polygons.iter().len()
    }

    /// Vertices of a polygon, counter-clockwise seen from outside.
    ///
    /// # Panics
    ///
    /// When there is no such polygon.
    #[must_use]
    pub fn polygon(&self, polygon: u32) -> &[u32] {
        self.polygons.row(polygon)
    }

    /// Neighbors of the vertices, |V| × 3, counter-clockwise seen from outside;
    /// [`NO_NEIGHBOR`] last where a vertex on the border has two.
    #[must_use]
    pub fn neighbors(&self) -> &[[u32; 3]] {
        &self.neighbors
    }

    /// Polygons at the vertices, |V| × 3: the `k`th lies between the `k`th
    /// neighbor and the next. The smallest first inside of the surface, and
    /// [`NO_NEIGHBOR`] last on the border.
    #[must_use]
    pub fn vertex_polygons(&self) -> &[[u32; 3]] {
        &self.vertex_polygons
    }

    pub(crate) fn polygons(&self) -> &Rows {
        &self.polygons
    }

    fn with_rows(vertex_count: usize, polygons: Rows) -> Result<Self, SimplexError> {
        let mut sectors = vec![Sectors::default(); vertex_count];
        for (k, polygon) in (0..).zip(polygons.iter()) {
            for (j, &vertex) in polygon.iter().enumerate() {
                let next = polygon[(j + 1) % polygon.len()];
                let previous = polygon[(j + polygon.len() - 1) % polygon.len()];
                sectors[vertex as usize].push(Sector { polygon: k, from: next, to: previous });
            }
        }
        let mut neighbors = Vec::with_capacity(vertex_count);
        let mut vertex_polygons = Vec::with_capacity(vertex_count);
        for (vertex, sectors) in sectors.iter().enumerate() {
            let not_simplex = SimplexError::NotSimplex { vertex, polygons: sectors.count };
            let (around, within) = sectors.in_order().ok_or(not_simplex)?;
            neighbors.push(around);
            vertex_polygons.push(within);
        }
        Ok(Self { polygons, neighbors, vertex_polygons })
    }
}

/// What a polygon covers about one of its vertices: counter-clockwise from the
/// next vertex to the previous one.
#[derive(Clone, Copy, Debug)]
struct Sector {
    polygon: u32,
    from: u32,
    to: u32,
}

/// Sectors about one vertex; of more than three, only the number is kept.
#[derive(Clone, Copy, Debug, Default)]
struct Sectors {
    first: [Option<Sector>; 3],
    count: usize,
}

impl Sectors {
    fn push(&mut self, sector: Sector) {
        if let Some(place) = self.first.get_mut(self.count) {
            *place = Some(sector);
        }
        self.count += 1;
    }

    /// Neighbors and polygons counter-clockwise; `None` unless three sectors
    /// close a ring, or two or one are open.
    fn in_order(&self) -> Option<([u32; 3], [u32; 3])> {
        let given = || self.first.into_iter().flatten();
        let after = |sector: Sector| given().find(|s| s.from == sector.to);
        let before = |sector: Sector| given().find(|s| s.to == sector.from);
        let first = match self.count {
            3 => given().next()?,
            1 | 2 => given().find(|s| before(*s).is_none())?,
            _ => return None,
        };
        let second = after(first);
        let third = second.and_then(after);
        let closes = third.is_some_and(|third| third.to == first.from);
        let whole = match self.count {
            3 => closes && second?.polygon != third?.polygon,
            2 => second.is_some() && third.is_none(),
            _ => second.is_none(),
        };
        let to = |sector: Option<Sector>| sector.map_or(NO_NEIGHBOR, |s| s.to);
        let polygon = |sector: Option<Sector>| sector.map_or(NO_NEIGHBOR, |s| s.polygon);
        whole.then_some((
            [first.from, first.to, to(second)],
            [first.polygon, polygon(second), polygon(third)],
        ))
    }
}

/// Faces about a vertex of a closed oriented manifold, counter-clockwise from
/// the first; empty where there is none.
fn ring(surface: &TriangleSurface, vertex: u32) -> Vec<u32> {
    let faces = surface.vertex_faces(vertex);
    let mut ring = Vec::with_capacity(faces.len());
    let mut next = faces.first().copied();
    while let Some(face) =
        next.filter(|face| ring.first() != Some(face) && ring.len() < faces.len())
    {
        ring.push(face);
        let corner = surface.faces()[face as usize].iter().position(|v| *v == vertex);
        let edge = corner.map(|k| surface.face_edges()[face as usize][(k + 2) % 3]);
        next = edge.and_then(|e| surface.edge_faces(e).iter().copied().find(|f| *f != face));
    }
    ring
}

fn check_counts(vertex_count: usize, polygons: &[Vec<u32>]) -> Result<(), SurfaceError> {
    let limit = u32::MAX as usize - 1;
    let corners = polygons.iter().fold(0_usize, |sum, polygon| sum.saturating_add(polygon.len()));
    for (what, count) in [("vertices", vertex_count), ("corners of polygons", corners)] {
        if count > limit {
            return Err(SurfaceError::TooMany { what, count, limit });
        }
    }
    Ok(())
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
