//! Exact Euclidean distance and feature transform in linear time, an axis at a time.
//!
//! Along each axis, the squared distance is the lower envelope of one parabola per node. All
//! in whole numbers, so that the result is exact.
//!
//! Source: A. Meijster, J. Roerdink and W. Hesselink, "A general algorithm for computing
//! distance transforms in linear time", 2000; P. Felzenszwalb and D. Huttenlocher, "Distance
//! transforms of sampled functions", Theory of Computing 8, 2012.

use surface::progress::{Interrupted, Progress};

use crate::separable::{self, Row};

/// Squared distance of nodes without a seed.
pub(crate) const FAR: u32 = u32::MAX;

/// Columns that are copied out together, so that each cache line is read once.
const COLUMNS: usize = 16;

/// Replaces the squared distance of every node, 0 at seeds and [`FAR`] elsewhere, by that to
/// its nearest seed, and its label by the label of that seed.
pub(crate) fn feature_transform<L: Copy + Default + Send>(
    labels: &mut [L],
    squared: &mut [u32],
    dims: [usize; 3],
    progress: Progress<'_>,
) -> Result<(), Interrupted> {
    let within = |rows: &mut [Row<'_, L, u32>]| {
        let mut columns = Columns::default();
        for row in &mut *rows {
            columns.along(row);
        }
        columns.across(rows);
    };
    let across = |rows: &mut [Row<'_, L, u32>]| Columns::default().across(rows);
    separable::passes(labels, squared, dims, progress, within, across)
}

/// Scratch memory for columns of nodes.
#[derive(Default)]
struct Columns<L> {
    envelope: Envelope,
    /// Squared distances and labels, column after column.
    heights: Vec<u32>,
    labels: Vec<L>,
}

impl<L: Copy + Default> Columns<L> {
    /// Transforms a row along itself.
    fn along(&mut self, row: &mut Row<'_, L, u32>) {
        self.heights.clear();
        self.heights.extend_from_slice(row.nearness);
        self.labels.clear();
        self.labels.extend_from_slice(row.labels);
        self.envelope.minima(&self.heights, |i, from, squared| {
            row.nearness[i] = squared;
            row.labels[i] = self.labels[from];
        });
    }

    /// Transforms the columns across rows of one length.
    fn across(&mut self, rows: &mut [Row<'_, L, u32>]) {
        let (length, width) = (rows.len(), rows.first().map_or(0, |row| row.nearness.len()));
        self.heights.resize(COLUMNS * length, FAR);
        self.labels.resize(COLUMNS * length, L::default());

        for start in (0..width).step_by(COLUMNS) {
            let count = COLUMNS.min(width - start);
            for (r, row) in rows.iter().enumerate() {
                for c in 0..count {
                    self.heights[c * length + r] = row.nearness[start + c];
                    self.labels[c * length + r] = row.labels[start + c];
                }
            }

            for c in 0..count {
                let column = c * length..(c + 1) * length;
                let labels = &self.labels[column.clone()];
                self.envelope.minima(&self.heights[column], |r, from, squared| {
                    rows[r].nearness[start + c] = squared;
                    rows[r].labels[start + c] = labels[from];
                });
            }
        }
    }
}

/// Lower envelope of parabolas, one per node of a column.
#[derive(Default)]
struct Envelope {
    /// Nodes whose parabola is lowest somewhere, ascending.
    parabolas: Vec<usize>,
    /// First node at which each of them is lowest.
    starts: Vec<usize>,
}

impl Envelope {
    /// Visits, for every node `i`, the node `j` that minimizes `heights[j] + (i − j)²` and
    /// that minimum; no node when all heights are [`FAR`]. Of equal minima the smaller `j`
    /// wins.
    #[inline]
    fn minima(&mut self, heights: &[u32], mut visit: impl FnMut(usize, usize, u32)) {
        self.build(heights);
        if self.parabolas.is_empty() {
            return;
        }

        let mut s = 0;
        for i in 0..heights.len() {
            while s + 1 < self.starts.len() && self.starts[s + 1] <= i {
                s += 1;
            }
            let j = self.parabolas[s];
            visit(i, j, heights[j] + square(i.abs_diff(j)));
        }
    }

    fn build(&mut self, heights: &[u32]) {
        self.parabolas.clear();
        self.starts.clear();
        for j in (0..heights.len()).filter(|&j| heights[j] != FAR) {
            // Parabolas that the new one overtakes before they begin are lowest nowhere.
            let mut start = 0;
            while let (Some(&top), Some(&top_start)) = (self.parabolas.last(), self.starts.last()) {
                start = overtakes(heights, top, j);
                if start > top_start {
                    break;
                }
                self.parabolas.pop();
                self.starts.pop();
                start = 0;
            }
            if start < heights.len() {
                self.parabolas.push(j);
                self.starts.push(start);
            }
        }
    }
}

/// Returns the first node at which the parabola of `j` is below that of `i < j`.
fn overtakes(heights: &[u32], i: usize, j: usize) -> usize {
    let rise = i64::from(heights[j]) + i64::from(square(j));
    let rise = rise - i64::from(heights[i]) - i64::from(square(i));
    let apart = 2 * i64::try_from(j - i).unwrap_or(i64::MAX);
    usize::try_from(rise.div_euclid(apart) + 1).unwrap_or(0)
}

/// Squares a distance along an axis.
#[expect(clippy::cast_possible_truncation, reason = "axes have at most 37,000 nodes")]
fn square(distance: usize) -> u32 {
    (distance * distance) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squared distance to the nearest seed, by all seeds.
    fn brute_force(node: usize, seeds: &[usize], [nx, ny, _]: [usize; 3]) -> u32 {
        let place = |node: usize| [node % nx, node / nx % ny, node / (nx * ny)];
        let apart = |seed: &usize| -> u32 {
            place(node).iter().zip(place(*seed)).map(|(a, b)| square(a.abs_diff(b))).sum()
        };
        seeds.iter().map(apart).min().unwrap_or(FAR)
    }

    #[test]
    fn distances_and_labels_are_those_of_a_nearest_seed() {
        arbtest::arbtest(|u| {
            let mut dims = [0; 3];
            for n in &mut dims {
                *n = u.int_in_range(1..=19_usize)?;
            }
            let mut squared = vec![FAR; dims.iter().product()];
            let mut labels = vec![usize::MAX; squared.len()];
            for _ in 0..u.int_in_range(0..=9)? {
                let node = u.choose_index(squared.len())?;
                (squared[node], labels[node]) = (0, node);
            }
            let seeds: Vec<usize> = (0..labels.len()).filter(|&node| squared[node] == 0).collect();

            feature_transform(&mut labels, &mut squared, dims, Progress::none()).unwrap();
            for (node, (&squared, &label)) in squared.iter().zip(&labels).enumerate() {
                assert_eq!(squared, brute_force(node, &seeds, dims), "{node} of {dims:?}");
                if squared != FAR {
                    assert_eq!(squared, brute_force(node, &[label], dims), "{node} of {dims:?}");
                }
            }
            Ok(())
        });
    }
}
