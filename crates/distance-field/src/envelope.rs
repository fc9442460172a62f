//! Distance along one axis by the lower envelope of parabolas, in linear time.
//!
//! Source: A. Meijster, J. Roerdink and W. Hesselink, "A general algorithm for
//! computing distance transforms in linear time", 2000; P. Felzenszwalb and
//! D. Huttenlocher, "Distance transforms of sampled functions", Theory of
//! Computing 8, 2012. All in whole numbers, so that the result is exact.

/// Squared distance of nodes that nothing has reached.
pub(crate) const FAR: u32 = u32::MAX;

/// Scratch of one column.
#[derive(Debug, Default)]
pub(crate) struct Envelope {
    /// Heights of the column, [`FAR`] where there is nothing.
    pub(crate) height: Vec<u32>,
    /// Places whose parabola is lowest somewhere, ascending.
    parabola: Vec<usize>,
    /// First place at which each of them is lowest.
    start: Vec<usize>,
}

impl Envelope {
    /// Hands out, for every place `i`, the place `j` that minimises
    /// `height[j] + (i − j)²` and that minimum; nothing when all heights are
    /// [`FAR`]. Of equal minima the smaller `j` wins.
    pub(crate) fn minima(&mut self, mut visit: impl FnMut(usize, usize, u32)) {
        self.build();
        if self.parabola.is_empty() {
            return;
        }
        let mut s = 0;
        for i in 0..self.height.len() {
            while s + 1 < self.start.len() && self.start[s + 1] <= i {
                s += 1;
            }
            let j = self.parabola[s];
            visit(i, j, self.height[j] + square(i.abs_diff(j)));
        }
    }

    fn build(&mut self) {
        self.parabola.clear();
        self.start.clear();
        for j in 0..self.height.len() {
            if self.height[j] == FAR {
                continue;
            }
            let start = loop {
                let (Some(&top), Some(&start)) = (self.parabola.last(), self.start.last()) else {
                    break 0;
                };
                let overtakes = self.overtakes(top, j);
                if overtakes > start {
                    break overtakes;
                }
                self.parabola.pop();
                self.start.pop();
            };
            if start < self.height.len() {
                self.parabola.push(j);
                self.start.push(start);
            }
        }
    }

    /// First place at which the parabola of `j` is below that of `i < j`.
    fn overtakes(&self, i: usize, j: usize) -> usize {
        let rise = i64::from(self.height[j]) + i64::from(square(j));
        let rise = rise - i64::from(self.height[i]) - i64::from(square(i));
        let apart = 2 * i64::try_from(j - i).unwrap_or(i64::MAX);
        usize::try_from(rise.div_euclid(apart) + 1).unwrap_or(0)
    }
}

/// Square of a distance along an axis.
#[expect(clippy::cast_possible_truncation, reason = "axes have at most 37,000 nodes")]
pub(crate) fn square(distance: usize) -> u32 {
    (distance * distance) as u32
}
