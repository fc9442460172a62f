//! Bounded feature transform: faces spread from band nodes to all nodes within a reach.
//!
//! A node takes the face of the nearest band node. The nearest one is found an axis at a
//! time: first along rows, then the best of the rows above and below, then of the planes.
//! Sixteen neighboring columns are searched together, from near to far, until no farther row
//! could be nearer. That is fast because the reach is short; where it is not,
//! [`crate::transform`] takes over.
//!
//! Distances are kept as *closeness*, `reach² + 1 − distance²`: nothing is 0 and nearer is
//! more, so that maxima of 16 bits do the work, or of 8 bits where the reach is short.
//!
//! Source: T. Saito and J.-I. Toriwaki, "New algorithms for Euclidean distance
//! transformation of an n-dimensional digitized picture with applications", Pattern
//! Recognition 27(11), 1994, for the separation by axes. Differs in carrying labels, in its
//! bound, and in its order of search.

use std::ops::Neg;

use surface::progress::{Interrupted, Progress};
use wide::{i16x16, u8x16};

use crate::separable;

/// Columns that are searched together: a vector of 8-bit numbers, two of 16 bits.
const LANES: usize = 16;

/// Blocks of as many columns that are loaded together: their rows fill lines of the cache.
const BLOCKS: usize = 4;

/// Maximum reach, in spacings, whose square 16 bits hold.
pub(super) const MAX_REACH: usize = 180;

/// Maximum reach, in spacings, whose square 8 bits hold.
pub(super) const MAX_SHORT_REACH: usize = 15;

/// Number of steps between two checks whether a search is over: a check costs as much as a
/// step, and more where its outcome has no pattern.
const CHECK_INTERVAL: usize = 3;

type Row<'a, C> = separable::Row<'a, u32, C>;

/// Closeness in 8 or 16 bits.
pub(super) trait Closeness: Copy + Default + Ord + Send + Sync {
    /// Number of rows, of as many bits.
    type Rows: Copy + Default + PartialEq + Neg<Output = Self::Rows> + TryFrom<usize> + Into<isize>;

    /// Returns the closeness of a whole number, or the largest.
    fn new(value: usize) -> Self;

    /// Keeps the larger of `best` and `other - loss` in each lane, and the row it came from.
    fn keep_larger(found: &mut Found<Self>, other: &[Self; LANES], loss: Self, step: Self::Rows);
}

impl Closeness for u8 {
    type Rows = i8;

    fn new(value: usize) -> Self {
        Self::try_from(value).unwrap_or(Self::MAX)
    }

    #[inline(always)]
    fn keep_larger(found: &mut Found<Self>, other: &[Self; LANES], loss: Self, step: i8) {
        let (best, from) = (u8x16::new(found.best), u8x16::new(found.from.map(i8::cast_unsigned)));
        let larger = best.max(u8x16::new(*other).saturating_sub(u8x16::splat(loss)));
        let from = larger.simd_eq(best).bitselect(from, u8x16::splat(step.cast_unsigned()));
        found.best = larger.to_array();
        found.from = from.to_array().map(Self::cast_signed);
    }
}

impl Closeness for i16 {
    type Rows = Self;

    fn new(value: usize) -> Self {
        Self::try_from(value).unwrap_or(Self::MAX)
    }

    #[inline(always)]
    fn keep_larger(found: &mut Found<Self>, other: &[Self; LANES], loss: Self, step: Self) {
        let (best, from) = (i16x16::new(found.best), i16x16::new(found.from));
        let larger = best.max(i16x16::new(*other) - i16x16::splat(loss));
        let from = larger.simd_eq(best).bitselect(from, i16x16::splat(step));
        (found.best, found.from) = (larger.to_array(), from.to_array());
    }
}

/// Gives every node within `reach` spacings of a seed the face of its nearest seed; seeds
/// are the nodes that have a face, all other faces are 0.
///
/// Writes the closeness of all nodes, 0 beyond the reach. Among
/// seeds at the same distance the order of the search decides, which is fixed.
pub(super) fn spread<C: Closeness>(
    face: &mut [u32],
    closeness: &mut [C],
    dims: [usize; 3],
    reach: usize,
    progress: Progress<'_>,
) -> Result<(), Interrupted> {
    debug_assert!(reach <= MAX_REACH, "closeness overflows beyond {MAX_REACH}, got {reach}");
    let across = |rows: &mut [Row<'_, C>]| across_rows(rows, reach);
    let within = |rows: &mut [Row<'_, C>]| {
        for row in &mut *rows {
            along_row(row, reach);
        }
        across(rows);
    };
    separable::passes(face, closeness, dims, progress, within, across)
}

/// Returns the closeness of a node at a distance; 0 beyond the reach.
#[inline]
fn closeness<C: Closeness>(reach: usize, distance: usize) -> C {
    C::new((reach * reach + 1).saturating_sub(distance * distance))
}

/// Spreads faces along a row: forward, then backward.
fn along_row<C: Closeness>(row: &mut Row<'_, C>, reach: usize) {
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
        } else if from - i <= reach && closeness::<C>(reach, from - i) > row.nearness[i] {
            row.nearness[i] = closeness(reach, from - i);
            row.labels[i] = row.labels[from];
        }
    }
}

/// Spreads faces across rows, sixteen columns at a time.
fn across_rows<C: Closeness>(rows: &mut [Row<'_, C>], reach: usize) {
    let width = rows.first().map_or(0, |row| row.labels.len());
    let mut blocks: [Columns<C>; BLOCKS] = Default::default();
    for first in (0..width).step_by(BLOCKS * LANES) {
        let starts = (first..width).step_by(LANES);
        blocks.iter_mut().for_each(|columns| columns.clear(reach));
        for row in &*rows {
            for (columns, start) in blocks.iter_mut().zip(starts.clone()) {
                columns.push(row, start);
            }
        }

        for (columns, start) in blocks.iter_mut().zip(starts) {
            if !columns.find_rows() {
                continue;
            }
            for (r, row) in rows.iter_mut().enumerate() {
                if let Some(found) = columns.search(r, reach) {
                    columns.write(r, &found, &mut row.nearness[start..], &mut row.labels[start..]);
                }
            }
        }
    }
}

/// Best closeness of sixteen nodes of a row, and how many rows farther on it comes from.
pub(super) struct Found<C: Closeness> {
    best: [C; LANES],
    from: [C::Rows; LANES],
}

/// Sixteen columns across some rows.
#[derive(Default)]
struct Columns<C> {
    /// Closeness of all rows, and of rows without any before and after them, so that no step of a
    /// search leaves them.
    closeness: Vec<[C; LANES]>,
    /// Number of rows without any at either end.
    margin: usize,
    face: Vec<[u32; LANES]>,
    /// Last row that has any closeness.
    last: usize,
    /// Nearest such row at or before each row, and at or after it.
    before: Vec<usize>,
    after: Vec<usize>,
}

/// No row.
const NONE: usize = usize::MAX;

impl<C: Closeness> Columns<C> {
    fn clear(&mut self, reach: usize) {
        self.margin = reach + CHECK_INTERVAL;
        self.closeness.clear();
        self.closeness.resize(self.margin, [C::default(); LANES]);
        self.face.clear();
        self.before.clear();
        self.after.clear();
        self.last = NONE;
    }

    /// Copies columns of the next row from `start`.
    fn push(&mut self, row: &Row<'_, C>, start: usize) {
        let closeness: [C; LANES] = lanes(row.nearness, start);
        if closeness != [C::default(); LANES] {
            self.last = self.before.len();
        }
        self.closeness.push(closeness);
        self.face.push(lanes(row.labels, start));
        self.before.push(self.last);
    }

    /// Finds the next row of each row that has any closeness; returns false if none has.
    ///
    /// Rows without any closeness are skipped by searches: far from a surface most are.
    fn find_rows(&mut self) -> bool {
        let rows = self.closeness.len() + self.margin;
        self.closeness.resize(rows, [C::default(); LANES]);

        self.after.resize(self.before.len(), NONE);
        let mut next = NONE;
        for (r, (after, before)) in self.after.iter_mut().zip(&self.before).enumerate().rev() {
            if *before == r {
                next = r;
            }
            *after = next;
        }
        next != NONE
    }

    /// Searches the rows around row `r`; `None` where nothing is within the reach.
    #[inline]
    fn search(&self, r: usize, reach: usize) -> Option<Found<C>> {
        let before = if self.before[r] == NONE { NONE } else { r - self.before[r] };
        let after = if self.after[r] == NONE { NONE } else { self.after[r] - r };
        let nearest = before.min(after);
        if nearest > reach {
            return None;
        }

        // From near to far, all lanes at once, until no row at distance k or more offers more than
        // was found. Beyond the reach that is nothing.
        let row = self.margin + r;
        let mut found = Found { best: self.closeness[row], from: [C::Rows::default(); LANES] };
        let mut k = nearest.max(1);
        loop {
            let limit: C = closeness(reach, k);
            if found.best.iter().all(|&best| best >= limit) {
                break;
            }
            for _ in 0..CHECK_INTERVAL {
                let loss = C::new(k * k);
                let back = C::Rows::try_from(k).unwrap_or_default();
                C::keep_larger(&mut found, &self.closeness[row - k], loss, -back);
                C::keep_larger(&mut found, &self.closeness[row + k], loss, back);
                k += 1;
            }
        }
        Some(found)
    }

    /// Writes what was found for row `r`.
    #[inline]
    fn write(&self, r: usize, found: &Found<C>, nearness: &mut [C], labels: &mut [u32]) {
        let nodes = nearness.iter_mut().zip(labels).zip(found.best.iter().zip(&found.from));
        for (lane, ((nearness, label), (&best, &from))) in nodes.enumerate() {
            *nearness = best;
            *label = self.face[r.wrapping_add_signed(from.into())][lane];
        }
    }
}

/// Copies some numbers of a row, zeros beyond its end.
#[inline]
fn lanes<T: Copy + Default>(row: &[T], start: usize) -> [T; LANES] {
    // Nearly always there are enough, and a copy of known length needs no call.
    if let Some(lanes) = row[start..].first_chunk() {
        return *lanes;
    }
    let mut lanes = [T::default(); LANES];
    lanes[..row.len() - start].copy_from_slice(&row[start..]);
    lanes
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
            let mut kept = vec![0_i16; face.len()];
            let mut short = vec![0_u8; face.len()];
            let mut short_face = face.clone();
            spread(&mut face, &mut kept, dims, reach, Progress::none()).unwrap();
            if reach <= MAX_SHORT_REACH {
                spread(&mut short_face, &mut short, dims, reach, Progress::none()).unwrap();
                assert_eq!(short_face, face);
                assert!(short.iter().zip(&kept).all(|(short, kept)| i16::from(*short) == *kept));
            }
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
