//! Lists of where each active particle occurs in the rows and the bonds of a problem.

use crate::elastic::Terms;

/// Occurrence of a particle in a row or a bond.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Occurrence {
    pub(crate) number: u32,
    pub(crate) weight: f64,
}

/// Marks particles that are not active.
pub(crate) const INACTIVE: u32 = u32::MAX;

/// Occurrences of all active particles, one after the other (compressed sparse rows).
pub(crate) struct Occurrences {
    pub(crate) all: Vec<Occurrence>,
    pub(crate) ends: Vec<usize>,
}

impl Occurrences {
    pub(crate) fn of(&self, i: usize) -> &[Occurrence] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.all[start..self.ends[i]]
    }

    /// Numbers `count` rows or bonds anew, in the order in which particles occur in them, so that those of a particle
    /// are near each other in memory; returns the old number of each.
    pub(crate) fn number_by_first(&mut self, count: usize) -> Vec<u32> {
        let mut new_numbers = vec![INACTIVE; count];
        let (mut order, mut next) = (Vec::with_capacity(count), 0);
        for Occurrence { number, .. } in &mut self.all {
            let new = &mut new_numbers[*number as usize];
            if *new == INACTIVE {
                order.push(*number);
                (*new, next) = (next, next + 1);
            }
            *number = *new;
        }
        order
    }
}

/// Lists where each active particle occurs in the terms of rows or bonds.
pub(crate) fn occurrences<'t>(
    terms: impl Iterator<Item = &'t Terms> + Clone,
    numbers: &[u32],
    count: usize,
) -> Occurrences {
    // Counted first, so that each list is filled in place.
    let mut ends = vec![0; count];
    for &(particle, _) in terms.clone().flatten() {
        let number = numbers[particle as usize];
        if number != INACTIVE {
            ends[number as usize] += 1;
        }
    }
    let mut total = 0;
    for end in &mut ends {
        (*end, total) = (total, total + *end);
    }

    // Each start moves to the end of its list.
    let mut all = vec![Occurrence::default(); total];
    for (number, terms) in (0..).zip(terms) {
        for &(particle, weight) in terms {
            let i = numbers[particle as usize];
            if i != INACTIVE {
                let end = &mut ends[i as usize];
                all[*end] = Occurrence { number, weight };
                *end += 1;
            }
        }
    }
    Occurrences { all, ends }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_numbered_in_the_order_in_which_particles_occur_in_them() {
        let terms = |[p, q]: [u32; 2]| -> Terms { [(p, 1.0), (q, -1.0)].into_iter().collect() };
        let rows = [[3, 1], [2, 0], [0, 3], [1, 2]].map(terms);
        let numbers = [0, 1, 2, 3];
        let before = occurrences(rows.iter(), &numbers, 4);
        let mut after = occurrences(rows.iter(), &numbers, 4);
        let order = after.number_by_first(4);
        assert_eq!(order, [1, 2, 0, 3]);
        for i in 0..4 {
            let old = after.of(i).iter().map(|it| (order[it.number as usize], it.weight));
            assert!(old.eq(before.of(i).iter().map(|it| (it.number, it.weight))), "particle {i}");
        }
    }
}
