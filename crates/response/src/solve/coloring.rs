//! Batches of rows of which no two write to the same particle.

/// Rows sorted by batch, and where each batch ends.
pub(super) struct Coloring {
    pub(super) order: Vec<u32>,
    pub(super) batches: Vec<Batch>,
}

/// Consecutive rows of the sorted list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Batch {
    pub(super) start: usize,
    pub(super) end: usize,
    /// Whether no two of its rows share a particle that can move.
    pub(super) independent: bool,
}

/// Colors that a row may have. A particle in more contacts than that sends
/// the rest of them to one last batch, which is swept in sequence; a muscle's
/// vertices have a handful.
const COLORS: u32 = u64::BITS;

/// Gives each row in turn the lowest color that none of its particles has.
pub(super) fn color(
    row_count: u32,
    particle_count: usize,
    particles_of: impl Fn(u32, &mut dyn FnMut(u32)),
) -> Coloring {
    let mut used = vec![0_u64; particle_count];
    let mut colors = Vec::with_capacity(row_count as usize);
    for row in 0..row_count {
        let mut taken = 0;
        particles_of(row, &mut |k| taken |= used[k as usize]);
        let color = taken.trailing_ones();
        if color < COLORS {
            particles_of(row, &mut |k| used[k as usize] |= 1 << color);
        }
        colors.push(color);
    }
    sort_by_color(&colors)
}

/// One batch of all rows, in the order given.
pub(super) fn uncolored(row_count: u32) -> Coloring {
    let all = Batch { start: 0, end: row_count as usize, independent: row_count <= 1 };
    Coloring { order: (0..row_count).collect(), batches: vec![all] }
}

/// Sorts by counting, so that rows of a color stay in the order given.
fn sort_by_color(colors: &[u32]) -> Coloring {
    let mut counts = vec![0_usize; COLORS as usize + 1];
    for &color in colors {
        counts[color as usize] += 1;
    }
    let mut batches = Vec::new();
    let mut next = Vec::with_capacity(counts.len());
    let mut start = 0;
    for (color, count) in counts.into_iter().enumerate() {
        let end = start + count;
        if count > 0 {
            batches.push(Batch { start, end, independent: color < COLORS as usize });
        }
        next.push(start);
        start = end;
    }
    let mut order = vec![0; colors.len()];
    for (row, &color) in (0..).zip(colors) {
        order[next[color as usize]] = row;
        next[color as usize] += 1;
    }
    Coloring { order, batches }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_hold_every_row_once_and_share_no_particle() {
        arbtest::arbtest(|u| {
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
            let count = u32::try_from(rows.len()).unwrap();
            let each = |row: u32, visit: &mut dyn FnMut(u32)| {
                rows[row as usize].iter().for_each(|&k| visit(k));
            };
            let coloring = color(count, particle_count as usize, each);
            let mut sorted = coloring.order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..count).collect::<Vec<_>>());
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
        let coloring = color(100, 1, |_, visit| visit(0));
        let last = coloring.batches.last().unwrap();
        assert_eq!((last.end - last.start, last.independent), (36, false));
    }
}
