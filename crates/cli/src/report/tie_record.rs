//! Ties of overlap removal, with the vertices that each holds.

use musculo_collide::{ResolveParams, Scene, TiedVertices};
use serde::Serialize;

use super::text::{grouped, length};
use crate::scene::Unit;

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
    /// Largest distance of a vertex that keeps its place from it.
    max_distance: f64,
    /// True if that is more than the distance within which bodies were tied, the gap and the tolerance together.
    torn: bool,
    /// The same in words.
    #[serde(skip)]
    torn_text: Option<String>,
}

impl TieRecord {
    pub(super) fn new(
        count: &TiedVertices,
        scene: &Scene,
        unit: Unit,
        params: &ResolveParams,
    ) -> Self {
        let [a, b] = [count.follower, count.leader].map(|id| scene.body(id).name().to_owned());
        let &TiedVertices { tied, crossing, loose, max_distance, .. } = count;
        let torn = count.is_torn(params.gap + params.tolerance);
        let torn_text = torn.then(|| {
            let (symbol, apart) = (unit.symbol(), length(max_distance, unit));
            format!("{a} is torn off {b}: tied vertices are up to {apart} {symbol} from their places on it")
        });
        Self { a, b, tied, crossing, loose, max_distance, torn, torn_text }
    }

    /// Describes a tie whose vertices have come away from their places.
    pub(super) fn torn_text(&self) -> Option<&str> {
        self.torn_text.as_deref()
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
        let &Self { ref a, ref b, tied, crossing, loose, .. } = self;
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
