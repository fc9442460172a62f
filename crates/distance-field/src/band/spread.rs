//! Bounded feature transform: faces spread from band nodes to all nodes within a reach.
//!
//! A node takes the face of the nearest band node. The nearest one is found an axis at a
//! time: first along rows, then the best of the rows above and below, then of the planes.
//! Sixteen neighboring columns are searched together, from near to far, until no farther row
//! could be nearer. That is fast because the reach is short; where it is not,
//! [`crate::transform`] takes over.
//!
//! Distances are kept as *closeness*, `reach² + 1 − distance²`: nothing is 0 and nearer is
//! more, so that 16-bit maxima do the work.
//!
//! Source: T. Saito and J.-I. Toriwaki, "New algorithms for Euclidean distance
//! transformation of an n-dimensional digitized picture with applications", Pattern
//! Recognition 27(11), 1994, for the separation by axes. Differs in carrying labels, in its
//! bound, and in its order of search.

use surface::progress::{Interrupted, Progress};

use crate::separable;

/// Columns that are searched together: two vectors of eight 16-bit numbers.
const LANES: usize = 16;

/// Maximum reach, in spacings, whose square 16 bits hold.
pub(super) const MAX_REACH: usize = 180;

/// Number of steps between two checks whether a search is over: a check costs as much as a
/// step.
const CHECK_INTERVAL: usize = 3;

type Row<'a> = separable::Row<'a, u32, i16>;

/// Gives every node within `reach` spacings of a seed the face of its nearest seed; seeds
/// are the nodes that have a face, all other faces are 0.
///
/// Writes the closeness of all nodes, 0 beyond the reach. Among
/// seeds at the same distance the order of the search decides, which is fixed.
pub(super) fn spread(
    face: &mut [u32],
    closeness: &mut [i16],
    dims: [usize; 3],
    reach: usize,
    progress: Progress<'_>,
) -> Result<(), Interrupted> {
    debug_assert!(reach <= MAX_REACH, "closeness overflows beyond {MAX_REACH}, got {reach}");
    let across = |rows: &mut [Row<'_>]| across_rows(rows, reach);
    let within = |rows: &mut [Row<'_>]| {
        for row in &mut *rows {
            along_row(row, reach);
        }
        across(rows);
    };
    separable::passes(face, closeness, dims, progress, within, across)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "reach and distance are at most 180, and its square is below 2^15"
)]
fn closeness(reach: usize, distance: usize) -> i16 {
    (reach * reach + 1) as i16 - (distance * distance) as i16
}

/// Spreads faces along a row: forward, then backward.
fn along_row(row: &mut Row<'_>, reach: usize) {
    let seed = closeness(reach, 0);
    let Some(first) = row.labels.iter().position(|&face| face != 0) else {
        return;
    };

    // Forward, every node takes the last seed.
    let mut from = first;
    for i in first..row.labels.len() {
        if row.labels[i] != 0 {
            row.nearness[i] = seed;
            from = i;
        } else if i - from <= reach {
            row.nearness[i] = closeness(reach, i - from);
            row.labels[i] = row.labels[from];
        }
    }

    // Backward, the next seed where that is nearer.
    for i in (0..from).rev() {
        if row.nearness[i] == seed {
            from = i;
        } else if from - i <= reach && closeness(reach, from - i) > row.nearness[i] {
            row.nearness[i] = closeness(reach, from - i);
            row.labels[i] = row.labels[from];
        }
    }
}

/// Spreads faces across rows, sixteen columns at a time.
fn across_rows(rows: &mut [Row<'_>], reach: usize) {
    let width = rows.first().map_or(0, |row| row.labels.len());
    let mut columns = Columns::default();
    for start in (0..width).step_by(LANES) {
        if !columns.load(rows, start) {
            continue;
        }
        for (r, row) in rows.iter_mut().enumerate() {
            columns.search(r, reach, |lane, closeness, face| {
                row.nearness[start + lane] = closeness;
                row.labels[start + lane] = face;
            });
        }
    }
}

/// Sixteen columns across some rows.
#[derive(Default)]
struct Columns {
    closeness: Vec<[i16; LANES]>,
    face: Vec<[u32; LANES]>,
    /// Nearest row at or before each row, and at or after it, that has any closeness.
    before: Vec<usize>,
    after: Vec<usize>,
}

/// No row.
const NONE: usize = usize::MAX;

impl Columns {
    /// Copies columns from `start`; returns false if there is nothing in them.
    ///
    /// Rows without any closeness are skipped by searches: far from a surface most are.
    fn load(&mut self, rows: &[Row<'_>], start: usize) -> bool {
        self.closeness.clear();
        self.face.clear();
        self.before.clear();

        // Forward: the nodes, and the last row that has any closeness.
        let mut last = NONE;
        for (r, row) in rows.iter().enumerate() {
            let end = (start + LANES).min(row.labels.len());
            let mut closeness = [0; LANES];
            closeness[..end - start].copy_from_slice(&row.nearness[start..end]);
            if closeness != [0; LANES] {
                last = r;
            }
            let mut face = [0; LANES];
            face[..end - start].copy_from_slice(&row.labels[start..end]);
            self.closeness.push(closeness);
            self.face.push(face);
            self.before.push(last);
        }
        if last == NONE {
            return false;
        }

        // Backward: the next such row.
        self.after.clear();
        self.after.resize(rows.len(), NONE);
        let mut next = NONE;
        for r in (0..rows.len()).rev() {
            if self.before[r] == r {
                next = r;
            }
            self.after[r] = next;
        }
        true
    }

    /// Searches the rows around row `r`, and passes on what changes there: lane, closeness
    /// and face.
    #[inline]
    fn search(&self, r: usize, reach: usize, mut change: impl FnMut(usize, i16, u32)) {
        let before = if self.before[r] == NONE { NONE } else { r - self.before[r] };
        let after = if self.after[r] == NONE { NONE } else { self.after[r] - r };
        let nearest = before.min(after);
        if nearest > reach {
            return;
        }

        // From near to far, all lanes at once.

        let mut best = self.closeness[r];
        let mut from = [0_i16; LANES];
        for k in nearest.max(1)..=reach {
            // No row at distance k or more offers more than this.
            let limit = closeness(reach, k);
            let is_checked = k < CHECK_INTERVAL || k % CHECK_INTERVAL == 0;
            if is_checked && best.iter().fold(i16::MAX, |min, &b| min.min(b)) >= limit {
                break;
            }
            let loss = closeness(reach, 0) - limit;
            let back = signed(k);
            if r >= k {
                take(&mut best, &mut from, &self.closeness[r - k], loss, -back);
            }
            if r + k < self.closeness.len() {
                take(&mut best, &mut from, &self.closeness[r + k], loss, back);
            }
        }

        // Only lanes that found a nearer seed are written.
        for lane in 0..LANES {
            if from[lane] != 0 {
                let source = r.wrapping_add_signed(isize::from(from[lane]));
                change(lane, best[lane], self.face[source][lane]);
            }
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "at most the reach, 180"
)]
fn signed(k: usize) -> i16 {
    k as i16
}

/// Keeps the larger of `best` and `other - loss` in each lane, and the row it came from.
#[inline]
fn take(
    best: &mut [i16; LANES],
    from: &mut [i16; LANES],
    other: &[i16; LANES],
    loss: i16,
    step: i16,
) {
    for lane in 0..LANES {
        let offer = other[lane] - loss;
        from[lane] = if offer > best[lane] { step } else { from[lane] };
        best[lane] = best[lane].max(offer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squared distance to the nearest seed, by all seeds.
    fn nearest(node: usize, seeds: &[usize], [nx, ny, _]: [usize; 3]) -> Option<usize> {
        let place = |node: usize| [node % nx, node / nx % ny, node / (nx * ny)];
        let apart = |seed: usize| -> usize {
            place(node).iter().zip(place(seed)).map(|(a, b)| a.abs_diff(b).pow(2)).sum()
        };
        seeds.iter().map(|&seed| apart(seed)).min()
    }

    /// Every node within reach has the face of a nearest seed.
    #[test]
    fn faces_come_from_a_nearest_seed() {
        fixtures::generate::cases(21, 1000, |u| {
            let dims = [u.int_in_range(1..=40)?, u.int_in_range(1..=14)?, u.int_in_range(1..=14)?];
            let reach = u.int_in_range(0..=17_usize)?;
            let mut face = vec![0; dims.iter().product()];
            for name in 1..=u.int_in_range(1..=6_u32)? {
                let node = u.choose_index(face.len())?;
                face[node] = name;
            }
            let seeds: Vec<usize> = (0..face.len()).filter(|&node| face[node] != 0).collect();
            let names: Vec<u32> = seeds.iter().map(|&seed| face[seed]).collect();
            let mut kept = vec![0; face.len()];
            spread(&mut face, &mut kept, dims, reach, Progress::none()).unwrap();
            for node in 0..face.len() {
                let squared = nearest(node, &seeds, dims).expect("there is a seed");
                if squared > reach * reach {
                    assert_eq!(kept[node], 0, "{node} is beyond {reach}");
                    continue;
                }
                let expected = reach * reach + 1 - squared;
                assert_eq!(usize::try_from(kept[node]), Ok(expected), "{node} in {dims:?}");
                let from = names.iter().position(|&name| name == face[node]);
                let from = from.expect("the face is a seed's");
                assert_eq!(nearest(node, &seeds[from..=from], dims), Some(squared));
            }
            Ok(())
        });
    }
}
