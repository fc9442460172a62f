//! Which vertices start with a ball of their own.
//!
//! A hundred balls do not need one trial at each of twenty thousand vertices:
//! where far fewer balls are asked for, every second ring of vertices is enough,
//! and each vertex between joins the seed next to it.

use surface::{Positions, TriangleSurface};

use crate::index;

/// Starting vertices, and the seed (by its place among them) of every vertex.
#[derive(Clone)]
pub(super) struct Seeds {
    pub(super) vertices: Vec<u32>,
    pub(super) owners: Vec<u32>,
}

impl Seeds {
    /// Every vertex.
    pub(super) fn all(surface: &TriangleSurface) -> Self {
        let vertices: Vec<u32> = (0..index(surface.vertex_count())).collect();
        Self { owners: vertices.clone(), vertices }
    }

    /// A largest set of vertices without neighbors in it, in their order; the
    /// others join the nearest neighbor that is in it.
    pub(super) fn sparse(surface: &TriangleSurface, x: Positions<'_>) -> Self {
        let faces = surface.faces();
        let ring = |vertex: u32| {
            surface.vertex_faces(vertex).iter().flat_map(|&face| faces[face as usize])
        };
        let mut number = vec![u32::MAX; surface.vertex_count()];
        let mut vertices = Vec::new();
        for vertex in 0..index(surface.vertex_count()) {
            if ring(vertex).all(|other| number[other as usize] == u32::MAX) {
                number[vertex as usize] = index(vertices.len());
                vertices.push(vertex);
            }
        }
        let owner = |vertex: u32| {
            let nearest = ring(vertex).filter(|&other| number[other as usize] != u32::MAX).min_by(
                |&a, &b| {
                    let distance = |other| x.at(other).distance_squared(x.at(vertex));
                    distance(a).total_cmp(&distance(b))
                },
            );
            nearest.map_or(0, |seed| number[seed as usize])
        };
        let owners = (0..index(surface.vertex_count())).map(owner).collect();
        Self { vertices, owners }
    }
}
