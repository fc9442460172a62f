//! Soft tissue that follows several bones: a blend of their maps along an axis.
//!
//! Below the first blend all is with the first segment, above the last one with
//! the last; between, the smooth step 3t² − 2t³ goes over from one to the next.
//! A blend of rigid maps is not rigid: it shears and bulges, as muscles do, and
//! it keeps no volume.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3};

use super::Problem;

/// Segments in ascending order along an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Skin {
    axis: DVec3,
    /// Names of the maps; none for a segment that rests.
    segments: Vec<Option<String>>,
    /// From where to where along the axis each segment goes over into the next.
    blends: Vec<[f64; 2]>,
}

impl Skin {
    pub(super) fn new(
        axis: DVec3,
        segments: Vec<Option<String>>,
        blends: Vec<[f64; 2]>,
    ) -> Result<Self, Problem> {
        let axis = axis.try_normalize().ok_or(Problem::SkinAxis(axis))?;
        if segments.len() != blends.len() + 1 {
            let (segments, blends) = (segments.len(), blends.len());
            return Err(Problem::SkinCounts { segments, blends });
        }
        let mut end = f64::NEG_INFINITY;
        for (blend, &[low, high]) in blends.iter().enumerate() {
            if !(end <= low && low < high && high.is_finite()) {
                return Err(Problem::SkinBlend { blend, low, high });
            }
            end = high;
        }
        Ok(Self { axis, segments, blends })
    }

    /// The maps it follows.
    pub(super) fn maps(&self) -> impl Iterator<Item = &String> {
        self.segments.iter().flatten()
    }

    pub(super) fn deform(&self, rest: &[DVec3], maps: &BTreeMap<String, DMat4>) -> Vec<DVec3> {
        let maps: Vec<DMat4> = self
            .segments
            .iter()
            .map(|name| name.as_ref().map_or(DMat4::IDENTITY, |name| maps[name]))
            .collect();
        rest.iter().map(|&x| self.blend(x, &maps)).collect()
    }

    fn blend(&self, x: DVec3, maps: &[DMat4]) -> DVec3 {
        let height = x.dot(self.axis);
        let passed = |&[low, high]: &[f64; 2]| smooth_step((height - low) / (high - low));
        let mut remaining = 1.0;
        let mut sum = DVec3::ZERO;
        for (segment, map) in maps.iter().enumerate() {
            let next = self.blends.get(segment).map_or(0.0, passed);
            sum += (remaining - next) * map.transform_point3(x);
            remaining = next;
        }
        sum
    }
}

fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
