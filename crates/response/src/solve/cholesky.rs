//! Incomplete Cholesky factors of the rows' matrix, the preconditioner of conjugate gradients.
//!
//! H = N W Nᵀ + A couples rows that share particles. Its factors keep the entries of H and drop
//! those that elimination would add. Rows are eliminated by how few others they are coupled to,
//! fewest first: a chain or a tree, such as a stack, adds none, and its factors are exact. There
//! conjugate gradients end after a step, whatever the masses are.
//!
//! Source: J. A. Meijerink and H. A. van der Vorst, "An iterative solution method for linear
//! systems of which the coefficient matrix is a symmetric M-matrix", Mathematics of Computation
//! 31, 1977; T. A. Manteuffel, "An incomplete factorization technique for positive definite linear
//! systems", Mathematics of Computation 34, 1980, for the shift of the diagonal.

use glam::DVec3;

use super::packed::{PackedSystem, RowGoal, Tangent};
use super::parts::Parts;
use super::row_graph::RowGraph;

/// Smallest pivot relative to the diagonal. Below, rounding and dropped entries decide it.
const MIN_PIVOT: f64 = 1e-10;

/// First relative shift of the diagonal after a pivot was too small, and the factor to the next.
const FIRST_SHIFT: f64 = 1e-4;
const SHIFT_FACTOR: f64 = 10.0;
const MAX_SHIFT: f64 = 1e3;

/// Incomplete factors L Lᵀ ≈ H, in memory that is reused.
#[derive(Clone, Debug, Default)]
pub(super) struct CholeskyFactors {
    /// Unknowns in the order of elimination, those of a row next to each other.
    unknowns: Vec<Unknown>,
    /// Unknowns of each row.
    of_rows: Vec<[u32; 2]>,
    /// Entries of H left of the diagonal, in ascending order: those of unknown k are
    /// `starts[k]..starts[k + 1]`.
    starts: Vec<usize>,
    entries: Vec<Entry>,
    /// Their values in L, and the inverse of its diagonal.
    factors: Vec<f64>,
    inverse: Vec<f64>,
    /// One value per unknown.
    values: Vec<f64>,
    graph: RowGraph,
}

/// Impulse of a row along a direction.
#[derive(Clone, Copy, Debug)]
struct Unknown {
    row: u32,
    is_normal: bool,
    direction: DVec3,
    /// Its entry in H.
    diagonal: f64,
}

/// Entry of H left of the diagonal.
#[derive(Clone, Copy, Debug)]
struct Entry {
    column: u32,
    value: f64,
}

impl CholeskyFactors {
    /// Factorizes the matrix of the rows.
    pub(super) fn factorize(&mut self, system: &PackedSystem, goals: &[RowGoal]) {
        self.graph.build(system);
        self.set_unknowns(system, goals);
        self.set_entries();

        // A matrix that is singular, or that dropped entries make so, is shifted.
        let mut shift = 0.0;
        while !self.eliminate(shift) && shift < MAX_SHIFT {
            shift = f64::max(FIRST_SHIFT, SHIFT_FACTOR * shift);
        }
    }

    /// Computes the solution of L Lᵀ z = r for the parts of all rows.
    pub(super) fn solve(&mut self, residual: &[Parts], out: &mut Vec<Parts>) {
        // Forward, along the rows of L.
        self.values.clear();
        for (number, unknown) in self.unknowns.iter().enumerate() {
            let at = residual[unknown.row as usize];
            let mut value =
                if unknown.is_normal { at.normal } else { at.tangent.dot(unknown.direction) };
            for k in self.starts[number]..self.starts[number + 1] {
                value -= self.factors[k] * self.values[self.entries[k].column as usize];
            }
            self.values.push(self.inverse[number] * value);
        }

        // Back, along its columns.
        out.clear();
        out.resize(residual.len(), Parts::default());
        for (number, unknown) in self.unknowns.iter().enumerate().rev() {
            let value = self.inverse[number] * self.values[number];
            for k in self.starts[number]..self.starts[number + 1] {
                self.values[self.entries[k].column as usize] -= self.factors[k] * value;
            }
            let part = &mut out[unknown.row as usize];
            if unknown.is_normal {
                part.normal = value;
            } else {
                part.tangent += value * unknown.direction;
            }
        }
    }

    /// Lists the unknowns in the order in which rows are eliminated.
    fn set_unknowns(&mut self, system: &PackedSystem, goals: &[RowGoal]) {
        let Self { unknowns, of_rows, graph, .. } = self;
        unknowns.clear();
        of_rows.clear();
        of_rows.resize(system.rows.len(), [0; 2]);
        graph.eliminate(system.rows.len(), |row| {
            let (packed, goal) = (&system.rows[row as usize], &goals[row as usize]);
            let first = index(unknowns.len());
            let (hard, compliant) = (packed.step.recip(), (packed.step * packed.hardness).recip());
            let direction = packed.normal;
            unknowns.push(Unknown { row, is_normal: true, direction, diagonal: compliant });

            // A share of a slip has one more, a row that holds the tangent plane two.
            let mut push = |direction: DVec3, diagonal: f64| {
                unknowns.push(Unknown { row, is_normal: false, direction, diagonal });
            };
            match goal.tangent {
                Tangent::Free | Tangent::Disc => {}
                Tangent::Share => push(goal.share.direction, hard),
                Tangent::Compliant => {
                    let (first, second) = packed.normal.any_orthonormal_pair();
                    push(first, compliant);
                    push(second, compliant);
                }
            }
            of_rows[row as usize] = [first, index(unknowns.len())];
        });
    }

    /// Lists the entries of H between unknowns and those eliminated before them.
    fn set_entries(&mut self) {
        let Self { unknowns, of_rows, starts, entries, graph, .. } = self;
        entries.clear();
        starts.clear();
        starts.push(0);
        for (number, unknown) in (0..).zip(&*unknowns) {
            // Unknowns of the same row are not coupled in H, but they are in L.
            let [own, _] = of_rows[unknown.row as usize];
            entries.extend((own..number).map(|column| Entry { column, value: 0.0 }));
            for coupling in graph.couplings_of(unknown.row) {
                let [first, end] = of_rows[coupling.other as usize];
                if end > own {
                    continue;
                }
                for column in first..end {
                    let cosine = unknown.direction.dot(unknowns[column as usize].direction);
                    entries.push(Entry { column, value: coupling.value * cosine });
                }
            }
            let start = starts[number as usize];
            entries[start..].sort_unstable_by_key(|entry| entry.column);
            starts.push(entries.len());
        }
    }

    /// Computes L for H with its diagonal raised by a share; returns false where a pivot is too
    /// small.
    fn eliminate(&mut self, shift: f64) -> bool {
        let Self { unknowns, starts, entries, factors, inverse, values, .. } = self;
        factors.clear();
        inverse.clear();
        values.clear();
        values.resize(unknowns.len(), 0.0);
        for (number, unknown) in unknowns.iter().enumerate() {
            // Row by row: values holds the present one, and zeros elsewhere.
            let own = starts[number]..starts[number + 1];
            let diagonal = (1.0 + shift) * unknown.diagonal;
            let mut pivot = diagonal;
            for k in own.clone() {
                let column = entries[k].column as usize;
                let mut value = entries[k].value;
                for j in starts[column]..starts[column + 1] {
                    value -= factors[j] * values[entries[j].column as usize];
                }
                value *= inverse[column];
                pivot -= value * value;
                values[column] = value;
                factors.push(value);
            }
            for k in own {
                values[entries[k].column as usize] = 0.0;
            }
            if pivot <= MIN_PIVOT * diagonal {
                return false;
            }
            inverse.push(pivot.sqrt().recip());
        }
        true
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rows and terms are numbered in 32 bits")]
fn index(count: usize) -> u32 {
    count as u32
}
