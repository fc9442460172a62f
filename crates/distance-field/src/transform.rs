//! Exact Euclidean distance and feature transform in linear time, an axis at a time.
//!
//! Along each axis, the squared distance is the lower envelope of one parabola per node. All
//! in whole numbers, so that the result is exact.
//!
//! Source: A. Meijster, J. Roerdink and W. Hesselink, "A general algorithm for computing
//! distance transforms in linear time", 2000; P. Felzenszwalb and D. Huttenlocher, "Distance
//! transforms of sampled functions", Theory of Computing 8, 2012.

use surface::progress::Progress;

use crate::FieldError;
use crate::memory::zeroed;
use crate::separable::{self, Row};

/// Squared distance of nodes without a seed.
pub(crate) const FAR: u32 = u32::MAX;

/// Columns that are copied out together: a cache line of each row.
const COLUMNS: usize = 16;

/// Returns the squared distance of every node from its nearest seed, [`FAR`] without seeds,
/// and replaces its label by the label of that seed.
///
/// Seeds are the nodes whose label is not the default.
pub(crate) fn feature_transform<L: Copy + Default + PartialEq + Send>(
    labels: &mut [L],
    dims: [usize; 3],
    progress: Progress<'_>,
) -> Result<Vec<u32>, FieldError> {
    let mut squared = zeroed(labels.len())?;
    separable::passes(labels, &mut squared, dims, progress, within_plane, across_rows)?;
    Ok(squared)
}

/// Transforms the rows of a plane, then the columns across them.
fn within_plane<L: Copy + Default + PartialEq>(rows: &mut [Row<'_, L, u32>]) {
    let mut envelope = Envelope::default();
    for row in &mut *rows {
        for (squared, &label) in row.nearness.iter_mut().zip(&*row.labels) {
            *squared = if label == L::default() { FAR } else { 0 };
        }
        envelope.transform::<1>(row.nearness, row.labels);
    }
    across_rows(rows);
}

/// Transforms the columns across rows of one length.
fn across_rows<L: Copy + Default>(rows: &mut [Row<'_, L, u32>]) {
    let width = rows.first().map_or(0, |row| row.nearness.len());
    let mut envelope = Envelope::default();
    let mut squared = vec![FAR; COLUMNS * rows.len()];
    let mut labels = vec![L::default(); COLUMNS * rows.len()];

    for start in (0..width).step_by(COLUMNS) {
        let columns = start..width.min(start + COLUMNS);
        let count = columns.len();

        // The rows are far apart in memory: each gives 16 nodes at once to a block that stays
        // in the cache, whose columns are 16 apart.
        for (r, row) in rows.iter().enumerate() {
            squared[COLUMNS * r..][..count].copy_from_slice(&row.nearness[columns.clone()]);
            labels[COLUMNS * r..][..count].copy_from_slice(&row.labels[columns.clone()]);
        }
        for c in 0..count {
            envelope.transform::<COLUMNS>(&mut squared[c..], &mut labels[c..]);
        }
        for (r, row) in rows.iter_mut().enumerate() {
            row.nearness[columns.clone()].copy_from_slice(&squared[COLUMNS * r..][..count]);
            row.labels[columns.clone()].copy_from_slice(&labels[COLUMNS * r..][..count]);
        }
    }
}

/// Lower envelope of parabolas, one per node of a column, in memory that is reused.
#[derive(Default)]
struct Envelope<L> {
    /// Parabolas that are lowest somewhere, in ascending order.
    parabolas: Vec<Parabola<L>>,
}

/// Squared distance over a column from the seed of one of its nodes.
struct Parabola<L> {
    node: usize,
    /// Squared distance at the node.
    height: u32,
    label: L,
    /// First node at which it is lowest.
    start: usize,
}

impl<L: Copy> Envelope<L> {
    /// Replaces the height of every node `i` by the minimum of `heights[j] + (i − j)²`, and
    /// its label by that of the node `j`. Of equal minima the smaller `j` wins. Nothing
    /// changes where all heights are [`FAR`].
    ///
    /// The nodes are every `STRIDE`th number of the lists.
    fn transform<const STRIDE: usize>(&mut self, heights: &mut [u32], labels: &mut [L]) {
        let count = heights.len().div_ceil(STRIDE);
        self.build::<STRIDE>(heights, labels, count);

        // The parabolas hold what they need of the column, so that it is overwritten in place.
        let mut end = count;
        for parabola in self.parabolas.iter().rev() {
            for i in parabola.start..end {
                heights[i * STRIDE] = parabola.at(i);
                labels[i * STRIDE] = parabola.label;
            }
            end = parabola.start;
        }
    }

    /// Finds the parabolas that are lowest somewhere, and where each begins to be.
    fn build<const STRIDE: usize>(&mut self, heights: &[u32], labels: &[L], count: usize) {
        self.parabolas.clear();
        for node in 0..count {
            let height = heights[node * STRIDE];
            if height == FAR {
                continue;
            }

            // Two parabolas meet once, the later one below from there on. One that is passed
            // at its first node is lowest nowhere.
            let mut new = Parabola { node, height, label: labels[node * STRIDE], start: 0 };
            while self.parabolas.last().is_some_and(|top| new.is_below(top, top.start)) {
                self.parabolas.pop();
            }

            // Many stay above up to the end: only the others need a division.
            if let Some(top) = self.parabolas.last() {
                if !new.is_below(top, count - 1) {
                    continue;
                }
                new.start = new.passes(top);
            }
            self.parabolas.push(new);
        }
    }
}

impl<L> Parabola<L> {
    /// Returns the squared distance at a node.
    #[inline]
    fn at(&self, i: usize) -> u32 {
        self.height + square(i.abs_diff(self.node))
    }

    #[inline]
    fn is_below(&self, other: &Self, i: usize) -> bool {
        self.at(i) < other.at(i)
    }

    /// Returns the first node at which this parabola is below an earlier one, which is lower
    /// at node 0.
    #[inline]
    fn passes(&self, earlier: &Self) -> usize {
        let rise = self.at(0) - earlier.at(0);
        rise as usize / (2 * (self.node - earlier.node)) + 1
    }
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
        fixtures::generate::cases(21, 1000, |u| {
            let mut dims = [0; 3];
            for n in &mut dims {
                *n = u.int_in_range(1..=19_usize)?;
            }
            let mut labels = vec![0; dims.iter().product()];
            for _ in 0..u.int_in_range(0..=9)? {
                let node = u.choose_index(labels.len())?;
                labels[node] = node + 1;
            }
            let seeds: Vec<usize> = (0..labels.len()).filter(|&node| labels[node] != 0).collect();

            let squared = feature_transform(&mut labels, dims, Progress::none()).unwrap();
            for (node, (&squared, &label)) in squared.iter().zip(&labels).enumerate() {
                assert_eq!(squared, brute_force(node, &seeds, dims), "{node} of {dims:?}");
                if squared != FAR {
                    assert_eq!(
                        squared,
                        brute_force(node, &[label - 1], dims),
                        "{node} of {dims:?}"
                    );
                }
            }
            Ok(())
        });
    }
}
