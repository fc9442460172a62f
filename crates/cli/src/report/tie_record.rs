//! Ties of overlap removal, with the vertices that each holds.

use musculo_collide::{Scene, TiedVertices};
use serde::Serialize;

use super::text::grouped;

/// Vertices of a tie.
#[derive(Debug, Serialize)]
pub(crate) struct TieRecord {
    /// Body whose vertices are tied, and the body to which.
    a: String,
    b: String,
    /// Number of vertices that keep their place.
    tied: usize,
    /// Number of vertices within the distance that are not held, since they were in the other body or crossed it.
    crossing: usize,
    /// Number of vertices within the distance that were let go, since faces at them would turn over.
    loose: usize,
}

impl TieRecord {
    pub(super) fn new(count: &TiedVertices, scene: &Scene) -> Self {
        let [a, b] = [count.follower, count.leader].map(|id| scene.body(id).name().to_owned());
        Self { a, b, tied: count.tied, crossing: count.crossing, loose: count.loose }
    }

    /// Warns of a tie that holds nothing.
    pub(super) fn warning(&self) -> Option<String> {
        let Self { a, b, tied, .. } = self;
        (*tied == 0).then(|| {
            format!("the tie of '{a}' to '{b}' holds nothing: no vertex within its distance is free of '{b}'")
        })
    }

    /// Describes a tie that does not hold all vertices within its distance.
    pub(super) fn text(&self) -> Option<String> {
        let &Self { ref a, ref b, tied, crossing, loose } = self;
        let mut reasons = Vec::new();
        if crossing > 0 {
            reasons.push(format!("{} in it or across it", grouped(crossing)));
        }
        if loose > 0 {
            reasons.push(format!("{} at faces that would turn over", grouped(loose)));
        }
        (!reasons.is_empty()).then(|| {
            let (tied, all) = (grouped(tied), grouped(tied + crossing + loose));
            let others = reasons.join(", and ");
            format!("{a} is tied to {b} by {tied} of {all} vertices: not by {others}")
        })
    }
}
