//! Squared distances between voxels, exact, an axis at a time.
//!
//! Sources: T. Saito and J.-I. Toriwaki, "New algorithms for Euclidean distance
//! transformation of an n-dimensional digitized picture with applications",
//! Pattern Recognition 27(11), 1994; for the other way see [`crate::envelope`].

use crate::envelope::{Envelope, FAR, square};
use crate::par;

/// Squared distance of every node to the nearest seed, in spacings; [`FAR`]
/// where there is none.
pub(crate) fn transform(seeds: &[bool], [nx, ny, _]: [usize; 3], squared: &mut [u32]) {
    let planes = squared.chunks_mut(nx * ny).zip(seeds.chunks(nx * ny)).collect();
    par::for_each(planes, |_, (squared, seeds): (&mut [u32], &[bool])| {
        for (row, seeds) in squared.chunks_mut(nx).zip(seeds.chunks(nx)) {
            along_row(seeds, row);
        }
        across(&mut squared.chunks_mut(nx).collect::<Vec<_>>());
    });
    par::for_each(par::walls(squared.chunks_mut(nx), ny), |_, mut rows| {
        across(&mut rows);
    });
}

fn along_row(seeds: &[bool], row: &mut [u32]) {
    let mut last = None;
    for i in 0..row.len() {
        last = if seeds[i] { Some(i) } else { last };
        row[i] = last.map_or(FAR, |seed| square(i - seed));
    }
    let mut next = None;
    for i in (0..row.len()).rev() {
        next = if seeds[i] { Some(i) } else { next };
        row[i] = row[i].min(next.map_or(FAR, |seed| square(seed - i)));
    }
}

/// Columns that are taken out together, so that each line of memory is read once.
const COLUMNS: usize = 16;

fn across(rows: &mut [&mut [u32]]) {
    let mut envelope = Envelope::default();
    let length = rows.len();
    let mut columns = vec![0; COLUMNS * length];
    let mut result = vec![0; length];
    for start in (0..rows.first().map_or(0, |row| row.len())).step_by(COLUMNS) {
        let count = COLUMNS.min(rows[0].len() - start);
        for (r, row) in rows.iter().enumerate() {
            for (c, &value) in row[start..start + count].iter().enumerate() {
                columns[c * length + r] = value;
            }
        }
        for column in columns.chunks_mut(length).take(count) {
            envelope.height.clear();
            envelope.height.extend_from_slice(column);
            result.fill(FAR);
            envelope.minima(|i, _, squared| result[i] = squared);
            column.copy_from_slice(&result);
        }
        for (r, row) in rows.iter_mut().enumerate() {
            for (c, value) in row[start..start + count].iter_mut().enumerate() {
                *value = columns[c * length + r];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squared distance of every node by looking at every seed.
    fn slow(seeds: &[bool], [nx, ny, _]: [usize; 3]) -> Vec<u32> {
        let place = |node: usize| [node % nx, node / nx % ny, node / (nx * ny)];
        let apart = |a: usize, b: usize| -> u32 {
            place(a).iter().zip(place(b)).map(|(a, b)| square(a.abs_diff(b))).sum()
        };
        let on: Vec<usize> = (0..seeds.len()).filter(|&node| seeds[node]).collect();
        let nearest = |node| on.iter().map(|&seed| apart(node, seed)).min().unwrap_or(FAR);
        (0..seeds.len()).map(nearest).collect()
    }

    #[test]
    fn squares_are_those_of_the_nearest_seed() {
        arbtest::arbtest(|u| {
            let mut dims = [0; 3];
            for n in &mut dims {
                *n = u.int_in_range(1..=19_usize)?;
            }
            let mut seeds = vec![false; dims.iter().product()];
            for _ in 0..u.int_in_range(0..=9)? {
                let node = u.choose_index(seeds.len())?;
                seeds[node] = true;
            }
            let expected = slow(&seeds, dims);
            let mut squared = vec![0; seeds.len()];
            transform(&seeds, dims, &mut squared);
            assert_eq!(squared, expected, "{dims:?}");
            Ok(())
        });
    }
}
