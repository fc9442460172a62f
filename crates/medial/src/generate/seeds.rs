//! Seeds: the vertices that start with a ball of their own.
//!
//! A hundred balls do not need a ball at each of twenty thousand vertices. Where far fewer are
//! requested, every second ring of vertices is sufficient, and each vertex between belongs to the
//! seed next to it.

use surface::{Positions, TriangleSurface};

use crate::index;

/// Starting vertices, with the seed (by its place among them) of every vertex.
pub(super) struct Seeds {
    pub(super) vertices: Vec<u32>,
    pub(super) owners: Vec<u32>,
}

impl Seeds {
    /// Returns every vertex as its own seed.
    pub(super) fn all(surface: &TriangleSurface) -> Self {
        let vertices: Vec<u32> = (0..index(surface.vertex_count())).collect();
        Self { owners: vertices.clone(), vertices }
    }

    /// Selects a maximal independent set of vertices, in their order; the others belong to their
    /// nearest neighbor in it.
    pub(super) fn sparse(surface: &TriangleSurface, x: Positions<'_>) -> Self {
        // A vertex without a selected neighbor is selected.
        let mut numbers = vec![None; surface.vertex_count()];
        let mut vertices = Vec::new();
        for vertex in 0..index(surface.vertex_count()) {
            if ring(surface, vertex).all(|other| numbers[other as usize].is_none()) {
                numbers[vertex as usize] = Some(index(vertices.len()));
                vertices.push(vertex);
            }
        }

        // The others belong to the nearest selected neighbor.
        let mut owners = Vec::with_capacity(surface.vertex_count());
        for vertex in 0..index(surface.vertex_count()) {
            let mut nearest = (f64::INFINITY, 0);
            for other in ring(surface, vertex) {
                let Some(number) = numbers[other as usize] else { continue };
                let distance = x.at(other).distance_squared(x.at(vertex));
                if distance < nearest.0 {
                    nearest = (distance, number);
                }
            }
            owners.push(nearest.1);
        }
        Self { vertices, owners }
    }
}

/// Returns the corners of the faces at a vertex.
pub(super) fn ring(surface: &TriangleSurface, vertex: u32) -> impl Iterator<Item = u32> {
    surface.vertex_faces(vertex).iter().flat_map(|&face| surface.faces()[face as usize])
}
