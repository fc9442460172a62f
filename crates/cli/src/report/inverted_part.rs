//! Closed parts of a body whose faces look to the wrong side.

use musculo_collide::Body;
use serde::Serialize;

use super::text::{counted, length};
use crate::scene::Unit;

/// A part whose faces look outward about a cavity, or inward in the open.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct InvertedPart {
    /// Its smallest vertex.
    vertex: u32,
    /// Position of that vertex.
    at: [f64; 3],
}

impl InvertedPart {
    /// Lists the inverted parts of a body with a tree; none of a body that is inside out as a whole.
    pub(crate) fn list(body: &Body) -> Vec<Self> {
        let Some(tree) = body.tree().filter(|tree| !tree.is_inside_out()) else {
            return Vec::new();
        };
        let place = |&vertex: &u32| Self { vertex, at: tree.position(vertex).to_array() };
        tree.inverted_parts().iter().map(place).collect()
    }

    /// Describes the number of parts, and the place of the first; `None` without any.
    pub(super) fn text(parts: &[Self], unit: Unit) -> Option<String> {
        let Self { vertex, at } = parts.first()?;
        let [x, y, z] = at.map(|coordinate| length(coordinate, unit));
        let which = if parts.len() == 1 { "that" } else { "the first" };
        let parts = counted(parts.len(), "part");
        Some(format!(
            "{parts} facing the wrong way (outward in another part, or inward in the open: reverse the \
             faces), {which} of vertex {vertex} at ({x}, {y}, {z})"
        ))
    }
}
