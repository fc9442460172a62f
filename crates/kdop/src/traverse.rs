//! Traversals: who meets whom.

pub(crate) mod cones;
pub(crate) mod nearest;
mod pairs;
#[cfg(feature = "rayon")]
mod parallel;
mod query;
mod self_pairs;

use std::convert::Infallible;
use std::ops::ControlFlow;

use crate::directions::norm;
use crate::dop::rounding_loss;
use crate::rows::to_nearest;
use crate::tree::DopTree;

/// Ends a traversal that nothing can break.
fn unbroken(flow: ControlFlow<Infallible>) {
    match flow {
        ControlFlow::Continue(()) => {}
    }
}

impl<const S: usize> DopTree<S> {
    /// How far to move this tree's bounds outward along every direction so that what lies within
    /// `margin` of a leaf is found; `None` where there is no need.
    ///
    /// A stored bound may have lost half an ulp in its rounding, so that is added, at the largest
    /// magnitude in the tree. The other side needs nothing: its rounding is monotone.
    fn widening(&self, margin: f64) -> Option<[f32; S]> {
        if margin.is_nan() || margin <= 0.0 {
            return None;
        }
        let root = self.root();
        Some(std::array::from_fn(|k| {
            let magnitude = f64::from(root.lo[k].abs().max(root.hi[k].abs()));
            let exact = margin * norm::<S>(k) * (1.0 + 4.0 * f64::EPSILON);
            to_nearest((exact + 2.0 * rounding_loss(magnitude)) * (1.0 + f64::from(f32::EPSILON)))
        }))
    }
}
