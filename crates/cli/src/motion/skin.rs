//! Linear blend skinning along an axis, for soft bodies that follow several bones.
//!
//! Below the first blend everything follows the first segment, above the last blend the
//! last one. Within a blend the smooth step 3t² − 2t³ shifts the weight from one segment
//! to the next. A blend of rigid maps is not rigid: it shears and bulges, as muscles do,
//! and it does not preserve volume.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3};

use super::MotionProblem;

/// Segments in ascending order along an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Skin {
    axis: DVec3,
    /// Names of the maps; none for a segment that rests.
    segments: Vec<Option<String>>,
    /// Interval along the axis between each segment and the next.
    blends: Vec<[f64; 2]>,
}

impl Skin {
    pub(super) fn new(
        axis: DVec3,
        segments: Vec<Option<String>>,
        blends: Vec<[f64; 2]>,
    ) -> Result<Self, MotionProblem> {
        // Heights along the axis are in the scene's unit.
        let axis = axis.try_normalize().ok_or(MotionProblem::SkinAxis(axis))?;
        if segments.len() != blends.len() + 1 {
            let (segments, blends) = (segments.len(), blends.len());
            return Err(MotionProblem::SkinCounts { segments, blends });
        }

        // Blends rise without overlap; a bound that is not a number fails the comparison.
        let mut end = f64::NEG_INFINITY;
        for (blend, &[low, high]) in blends.iter().enumerate() {
            if !(end <= low && low < high && high.is_finite()) {
                return Err(MotionProblem::SkinBlend { blend, low, high });
            }
            end = high;
        }
        Ok(Self { axis, segments, blends })
    }

    /// Returns the names of the maps that the skin follows.
    pub(super) fn maps(&self) -> impl Iterator<Item = &String> {
        self.segments.iter().flatten()
    }

    /// Returns the names of the segments' maps; none for a segment that rests.
    pub(super) fn segments(&self) -> &[Option<String>] {
        &self.segments
    }

    /// Returns the segment that a point at rest follows, and the share of the next one: blends do
    /// not overlap, so that no point follows more than two.
    pub(super) fn share(&self, x: DVec3) -> (usize, f64) {
        let height = x.dot(self.axis);
        let passed = self.blends.iter().take_while(|[_, high]| height >= *high).count();
        match self.blends.get(passed) {
            Some([low, high]) => (passed, smooth_step((height - low) / (high - low))),
            None => (passed, 0.0),
        }
    }

    /// Computes the positions of a body in a frame.
    pub(super) fn deform(&self, rest: &[DVec3], maps: &BTreeMap<String, DMat4>) -> Vec<DVec3> {
        // A segment without a map rests.
        let mut of_segments = Vec::new();
        for segment in &self.segments {
            of_segments.push(segment.as_ref().map_or(DMat4::IDENTITY, |name| maps[name]));
        }
        let maps = of_segments;
        rest.iter().map(|&x| self.blend(x, &maps)).collect()
    }

    fn blend(&self, x: DVec3, maps: &[DMat4]) -> DVec3 {
        let height = x.dot(self.axis);

        // From the lowest segment up, each takes what those above it leave: weights sum to 1.
        let mut remaining = 1.0;
        let mut sum = DVec3::ZERO;
        for (segment, map) in maps.iter().enumerate() {
            // Weight of all segments above this one.
            let above = match self.blends.get(segment) {
                Some([low, high]) => smooth_step((height - low) / (high - low)),
                None => 0.0,
            };
            sum += (remaining - above) * map.transform_point3(x);
            remaining = above;
        }
        sum
    }
}

/// Returns a share that rises from 0 to 1 with level ends.
pub(super) fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
