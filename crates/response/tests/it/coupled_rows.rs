//! Coupled rows of all kinds by every solver, against a dense reference solution.

use glam::{DMat3, DVec3};
use response::{Constraint, ContactLaw, ContactRows, Friction, SolveLevel};
use surface::{Contact, Stencil};

use crate::common::{self, LEVELS, METHODS, Stream, law, solve_by, term};

/// Rows of a strip in which each shares particles with the next, of all kinds.
struct Strip {
    q: Vec<DVec3>,
    w: Vec<f64>,
    contacts: Vec<(Contact, ContactLaw, Constraint)>,
}

impl Strip {
    fn new(count: u32, seed: u64, one_sided: bool) -> Self {
        let mut s = Stream(seed);
        let mut any = || DVec3::new(s.next(), s.next(), s.next()) - 0.5;
        let q: Vec<DVec3> = (0..=2 * count).map(|_| any()).collect();
        let normals: Vec<DVec3> = (0..count).map(|_| (any() + DVec3::Z).normalize()).collect();
        let targets: Vec<DVec3> = (0..count).map(|_| any()).collect();
        let w = (0..=2 * count).map(|k| [1.0, 0.3, 2.0, 3.0, 0.0][k as usize % 5]).collect();
        let share = Friction::share(0.6).expect("in range");
        let mut contacts = Vec::new();
        for k in 0..count {
            let terms = [term(2 * k + 1, -1.0), term(2 * k, 0.3), term(2 * k + 2, 0.7)];
            let stencil = Stencil::new(&terms).expect("three terms");
            let (normal, target) = (normals[k as usize], targets[k as usize]);
            let contact = common::contact(stencil, normal, -target.x);
            let alpha = [0.0, 0.4, 0.0][k as usize % 3];
            let law = law(0.0).with_compliance(alpha).expect("in range");
            let of_kind = match k % 4 {
                0 => (contact, law, Constraint::Vector(target)),
                1 if one_sided => (contact, law.with_friction(share), Constraint::Contact),
                2 if one_sided => (contact, law, Constraint::OneSided(target.y)),
                _ => (contact, law.with_friction(share), Constraint::TwoSided(target.z)),
            };
            contacts.push(of_kind);
        }
        Self { q, w, contacts }
    }

    fn rows(&self) -> ContactRows {
        let mut rows = ContactRows::new(self.q.len());
        for (contact, law, constraint) in &self.contacts {
            rows.push_constraint(contact, *law, *constraint).expect("valid");
        }
        rows
    }

    /// Solves by dense elimination, for the first active set that fulfills the conditions.
    fn dense(&self, level: SolveLevel) -> Vec<DVec3> {
        let rows: Vec<_> = self.contacts.iter().map(|c| DenseRow::new(self, c, level)).collect();
        let one_sided: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].one_sided).collect();
        for set in 0..1_u32 << one_sided.len() {
            let is_off =
                |i: usize| one_sided.iter().position(|k| *k == i).is_some_and(|p| set >> p & 1 > 0);
            let impulses = self.eliminate(&rows, is_off);
            let q = self.after(&impulses);
            let holds = rows.iter().zip(&impulses).enumerate().all(|(i, (row, j))| {
                let left = (row.at(&q) - row.target).dot(row.normal);
                !row.one_sided
                    || if is_off(i) { left <= 1e-12 } else { j.dot(row.normal) >= -1e-12 }
            });
            if holds {
                return q;
            }
        }
        unreachable!("no active set fulfills the conditions")
    }

    /// Impulses of the rows, with no normal one where `is_off`.
    fn eliminate(&self, rows: &[DenseRow], is_off: impl Fn(usize) -> bool) -> Vec<DVec3> {
        let n = rows.len();
        let projections: Vec<DMat3> = (0..n).map(|i| rows[i].directions(is_off(i))).collect();
        let mut matrix = vec![vec![0.0; 3 * n + 1]; 3 * n];
        for i in 0..n {
            for j in 0..n {
                let mut coupling = 0.0;
                for k in 0..self.q.len() {
                    coupling += rows[i].weights[k] * rows[j].weights[k] * self.w[k];
                }
                let mut block = projections[i] * projections[j] * coupling;
                if i == j {
                    // Directions without an impulse have the equation λ = 0.
                    block += projections[i] * rows[i].compliance * projections[i];
                    block += DMat3::IDENTITY - projections[i];
                }
                for r in 0..3 {
                    for c in 0..3 {
                        matrix[3 * i + r][3 * j + c] = block.col(c)[r];
                    }
                }
            }
            let right = projections[i] * (rows[i].at(&self.q) - rows[i].target);
            for r in 0..3 {
                matrix[3 * i + r][3 * n] = right[r];
            }
        }
        let solution = gauss(matrix);
        (0..n).map(|i| DVec3::from_slice(&solution[3 * i..])).collect()
    }

    fn after(&self, impulses: &[DVec3]) -> Vec<DVec3> {
        let mut q = self.q.clone();
        for ((contact, _, _), impulse) in self.contacts.iter().zip(impulses) {
            for t in contact.stencil.terms() {
                q[t.particle as usize] -= t.weight * self.w[t.particle as usize] * *impulse;
            }
        }
        q
    }
}

/// One row of the dense reference: its directions are all, or the normal, with a tangent where
/// the source's friction holds it.
struct DenseRow {
    weights: Vec<f64>,
    normal: DVec3,
    target: DVec3,
    compliance: DMat3,
    one_sided: bool,
    has_tangent: bool,
}

impl DenseRow {
    fn new(
        strip: &Strip,
        (contact, law, constraint): &(Contact, ContactLaw, Constraint),
        level: SolveLevel,
    ) -> Self {
        let mut weights = vec![0.0; strip.q.len()];
        for t in contact.stencil.terms() {
            weights[t.particle as usize] += t.weight;
        }
        let normal = contact.normal;
        let along = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        let start = contact.stencil.combine(|k| strip.q[k as usize]);
        let (approach, depth) = (start.dot(normal), -contact.gap);
        let lambda = (1.0 + depth).clamp(0.0, 1.0);
        let is_position = level == SolveLevel::Position;
        let is_share = law.friction() != Friction::NONE;
        let left = (1.0 - 0.6 * lambda) * (start - approach * normal);
        let of_normal = |t: f64| t * normal + if is_share { left } else { DVec3::ZERO };
        let (target, one_sided) = match *constraint {
            Constraint::Vector(target) => (target, false),
            Constraint::Contact if is_position => (of_normal(-depth), true),
            Constraint::Contact => (of_normal((1.0 - lambda) * approach.max(0.0)), true),
            Constraint::OneSided(target) => (of_normal(target), true),
            Constraint::TwoSided(target) => (of_normal(target), false),
            _ => unreachable!("another constraint"),
        };
        let is_vector = matches!(constraint, Constraint::Vector(_));
        let rubs = is_share && (!one_sided || is_position || approach > 0.0);
        let compliance = law.compliance() * if is_vector { DMat3::IDENTITY } else { along };
        let has_tangent = is_vector || rubs;
        Self { weights, normal, target, compliance, one_sided, has_tangent }
    }

    fn at(&self, q: &[DVec3]) -> DVec3 {
        self.weights.iter().zip(q).map(|(weight, q)| *weight * *q).sum()
    }

    fn directions(&self, is_off: bool) -> DMat3 {
        let n = self.normal;
        let along = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        let across = if self.has_tangent { DMat3::IDENTITY - along } else { DMat3::ZERO };
        if is_off { across } else { along + across }
    }
}

/// Gaussian elimination with pivots.
fn gauss(mut m: Vec<Vec<f64>>) -> Vec<f64> {
    let n = m.len();
    for column in 0..n {
        let mut pivot = column;
        for row in column..n {
            if m[row][column].abs() > m[pivot][column].abs() {
                pivot = row;
            }
        }
        m.swap(column, pivot);
        let (done, rest) = m.split_at_mut(column + 1);
        for row in rest {
            let factor = row[column] / done[column][column];
            for (entry, of_pivot) in row.iter_mut().zip(&done[column]) {
                *entry -= factor * of_pivot;
            }
        }
    }
    let mut x = vec![0.0; n];
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| m[row][k] * x[k]).sum();
        x[row] = (m[row][n] - known) / m[row][row];
    }
    x
}

#[test]
fn coupled_rows_of_all_kinds_are_those_of_the_dense_solution() {
    for (count, one_sided, seeds) in [(9, false, 12), (9, true, 30)] {
        for seed in 0..seeds {
            for level in LEVELS {
                let strip = Strip::new(count, seed, one_sided);
                let expected = strip.dense(level);
                for method in METHODS {
                    let mut q = strip.q.clone();
                    let report = solve_by(&strip.rows(), &strip.w, level, &mut q, method);
                    assert!(report.converged, "{method:?} {level:?} {seed}: {report:?}");
                    for (found, expected) in q.iter().zip(&expected) {
                        let error = (*found - *expected).length();
                        assert!(error < 1e-9, "{method:?} {level:?} seed {seed}: {error}");
                    }
                }
            }
        }
    }
}
