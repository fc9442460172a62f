//! Medial surfaces: volumes as balls, cones and slabs.

mod ball;
mod deviation;
mod distance;
mod error;
mod generate;
mod medial_surface;
mod parallel;
mod primitive_tree;
mod surface_distance;
mod text;

pub use crate::ball::Ball;
pub use crate::deviation::{Deviation, OneSided};
pub use crate::distance::{
    Foot, FootRule, PairFoot, bare_face_foot, cone_foot, foot, pair_foot, slab_foot,
};
pub use crate::error::MedialError;
pub use crate::generate::{Generated, Params, Progress, Size, Step, generate};
pub use crate::medial_surface::MedialSurface;
pub use crate::primitive_tree::{NearestPrimitive, PrimitiveTree};

#[expect(clippy::cast_possible_truncation, reason = "counts of surfaces and balls fit 32 bits")]
fn index(count: usize) -> u32 {
    count as u32
}

#[expect(clippy::cast_precision_loss, reason = "counts stay far below 2^52")]
fn real(count: usize) -> f64 {
    count as f64
}
