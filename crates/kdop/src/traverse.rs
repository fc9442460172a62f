//! Traversals: pairs of leaves, leaves that meet a bound or a ray, and nearest leaves.

mod moving;
mod nearest;
mod pairs;
mod query;
mod self_pairs;
mod steps;

pub use self::moving::{MovingPairs, RigidSweep};
pub use self::steps::StepTree;
use crate::directions::norm;
use crate::dop::rounding_loss;
use crate::projections::to_nearest;
use crate::tree::DopTree;

impl<const S: usize> DopTree<S> {
    /// Computes the distance by which to move the bounds of this tree outward along every
    /// direction, such that everything within `margin` of a leaf is found. `None` stands for 0.
    ///
    /// A stored bound may have lost half an ulp in its rounding, so that is added, at the largest
    /// magnitude in the tree. The other tree needs nothing: its rounding is monotone.
    fn widening(&self, margin: f64) -> Option<[f32; S]> {
        if margin.is_nan() || margin <= 0.0 {
            return None;
        }
        let root = self.root();
        Some(std::array::from_fn(|k| {
            // The half ulp is that of the stored bound; the last factor rounds the result up.
            let magnitude = f64::from(root.lo[k].abs().max(root.hi[k].abs()));
            let exact = margin * norm::<S>(k) * (1.0 + 4.0 * f64::EPSILON);
            to_nearest((exact + 2.0 * rounding_loss(magnitude)) * (1.0 + f64::from(f32::EPSILON)))
        }))
    }
}
