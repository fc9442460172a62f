//! Elastic model of a body: particles with masses, and links along which a push spreads.
//!
//! Links are the edges of the surface and struts through the body, from a vertex to the
//! opposite side.

use std::sync::Arc;

use glam::DVec3;
use kdop::{Dop18, Workspace};
use proximity::SurfaceTree;
use scene::{Body, Scene};
use surface::{TriangleSurface, parallel, triangle, vertex_areas, vertex_normals};

use crate::tuning;

/// Vertices of one body at rest, with the links between them.
#[derive(Debug)]
pub(crate) struct Tissue {
    pub(crate) surface: Arc<TriangleSurface>,
    /// Positions at the start, |V|.
    pub(crate) rest: Vec<DVec3>,
    /// Unit normals at rest, |V|.
    pub(crate) normals: Vec<DVec3>,
    /// A third of the areas of each vertex's faces, |V|.
    pub(crate) areas: Vec<f64>,
    /// Signed volume at rest; `None` where the body has no inside.
    pub(crate) volume: Option<f64>,
    links: Vec<Link>,
    /// Where the links of each vertex begin, |V| + 1.
    first_links: Vec<usize>,
    struts: Vec<Option<Option<Strut>>>,
}

/// Elastic link from a vertex to a neighbor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) neighbor: u32,
    stiffness: f64,
}

/// Elastic link from a vertex through the body, to a point of the opposite side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strut {
    pub(crate) corners: [u32; 3],
    weights: [f64; 3],
    stiffness: f64,
}

impl Strut {
    /// Interpolates a value of the vertices at the opposite point.
    pub(crate) fn interpolate(&self, value: impl Fn(u32) -> DVec3) -> DVec3 {
        self.corners.iter().zip(self.weights).map(|(&corner, weight)| weight * value(corner)).sum()
    }
}

impl Tissue {
    /// Builds the tissue of a body at rest where it is.
    pub(crate) fn new(tree: &SurfaceTree) -> Self {
        let (surface, x) = (tree.shared_surface(), tree.positions());
        let (links, first_links) = links(surface.edges(), x.as_slice());
        let mut tissue = Self {
            rest: x.as_slice().to_vec(),
            normals: vertex_normals(surface.faces(), x.as_slice()),
            areas: vertex_areas(surface.faces(), x.as_slice()),
            volume: None,
            links,
            first_links,
            struts: vec![None; x.as_slice().len()],
            surface,
        };
        tissue.volume = tree.has_inside().is_ok().then(|| tissue.volume_at(&tissue.rest));
        tissue
    }

    /// Computes the signed volume that the surface encloses at `x`.
    pub(crate) fn volume_at(&self, x: &[DVec3]) -> f64 {
        let corners = |face: &[u32; 3]| face.map(|vertex| x[vertex as usize]);
        triangle::signed_volume(self.surface.faces().iter().map(corners), x[0])
    }

    /// Returns the corners of a face.
    pub(crate) fn corners(&self, face: u32) -> [u32; 3] {
        self.surface.faces()[face as usize]
    }

    /// Returns the links to the vertices that share an edge with `vertex`.
    pub(crate) fn links(&self, vertex: u32) -> &[Link] {
        let [from, to] = [vertex as usize, vertex as usize + 1].map(|v| self.first_links[v]);
        &self.links[from..to]
    }

    /// Returns the strut of a vertex, where [`Self::find_strut`] found one.
    pub(crate) fn strut(&self, vertex: u32) -> Option<&Strut> {
        self.struts[vertex as usize].as_ref()?.as_ref()
    }

    /// Finds the strut of a vertex, unless that was done before.
    pub(crate) fn find_strut(
        &mut self,
        tree: &SurfaceTree,
        vertex: u32,
        smoothing: f64,
        workspace: &mut Workspace,
    ) {
        let strut = &mut self.struts[vertex as usize];
        if strut.is_none() {
            let direction = -self.normals[vertex as usize];
            let ray = Ray { origin: tree.position(vertex), direction };
            let max_length = tuning::MAX_STRUT_LENGTH * smoothing;
            *strut = Some(ray.find_strut(tree, vertex, max_length, workspace));
        }
    }

    /// Computes the displacement at which a vertex is in equilibrium with its links, whose
    /// other ends are displaced by `u`; `None` where nothing holds it.
    ///
    /// A `foundation` is the stiffness of a link to the vertex's own place.
    pub(crate) fn equilibrium(
        &self,
        vertex: u32,
        u: impl Fn(u32) -> DVec3,
        foundation: f64,
    ) -> Option<DVec3> {
        let (mut force, mut stiffness) = (DVec3::ZERO, foundation);
        for link in self.links(vertex) {
            force += link.stiffness * u(link.neighbor);
            stiffness += link.stiffness;
        }
        if let Some(strut) = self.strut(vertex) {
            force += strut.stiffness * strut.interpolate(u);
            stiffness += strut.stiffness;
        }
        (stiffness > 0.0).then(|| force / stiffness)
    }
}

/// Returns the fitted tree of a body. Detection fits the trees of all bodies.
pub(crate) fn fitted_tree(body: &Body) -> &SurfaceTree {
    body.tree().expect("detection fits the trees of all bodies")
}

/// Builds the tissues of all bodies of a scene.
pub(crate) fn tissues(scene: &Scene) -> Vec<Tissue> {
    parallel::map_slice_with(scene.bodies(), || (), |(), body| Tissue::new(fitted_tree(body)))
}

/// Computes the inverse masses of all particles of a scene; 0 for those that do not move.
///
/// A mass is area times the mean thickness of the body, so that bulky muscles move slim ones.
pub(crate) fn inverse_masses(scene: &Scene, tissues: &[Tissue], smoothing: f64) -> Vec<f64> {
    let mut inverse_masses = Vec::new();
    for (body, tissue) in scene.bodies().iter().zip(tissues) {
        let thickness = match tissue.volume {
            Some(volume) if volume != 0.0 => volume.abs() / tissue.areas.iter().sum::<f64>(),
            _ => tuning::OPEN_THICKNESS * smoothing,
        };
        inverse_masses.extend(tissue.areas.iter().map(|area| {
            let mass = area * thickness;
            if mass > 0.0 && !body.is_rigid() { mass.recip() } else { 0.0 }
        }));
    }
    inverse_masses
}

/// Returns both links of each edge, by vertex, and where the links of each vertex begin.
fn links(edges: &[[u32; 2]], x: &[DVec3]) -> (Vec<Link>, Vec<usize>) {
    let mut links = Vec::with_capacity(2 * edges.len());
    for &[p, q] in edges {
        // On a regular mesh of edge h, Σ (u_j − u_i) 2/(3h²) is the Laplacian.
        let length_squared = x[p as usize].distance_squared(x[q as usize]);
        let stiffness = if length_squared > 0.0 { 2.0 / (3.0 * length_squared) } else { 0.0 };
        links.push((p, Link { neighbor: q, stiffness }));
        links.push((q, Link { neighbor: p, stiffness }));
    }
    // Stable: each vertex keeps the order of its edges.
    links.sort_by_key(|&(vertex, _)| vertex);

    let begin = |v: usize| links.partition_point(|&(vertex, _)| (vertex as usize) < v);
    let first_links = (0..=x.len()).map(begin).collect();
    (links.into_iter().map(|(_, link)| link).collect(), first_links)
}

/// Half-line from a point in a unit direction.
#[derive(Clone, Copy)]
struct Ray {
    origin: DVec3,
    direction: DVec3,
}

/// Point at which a ray leaves a body.
struct Exit {
    distance: f64,
    face: u32,
    weights: [f64; 3],
}

impl Ray {
    /// Finds the nearest face at which the ray leaves a body within `max_length`, faces of
    /// `vertex` left out.
    fn find_strut(
        self,
        tree: &SurfaceTree,
        vertex: u32,
        max_length: f64,
        workspace: &mut Workspace,
    ) -> Option<Strut> {
        let end = self.origin + max_length * self.direction;
        let bounds = Dop18::from_points(&[self.origin, end]);
        let mut nearest: Option<Exit> = None;
        tree.tree().query(&bounds, workspace, |face| {
            if tree.surface().faces()[face as usize].contains(&vertex) {
                return;
            }
            let Some((distance, weights)) = self.exit(tree.corners(face)) else { return };
            let is_nearer = |other: &Exit| (distance, face) < (other.distance, other.face);
            if distance <= max_length && nearest.as_ref().is_none_or(is_nearer) {
                nearest = Some(Exit { distance, face, weights });
            }
        });
        let Exit { distance, face, weights } = nearest?;
        let corners = tree.surface().faces()[face as usize];
        Some(Strut { corners, weights, stiffness: (distance * distance).recip() })
    }

    /// Computes the distance at which the ray passes a triangle from behind, and the weights
    /// of its corners there.
    fn exit(self, [a, b, c]: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let slope = self.direction.dot(normal);
        if slope <= 0.0 {
            return None;
        }
        let to = self.origin - a;
        let v = to.cross(ac).dot(self.direction) / slope;
        let w = ab.cross(to).dot(self.direction) / slope;
        let distance = -to.dot(normal) / slope;
        let is_hit = distance > 0.0 && v >= 0.0 && w >= 0.0 && v + w <= 1.0;
        is_hit.then_some((distance, [1.0 - v - w, v, w]))
    }
}
