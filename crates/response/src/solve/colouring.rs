//! Batches of rows of which no two write to the same particle.

/// Rows sorted by batch, and where each batch ends.
pub(super) struct Colouring {
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

/// Colours that a row may have. A particle in more contacts than that sends
/// the rest of them to one last batch, which is swept in sequence; a muscle's
/// vertices have a handful.
const COLOURS: u32 = u64::BITS;

/// Gives each row in turn the lowest colour that none of its particles has.
pub(super) fn colour(
    row_count: u32,
    particle_count: usize,
    particles_of: impl Fn(u32, &mut dyn FnMut(u32)),
) -> Colouring {
    let mut used = vec![0_u64; particle_count];
    let mut colours = Vec::with_capacity(row_count as usize);
    for row in 0..row_count {
        let mut taken = 0;
        particles_of(row, &mut |k| taken |= used[k as usize]);
        let colour = taken.trailing_ones();
        if colour < COLOURS {
            particles_of(row, &mut |k| used[k as usize] |= 1 << colour);
        }
        colours.push(colour);
    }
    sort_by_colour(&colours)
}

/// One batch of all rows, in the order given.
pub(super) fn uncoloured(row_count: u32) -> Colouring {
    let all = Batch { start: 0, end: row_count as usize, independent: row_count <= 1 };
    Colouring { order: (0..row_count).collect(), batches: vec![all] }
}

/// Sorts by counting, so that rows of a colour stay in the order given.
fn sort_by_colour(colours: &[u32]) -> Colouring {
    let mut counts = vec![0_usize; COLOURS as usize + 1];
    for &colour in colours {
        counts[colour as usize] += 1;
    }
    let mut batches = Vec::new();
    let mut next = Vec::with_capacity(counts.len());
    let mut start = 0;
    for (colour, count) in counts.into_iter().enumerate() {
        let end = start + count;
        if count > 0 {
            batches.push(Batch { start, end, independent: colour < COLOURS as usize });
        }
        next.push(start);
        start = end;
    }
    let mut order = vec![0; colours.len()];
    for (row, &colour) in (0..).zip(colours) {
        order[next[colour as usize]] = row;
        next[colour as usize] += 1;
    }
    Colouring { order, batches }
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
            let colouring = colour(count, particle_count as usize, each);
            let mut sorted = colouring.order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..count).collect::<Vec<_>>());
            let ends: Vec<_> = colouring.batches.iter().map(|b| (b.start, b.end)).collect();
            assert!(ends.windows(2).all(|w| w[0].1 == w[1].0), "{ends:?}");
            for batch in colouring.batches.iter().filter(|b| b.independent) {
                let rows_in = &colouring.order[batch.start..batch.end];
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
        let colouring = colour(100, 1, |_, visit| visit(0));
        let last = colouring.batches.last().unwrap();
        assert_eq!((last.end - last.start, last.independent), (36, false));
    }
}
