//! Bodies of a page, with fewer faces where a scene has too many.

use musculo_collide::decimate::Preview;
use musculo_collide::{Body, Scene};
use rayon::prelude::*;

/// Faces of a scene that a page shows as they are: some two megabytes.
const MAX_FACES: usize = 120_000;

/// Distance of vertices from a coarser surface, about, relative to the diagonal of their body: below a
/// pixel where the body fills the view.
const TOLERANCE: f64 = 1e-3;

/// Surfaces of all bodies in a page, in their order. They serve all states of a scene: vertices are
/// those of the bodies themselves.
#[derive(Debug)]
pub(crate) struct ShownSurfaces(pub(super) Vec<ShownSurface>);

/// Surface of a body in a page.
#[derive(Debug)]
pub(super) struct ShownSurface {
    /// Numbers of its vertices in the body.
    pub(super) vertices: Vec<u32>,
    /// Corners, in its own numbers.
    pub(super) faces: Vec<[u32; 3]>,
}

impl ShownSurfaces {
    /// Returns the surfaces of a scene, thinned out at its present state where it is too fine.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut faces = 0;
        for body in scene.bodies() {
            faces += body.surface().faces().len();
        }
        let is_fine = faces > MAX_FACES;
        Self(scene.bodies().par_iter().map(|body| shown_surface(body, is_fine)).collect())
    }
}

fn shown_surface(body: &Body, is_fine: bool) -> ShownSurface {
    if is_fine && let Some(coarse) = coarse_surface(body) {
        return coarse;
    }
    let surface = body.surface();
    let vertices = (0_u32..).take(surface.vertex_count()).collect();
    ShownSurface { vertices, faces: surface.faces().to_vec() }
}

/// Thins out a body; `None` where its surface is not closed and clean, and stays as it is.
fn coarse_surface(body: &Body) -> Option<ShownSurface> {
    let tolerance = TOLERANCE * body.face_bounds().diagonal();
    let Preview { kept, faces } = Preview::new(body.surface(), body.positions(), tolerance).ok()?;
    Some(ShownSurface { vertices: kept, faces })
}
