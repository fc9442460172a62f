//! Elastic model of a body: particles with masses, and links along which a push spreads.
//!
//! Links are the edges of the surface and struts through the body, from a vertex to the
//! opposite side.

use glam::DVec3;
use kdop::{Dop18, Workspace};
use surface::{triangle, vertex_areas, vertex_normals};

use super::tuning;
use scene::Body;
use scene::{BodyKind, Scene};
use surface::parallel;

/// Vertices of one body at rest, with the links between them.
#[derive(Debug)]
pub(super) struct Tissue {
    /// Positions at the start, |V|.
    pub(super) rest: Vec<DVec3>,
    /// Unit normals at rest, |V|.
    pub(super) normals: Vec<DVec3>,
    /// A third of the areas of each vertex's faces, |V|.
    pub(super) areas: Vec<f64>,
    /// Signed volume at rest.
    pub(super) volume: f64,
    links: Vec<Link>,
    /// Where the links of each vertex begin, |V| + 1.
    first_links: Vec<usize>,
    struts: Vec<Option<Option<Strut>>>,
}

/// Elastic link from a vertex to a neighbor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub(super) neighbor: u32,
    stiffness: f64,
}

/// Elastic link from a vertex through the body, to a point of the opposite side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strut {
    pub(super) corners: [u32; 3],
    weights: [f64; 3],
    stiffness: f64,
}

impl Strut {
    /// Interpolates a value of the vertices at the opposite point.
    pub(super) fn interpolate(&self, value: impl Fn(u32) -> DVec3) -> DVec3 {
        self.corners.iter().zip(self.weights).map(|(&corner, weight)| weight * value(corner)).sum()
    }
}

impl Tissue {
    /// Builds the tissue of a body at rest where it is.
    pub(super) fn new(body: &Body) -> Self {
        let (surface, x) = (body.surface(), body.positions());
        let (links, first_links) = links(surface.edges(), x);
        Self {
            rest: x.to_vec(),
            normals: vertex_normals(surface.faces(), x),
            areas: vertex_areas(surface.faces(), x),
            volume: volume(body.surface().faces(), x),
            links,
            first_links,
            struts: vec![None; x.len()],
        }
    }

    /// Returns the links to the vertices that share an edge with `vertex`.
    pub(super) fn links(&self, vertex: u32) -> &[Link] {
        let [from, to] = [vertex as usize, vertex as usize + 1].map(|v| self.first_links[v]);
        &self.links[from..to]
    }

    /// Returns the strut of a vertex, where [`Self::find_strut`] found one.
    pub(super) fn strut(&self, vertex: u32) -> Option<&Strut> {
        self.struts[vertex as usize].as_ref()?.as_ref()
    }

    /// Finds the strut of a vertex, unless that was done before.
    pub(super) fn find_strut(
        &mut self,
        body: &Body,
        vertex: u32,
        smoothing: f64,
        workspace: &mut Workspace,
    ) {
        let strut = &mut self.struts[vertex as usize];
        if strut.is_none() {
            let ray = Ray {
                origin: body.positions()[vertex as usize],
                direction: -self.normals[vertex as usize],
            };
            let max_length = tuning::MAX_STRUT_LENGTH * smoothing;
            *strut = Some(ray.find_strut(body, vertex, max_length, workspace));
        }
    }

    /// Computes the displacement at which a vertex is in equilibrium with its links, whose
    /// other ends are displaced by `u`; `None` where nothing holds it.
    ///
    /// A `foundation` is the stiffness of a link to the vertex's own place.
    pub(super) fn equilibrium(
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

/// Builds the tissues of all bodies of a scene.
pub(super) fn tissues(scene: &Scene) -> Vec<Tissue> {
    parallel::map_slice_with(scene.bodies(), || (), |(), body| Tissue::new(body))
}

/// Computes the inverse masses of all particles of a scene; 0 for those that do not move.
///
/// A mass is area times the mean thickness of the body, so that bulky muscles move slim ones.
pub(super) fn inverse_masses(scene: &Scene, tissues: &[Tissue], smoothing: f64) -> Vec<f64> {
    let mut inverse_masses = Vec::new();
    for (body, tissue) in scene.bodies().iter().zip(tissues) {
        let thickness = mean_thickness(body, tissue, smoothing);
        inverse_masses.extend(tissue.areas.iter().map(|area| {
            let mass = area * thickness;
            if mass > 0.0 && body.kind() != BodyKind::Rigid { mass.recip() } else { 0.0 }
        }));
    }
    inverse_masses
}

fn mean_thickness(body: &Body, tissue: &Tissue, smoothing: f64) -> f64 {
    if body.has_inside().is_err() || tissue.volume == 0.0 {
        return tuning::OPEN_THICKNESS * smoothing;
    }
    tissue.volume.abs() / tissue.areas.iter().sum::<f64>()
}

/// Computes the signed volume that a closed oriented surface encloses.
pub(super) fn volume(faces: &[[u32; 3]], x: &[DVec3]) -> f64 {
    let corners = |face: &[u32; 3]| face.map(|vertex| x[vertex as usize]);
    triangle::signed_volume(faces.iter().map(corners), x[0])
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
        body: &Body,
        vertex: u32,
        max_length: f64,
        workspace: &mut Workspace,
    ) -> Option<Strut> {
        let end = self.origin + max_length * self.direction;
        let bounds = Dop18::from_points(&[self.origin, end]);
        let mut nearest: Option<Exit> = None;
        body.tree()?.tree().query(&bounds, workspace, |face| {
            if body.surface().faces()[face as usize].contains(&vertex) {
                return;
            }
            let Some((distance, weights)) = self.exit(body.corners(face)) else { return };
            let is_nearer = |other: &Exit| (distance, face) < (other.distance, other.face);
            if distance <= max_length && nearest.as_ref().is_none_or(is_nearer) {
                nearest = Some(Exit { distance, face, weights });
            }
        });
        let Exit { distance, face, weights } = nearest?;
        let corners = body.surface().faces()[face as usize];
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
