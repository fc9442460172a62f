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
