//! The lowest point of an edge over a field.
//!
//! Branch and bound: between two points whose values are known, no value is
//! lower than slopes allow. Parts that cannot hold a lower value, or none within
//! reach, are left; others are halved. So the lowest value is found to a
//! tolerance however the field bends, and most edges are left after two looks.
//!
//! Source: S. A. Piyavskii, "An algorithm for finding the absolute extremum of a
//! function", USSR Computational Mathematics and Mathematical Physics 12, 1972.

use distance_field::{DistanceField, Interpolation};
use glam::DVec3;

use super::volume::Volume;

/// Share along `ends`, in the field's frame, of the lowest value within
/// `tolerance`; none where no value comes within `reach` plus that.
pub(super) fn lowest(
    field: &DistanceField,
    volume: &Volume,
    ends: [DVec3; 2],
    reach: f64,
    tolerance: f64,
) -> Option<f64> {
    let [from, to] = volume.clip(ends)?;
    let [a, b] = ends;
    let height = |share: f64| {
        let p = volume.clamp(a + share * (b - a));
        field.sample(p, Interpolation::Trilinear).map_or(f64::INFINITY, |sample| sample.distance)
    };
    let [first, last] = [from, to].map(|share| Point { share, height: height(share) });
    let slope = volume.slope * a.distance(b);
    let lowest = if last.height < first.height { last } else { first };
    let mut search = Search { height, slope, reach, tolerance, lowest };
    search.refine(first, last);
    let Point { share, height } = search.lowest;
    (height - tolerance <= reach).then_some(share)
}

#[derive(Clone, Copy, Debug)]
struct Point {
    share: f64,
    height: f64,
}

struct Search<F> {
    height: F,
    /// Most that heights change over the whole edge.
    slope: f64,
    reach: f64,
    tolerance: f64,
    lowest: Point,
}

impl<F: Fn(f64) -> f64> Search<F> {
    /// Looks between two points. Ends, because the bound is within the tolerance
    /// of the lowest known height once the slope over the part is twice that.
    fn refine(&mut self, a: Point, b: Point) {
        let bound = 0.5 * (a.height + b.height - self.slope * (b.share - a.share));
        if bound > self.reach || bound >= self.lowest.height - self.tolerance {
            return;
        }
        let share = 0.5 * (a.share + b.share);
        // Of an edge so long that its shares have run out of digits.
        if share <= a.share || share >= b.share {
            return;
        }
        let middle = Point { share, height: (self.height)(share) };
        if middle.height < self.lowest.height {
            self.lowest = middle;
        }
        self.refine(a, middle);
        self.refine(middle, b);
    }
}
