//! Conjugate gradients with bounds: the equality Q_c = t + α λ of all rows, on the active
//! set of the one-sided ones.
//!
//! With N the rows' directions, W the inverse masses and A the compliances,
//! H = N W Nᵀ + A is symmetric and positive semidefinite. Its impulses minimize
//! λᵀ H λ / 2 − bᵀ λ with λ_n >= 0 for one-sided rows. Without any, these are conjugate
//! gradients preconditioned by [incomplete Cholesky factors](super::cholesky) of H, which are
//! exact on chains and trees of rows: a ratio of masses does not slow them there.
//!
//! One-sided rows that carry no impulse are at their bound. A step ends where an impulse
//! reaches its bound, and rows leave theirs where that lowers the energy more than another
//! step on the active set. Source: Z. Dostál, "Optimal Quadratic Programming Algorithms",
//! Springer 2009, chapter 5 (MPRGP).
//!
//! Rows that repeat each other make H singular, which does no harm. Rows that contradict
//! each other have no solution, and the steps would diverge: the best impulses found are
//! kept. Coulomb's friction is left out. A share of a slip is removed by an equality, too; where
//! that takes an impulse beyond its limits, or has no solution, Gauss–Seidel sweeps go on.

use glam::DVec3;

use super::cholesky::CholeskyFactors;
use super::gauss_seidel;
use super::jacobi::JacobiMemory;
use super::packed::{PackedRow, PackedSystem, RowGoal, SolverState, Tangent};
use super::parts::{Parts, dot};
use super::slots::cells;
use super::{Impulse, SolverParams};

/// Growth of the residual, over the smallest found, at which steps are given
/// up. A solvable system wavers by less; a contradictory one soon exceeds it.
const DIVERGENCE: f64 = 1e4;

/// Length of a projected step over the inverse of the bound on the largest eigenvalue; below
/// 2 the energy falls.
const PROJECTED_STEP: f64 = 1.9;

/// Memory of a solution, one entry per row in each list but the last.
#[derive(Clone, Debug, Default)]
pub(super) struct GradientMemory {
    /// Preconditioners along the normal and in the tangent plane.
    scales: Vec<[f64; 2]>,
    /// λ.
    impulses: Vec<Parts>,
    /// Impulses of the smallest residual.
    best: Vec<Parts>,
    /// Q_c − t − α λ: what impulses still have to cancel.
    residual: Vec<Parts>,
    direction: Vec<Parts>,
    /// H times the direction.
    product: Vec<Parts>,
    /// Residual without the rows at their bound.
    free: Vec<Parts>,
    /// Descent of the free rows, by the preconditioner.
    descent: Vec<Parts>,
    factors: CholeskyFactors,
    /// Goals with Coulomb's friction.
    goals: Vec<RowGoal>,
    /// One vector per particle.
    moved: Vec<DVec3>,
}

/// Solves for all rows; returns the steps.
pub(super) fn solve(
    system: &PackedSystem,
    state: &mut SolverState,
    params: &SolverParams,
    memory: &mut GradientMemory,
    factors: &mut JacobiMemory,
) -> u32 {
    drop_discs(system, state);
    let steps = solve_equalities(system, state, params, memory, factors);
    let has_shares = state.goals.iter().any(|goal| goal.tangent == Tangent::Share);
    if steps >= params.max_iterations || !has_shares {
        return steps;
    }

    // Sweeps keep to the limits of shares. Coulomb's friction stays left out.
    memory.goals.clone_from(&state.goals);
    for goal in &mut state.goals {
        if goal.tangent == Tangent::Disc {
            goal.tangent = Tangent::Free;
        }
    }
    let mut sweeps = 0;
    if state.residual(system).max() > params.tolerance {
        let rest = SolverParams { max_iterations: params.max_iterations - steps, ..*params };
        sweeps = gauss_seidel::solve(system, state, &rest);
    }
    state.goals.clone_from(&memory.goals);
    steps + sweeps
}

/// Solves for all rows with shares as equalities; returns the steps.
fn solve_equalities(
    system: &PackedSystem,
    state: &mut SolverState,
    params: &SolverParams,
    memory: &mut GradientMemory,
    factors: &mut JacobiMemory,
) -> u32 {
    factors.set_factors(system);
    let step = PROJECTED_STEP * factors.smallest_factor();
    let mut solution = Solution { system, goals: &state.goals, memory, step };

    // Steps carry the residual along, and it drifts by rounding: it is computed anew in the
    // end, and steps go on while they help.
    let mut iterations = 0;
    let mut last = f64::INFINITY;
    loop {
        solution.load(&mut state.q, &state.impulses);
        let present = solution.largest();
        if present <= params.tolerance || present >= last || iterations >= params.max_iterations {
            return iterations;
        }
        if iterations == 0 {
            solution.memory.factors.factorize(system, solution.goals);
        }
        last = present;
        iterations += solution.minimize(params.max_iterations - iterations, params.tolerance);
        solution.store_best(&mut state.q, &mut state.impulses);
    }
}

/// Takes back tangential impulses of Coulomb's law.
fn drop_discs(system: &PackedSystem, state: &mut SolverState) {
    let slots = cells(&mut state.q);
    for ((row, goal), impulse) in system.rows.iter().zip(&state.goals).zip(&mut state.impulses) {
        if goal.tangent == Tangent::Disc {
            system.apply(row, DVec3::ZERO, -impulse.tangent, slots);
            impulse.tangent = DVec3::ZERO;
        }
    }
}

struct Solution<'a> {
    system: &'a PackedSystem,
    goals: &'a [RowGoal],
    memory: &'a mut GradientMemory,
    /// Factor of projected steps.
    step: f64,
}

impl Solution<'_> {
    /// Reads the impulses, and computes the residual from the particles.
    fn load(&mut self, q: &mut [DVec3], impulses: &[Impulse]) {
        // The residual is what the rows' own impulses leave of Q_c − t.
        let memory = &mut *self.memory;
        memory.impulses.clear();
        memory.residual.clear();
        memory.scales.clear();
        let slots = cells(q);
        for ((row, goal), impulse) in self.system.rows.iter().zip(self.goals).zip(impulses) {
            let lambda = Parts { normal: impulse.normal, tangent: impulse.tangent };
            let at = restrained(row, goal, self.system.relative(row, goal.bias, slots));
            memory.residual.push(at.plus(-1.0, compliant(row, goal, lambda)));
            memory.impulses.push(lambda);

            // 1 / (D + α): the inverse of the row's own entry in H.
            let normal = row.step * row.hardness;
            let is_hard = goal.tangent == Tangent::Share;
            memory.scales.push([normal, if is_hard { row.step } else { normal }]);
        }
    }

    /// Writes the best impulses, and changes the particles by their change.
    fn store_best(&self, q: &mut [DVec3], impulses: &mut [Impulse]) {
        let slots = cells(q);
        let rows = self.system.rows.iter().zip(self.goals).zip(impulses);
        for (((row, goal), impulse), &best) in rows.zip(&self.memory.best) {
            // A step to the bound may end beyond it by rounding.
            let normal = if goal.is_one_sided { best.normal.max(0.0) } else { best.normal };
            let best = Parts { normal, ..best };
            let change = (best.normal - impulse.normal) * row.normal;
            self.system.apply(row, change, best.tangent - impulse.tangent, slots);
            *impulse = Impulse { normal: best.normal, tangent: best.tangent };
        }
    }

    /// Steps until no row requires a change beyond the tolerance; returns the steps. The best
    /// impulses are those of the smallest residual.
    fn minimize(&mut self, max_iterations: u32, tolerance: f64) -> u32 {
        let mut iterations = 0;
        self.memory.best.clone_from(&self.memory.impulses);
        let mut least = self.norm();
        self.restart();

        // Rows that contradict each other make the residual grow.
        while iterations < max_iterations && self.largest() > tolerance {
            iterations += 1;
            if !self.step() {
                break;
            }
            let present = self.norm();
            if present < least {
                least = present;
                self.memory.best.clone_from(&self.memory.impulses);
            } else if present > DIVERGENCE * least {
                break;
            }
        }
        iterations
    }

    /// Takes one step; returns false where there is none.
    fn step(&mut self) -> bool {
        // Rows leave their bound where that is worth more than a step without them.
        let is_proportioning = self.chopped_square() > self.free_square();
        if is_proportioning {
            self.leave_bounds();
        }
        self.multiply();
        let memory = &*self.memory;
        let along = dot(&memory.direction, &memory.residual);
        let curvature = dot(&memory.direction, &memory.product);
        if curvature <= 0.0 || along <= 0.0 {
            return false;
        }

        // To the minimum along the direction, or to the first bound on the way.
        let to_minimum = along / curvature;
        let to_bound = self.distance_to_bound();
        self.advance(to_minimum.min(to_bound));
        if to_bound < to_minimum {
            self.project();
            self.restart();
        } else if is_proportioning {
            self.restart();
        } else {
            self.conjugate(curvature);
        }
        true
    }

    /// Sets the direction to the descent without the rows at their bound.
    fn restart(&mut self) {
        self.precondition();
        let GradientMemory { direction, descent, .. } = &mut *self.memory;
        direction.clone_from(descent);
    }

    /// Computes the descent of the rows that are not at their bound.
    fn precondition(&mut self) {
        self.memory.free.clear();
        for row in 0..self.goals.len() {
            let residual = self.memory.residual[row];
            let normal = if self.is_bound(row) { 0.0 } else { residual.normal };
            self.memory.free.push(Parts { normal, ..residual });
        }
        let GradientMemory { free, descent, factors, .. } = &mut *self.memory;
        factors.solve(free, descent);
        for row in 0..self.goals.len() {
            if self.is_bound(row) {
                self.memory.descent[row].normal = 0.0;
            }
        }
    }

    /// Sets the direction to the steepest descent of the rows that should leave their bound.
    fn leave_bounds(&mut self) {
        self.memory.direction.clear();
        for row in 0..self.goals.len() {
            let normal = self.memory.residual[row].normal.max(0.0) * self.memory.scales[row][0];
            let normal = if self.is_bound(row) { normal } else { 0.0 };
            self.memory.direction.push(Parts { normal, tangent: DVec3::ZERO });
        }
    }

    /// Makes the descent conjugate to the last direction.
    fn conjugate(&mut self, curvature: f64) {
        // Conjugate by H: the overlap with the product is taken out.
        self.precondition();
        let GradientMemory { direction, descent, product, .. } = &mut *self.memory;
        let turn = dot(descent, product) / curvature;
        for (direction, descent) in direction.iter_mut().zip(descent) {
            *direction = descent.plus(-turn, *direction);
        }
    }

    /// Computes the scaled residual of a row, without a normal part at its bound.
    fn descent(&self, row: usize) -> Parts {
        let residual = self.memory.residual[row];
        let [by_normal, by_tangent] = self.memory.scales[row];
        let normal = if self.is_bound(row) { 0.0 } else { by_normal * residual.normal };
        Parts { normal, tangent: by_tangent * residual.tangent }
    }

    /// Computes H times the direction.
    fn multiply(&mut self) {
        let GradientMemory { direction, product, moved, .. } = &mut *self.memory;
        // W Nᵀ: what the direction does to particles.
        moved.clear();
        moved.resize(self.system.particle_count, DVec3::ZERO);
        let slots = cells(moved);
        for (row, direction) in self.system.rows.iter().zip(&*direction) {
            self.system.apply(row, -direction.normal * row.normal, -direction.tangent, slots);
        }

        // N of that, and the compliance of the row itself.
        product.clear();
        for ((row, goal), &direction) in self.system.rows.iter().zip(self.goals).zip(&*direction) {
            let at = restrained(row, goal, self.system.relative(row, DVec3::ZERO, slots));
            product.push(at.plus(1.0, compliant(row, goal, direction)));
        }
    }

    /// Moves impulses and residual along the direction.
    fn advance(&mut self, step: f64) {
        let GradientMemory { direction, product, impulses, residual, .. } = &mut *self.memory;
        for (impulse, direction) in impulses.iter_mut().zip(direction) {
            *impulse = impulse.plus(step, *direction);
        }
        for (residual, product) in residual.iter_mut().zip(product) {
            *residual = residual.plus(-step, *product);
        }
    }

    /// Takes a step of steepest descent, cut at the bounds.
    fn project(&mut self) {
        // Impulses just at their bound are put there exactly.
        self.memory.direction.clear();
        for row in 0..self.goals.len() {
            let from = self.memory.impulses[row];
            let mut to = from.plus(self.step, self.descent(row));
            if self.goals[row].is_one_sided {
                to.normal = to.normal.max(0.0);
            }
            self.memory.direction.push(to.plus(-1.0, from));
            self.memory.impulses[row] = to;
        }

        // The residual follows by H.
        self.multiply();
        let GradientMemory { product, residual, .. } = &mut *self.memory;
        for (residual, product) in residual.iter_mut().zip(product) {
            *residual = residual.plus(-1.0, *product);
        }
    }

    /// Computes the step at which the first impulse reaches its bound.
    fn distance_to_bound(&self) -> f64 {
        let mut shortest = f64::INFINITY;
        for (row, direction) in self.memory.direction.iter().enumerate() {
            if self.goals[row].is_one_sided && direction.normal < 0.0 {
                shortest = shortest.min(-self.memory.impulses[row].normal / direction.normal);
            }
        }
        shortest
    }

    /// Computes the scaled square of the residual without the rows at their bound; the
    /// residual of others counts up to their bound.
    fn free_square(&self) -> f64 {
        let mut square = 0.0;
        for row in 0..self.goals.len() {
            let (residual, [by_normal, by_tangent]) =
                (self.memory.residual[row], self.memory.scales[row]);
            square += by_tangent * residual.tangent.length_squared();
            if self.goals[row].is_one_sided {
                let way = self.memory.impulses[row].normal / (self.step * by_normal);
                let reduced = residual.normal.max(-way);
                square +=
                    if self.is_bound(row) { 0.0 } else { by_normal * reduced * residual.normal };
            } else {
                square += by_normal * residual.normal * residual.normal;
            }
        }
        square
    }

    /// Computes the scaled square of the residual of the rows that should leave their bound.
    fn chopped_square(&self) -> f64 {
        let mut square = 0.0;
        for row in 0..self.goals.len() {
            let normal = self.memory.residual[row].normal.max(0.0);
            square +=
                if self.is_bound(row) { self.memory.scales[row][0] * normal * normal } else { 0.0 };
        }
        square
    }

    /// Computes the largest change of Q_c that a row alone requires.
    fn largest(&self) -> f64 {
        let mut largest = 0.0_f64;
        for row in 0..self.goals.len() {
            let required = self.required(row);
            largest = largest.max(required.normal.abs()).max(required.tangent.length());
        }
        largest
    }

    /// Computes the norm of the changes that the rows require, in the measure in which steps
    /// shorten it.
    fn norm(&self) -> f64 {
        let mut square = 0.0;
        for row in 0..self.goals.len() {
            let (required, [by_normal, by_tangent]) = (self.required(row), self.memory.scales[row]);
            square += by_normal * required.normal * required.normal;
            square += by_tangent * required.tangent.length_squared();
        }
        square.sqrt()
    }

    /// Computes the change of Q_c that a row alone requires.
    fn required(&self, row: usize) -> Parts {
        let residual = self.memory.residual[row];
        if !self.goals[row].is_one_sided {
            return residual;
        }

        // A push that is not needed can be taken back up to its size.
        let way = self.memory.impulses[row].normal / self.memory.scales[row][0];
        Parts { normal: residual.normal.max(-way), ..residual }
    }

    /// Returns true if the normal impulse of a row is at its bound.
    fn is_bound(&self, row: usize) -> bool {
        self.goals[row].is_one_sided && self.memory.impulses[row].normal <= 0.0
    }
}

/// Returns the part of a vector in the directions that a row restrains.
fn restrained(row: &PackedRow, goal: &RowGoal, vector: DVec3) -> Parts {
    let normal = vector.dot(row.normal);
    let tangent = match goal.tangent {
        Tangent::Free | Tangent::Disc => DVec3::ZERO,
        Tangent::Share => vector.dot(goal.share.direction) * goal.share.direction,
        Tangent::Compliant => vector - normal * row.normal,
    };
    Parts { normal, tangent }
}

/// Computes α λ.
fn compliant(row: &PackedRow, goal: &RowGoal, lambda: Parts) -> Parts {
    let compliance = (1.0 - row.hardness) / (row.hardness * row.step);
    let is_compliant = goal.tangent == Tangent::Compliant;
    let tangent = if is_compliant { compliance * lambda.tangent } else { DVec3::ZERO };
    Parts { normal: compliance * lambda.normal, tangent }
}
