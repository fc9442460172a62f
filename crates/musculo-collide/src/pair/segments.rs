//! A surface cut into regions by another, each on one side of it.
//!
//! Faces that meet the other surface belong to no region; from these, the others
//! fall into regions by common corners. Around a closed body a region is inside or
//! outside. An open one has two faces but no inside: corners next to the cut tell
//! on which side of it their region lies, by the normal at their nearest point.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2, which
//! mentions such a segmentation for surfaces without an inside.

use kdop::Workspace;
use surface::{NO_EDGE, Pseudonormals, TriangleFeature, TriangleSurface};

use super::crossings::Cut;
use super::regions::{self, is_inside};
use super::{NO_HINT, nearest};
use crate::shape::Shape;
use crate::{BodyId, Scene, SceneError};

/// A connected part of a surface that does not meet another.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Region {
    /// Its faces, ascending.
    pub faces: Vec<u32>,
    /// Sum of their areas, in the square of the length unit.
    pub area: f64,
    /// Where it is.
    pub side: Side,
}

/// Where a region is, as seen from the surface that cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Side {
    /// Inside a body that has an inside.
    Inside,
    /// Outside of it.
    Outside,
    /// At the cut, where the normals of an open surface point to.
    Front,
    /// At the cut, behind an open surface.
    Back,
    /// At the cut on both sides, round the border of an open surface.
    Around,
    /// Not at the cut with an open surface.
    Apart,
}

impl Scene {
    /// Cuts `body` by `by`, where they are: regions of `body` that do not meet `by`,
    /// largest first. One region where nothing is cut.
    ///
    /// Which faces are cut is exact, and so is which region is inside a body that
    /// has an inside. Sides of an open surface are decided by the nearest points of
    /// corners of cut faces; those nearest to its border decide nothing.
    ///
    /// ```
    /// use musculo_collide::glam::DVec3;
    /// use musculo_collide::surface::TriangleSurface;
    /// use musculo_collide::{BodyKind, Scene, Side};
    ///
    /// let x = [[0.0, 0.0, -1.0], [6.0, 0.0, -1.0], [0.0, 0.0, 2.0], [6.0, 0.0, 2.0], [0.0, 0.0, 5.0]];
    /// let strip = TriangleSurface::new(5, vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]])?;
    /// let floor = TriangleSurface::new(3, vec![[0, 1, 2]])?;
    /// let y = [[-9.0, -9.0, 0.0], [19.0, -9.0, 0.0], [-9.0, 19.0, 0.0]];
    /// let mut scene = Scene::new();
    /// let strip = scene.add("strip", BodyKind::Open, strip, x.map(DVec3::from).to_vec())?;
    /// let floor = scene.add("floor", BodyKind::Open, floor, y.map(DVec3::from).to_vec())?;
    ///
    /// let regions = scene.segment(strip, floor)?;
    /// assert_eq!(regions.len(), 1);
    /// assert_eq!((&regions[0].faces[..], regions[0].side), (&[2][..], Side::Front));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::NoSuchBody`] when a body is of another scene.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    pub fn segment(&mut self, body: BodyId, by: BodyId) -> Result<Vec<Region>, SceneError> {
        let count = self.bodies().len();
        if let Some(id) = [body, by].into_iter().find(|id| id.index() >= count) {
            return Err(SceneError::NoSuchBody { index: id.index(), count });
        }
        self.bound_states()?;
        Ok(Segmentation::new(self.body(body).shape(), self.body(by).shape()).regions())
    }
}

/// A surface about to be cut by another.
struct Segmentation<'a> {
    a: &'a Shape,
    b: &'a Shape,
    cut: Cut,
    parents: Vec<u32>,
    traversal: Workspace,
}

impl<'a> Segmentation<'a> {
    fn new(a: &'a Shape, b: &'a Shape) -> Self {
        let (mut cut, mut traversal) = (Cut::default(), Workspace::default());
        cut.find(a, b, &mut traversal);
        let mut parents = Vec::new();
        regions::each_alone(&mut parents, a.surface().vertex_count());
        let mut this = Self { a, b, cut, parents, traversal };
        for face in this.whole_faces().collect::<Vec<_>>() {
            regions::join_all(&mut this.parents, a.surface().faces()[face as usize]);
        }
        this
    }

    /// Faces that are not cut, ascending.
    fn whole_faces(&self) -> impl Iterator<Item = u32> {
        let mut cut = self.cut.faces_of_a.iter().peekable();
        (0..)
            .take(self.a.surface().faces().len())
            .filter(move |face| cut.next_if_eq(&face).is_none())
    }

    fn regions(mut self) -> Vec<Region> {
        // By the smallest vertex of each region.
        let mut faces: Vec<Vec<u32>> = vec![Vec::new(); self.a.surface().vertex_count()];
        for face in self.whole_faces().collect::<Vec<_>>() {
            let corner = self.a.surface().faces()[face as usize][0];
            faces[regions::root(&mut self.parents, corner) as usize].push(face);
        }
        let sides = self.sides();
        let found = faces.into_iter().zip(sides).filter(|(faces, _)| !faces.is_empty());
        let mut found: Vec<Region> =
            found.map(|(faces, side)| Region { area: area(self.a, &faces), faces, side }).collect();
        found.sort_by(|p, q| q.area.total_cmp(&p.area).then(p.faces[0].cmp(&q.faces[0])));
        found
    }

    /// By the smallest vertex of each region; of no meaning for others. Called once,
    /// since it takes the cut.
    fn sides(&mut self) -> Vec<Side> {
        if self.b.has_inside().is_ok() {
            return self.sides_of_body();
        }
        let x = self.b.surface().positions(self.b.positions()).expect("positions were checked");
        let normals = Pseudonormals::new(self.b.surface(), x);
        let mut seen = vec![[false; 2]; self.parents.len()];
        for face in std::mem::take(&mut self.cut.faces_of_a) {
            for vertex in self.a.surface().faces()[face as usize] {
                if let Some(in_front) = self.is_in_front(vertex, &normals) {
                    let root = regions::root(&mut self.parents, vertex);
                    seen[root as usize][usize::from(in_front)] = true;
                }
            }
        }
        let side = |[back, front]: [bool; 2]| match (front, back) {
            (true, true) => Side::Around,
            (true, false) => Side::Front,
            (false, true) => Side::Back,
            (false, false) => Side::Apart,
        };
        seen.into_iter().map(side).collect()
    }

    fn sides_of_body(&mut self) -> Vec<Side> {
        let Self { a, b, parents, traversal, .. } = self;
        let mut side = |(vertex, parent): (u32, &u32)| {
            let inside =
                vertex == *parent && is_inside(b, a.positions()[vertex as usize], traversal);
            if inside { Side::Inside } else { Side::Outside }
        };
        (0..).zip(&*parents).map(&mut side).collect()
    }

    /// Whether a vertex is in front of an open surface; unknown on it, and where its
    /// nearest point is on the border.
    fn is_in_front(&mut self, vertex: u32, normals: &Pseudonormals) -> Option<bool> {
        let p = self.a.positions()[vertex as usize];
        let (face, foot) = nearest(self.b, p, f64::INFINITY, NO_HINT, &mut self.traversal)?;
        let surface = self.b.surface();
        if is_on_border(surface, face, foot.feature) {
            return None;
        }
        let height = normals.signed_distance(surface, p, face, &foot);
        (height != 0.0).then_some(height > 0.0)
    }
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

fn area(shape: &Shape, faces: &[u32]) -> f64 {
    let area = |&face: &u32| {
        let [p, q, r] = shape.corners(face);
        0.5 * (q - p).cross(r - p).length()
    };
    faces.iter().map(area).sum()
}
