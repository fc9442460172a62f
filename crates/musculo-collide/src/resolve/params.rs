//! How bodies are pushed apart.

use crate::SceneError;

/// How [`Scene::resolve`](crate::Scene::resolve) pushes bodies apart. Lengths
/// are in the scene's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResolveParams {
    /// How deep bodies may still be in each other at the end, `> 0`.
    pub tolerance: f64,
    /// How far apart they are pushed, `>= 0`. More keeps the edges of curved
    /// surfaces apart where vertices alone would let them cross; less moves
    /// tissue less.
    pub clearance: f64,
    /// How far along a surface a push spreads, `> 0`: the length over which
    /// the displacement falls to a third. Longer keeps shape better, and moves
    /// more.
    pub smoothing: f64,
    /// Rounds of detection and pushing at most.
    pub max_rounds: u32,
}

impl ResolveParams {
    /// For lengths in millimetres: what is left is far below what images
    /// resolve, bodies end a fiftieth of a millimetre apart, and pushes spread
    /// over a few edges of a muscle's mesh.
    pub const MILLIMETRES: Self =
        Self { tolerance: 0.05, clearance: 0.02, smoothing: 6.0, max_rounds: 60 };

    pub(super) fn validate(&self) -> Result<(), SceneError> {
        let Self { tolerance, clearance, smoothing, .. } = *self;
        let named = [
            ("tolerance", tolerance, 0.0),
            ("clearance", clearance, -1.0),
            ("smoothing", smoothing, 0.0),
        ];
        let within = |value: f64, above: f64| {
            value.is_finite() && if above < 0.0 { value >= 0.0 } else { value > above }
        };
        match named.into_iter().find(|&(_, value, above)| !within(value, above)) {
            Some((name, value, _)) => Err(SceneError::Resolve { name, value }),
            None => Ok(()),
        }
    }
}
