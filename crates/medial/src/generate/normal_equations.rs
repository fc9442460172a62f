//! Normal equations of a fit over balls: a symmetric sparse matrix of 4 × 4 blocks, one per pair of
//! balls that share a primitive, solved by preconditioned conjugate gradients.

use glam::DVec4;

use crate::symmetric::{DIAGONAL, Symmetric4};

/// Residual of a fit. Its gradient with respect to a ball of the primitive is `gradient` times the
/// weight of that ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Residual {
    pub(super) primitive: u32,
    pub(super) weights: [f64; 3],
    pub(super) gradient: DVec4,
    pub(super) value: f64,
    /// Importance of its square in the sum.
    pub(super) importance: f64,
}

/// System `H δ = g`, with `H = Σ JᵀJ` and `g = −Σ Jᵀ residual`.
pub(super) struct NormalEquations<'a> {
    primitives: &'a [[u32; 3]],
    /// Places of each primitive's pairs (01, 12, 20) among the off-diagonal blocks.
    pair_places: Vec<[usize; 3]>,
    /// Balls of the off-diagonal blocks.
    pairs: Vec<[u32; 2]>,
    diagonal: Vec<Symmetric4>,
    off_diagonal: Vec<Symmetric4>,
    right_side: Vec<DVec4>,
}

/// Damping of the first step, relative to the diagonal; no step has less.
///
/// With less, balls slide along flat parts of the sheet until the feet of samples are no longer those
/// that the step was solved for, and it has to be repeated; with ten times more the fit creeps.
pub(super) const MIN_DAMPING: f64 = 1e-2;

/// Relative length of the residual at which conjugate gradients end: each step is one of several,
/// linearized at its own place.
///
/// Smaller takes more iterations for steps that are hardly better; larger takes more steps.
const CG_TOLERANCE: f64 = 1e-3;

/// Maximum number of iterations of conjugate gradients.
const MAX_CG_ITERATIONS: usize = 200;

/// Entry of the diagonal that keeps balls without residuals in place, relative to the largest: far
/// below any other entry, far above its rounding.
const DIAGONAL_FLOOR: f64 = 1e-9;

impl<'a> NormalEquations<'a> {
    pub(super) fn new(balls: usize, primitives: &'a [[u32; 3]]) -> Self {
        let mut pairs: Vec<[u32; 2]> = Vec::with_capacity(3 * primitives.len());
        for &primitive in primitives {
            pairs.extend(sides(primitive));
        }
        pairs.retain(|[i, j]| i != j);
        pairs.sort_unstable();
        pairs.dedup();

        // A repeated ball has no pair with itself, and its place is never used.
        let place = |pair: [u32; 2]| pairs.binary_search(&pair).unwrap_or(usize::MAX);
        let mut pair_places = Vec::with_capacity(primitives.len());
        for &primitive in primitives {
            pair_places.push(sides(primitive).map(place));
        }
        Self {
            primitives,
            pair_places,
            diagonal: vec![Symmetric4::default(); balls],
            off_diagonal: vec![Symmetric4::default(); pairs.len()],
            right_side: vec![DVec4::ZERO; balls],
            pairs,
        }
    }

    pub(super) fn clear(&mut self) {
        self.diagonal.fill(Symmetric4::default());
        self.off_diagonal.fill(Symmetric4::default());
        self.right_side.fill(DVec4::ZERO);
    }

    pub(super) fn add(&mut self, residual: &Residual) {
        let square = Symmetric4::outer(residual.gradient).scaled(residual.importance);
        let pull = -residual.importance * residual.value * residual.gradient;
        let balls = self.primitives[residual.primitive as usize];
        let places = self.pair_places[residual.primitive as usize];
        let b = residual.weights;
        // The diagonal blocks of its balls, and the blocks of its pairs.
        for k in 0..3 {
            let (ball, next) = (balls[k] as usize, (k + 1) % 3);
            self.diagonal[ball].add_scaled(b[k] * b[k], &square);
            self.right_side[ball] += b[k] * pull;
            if balls[k] == balls[next] {
                self.diagonal[ball].add_scaled(2.0 * b[k] * b[next], &square);
            } else {
                self.off_diagonal[places[k]].add_scaled(b[k] * b[next], &square);
            }
        }
    }

    /// Solves `(H + damping · diag H) δ = g` by conjugate gradients, preconditioned with the diagonal
    /// blocks.
    pub(super) fn solve(&self, damping: f64) -> Vec<DVec4> {
        // Marquardt's damping, relative to the diagonal.
        let floor = self.diagonal_floor();
        let mut damped = self.diagonal.clone();
        for block in &mut damped {
            for place in DIAGONAL {
                block.0[place] += damping * block.0[place] + floor;
            }
        }

        // Steepest descent first, from zero.
        let mut x = vec![DVec4::ZERO; self.diagonal.len()];
        let mut r = self.right_side.clone();
        let mut z = precondition(&r, &damped, floor);
        let mut direction = z.clone();
        let mut rz = dot(&r, &z);
        let goal = CG_TOLERANCE * CG_TOLERANCE * rz;
        for _ in 0..MAX_CG_ITERATIONS {
            if rz <= goal {
                break;
            }
            let image = self.times(&damped, &direction);
            let step = rz / dot(&direction, &image);
            for (i, &image) in image.iter().enumerate() {
                x[i] += step * direction[i];
                r[i] -= step * image;
            }

            // The next direction, conjugate to the ones before.
            z = precondition(&r, &damped, floor);
            let next_rz = dot(&r, &z);
            for (direction, &z) in direction.iter_mut().zip(&z) {
                *direction = z + next_rz / rz * *direction;
            }
            rz = next_rz;
        }
        x
    }

    fn diagonal_floor(&self) -> f64 {
        let mut largest = f64::MIN_POSITIVE / DIAGONAL_FLOOR;
        for block in &self.diagonal {
            for place in DIAGONAL {
                largest = largest.max(block.0[place]);
            }
        }
        DIAGONAL_FLOOR * largest
    }

    /// Computes the product of the matrix, with its damped diagonal, and a vector.
    fn times(&self, diagonal: &[Symmetric4], x: &[DVec4]) -> Vec<DVec4> {
        let mut y: Vec<DVec4> = diagonal.iter().zip(x).map(|(block, &x)| block.times(x)).collect();
        for (&[i, j], block) in self.pairs.iter().zip(&self.off_diagonal) {
            let (i, j) = (i as usize, j as usize);
            y[i] += block.times(x[j]);
            y[j] += block.times(x[i]);
        }
        y
    }
}

/// Solves for each ball alone, by its diagonal block.
fn precondition(r: &[DVec4], diagonal: &[Symmetric4], floor: f64) -> Vec<DVec4> {
    r.iter().zip(diagonal).map(|(&r, block)| block.solve(r).unwrap_or(r / floor)).collect()
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[i, j]| [i.min(j), i.max(j)])
}

fn dot(a: &[DVec4], b: &[DVec4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}
