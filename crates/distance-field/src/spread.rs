//! Carrying the faces of seed nodes to all nodes within a bounded reach.
//!
//! A node takes the face of the nearest seed node. The nearest one is found an
//! axis at a time: first along rows, then the best of the rows above and below,
//! then of the planes. Sixteen neighbouring columns are searched together, from
//! near to far, until no farther row could be nearer; that is quick because the
//! reach is short, and where it is not, [`crate::envelope`] takes over.
//!
//! Distances are kept as *closeness*, `reach² + 1 − distance²`: nothing is 0, and
//! nearer is more, so that 16-bit maxima do the work.
//!
//! Source: T. Saito and J.-I. Toriwaki, "New algorithms for Euclidean distance
//! transformation of an n-dimensional digitized picture with applications",
//! Pattern Recognition 27(11), 1994, for the separation by axes. Differs in
//! carrying what lies nearest, in its bound, and in its order of search.

use crate::par;

/// Columns that are searched together: two vectors of eight 16-bit numbers.
const LANES: usize = 16;

/// Farthest reach whose square 16 bits hold \[spacings\].
pub(crate) const MAX_REACH: usize = 180;

/// One row of nodes along x.
struct Row<'a> {
    face: &'a mut [u32],
    closeness: &'a mut [i16],
}

/// Gives every node within `reach` spacings of a seed the face of its nearest
/// seed node; seeds are the nodes that have a face. Among seeds at the same
/// distance the order of the search decides, which is fixed.
///
/// Returns the closeness of all nodes: [`seed_closeness`] at seeds, 0 beyond
/// the reach.
pub(crate) fn spread(
    face: &mut [u32],
    closeness: &mut [i16],
    [nx, ny, _]: [usize; 3],
    reach: usize,
) {
    debug_assert!(reach <= MAX_REACH, "closeness overflows beyond {MAX_REACH}, got {reach}");
    let planes = face.chunks_mut(nx * ny).zip(closeness.chunks_mut(nx * ny)).collect();
    par::for_each(planes, |_, (face, closeness)| {
        let mut rows: Vec<Row<'_>> = rows(face, closeness, nx).collect();
        for row in &mut rows {
            along_row(row, reach);
        }
        across_rows(&mut rows, reach);
    });
    let rows = rows(face, closeness, nx);
    par::for_each(par::walls(rows, ny), |_, mut rows| across_rows(&mut rows, reach));
}

fn rows<'a>(
    face: &'a mut [u32],
    closeness: &'a mut [i16],
    nx: usize,
) -> impl Iterator<Item = Row<'a>> {
    let rows = face.chunks_mut(nx).zip(closeness.chunks_mut(nx));
    rows.map(|(face, closeness)| Row { face, closeness })
}

/// What a seed's closeness is: its distance is 0.
pub(crate) fn seed_closeness(reach: usize) -> i16 {
    closeness(reach, 0)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "reach and distance are at most 180, and its square is below 2^15"
)]
fn closeness(reach: usize, distance: usize) -> i16 {
    (reach * reach + 1) as i16 - (distance * distance) as i16
}

fn along_row(row: &mut Row<'_>, reach: usize) {
    let seed = seed_closeness(reach);
    let Some(first) = row.face.iter().position(|&f| f != 0) else {
        return;
    };
    let mut from = first;
    for i in first..row.face.len() {
        if row.face[i] != 0 {
            row.closeness[i] = seed;
            from = i;
        } else if i - from <= reach {
            row.closeness[i] = closeness(reach, i - from);
            row.face[i] = row.face[from];
        }
    }
    for i in (0..from).rev() {
        if row.closeness[i] == seed {
            from = i;
        } else if from - i <= reach && closeness(reach, from - i) > row.closeness[i] {
            row.closeness[i] = closeness(reach, from - i);
            row.face[i] = row.face[from];
        }
    }
}

/// Scratch for sixteen columns across some rows.
#[derive(Default)]
struct Columns {
    closeness: Vec<[i16; LANES]>,
    face: Vec<[u32; LANES]>,
    /// Nearest row at or before this one, and at or after it, that has anything.
    before: Vec<usize>,
    after: Vec<usize>,
}

fn across_rows(rows: &mut [Row<'_>], reach: usize) {
    let Some(first) = rows.first() else {
        return;
    };
    let mut columns = Columns::default();
    for start in (0..first.face.len()).step_by(LANES) {
        if columns.load(rows, start) {
            for (r, row) in rows.iter_mut().enumerate() {
                columns.best(r, reach, |lane, closeness, face| {
                    row.closeness[start + lane] = closeness;
                    row.face[start + lane] = face;
                });
            }
        }
    }
}

impl Columns {
    /// Copies columns from `start`; false when there is nothing in them.
    fn load(&mut self, rows: &[Row<'_>], start: usize) -> bool {
        self.closeness.clear();
        self.face.clear();
        self.before.clear();
        let mut last = usize::MAX;
        for (r, row) in rows.iter().enumerate() {
            let end = (start + LANES).min(row.face.len());
            let mut closeness = [0; LANES];
            closeness[..end - start].copy_from_slice(&row.closeness[start..end]);
            if closeness != [0; LANES] {
                last = r;
            }
            let mut face = [0; LANES];
            face[..end - start].copy_from_slice(&row.face[start..end]);
            self.closeness.push(closeness);
            self.face.push(face);
            self.before.push(last);
        }
        if last == usize::MAX {
            return false;
        }
        self.after.clear();
        self.after.resize(rows.len(), usize::MAX);
        let mut next = usize::MAX;
        for r in (0..rows.len()).rev() {
            if self.before[r] == r {
                next = r;
            }
            self.after[r] = next;
        }
        true
    }

    /// Hands out what changes in row `r`: lane, closeness, face.
    #[inline]
    fn best(&self, r: usize, reach: usize, mut change: impl FnMut(usize, i16, u32)) {
        let before = if self.before[r] == usize::MAX { usize::MAX } else { r - self.before[r] };
        let after = if self.after[r] == usize::MAX { usize::MAX } else { self.after[r] - r };
        let nearest = before.min(after);
        if nearest > reach {
            return;
        }
        let mut best = self.closeness[r];
        let mut from = [0_i16; LANES];
        for k in nearest.max(1)..=reach {
            let limit = closeness(reach, k);
            // Looked at now and then only: it costs as much as a row.
            let look = k < 3 || k % 3 == 0;
            if look && best.iter().fold(i16::MAX, |least, &b| least.min(b)) >= limit {
                break;
            }
            let loss = closeness(reach, 0) - limit;
            let back = row_number(k);
            if r >= k {
                take(&mut best, &mut from, &self.closeness[r - k], loss, -back);
            }
            if r + k < self.closeness.len() {
                take(&mut best, &mut from, &self.closeness[r + k], loss, back);
            }
        }
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
fn row_number(k: usize) -> i16 {
    k as i16
}

/// Keeps the larger of `best` and `other - loss` in each lane, and whence it came.
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

    /// Squared distance to the nearest seed, by looking at each.
    fn nearest(node: usize, seeds: &[usize], [nx, ny, _]: [usize; 3]) -> Option<usize> {
        let place = |node: usize| [node % nx, node / nx % ny, node / (nx * ny)];
        let apart = |seed: usize| -> usize {
            place(node).iter().zip(place(seed)).map(|(a, b)| a.abs_diff(b).pow(2)).sum()
        };
        seeds.iter().map(|&seed| apart(seed)).min()
    }

    /// Every node within reach has the face of a seed that no other is nearer than.
    #[test]
    fn faces_come_from_a_nearest_seed() {
        arbtest::arbtest(|u| {
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
            spread(&mut face, &mut kept, dims, reach);
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
