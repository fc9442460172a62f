//! Coupled rows of all kinds by every solver, against a dense reference solution.

use glam::DVec3;
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

    /// Solves by dense elimination, for the first modes of all rows that fulfill the conditions.
    fn dense(&self, level: SolveLevel) -> Vec<DVec3> {
        let rows: Vec<_> = self.contacts.iter().map(|c| DenseRow::new(self, c, level)).collect();
        let modes: Vec<Vec<Mode>> = rows.iter().map(DenseRow::modes).collect();
        let count: usize = modes.iter().map(Vec::len).product();
        for mut number in 0..count {
            let mut present = Vec::new();
            for modes in &modes {
                present.push(modes[number % modes.len()]);
                number /= modes.len();
            }
            let impulses = self.eliminate(&rows, &present);
            let q = self.after(&impulses);
            let mut all = rows.iter().zip(&present).zip(&impulses);
            if all.all(|((row, mode), impulse)| row.holds(*mode, *impulse, &q)) {
                return q;
            }
        }
        unreachable!("no modes fulfill the conditions")
    }

    /// Impulses of the rows in some modes.
    fn eliminate(&self, rows: &[DenseRow], modes: &[Mode]) -> Vec<DVec3> {
        let mut unknowns = Vec::new();
        for (row, mode) in rows.iter().zip(modes) {
            unknowns.extend(row.unknowns(*mode).into_iter().map(|unknown| (row, unknown)));
        }
        let mut matrix = Vec::new();
        for (number, (row, unknown)) in unknowns.iter().enumerate() {
            let mut entries = Vec::new();
            for (place, (other, by)) in unknowns.iter().enumerate() {
                let mut coupling = 0.0;
                for k in 0..self.q.len() {
                    coupling += row.weights[k] * other.weights[k] * self.w[k];
                }
                let own = if number == place { unknown.compliance } else { 0.0 };
                entries.push(coupling * unknown.along.dot(by.impulse) + own);
            }
            entries.push((row.at(&self.q) - row.target).dot(unknown.along));
            matrix.push(entries);
        }
        let mut impulses = vec![DVec3::ZERO; rows.len()];
        for ((row, unknown), value) in unknowns.iter().zip(gauss(matrix)) {
            let number = rows.iter().position(|other| std::ptr::eq(other, *row));
            impulses[number.expect("one of the rows")] += value * unknown.impulse;
        }
        impulses
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

/// State of a row in a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mode {
    /// True if the normal impulse is not 0.
    pushes: bool,
    rubs: Rub,
}

/// State of the friction of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rub {
    /// No impulse: the slip is no larger than its target.
    Free,
    /// The slip is at its target.
    Held,
    /// The impulse is the largest one: the slip is no smaller than its target.
    Largest,
}

/// One unknown of the dense reference: the part of the motion that it sets, and its impulse.
struct Unknown {
    along: DVec3,
    impulse: DVec3,
    compliance: f64,
}

/// One row of the dense reference.
struct DenseRow {
    weights: Vec<f64>,
    normal: DVec3,
    target: DVec3,
    compliance: f64,
    is_one_sided: bool,
    is_vector: bool,
    /// Direction of the slip at the start, where the source's friction acts on it.
    slip: Option<DVec3>,
    /// Largest impulse of friction over the normal one, where it has such a limit.
    ratio: Option<f64>,
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
        let start = contact.stencil.combine(|k| strip.q[k as usize]);
        let (approach, depth) = (start.dot(normal), -contact.gap);
        let lambda = (1.0 + depth).clamp(0.0, 1.0);
        let is_position = level == SolveLevel::Position;
        let slip = start - approach * normal;
        let left = (1.0 - 0.6 * lambda) * slip;
        let (target, is_one_sided) = match *constraint {
            Constraint::Vector(target) => (target, false),
            Constraint::Contact if is_position => (-depth * normal, true),
            Constraint::Contact => ((1.0 - lambda) * approach.max(0.0) * normal, true),
            Constraint::OneSided(target) => (target * normal, true),
            Constraint::TwoSided(target) => (target * normal, false),
            _ => unreachable!("another constraint"),
        };
        let is_vector = matches!(constraint, Constraint::Vector(_));

        // Alone, the row has the push that meets its target, and the friction in proportion.
        let is_limited = is_one_sided && !is_position;
        let hardness = 1.0 / (1.0 + law.compliance() / mobility(&weights, &strip.w));
        let push = hardness * (approach - target.dot(normal));
        let rubs = law.friction() != Friction::NONE
            && lambda > 0.0
            && (!is_limited || (approach > 0.0 && push > 0.0));
        let ratio = is_limited.then(|| 0.6 * lambda * slip.length() / push);
        let target = if rubs { target + left } else { target };
        let slip = rubs.then(|| slip.normalize());
        let compliance = law.compliance();
        Self { weights, normal, target, compliance, is_one_sided, is_vector, slip, ratio }
    }

    fn at(&self, q: &[DVec3]) -> DVec3 {
        self.weights.iter().zip(q).map(|(weight, q)| *weight * *q).sum()
    }

    /// All modes that the row may be in.
    fn modes(&self) -> Vec<Mode> {
        let mut modes = Vec::new();
        for pushes in [true, false] {
            for rubs in [Rub::Free, Rub::Held, Rub::Largest] {
                let can_push = pushes || self.is_one_sided;
                let can_rub = match rubs {
                    Rub::Free => true,
                    Rub::Held => self.slip.is_some() && (pushes || self.ratio.is_none()),
                    Rub::Largest => self.slip.is_some() && pushes && self.ratio.is_some(),
                };
                if can_push && can_rub {
                    modes.push(Mode { pushes, rubs });
                }
            }
        }
        modes
    }

    fn unknowns(&self, mode: Mode) -> Vec<Unknown> {
        let compliance = self.compliance;
        if self.is_vector {
            let axes = [DVec3::X, DVec3::Y, DVec3::Z];
            return axes.map(|along| Unknown { along, impulse: along, compliance }).into();
        }
        let (n, slip) = (self.normal, self.slip.unwrap_or_default());
        let mut unknowns = Vec::new();
        if mode.pushes {
            let most = self.ratio.unwrap_or(0.0) * slip;
            let impulse = if mode.rubs == Rub::Largest { n + most } else { n };
            unknowns.push(Unknown { along: n, impulse, compliance });
        }
        if mode.rubs == Rub::Held {
            unknowns.push(Unknown { along: slip, impulse: slip, compliance: 0.0 });
        }
        unknowns
    }

    /// Returns true if a solution fulfills the conditions of the mode.
    fn holds(&self, mode: Mode, impulse: DVec3, q: &[DVec3]) -> bool {
        const ROUNDING: f64 = 1e-12;
        let left = self.at(q) - self.target;
        let push = impulse.dot(self.normal);
        let pushes = !self.is_one_sided
            || if mode.pushes { push >= -ROUNDING } else { left.dot(self.normal) <= ROUNDING };
        let Some(slip) = self.slip else { return pushes };
        let most = self.ratio.map_or(f64::INFINITY, |ratio| ratio * push);
        let (left, rub) = (left.dot(slip), impulse.dot(slip));
        pushes
            && match mode.rubs {
                // Without a push, no slip is too fast.
                Rub::Free => left <= ROUNDING || most <= ROUNDING,
                Rub::Held => rub >= -ROUNDING && rub <= most + ROUNDING,
                Rub::Largest => left >= -ROUNDING,
            }
    }
}

/// Σ β² / m of a row.
fn mobility(weights: &[f64], w: &[f64]) -> f64 {
    weights.iter().zip(w).map(|(weight, w)| weight * weight * w).sum()
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
