//! What moves: particles with masses, and the links along which a push spreads.

use glam::DVec3;
use kdop::{Dop18, Workspace};

use super::contacts::vertex_normals;
use crate::scene::Body;
use crate::{BodyKind, Scene, parallel};

/// Thickest part of a body through which pushes are handed on, in lengths of
/// smoothing. Thinner sheets than this would be squeezed; in a thicker part
/// the push has faded before it comes out.
const DEEPEST_STRUT: f64 = 3.0;

/// Thickness that an open surface is taken to have, in lengths of smoothing.
const SHEET: f64 = 1.0 / 6.0;

/// The opposite side of a body, seen from a vertex through the tissue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strut {
    pub(super) corners: [u32; 3],
    pub(super) weights: [f64; 3],
    pub(super) stiffness: f64,
}

/// One body's vertices and what they are tied to.
#[derive(Debug)]
pub(super) struct Tissue {
    /// Where the particles were at first.
    pub(super) rest: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
    /// A third of the areas of each vertex's faces.
    pub(super) areas: Vec<f64>,
    pub(super) volume: f64,
    starts: Vec<u32>,
    neighbours: Vec<(u32, f64)>,
    struts: Vec<Option<Option<Strut>>>,
}

impl Tissue {
    pub(super) fn new(body: &Body) -> Self {
        let (surface, x) = (body.surface(), body.positions());
        let mut areas = vec![0.0; x.len()];
        for face in surface.faces() {
            let [p, q, r] = face.map(|corner| x[corner as usize]);
            let third = (q - p).cross(r - p).length() / 6.0;
            face.iter().for_each(|&corner| areas[corner as usize] += third);
        }
        let (starts, neighbours) = adjacency(body);
        Self {
            normals: vertex_normals(surface, x),
            volume: volume(body.surface().faces(), x),
            struts: vec![None; x.len()],
            rest: x.to_vec(),
            areas,
            starts,
            neighbours,
        }
    }

    /// Vertices that share an edge with one, and the stiffness of the link.
    pub(super) fn neighbours(&self, vertex: u32) -> &[(u32, f64)] {
        let at = |v: u32| self.starts[v as usize] as usize;
        &self.neighbours[at(vertex)..at(vertex + 1)]
    }

    /// The opposite side of a vertex, if it was looked for and found.
    pub(super) fn strut(&self, vertex: u32) -> Option<&Strut> {
        self.struts[vertex as usize].as_ref()?.as_ref()
    }

    /// Looks for the opposite sides of vertices that have not been asked for
    /// before.
    pub(super) fn find_struts(
        &mut self,
        body: &Body,
        vertices: &[u32],
        smoothing: f64,
        traversal: &mut Workspace,
    ) {
        for &vertex in vertices {
            if self.struts[vertex as usize].is_none() {
                let inward = -self.normals[vertex as usize];
                let found = opposite(body, vertex, inward, DEEPEST_STRUT * smoothing, traversal);
                self.struts[vertex as usize] = Some(found);
            }
        }
    }
}

/// Inverse masses of all particles: area times mean thickness, so that bulky
/// muscles move slim ones; 0 for what is fixed.
pub(super) fn inverse_masses(scene: &Scene, tissues: &[Tissue], smoothing: f64) -> Vec<f64> {
    let of_body = |(body, tissue): (&Body, &Tissue)| -> Vec<f64> {
        if body.kind() == BodyKind::Rigid {
            return vec![0.0; tissue.rest.len()];
        }
        let area: f64 = tissue.areas.iter().sum();
        let closed = body.has_inside().is_ok() && tissue.volume != 0.0;
        let thickness = if closed { tissue.volume.abs() / area } else { SHEET * smoothing };
        let inverse = |&share: &f64| {
            let mass = share * thickness;
            if mass > 0.0 { mass.recip() } else { 0.0 }
        };
        tissue.areas.iter().map(inverse).collect()
    };
    scene.bodies().iter().zip(tissues).flat_map(of_body).collect()
}

/// Volume that a closed oriented surface holds.
pub(super) fn volume(faces: &[[u32; 3]], x: &[DVec3]) -> f64 {
    let origin = x[0];
    let corner = |v: u32| x[v as usize] - origin;
    faces.iter().map(|&[p, q, r]| corner(p).dot(corner(q).cross(corner(r)))).sum::<f64>() / 6.0
}

/// One tissue a body.
pub(super) fn tissues(scene: &Scene) -> Vec<Tissue> {
    parallel::map_with(scene.bodies(), || (), |(), body| Tissue::new(body))
}

fn adjacency(body: &Body) -> (Vec<u32>, Vec<(u32, f64)>) {
    let x = body.positions();
    let mut starts = vec![0_u32; x.len() + 1];
    for &[p, q] in body.surface().edges() {
        starts[p as usize + 1] += 1;
        starts[q as usize + 1] += 1;
    }
    for v in 0..x.len() {
        starts[v + 1] += starts[v];
    }
    let mut next = starts.clone();
    let mut neighbours = vec![(0, 0.0); starts[x.len()] as usize];
    let mut put = |from: u32, to: u32, stiffness: f64| {
        neighbours[next[from as usize] as usize] = (to, stiffness);
        next[from as usize] += 1;
    };
    for &[p, q] in body.surface().edges() {
        // On a regular mesh of edge h, Σ (u_j − u_i) 2/(3h²) is the Laplacian.
        let length_squared = x[p as usize].distance_squared(x[q as usize]);
        let stiffness = if length_squared > 0.0 { 2.0 / (3.0 * length_squared) } else { 0.0 };
        put(p, q, stiffness);
        put(q, p, stiffness);
    }
    (starts, neighbours)
}

/// Where a ray from a vertex into the body comes out again within `depth`.
fn opposite(
    body: &Body,
    vertex: u32,
    inward: DVec3,
    depth: f64,
    traversal: &mut Workspace,
) -> Option<Strut> {
    let from = body.positions()[vertex as usize];
    let bound = Dop18::from_points(&[from, from + depth * inward]);
    let mut best: Option<(f64, u32, [f64; 3])> = None;
    body.tree().query(&bound, traversal, |face| {
        if body.surface().faces()[face as usize].contains(&vertex) {
            return;
        }
        if let Some((distance, weights)) = passes_out(from, inward, body.corners(face)) {
            let nearer = best.is_none_or(|(least, lowest, _)| (distance, face) < (least, lowest));
            if distance <= depth && nearer {
                best = Some((distance, face, weights));
            }
        }
    });
    best.map(|(distance, face, weights)| Strut {
        corners: body.surface().faces()[face as usize],
        weights,
        stiffness: (distance * distance).recip(),
    })
}

/// Distance along a ray to a face that it passes from behind, and the weights
/// of the face's corners there.
fn passes_out(from: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
    let (ab, ac) = (b - a, c - a);
    let slope = direction.dot(ab.cross(ac));
    if slope <= 0.0 {
        return None;
    }
    let to = from - a;
    let v = to.cross(ac).dot(direction) / slope;
    let w = ab.cross(to).dot(direction) / slope;
    let distance = -to.dot(ab.cross(ac)) / slope;
    let hit = distance > 0.0 && v >= 0.0 && w >= 0.0 && v + w <= 1.0;
    hit.then_some((distance, [1.0 - v - w, v, w]))
}
