//! Elastic model of a body: particles, and links along which a push spreads.
//!
//! Links are the edges of the surface and struts through the body, from a vertex to the
//! opposite side.

use std::sync::Arc;

use glam::DVec3;
use proximity::SurfaceTree;
use scene::{Body, BodyId, Scene};
use surface::progress::{Interrupted, Progress};
use surface::{TriangleSurface, mean_edge, parallel, triangle, vertex_areas, vertex_normals};

use crate::ResolveParams;
use crate::count::as_f64;
use crate::pieces::pieces;

/// One body at rest, with the links between its vertices and its displacement in a round.
#[derive(Debug)]
pub(crate) struct Tissue {
    pub(crate) id: BodyId,
    pub(crate) is_rigid: bool,
    /// True for a soft body that stays where it is.
    pub(crate) is_held: bool,
    pub(crate) surface: Arc<TriangleSurface>,
    /// Positions at the start, |V|.
    pub(crate) rest: Vec<DVec3>,
    /// Outward unit normals at rest, |V|.
    pub(crate) rest_normals: Vec<DVec3>,
    /// Normals of the faces at rest, twice as long as their areas, |F|.
    pub(crate) rest_face_normals: Vec<DVec3>,
    /// A third of the areas of each vertex's faces, |V|.
    areas: Vec<f64>,
    /// True for vertices that stay where they are, |V|; empty where none does.
    pub(crate) is_fixed: Vec<bool>,
    /// Factor on the mass and on the elastic energy.
    pub(crate) stiffness: f64,
    /// True where positions are rounded to single precision in the end.
    pub(crate) is_written_single: bool,
    /// Parameters of the run.
    pub(crate) params: ResolveParams,
    /// Number of self-crossings at the start, if they are to be resolved.
    pub(crate) crossings_to_resolve: Option<usize>,
    /// True for vertices inside another part of the body at the start, |V|; empty where none is.
    pub(crate) is_inside_itself: Vec<bool>,
    /// Number of the piece of each vertex, |V|; empty for bodies of one.
    pub(crate) pieces: Vec<u32>,
    /// Mean length of the edges at rest.
    pub(crate) mean_edge: f64,
    /// Signed volume at rest; `None` where the body has no inside, or none beyond rounding.
    pub(crate) volume: Option<f64>,
    /// Links of each vertex along edges, |V|.
    links: Vec<Vec<Link>>,
    /// Strut of each vertex, |V|: `None` before it is searched, then the result.
    pub(crate) struts: Vec<Option<Option<Strut>>>,
    /// Corners of cells that the surface holds by itself.
    pub(crate) cell_corners: Vec<CellCorner>,
    /// Outward unit normals at the start of the present round, |V|.
    pub(crate) normals: Vec<DVec3>,
    /// True for vertices near another body in the present round, |V|.
    pub(crate) is_near: Vec<bool>,
    /// Displacement in the present round, |V|.
    pub(crate) u: Vec<DVec3>,
    /// Positions after the best round, |V|.
    pub(crate) best: Vec<DVec3>,
    pub(crate) damage: Damage,
    /// Faces of what crosses itself and is being taken apart, ascending.
    pub(crate) tangle: Vec<u32>,
    /// Number of [new self-crossings](Tissue::count_new_self_crossings) at the present positions, once
    /// they are counted.
    pub(crate) counted_crossings: Option<usize>,
}

/// Damage that pushes did to the shape of a body.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Damage {
    pub(crate) flipped_faces: usize,
    /// Corners of cells that are below their limit.
    pub(crate) flat_corners: usize,
    /// Relative change of the volume.
    pub(crate) volume_change: f64,
    /// Pairs of the body's own faces that cross, beyond their number at the start; all of them where
    /// they are to be resolved.
    pub(crate) self_crossings: usize,
    /// Largest [strain](Tissue::strain) of an edge.
    pub(crate) strain: f64,
    /// Length of the longest displacement.
    pub(crate) max_displacement: f64,
}

/// Returns the positions of the corners of a face.
pub(crate) fn corners_at(face: [u32; 3], x: &[DVec3]) -> [DVec3; 3] {
    face.map(|vertex| x[vertex as usize])
}

/// Computes the normals of faces, twice as long as their areas.
fn face_normals(faces: &[[u32; 3]], x: &[DVec3]) -> Vec<DVec3> {
    let mut normals = Vec::with_capacity(faces.len());
    for &face in faces {
        normals.push(triangle::normal(corners_at(face, x)));
    }
    normals
}

/// Elastic link from a vertex to a neighbor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) neighbor: u32,
    pub(crate) stiffness: f64,
}

/// Corner of a cell whose nodes are all on the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellCorner {
    /// Its vertex, and those at the ends of its edges.
    pub(crate) vertices: [u32; 4],
    /// Determinant of its edges over the product of their lengths, at rest.
    pub(crate) at_rest: f64,
    /// Such a determinant that it keeps.
    pub(crate) limit: f64,
}

/// Elastic link from a vertex through the body, to a point of the opposite side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strut {
    pub(crate) corners: [u32; 3],
    pub(crate) weights: [f64; 3],
    pub(crate) stiffness: f64,
}

impl Tissue {
    /// Builds the tissues of all bodies of a scene at rest where they are.
    pub(crate) fn of_bodies(
        scene: &Scene,
        params: &ResolveParams,
        progress: Progress<'_>,
    ) -> Result<Vec<Self>, Interrupted> {
        let ids: Vec<BodyId> = scene.ids().collect();
        let tissues = parallel::map(ids.len(), |i| {
            progress.report(0.0)?;
            let body = scene.body(ids[i]);
            Ok(Self::new(ids[i], body.is_rigid(), fitted_tree(body), params))
        });
        tissues.into_iter().collect()
    }

    /// Builds the tissue of a body at rest where it is.
    pub(crate) fn new(
        id: BodyId,
        is_rigid: bool,
        tree: &SurfaceTree,
        params: &ResolveParams,
    ) -> Self {
        let (surface, x) = (tree.shared_surface(), tree.positions().as_slice());
        let mut tissue = Self {
            id,
            is_rigid,
            is_held: false,
            rest: x.to_vec(),
            rest_normals: Vec::new(),
            rest_face_normals: face_normals(surface.faces(), x),
            normals: Vec::new(),
            areas: vertex_areas(surface.faces(), x),
            is_fixed: Vec::new(),
            stiffness: 1.0,
            is_written_single: params.rounds_to_single(),
            params: *params,
            crossings_to_resolve: None,
            is_inside_itself: Vec::new(),
            pieces: pieces(&surface, x),
            mean_edge: mean_edge(&surface, tree.positions()),
            volume: None,
            links: links(surface.edges(), x),
            struts: vec![None; x.len()],
            cell_corners: Vec::new(),
            is_near: vec![false; x.len()],
            u: vec![DVec3::ZERO; x.len()],
            best: x.to_vec(),
            damage: Damage::default(),
            tangle: Vec::new(),
            counted_crossings: None,
            surface,
        };

        // A volume to keep, where there is one.
        if tree.has_inside().is_ok() {
            tissue.volume = Some(tissue.volume_at(x)).filter(|volume| tissue.is_volume(*volume));
        }
        tissue.rest_normals = tissue.outward_normals(x);
        tissue
    }

    /// Returns true if a volume at rest is more than the rounding of coordinates: sheets of two layers have none.
    fn is_volume(&self, volume: f64) -> bool {
        let coordinates = self.rest.iter().map(|x| x.abs().max_element());
        let rounding = f64::EPSILON * coordinates.fold(0.0, f64::max);
        volume.abs() > rounding * self.areas.iter().sum::<f64>()
    }

    /// Returns true if the faces are turned inward, so that the volume they enclose is negative.
    pub(crate) fn is_inside_out(&self) -> bool {
        self.volume.is_some_and(|volume| volume < 0.0)
    }

    /// Returns the sign by which normals of faces point outward; 1 where the body has no inside.
    pub(crate) fn orientation(&self) -> f64 {
        if self.is_inside_out() { -1.0 } else { 1.0 }
    }

    /// Computes the outward unit normals of the vertices at `x`.
    pub(crate) fn outward_normals(&self, x: &[DVec3]) -> Vec<DVec3> {
        let mut normals = vertex_normals(self.surface.faces(), x);
        for normal in &mut normals {
            *normal *= self.orientation();
        }
        normals
    }

    /// Returns the relative time of work on the body.
    pub(crate) fn cost(&self) -> f64 {
        as_f64(self.rest.len())
    }

    /// Returns true if a vertex may move.
    pub(crate) fn is_free(&self, vertex: u32) -> bool {
        let is_fixed = self.is_fixed.get(vertex as usize).is_some_and(|fixed| *fixed);
        !(self.is_rigid || self.is_held || is_fixed)
    }

    /// Returns the outward normal of a vertex at rest; 0 where the body has no inside.
    pub(crate) fn outward(&self, vertex: u32) -> DVec3 {
        if self.volume.is_some() { self.rest_normals[vertex as usize] } else { DVec3::ZERO }
    }

    /// Returns true if a direction is on one side.
    pub(crate) fn agrees(&self, direction: DVec3, side: DVec3) -> bool {
        direction.dot(side) > self.params.tuning.min_cosine
    }

    /// Returns a third of the areas of a vertex's faces at rest.
    pub(crate) fn area(&self, vertex: u32) -> f64 {
        self.areas[vertex as usize]
    }

    /// Computes the gradient of the enclosed volume with respect to a vertex at `x`.
    pub(crate) fn volume_gradient(&self, vertex: u32, x: &[DVec3]) -> DVec3 {
        let mut doubled = DVec3::ZERO;
        for &face in self.surface.vertex_faces(vertex) {
            doubled += triangle::normal(corners_at(self.corners(face), x));
        }
        doubled / 6.0
    }

    /// Returns the mass per area: the mean thickness, times the stiffness of the body. Sheets without a
    /// volume count as thick as their edges are long.
    pub(crate) fn mass_per_area(&self) -> f64 {
        let thickness = match self.volume {
            Some(volume) if volume != 0.0 => volume.abs() / self.areas.iter().sum::<f64>(),
            _ => self.mean_edge,
        };
        self.stiffness * thickness
    }

    /// Returns the corners of a face.
    pub(crate) fn corners(&self, face: u32) -> [u32; 3] {
        self.surface.faces()[face as usize]
    }

    /// Returns the links to the vertices that share an edge with `vertex`.
    pub(crate) fn links(&self, vertex: u32) -> &[Link] {
        &self.links[vertex as usize]
    }

    /// Returns true if a vertex moves in this round.
    fn is_pushed(&self) -> bool {
        self.u.iter().any(|&u| u != DVec3::ZERO)
    }

    /// Returns the positions that this round moves vertices to, if it moves any.
    pub(crate) fn pushed(&self, from: &[DVec3]) -> Option<Vec<DVec3>> {
        if self.is_pushed() { Some(self.displaced(from)) } else { None }
    }

    /// Returns the positions that this round moves vertices to.
    fn displaced(&self, from: &[DVec3]) -> Vec<DVec3> {
        let mut x = from.to_vec();
        for (vertex, (x, u)) in (0..).zip(x.iter_mut().zip(&self.u)) {
            if self.is_free(vertex) {
                *x += *u;
            }
        }
        x
    }

    /// Changes the positions that this round moves vertices to, unless it moves none and the
    /// shape is not spoilt. Vertices that are not changed keep the bits of their displacement.
    pub(crate) fn alter(
        &mut self,
        tree: &SurfaceTree,
        change: impl FnOnce(&Self, &mut [DVec3]) -> Result<(), Interrupted>,
    ) -> Result<(), Interrupted> {
        if !self.is_pushed() && !self.damage.is_spoilt(self.params.volume_tolerance()) {
            return Ok(());
        }
        let from = tree.positions().as_slice();
        let x = self.displaced(from);
        let mut changed = x.clone();
        change(self, &mut changed)?;

        // A displacement computed from positions would differ in its last bits.
        for (v, u) in self.u.iter_mut().enumerate() {
            if changed[v] != x[v] {
                *u = changed[v] - from[v];
            }
        }
        Ok(())
    }

    /// Computes the signed volume that the surface encloses at `x`.
    pub(crate) fn volume_at(&self, x: &[DVec3]) -> f64 {
        let corners = |face: &[u32; 3]| corners_at(*face, x);
        triangle::signed_volume(self.surface.faces().iter().map(corners), x[0])
    }

    /// Computes the inverse masses of the vertices; 0 for those that do not move.
    ///
    /// A mass is area times the mean thickness of the body, so that bulky muscles move slim ones, times
    /// its stiffness.
    pub(crate) fn inverse_masses(&self) -> Vec<f64> {
        // Vertices without a face have no mass, and stay as fixed ones do.
        let mass_per_area = self.mass_per_area();
        let mut inverse_masses = vec![0.0; self.areas.len()];
        for (vertex, inverse_mass) in (0..).zip(&mut inverse_masses) {
            let mass = self.area(vertex) * mass_per_area;
            if mass > 0.0 && self.is_free(vertex) {
                *inverse_mass = mass.recip();
            }
        }
        inverse_masses
    }

    /// Computes the volume that vertices sweep when each moves by `heights` along its normal, to
    /// first order.
    pub(crate) fn swept_volume(&self, heights: &[f64]) -> f64 {
        heights.iter().zip(&self.areas).map(|(height, area)| height * area).sum()
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
        // Forces over stiffnesses: the mean of the other ends, weighted.
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

impl Damage {
    /// Returns true if the body's shape has to be restored.
    pub(crate) fn is_spoilt(&self, max_change: f64) -> bool {
        let spoilt = self.flipped_faces + self.flat_corners + self.self_crossings;
        spoilt > 0 || self.volume_change > max_change
    }
}

/// Returns the fitted tree of a body. Detection fits the trees of all bodies.
pub(crate) fn fitted_tree(body: &Body) -> &SurfaceTree {
    body.tree().expect("detection fits the trees of all bodies")
}

/// Builds the links of each vertex along the edges.
fn links(edges: &[[u32; 2]], x: &[DVec3]) -> Vec<Vec<Link>> {
    let mut links = vec![Vec::new(); x.len()];
    for &[p, q] in edges {
        // On a regular mesh of edge h, Σ (u_j − u_i) 2/(3h²) is the Laplacian.
        let length_squared = x[p as usize].distance_squared(x[q as usize]);
        let stiffness = if length_squared > 0.0 { 2.0 / (3.0 * length_squared) } else { 0.0 };
        links[p as usize].push(Link { neighbor: q, stiffness });
        links[q as usize].push(Link { neighbor: p, stiffness });
    }
    links
}
