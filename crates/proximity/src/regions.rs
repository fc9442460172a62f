//! Segmentation of a surface by another one, each region on one side of it.
//!
//! Faces that meet the other surface belong to no region; the others form regions by common
//! corners. Against a closed surface a region is inside or outside. An open surface has two sides
//! but no inside: corners next to the cut decide on which side their region lies, by the normal
//! at their closest point.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal system using
//! MRI*, PhD thesis, 2007, section 4.7.2, which mentions such a segmentation for surfaces without
//! an inside.

use kdop::Workspace;
use surface::{NO_EDGE, Pseudonormals, TriangleFeature, TriangleSurface, UnionFind, triangle};

use crate::SurfaceTree;
use crate::crossings::Crossings;

/// Connected region of a surface that does not meet another one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Region {
    /// Its faces, ascending.
    pub faces: Vec<u32>,
    /// Sum of their areas, in the square of the length unit.
    pub area: f64,
    /// Its side of the cutting surface.
    pub side: Side,
}

/// Side of a cutting surface on which a region lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Side {
    /// Inside a surface that has an inside.
    Inside,
    /// Outside of it.
    Outside,
    /// At the cut, in front of an open surface: where its normals point.
    Front,
    /// At the cut, behind an open surface.
    Back,
    /// At the cut on both sides, around the border of an open surface.
    Around,
    /// Not at the cut with an open surface.
    Apart,
}

/// Finds the regions of `a` that do not meet `by`, largest first; one region where nothing is
/// cut.
///
/// Which faces are cut is exact, and so is which region is inside a surface that has an inside.
/// Sides of an open surface are decided by the closest points of corners of cut faces; those
/// closest to its border decide nothing.
///
/// ```
/// use proximity::glam::DVec3;
/// use proximity::{Side, SurfaceTree, regions};
/// use surface::TriangleSurface;
///
/// let x = [[0.0, 0.0, -1.0], [6.0, 0.0, -1.0], [0.0, 0.0, 2.0], [6.0, 0.0, 2.0], [0.0, 0.0, 5.0]];
/// let strip = TriangleSurface::new(5, vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]])?;
/// let strip = SurfaceTree::new(strip, x.map(DVec3::from).to_vec())?;
/// let y = [[-9.0, -9.0, 0.0], [19.0, -9.0, 0.0], [-9.0, 19.0, 0.0]];
/// let floor = TriangleSurface::new(3, vec![[0, 1, 2]])?;
/// let floor = SurfaceTree::new(floor, y.map(DVec3::from).to_vec())?;
///
/// let regions = regions(&strip, &floor);
/// assert_eq!(regions.len(), 1);
/// assert_eq!((&regions[0].faces[..], regions[0].side), (&[2][..], Side::Front));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn regions(a: &SurfaceTree, by: &SurfaceTree) -> Vec<Region> {
    let mut segmentation = Segmentation::new(a, by);
    let sides = match by.has_inside() {
        Ok(()) => segmentation.sides_of_closed(),
        Err(_) => segmentation.sides_of_open(),
    };
    segmentation.regions(&sides)
}

/// Segmentation of `a` by `by`.
struct Segmentation<'a> {
    a: &'a SurfaceTree,
    by: &'a SurfaceTree,
    /// Faces of `a` that meet `by`, ascending.
    cut_faces: Vec<u32>,
    /// Vertices joined by faces that are not cut.
    sets: UnionFind,
    workspace: Workspace,
}

impl<'a> Segmentation<'a> {
    fn new(a: &'a SurfaceTree, by: &'a SurfaceTree) -> Self {
        let (mut crossings, mut workspace) = (Crossings::default(), Workspace::default());
        crossings.find(a, by, &mut workspace);
        let cut_faces = crossings.cut_faces_of_a;

        let mut sets = UnionFind::new(a.surface().vertex_count());
        for face in whole_faces(a, &cut_faces) {
            let [p, q, r] = a.surface().faces()[face as usize];
            sets.join(p, q);
            sets.join(q, r);
        }
        Self { a, by, cut_faces, sets, workspace }
    }

    /// Collects the regions, given the side of each by its root vertex.
    fn regions(mut self, sides: &[Side]) -> Vec<Region> {
        let mut faces: Vec<Vec<u32>> = vec![Vec::new(); sides.len()];
        for face in whole_faces(self.a, &self.cut_faces) {
            let corner = self.a.surface().faces()[face as usize][0];
            faces[self.sets.find(corner) as usize].push(face);
        }

        let mut regions = Vec::new();
        for (faces, &side) in faces.into_iter().zip(sides) {
            if !faces.is_empty() {
                regions.push(Region { area: area(self.a, &faces), faces, side });
            }
        }
        regions.sort_by(|p, q| q.area.total_cmp(&p.area).then(p.faces[0].cmp(&q.faces[0])));
        regions
    }

    /// Decides the side of each root vertex against a surface with an inside.
    fn sides_of_closed(&mut self) -> Vec<Side> {
        let mut sides = vec![Side::Outside; self.a.surface().vertex_count()];
        for (vertex, side) in (0..).zip(&mut sides) {
            let is_root = self.sets.is_root(vertex);
            if is_root && self.by.contains(self.a.position(vertex), &mut self.workspace) {
                *side = Side::Inside;
            }
        }
        sides
    }

    /// Decides the side of each root vertex against an open surface, by the corners of cut faces
    /// in its region.
    fn sides_of_open(&mut self) -> Vec<Side> {
        let normals = Pseudonormals::new(self.by.surface(), self.by.positions());
        let mut sides = vec![Side::Apart; self.a.surface().vertex_count()];
        for i in 0..self.cut_faces.len() {
            for vertex in self.a.surface().faces()[self.cut_faces[i] as usize] {
                if let Some(side) = self.side_of_open(vertex, &normals) {
                    let region = &mut sides[self.sets.find(vertex) as usize];
                    let is_first = *region == Side::Apart;
                    *region = if is_first || *region == side { side } else { Side::Around };
                }
            }
        }
        sides
    }

    /// Returns the side of an open surface on which a vertex lies; `None` on the surface, and
    /// where the closest point is on its border.
    fn side_of_open(&mut self, vertex: u32, normals: &Pseudonormals) -> Option<Side> {
        let p = self.a.position(vertex);
        let found = self.by.closest_point(p, f64::INFINITY, None, &mut self.workspace)?;
        let surface = self.by.surface();
        if is_on_border(surface, found.face, found.foot.feature) {
            return None;
        }

        let height = normals.signed_distance(surface, p, found.face, &found.foot);
        let side = if height > 0.0 { Side::Front } else { Side::Back };
        (height != 0.0).then_some(side)
    }
}

/// Returns the faces that are not cut, ascending.
fn whole_faces(a: &SurfaceTree, cut_faces: &[u32]) -> impl Iterator<Item = u32> {
    let mut cut = cut_faces.iter().peekable();
    (0..).take(a.surface().faces().len()).filter(move |face| cut.next_if_eq(&face).is_none())
}

fn is_on_border(surface: &TriangleSurface, face: u32, feature: TriangleFeature) -> bool {
    let is_border = |edge: u32| edge != NO_EDGE && surface.edge_faces(edge).len() < 2;
    let sides = surface.face_edges()[face as usize];
    match feature {
        TriangleFeature::Face => false,
        TriangleFeature::Edge(k) => is_border(sides[k]),
        TriangleFeature::Corner(k) => {
            let corner = surface.faces()[face as usize][k];
            let around = surface.vertex_faces(corner).iter();
            let mut edges = around.flat_map(|&face| surface.face_edges()[face as usize]);
            edges.any(|edge| is_border(edge) && surface.edges()[edge as usize].contains(&corner))
        }
    }
}

fn area(a: &SurfaceTree, faces: &[u32]) -> f64 {
    faces.iter().map(|&face| triangle::area(a.corners(face))).sum()
}
