//! Graph coloring: batches of rows of which no two write to the same particle.

/// Greedy coloring: each row in turn gets the lowest color that none of its particles has.
///
/// Its lists are kept for the next coloring.
#[derive(Clone, Debug, Default)]
pub(super) struct Coloring {
    /// Rows sorted by batch.
    pub(super) order: Vec<u32>,
    /// Range of each batch.
    pub(super) batches: Vec<Batch>,
    /// Bit set of the colors at each particle.
    used: Vec<u64>,
    of_rows: Vec<u32>,
    /// Place of the next row of each color.
    next: Vec<usize>,
}

/// Consecutive rows of the sorted list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Batch {
    pub(super) start: usize,
    pub(super) end: usize,
    /// True if no two of its rows share a particle that can move.
    pub(super) independent: bool,
}

/// Maximum number of colors. A particle in more contacts sends the rest of them to one
/// last batch, which is swept in sequence; a muscle's vertices have a handful.
const COLORS: u32 = u64::BITS;

impl Coloring {
    /// Forgets all rows, and makes room for others.
    pub(super) fn clear(&mut self, row_count: usize, particle_count: usize) {
        self.of_rows.clear();
        self.of_rows.reserve(row_count);
        self.used.clear();
        self.used.resize(particle_count, 0);
    }

    /// Colors the next row, which writes to `particles`.
    pub(super) fn add_row(&mut self, particles: impl Iterator<Item = u32> + Clone) {
        let taken = particles.clone().fold(0, |taken, k| taken | self.used[k as usize]);
        let color = taken.trailing_ones();
        if color < COLORS {
            for k in particles {
                self.used[k as usize] |= 1 << color;
            }
        }
        self.of_rows.push(color);
    }

    /// Sorts the rows by color; rows of one color stay in the order given.
    pub(super) fn sort(&mut self) {
        // Counting sort: the end of one color is the start of the next.
        self.next.clear();
        self.next.resize(COLORS as usize + 1, 0);
        for &color in &self.of_rows {
            self.next[color as usize] += 1;
        }
        self.batches.clear();
        let mut start = 0;
        for (color, next) in self.next.iter_mut().enumerate() {
            let end = start + std::mem::replace(next, start);
            if end > start {
                self.batches.push(Batch { start, end, independent: color < COLORS as usize });
            }
            start = end;
        }

        // Place the rows in the order given.
        self.order.clear();
        self.order.resize(self.of_rows.len(), 0);
        for (row, &color) in (0..).zip(&self.of_rows) {
            self.order[self.next[color as usize]] = row;
            self.next[color as usize] += 1;
        }
    }

    /// Makes one batch of all rows, in the order given.
    pub(super) fn keep_order(&mut self, row_count: u32) {
        self.order.clear();
        self.order.extend(0..row_count);
        self.batches.clear();
        let all = Batch { start: 0, end: row_count as usize, independent: row_count <= 1 };
        self.batches.push(all);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn color(rows: &[Vec<u32>], particle_count: usize) -> Coloring {
        let mut coloring = Coloring::default();
        // A second coloring in the same memory starts afresh.
        for _ in 0..2 {
            coloring.clear(rows.len(), particle_count);
            rows.iter().for_each(|particles| coloring.add_row(particles.iter().copied()));
            coloring.sort();
        }
        coloring
    }

    #[test]
    fn batches_hold_every_row_once_and_share_no_particle() {
        fixtures::generate::cases(21, 1000, |u| {
            let particle_count = u.int_in_range(1..=12_u32)?;
            let mut rows: Vec<Vec<u32>> = Vec::new();
            for _ in 0..u.int_in_range(0..=100)? {
                let of_row = u.int_in_range(1..=4)?;
                rows.push(
                    (0..of_row)
                        .map(|_| u.int_in_range(0..=particle_count - 1))
                        .collect::<Result<_, _>>()?,
                );
            }
            let coloring = color(&rows, particle_count as usize);
            let mut sorted = coloring.order.clone();
            sorted.sort_unstable();
            assert!(sorted.iter().copied().eq((0..).take(rows.len())));
            let ends: Vec<_> = coloring.batches.iter().map(|b| (b.start, b.end)).collect();
            assert!(ends.windows(2).all(|w| w[0].1 == w[1].0), "{ends:?}");
            for batch in coloring.batches.iter().filter(|b| b.independent) {
                let rows_in = &coloring.order[batch.start..batch.end];
                assert!(rows_in.is_sorted(), "order within a batch is as given");
                let mut seen = vec![None; particle_count as usize];
                for &row in rows_in {
                    for &k in &rows[row as usize] {
                        let first = *seen[k as usize].get_or_insert(row);
                        assert_eq!(first, row, "particle {k} in two rows of a batch");
                    }
                }
            }
            Ok(())
        });
    }

    #[test]
    fn a_crowded_particle_fills_the_last_batch() {
        let coloring = color(&vec![vec![0]; 100], 1);
        let last = coloring.batches.last().unwrap();
        assert_eq!((last.end - last.start, last.independent), (36, false));
    }
}
