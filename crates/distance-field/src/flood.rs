//! Inside is what a flood from the border of the grid does not reach.
//!
//! The flood steps between neighbouring nodes along the axes. It is stopped by
//! voxels that are switched on, or by links that the surface crosses; the
//! latter are exact, and need no voxels.

use std::ops::Range;

/// Bit of a node that the flood has reached.
const REACHED: u8 = 8;
/// Bit of a node that the flood may not enter.
const WALL: u8 = 16;

/// Nodes that the flood neither reaches nor is stopped by.
pub(crate) fn behind_voxels(voxels: &[bool], dims: [usize; 3]) -> Vec<bool> {
    let mut state: Vec<u8> = voxels.iter().map(|&on| if on { WALL } else { 0 }).collect();
    flood(&mut state, dims);
    state.into_iter().map(is_free).collect()
}

/// Reaches what it can, a run of nodes along x at a time.
fn flood(state: &mut [u8], dims: [usize; 3]) {
    let [nx, ny, nz] = dims;
    let mut front: Vec<usize> = Vec::new();
    for r in 0..ny * nz {
        let [j, k] = [r % ny, r / ny];
        let is_outer = j == 0 || j + 1 == ny || k == 0 || k + 1 == nz;
        front.extend((0..nx).step_by(if is_outer { 1 } else { nx - 1 }).map(|i| r * nx + i));
    }
    while let Some(node) = front.pop() {
        if !is_free(state[node]) {
            continue;
        }
        let run = take_run(state, node, nx);
        let (j, k) = (node / nx % ny, node / (nx * ny));
        let ways = [(j > 0, j + 1 < ny, nx, 1), (k > 0, k + 1 < nz, nx * ny, 2)];
        for (below, above, stride, axis) in ways {
            if below {
                enter(state, run.clone(), |node| (node - stride, node), axis, &mut front);
            }
            if above {
                enter(state, run.clone(), |node| (node + stride, node + stride), axis, &mut front);
            }
        }
    }
}

fn is_free(bits: u8) -> bool {
    bits & (REACHED | WALL) == 0
}

/// Marks the longest run of free nodes around one.
fn take_run(state: &mut [u8], node: usize, nx: usize) -> Range<usize> {
    let row = node - node % nx..node - node % nx + nx;
    let (mut start, mut end) = (node, node + 1);
    while start > row.start && state[start] & 1 == 0 && is_free(state[start - 1]) {
        start -= 1;
    }
    while end < row.end && state[end] & 1 == 0 && is_free(state[end]) {
        end += 1;
    }
    state[start..end].iter_mut().for_each(|bits| *bits |= REACHED);
    start..end
}

/// Adds one node for each run of a neighbouring row that can be entered;
/// `next` gives the neighbour of a node, and the upper of the two.
fn enter(
    state: &[u8],
    run: Range<usize>,
    next: impl Fn(usize) -> (usize, usize),
    axis: usize,
    front: &mut Vec<usize>,
) {
    let mut was_open = false;
    for node in run {
        let (next, upper) = next(node);
        let is_open = is_free(state[next]) && state[upper] & 1 << axis == 0;
        if is_open && (!was_open || state[next] & 1 != 0) {
            front.push(next);
        }
        was_open = is_open;
    }
}
