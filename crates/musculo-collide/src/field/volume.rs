//! What one look at all nodes of a field tells: a box around all that is within
//! reach, and how fast values can change.

use distance_field::DistanceField;
use glam::DVec3;

/// Bounds of a field; the box is of its own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Volume {
    /// Lowest and highest corner; the lowest is above where nothing is in reach.
    range: [DVec3; 2],
    /// Most that a trilinear value changes over a unit of length.
    slope: f64,
    /// Values of at most this are in reach.
    reach: f64,
    /// The largest value: one that is not less may be truncated.
    pub(super) highest: f64,
}

/// How far inside the grid's border the box ends, in spacings: what rounding may
/// carry a point of it outside.
const HAIR: f64 = 1e-9;

impl Volume {
    /// Every point with a trilinear value of at most `reach` has a node of at
    /// most that within a spacing along each axis. The gradient is bounded along
    /// each axis by the steepest step between two nodes.
    pub(crate) fn of(field: &DistanceField, reach: f64) -> Self {
        let (grid, values) = (field.grid(), field.values());
        let [nx, ny, nz] = grid.dims();
        let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut steepest = [0.0_f32; 3];
        let mut highest = f32::NEG_INFINITY;
        for k in 0..nz {
            for j in 0..ny {
                let row = nx * (j + ny * k);
                for i in 0..nx {
                    let value = values[row + i];
                    highest = highest.max(value);
                    if f64::from(value) <= reach {
                        let p = grid.position([i, j, k]);
                        (lo, hi) = (lo.min(p), hi.max(p));
                    }
                    let steps = [(i, nx, 1), (j, ny, nx), (k, nz, nx * ny)];
                    for (most, (at, count, stride)) in steepest.iter_mut().zip(steps) {
                        if at + 1 < count {
                            *most = most.max((values[row + i + stride] - value).abs());
                        }
                    }
                }
            }
        }
        let h = grid.spacing();
        let first = grid.origin() + HAIR * h;
        let last = grid.position([nx - 1, ny - 1, nz - 1]) - HAIR * h;
        // The differences were rounded once, to 24 bits.
        let slope = DVec3::from_array(steepest.map(f64::from)).length() / h * (1.0 + 1e-6);
        Self {
            range: [(lo - h).max(first), (hi + h).min(last)],
            slope,
            reach,
            highest: f64::from(highest),
        }
    }

    /// The box's eight corners; none where nothing is within reach.
    pub(super) fn corners(&self) -> Option<[DVec3; 8]> {
        let [lo, hi] = self.range;
        let corner = |k: usize| {
            let pick = |axis: usize| if k >> axis & 1 == 0 { lo[axis] } else { hi[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        lo.cmple(hi).all().then(|| std::array::from_fn(corner))
    }

    /// No straight way within the grid from a point of this height down to the reach
    /// is shorter. 0 for infinity, which stands for points outside the grid.
    pub(super) fn descent(&self, height: f64) -> f64 {
        if height == f64::INFINITY { 0.0 } else { (height - self.reach) / self.slope }
    }

    /// Whether no straight way of this length between points of these heights comes
    /// within reach.
    pub(super) fn stays_out(&self, [a, b]: [f64; 2], length: f64) -> bool {
        self.descent(a) + self.descent(b) > length
    }

    pub(super) fn middle(&self) -> DVec3 {
        0.5 * (self.range[0] + self.range[1])
    }

    /// The nearest point of the box.
    pub(super) fn clamp(&self, p: DVec3) -> DVec3 {
        p.max(self.range[0]).min(self.range[1])
    }
}
