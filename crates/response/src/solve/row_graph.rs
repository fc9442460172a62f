//! Graph of rows that share particles, and the order in which they are eliminated.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::packed::PackedSystem;

/// Average number of couplings of a row above which none are listed: more cost more than the
/// iterations that they save.
const MAX_COUPLINGS: usize = 128;

/// Couplings of rows by the particles that they share, in memory that is reused.
#[derive(Clone, Debug, Default)]
pub(super) struct RowGraph {
    sharing: Vec<Sharing>,
    /// Both ways, by row.
    couplings: Vec<Coupling>,
    /// First coupling of each row, and the end.
    starts: Vec<usize>,
    heap: BinaryHeap<Reverse<(u32, u32)>>,
    /// Per row, the number of coupled rows that are left; `None` once it is eliminated.
    degrees: Vec<Option<u32>>,
}

/// Row that acts on a particle.
#[derive(Clone, Copy, Debug)]
struct Sharing {
    particle: u32,
    row: u32,
    weight: f64,
    /// β / m.
    step: f64,
}

/// Rows that share particles, and Σ β β / m over these.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coupling {
    row: u32,
    pub(super) other: u32,
    particle: u32,
    pub(super) value: f64,
}

impl RowGraph {
    /// Lists the couplings of all rows; none where they are too many.
    pub(super) fn build(&mut self, system: &PackedSystem) {
        self.sharing.clear();
        for (row, packed) in (0..).zip(&system.rows) {
            for term in system.terms_of(packed) {
                let (particle, weight, step) = (term.particle, term.weight, term.step);
                self.sharing.push(Sharing { particle, row, weight, step });
            }
        }
        self.sharing.sort_unstable_by_key(|sharing| (sharing.particle, sharing.row));

        self.couplings.clear();
        let count = system.rows.len();
        for sharing in self.sharing.chunk_by(|a, b| a.particle == b.particle) {
            if self.couplings.len() + sharing.len() * sharing.len() > MAX_COUPLINGS * count {
                self.couplings.clear();
                break;
            }
            for a in sharing {
                for b in sharing.iter().filter(|b| b.row != a.row) {
                    let value = a.weight * b.step;
                    let (row, other, particle) = (a.row, b.row, a.particle);
                    self.couplings.push(Coupling { row, other, particle, value });
                }
            }
        }
        self.merge(count);
    }

    /// Adds up the couplings of the same rows, in the order of particles.
    fn merge(&mut self, count: usize) {
        let key = |coupling: &Coupling| (coupling.row, coupling.other, coupling.particle);
        self.couplings.sort_unstable_by_key(key);
        self.couplings.dedup_by(|next, last| {
            let is_same = (next.row, next.other) == (last.row, last.other);
            if is_same {
                last.value += next.value;
            }
            is_same
        });

        self.starts.clear();
        self.starts.resize(count + 1, 0);
        for coupling in &self.couplings {
            self.starts[coupling.row as usize + 1] += 1;
        }
        for row in 0..count {
            self.starts[row + 1] += self.starts[row];
        }
    }

    /// Returns the couplings of a row.
    pub(super) fn couplings_of(&self, row: u32) -> &[Coupling] {
        &self.couplings[self.starts[row as usize]..self.starts[row as usize + 1]]
    }

    /// Visits all rows, each time one that is coupled to the fewest of those left.
    ///
    /// In a tree there is always one that is coupled to a single other one, so that its
    /// elimination couples no others.
    pub(super) fn eliminate(&mut self, count: usize, mut visit: impl FnMut(u32)) {
        self.heap.clear();
        self.degrees.clear();
        for (row, ends) in (0..).zip(self.starts.windows(2).take(count)) {
            let degree = u32::try_from(ends[1] - ends[0]).unwrap_or(u32::MAX);
            self.degrees.push(Some(degree));
            self.heap.push(Reverse((degree, row)));
        }

        // Entries of the heap whose degree has fallen since are out of date.
        while let Some(Reverse((degree, row))) = self.heap.pop() {
            if self.degrees[row as usize] != Some(degree) {
                continue;
            }
            self.degrees[row as usize] = None;
            visit(row);
            for k in self.starts[row as usize]..self.starts[row as usize + 1] {
                let other = self.couplings[k].other;
                if let Some(degree) = &mut self.degrees[other as usize] {
                    *degree -= 1;
                    self.heap.push(Reverse((*degree, other)));
                }
            }
        }
    }
}
