//! Tests of the public interface against rational arithmetic, planted answers and real
//! meshes.

mod closest;
mod crossing;
mod inspect;
mod perturbed;
mod pseudonormal;
mod range;
#[cfg(feature = "serde")]
mod serde;
mod simplex;
mod support;
mod winding;
