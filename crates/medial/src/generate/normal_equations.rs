//! The normal equations of a fit over balls: a symmetric sparse matrix of
//! 4 × 4 blocks, one between every two balls that share a primitive.

use glam::DVec4;

use super::quadric::{outer, solve};

/// What one residual adds: its gradient with respect to a ball of the primitive
/// is `gradient` times that ball's weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Residual {
    pub(super) primitive: u32,
    pub(super) weights: [f64; 3],
    pub(super) gradient: DVec4,
    pub(super) value: f64,
    /// Importance of its square in the sum.
    pub(super) importance: f64,
}

/// Symmetric blocks, by their upper triangle.
type Block = [f64; 10];

/// `H δ = g`, with `H = Σ JᵀJ` and `g = −Σ Jᵀ residual`.
pub(super) struct NormalEquations<'a> {
    primitives: &'a [[u32; 3]],
    /// Places of each primitive's pairs (01, 12, 20) among the off-diagonal blocks.
    slots: Vec<[usize; 3]>,
    pairs: Vec<[u32; 2]>,
    diagonal: Vec<Block>,
    off_diagonal: Vec<Block>,
    right_side: Vec<DVec4>,
}

/// Places in a [`Block`] of the matrix's diagonal.
const DIAGONAL: [usize; 4] = [0, 4, 7, 9];

/// Relative length of the residual at which conjugate gradients end: the step
/// is one of several, each of which is linearized anew.
const CG_TOLERANCE: f64 = 1e-3;

/// Iterations before conjugate gradients end anyway.
const CG_LIMIT: usize = 200;

impl<'a> NormalEquations<'a> {
    pub(super) fn new(balls: usize, primitives: &'a [[u32; 3]]) -> Self {
        let mut pairs: Vec<[u32; 2]> =
            primitives.iter().flat_map(|&p| sides(p)).filter(|[i, j]| i != j).collect();
        pairs.sort_unstable();
        pairs.dedup();
        // A repeated ball has no pair with itself; its place is never looked up.
        let slot = |pair: [u32; 2]| pairs.binary_search(&pair).unwrap_or(usize::MAX);
        let slots = primitives.iter().map(|&p| sides(p).map(slot)).collect();
        Self {
            primitives,
            slots,
            diagonal: vec![[0.0; 10]; balls],
            off_diagonal: vec![[0.0; 10]; pairs.len()],
            right_side: vec![DVec4::ZERO; balls],
            pairs,
        }
    }

    pub(super) fn clear(&mut self) {
        self.diagonal.fill([0.0; 10]);
        self.off_diagonal.fill([0.0; 10]);
        self.right_side.fill(DVec4::ZERO);
    }

    pub(super) fn add(&mut self, residual: &Residual) {
        let square = outer(residual.gradient).map(|entry| residual.importance * entry);
        let balls = self.primitives[residual.primitive as usize];
        let slots = self.slots[residual.primitive as usize];
        let b = residual.weights;
        let pull = -residual.importance * residual.value * residual.gradient;
        for k in 0..3 {
            let l = (k + 1) % 3;
            add_scaled(&mut self.diagonal[balls[k] as usize], b[k] * b[k], &square);
            self.right_side[balls[k] as usize] += b[k] * pull;
            if balls[k] == balls[l] {
                add_scaled(&mut self.diagonal[balls[k] as usize], 2.0 * b[k] * b[l], &square);
            } else {
                add_scaled(&mut self.off_diagonal[slots[k]], b[k] * b[l], &square);
            }
        }
    }

    /// Solves `(H + damping · diag H) δ = g` by conjugate gradients,
    /// preconditioned with the diagonal blocks.
    pub(super) fn solve(&self, damping: f64) -> Vec<DVec4> {
        let floor = self.diagonal_floor();
        let damped: Vec<Block> = self
            .diagonal
            .iter()
            .map(|block| {
                let mut block = *block;
                for k in DIAGONAL {
                    block[k] += damping * block[k] + floor;
                }
                block
            })
            .collect();
        let precondition = |r: &[DVec4]| -> Vec<DVec4> {
            r.iter().zip(&damped).map(|(&r, block)| solve(block, r).unwrap_or(r / floor)).collect()
        };
        let mut x = vec![DVec4::ZERO; self.diagonal.len()];
        let mut r = self.right_side.clone();
        let mut z = precondition(&r);
        let mut direction = z.clone();
        let mut rz = dot(&r, &z);
        let goal = CG_TOLERANCE * CG_TOLERANCE * rz;
        for _ in 0..CG_LIMIT {
            if rz <= goal {
                break;
            }
            let image = self.times(&damped, &direction);
            let step = rz / dot(&direction, &image);
            for (i, &image) in image.iter().enumerate() {
                x[i] += step * direction[i];
                r[i] -= step * image;
            }
            z = precondition(&r);
            let next = dot(&r, &z);
            for (direction, &z) in direction.iter_mut().zip(&z) {
                *direction = z + next / rz * *direction;
            }
            rz = next;
        }
        x
    }

    /// Keeps balls that no residual sees where they are: far below any other
    /// diagonal entry, far above its rounding.
    fn diagonal_floor(&self) -> f64 {
        let largest = self.diagonal.iter().flat_map(|block| DIAGONAL.map(|k| block[k]));
        1e-9 * largest.fold(f64::MIN_POSITIVE / 1e-9, f64::max)
    }

    fn times(&self, diagonal: &[Block], x: &[DVec4]) -> Vec<DVec4> {
        let mut y: Vec<DVec4> = diagonal.iter().zip(x).map(|(block, &x)| times(block, x)).collect();
        for (&[i, j], block) in self.pairs.iter().zip(&self.off_diagonal) {
            let (i, j) = (i as usize, j as usize);
            y[i] += times(block, x[j]);
            y[j] += times(block, x[i]);
        }
        y
    }
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[i, j]| [i.min(j), i.max(j)])
}

fn add_scaled(block: &mut Block, scale: f64, other: &Block) {
    for (mine, theirs) in block.iter_mut().zip(other) {
        *mine += scale * theirs;
    }
}

fn times([xx, xy, xz, xw, yy, yz, yw, zz, zw, ww]: &Block, v: DVec4) -> DVec4 {
    DVec4::new(
        xx * v.x + xy * v.y + xz * v.z + xw * v.w,
        xy * v.x + yy * v.y + yz * v.z + yw * v.w,
        xz * v.x + yz * v.y + zz * v.z + zw * v.w,
        xw * v.x + yw * v.y + zw * v.z + ww * v.w,
    )
}

fn dot(a: &[DVec4], b: &[DVec4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}
