//! What one look at all nodes of a field tells: a box around all that is within
//! margin, and how fast values can change where.

use distance_field::DistanceField;
use glam::DVec3;

use super::slopes::Slopes;

/// Bounds of a field; the box is of its own frame.
#[derive(Clone, Debug)]
pub struct Volume {
    /// Lowest and highest corner; the lowest is above where nothing is within the margin.
    range: [DVec3; 2],
    slopes: Slopes,
    /// Values of at most this are within the margin.
    margin: f64,
    /// The largest value: one that is not less may be truncated.
    pub(super) highest: f64,
}

/// How far inside the grid's border the box ends, in spacings: what rounding may
/// carry a point of it outside.
const HAIR: f64 = 1e-9;

impl Volume {
    /// Every point with a trilinear value of at most `margin` has a node of at
    /// most that within a spacing along each axis.
    #[must_use]
    pub fn of(field: &DistanceField, margin: f64) -> Self {
        let (grid, values) = (field.grid(), field.values());
        let [nx, ny, nz] = grid.dims();
        let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut highest = f32::NEG_INFINITY;
        for k in 0..nz {
            for j in 0..ny {
                let row = nx * (j + ny * k);
                for i in 0..nx {
                    let value = values[row + i];
                    highest = highest.max(value);
                    if f64::from(value) <= margin {
                        let p = grid.position([i, j, k]);
                        (lo, hi) = (lo.min(p), hi.max(p));
                    }
                }
            }
        }
        let h = grid.spacing();
        let first = grid.origin() + HAIR * h;
        let last = grid.position([nx - 1, ny - 1, nz - 1]) - HAIR * h;
        Self {
            range: [(lo - h).max(first), (hi + h).min(last)],
            slopes: Slopes::of(grid, &values),
            margin,
            highest: f64::from(highest),
        }
    }

    /// The box's eight corners; none where nothing is within the margin.
    pub(super) fn corners(&self) -> Option<[DVec3; 8]> {
        let [lo, hi] = self.range;
        let corner = |k: usize| {
            let pick = |axis: usize| if k >> axis & 1 == 0 { lo[axis] } else { hi[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        lo.cmple(hi).all().then(|| std::array::from_fn(corner))
    }

    /// Whether a value within the margin may be in a ball, given the height of the point of
    /// the box that is nearest to its middle.
    pub(super) fn may_sink(&self, (centre, radius): (DVec3, f64), height: f64) -> bool {
        let (fall, corners) = (self.fall(height), [centre - radius, centre + radius]);
        let may = |slope: f64| fall <= slope * radius;
        may(self.slopes.anywhere) && may(self.slopes.between(corners.map(|p| self.clamp(p))))
    }

    /// Whether no straight way of this length between points of these heights comes
    /// within the margin.
    pub(super) fn stays_out(&self, [a, b]: [f64; 2], length: f64) -> bool {
        self.fall(a) + self.fall(b) > self.slopes.anywhere * length
    }

    /// The same for the way between two points of the field's frame, by the slopes
    /// there. Of what is outside the box, the nearest points of the box count.
    pub(super) fn stays_out_between(&self, ends: [DVec3; 2], [a, b]: [f64; 2]) -> bool {
        let slope = self.slopes.between(ends.map(|end| self.clamp(end)));
        self.fall(a) + self.fall(b) > slope * ends[0].distance(ends[1])
    }

    /// How far it is down to the margin; 0 for infinity, which stands for points outside
    /// the grid.
    fn fall(&self, height: f64) -> f64 {
        if height == f64::INFINITY { 0.0 } else { height - self.margin }
    }

    /// Bytes it holds.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.slopes.bytes()
    }

    pub(super) fn middle(&self) -> DVec3 {
        0.5 * (self.range[0] + self.range[1])
    }

    /// The nearest point of the box.
    pub(super) fn clamp(&self, p: DVec3) -> DVec3 {
        p.max(self.range[0]).min(self.range[1])
    }
}
