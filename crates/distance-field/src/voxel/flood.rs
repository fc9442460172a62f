//! Scanline flood fill: inside is what a flood from the border of the grid does not reach.

use std::ops::Range;

use surface::progress::{Interrupted, Progress};

/// State of a node.
#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Free,
    Reached,
    /// A voxel of the surface.
    Wall,
}

/// Runs between two progress reports.
const REPORT: usize = 1 << 16;

/// Returns the nodes that a 6-connected flood from the border neither reaches nor is stopped
/// by.
pub(super) fn enclosed(
    voxels: &[bool],
    dims: [usize; 3],
    progress: Progress<'_>,
) -> Result<Vec<bool>, Interrupted> {
    // Collected, which vectorizes.
    let state = |&is_on: &bool| if is_on { State::Wall } else { State::Free };
    let mut states: Vec<State> = voxels.iter().map(state).collect();
    flood(&mut states, dims, progress)?;
    Ok(states.into_iter().map(|state| state == State::Free).collect())
}

/// Floods from the border, a run of nodes along x at a time.
fn flood(
    states: &mut [State],
    [nx, ny, nz]: [usize; 3],
    progress: Progress<'_>,
) -> Result<(), Interrupted> {
    // Begin at every node of the outer rows, and at the ends of the others.
    let mut front: Vec<usize> = Vec::new();
    for r in 0..ny * nz {
        let [j, k] = [r % ny, r / ny];
        let is_outer = j == 0 || j + 1 == ny || k == 0 || k + 1 == nz;
        front.extend((r * nx..(r + 1) * nx).step_by(if is_outer { 1 } else { nx - 1 }));
    }

    let mut runs = 0;
    while let Some(node) = front.pop() {
        if states[node] != State::Free {
            continue;
        }
        runs += 1;
        if runs % REPORT == 0 {
            progress.report(0.0)?;
        }

        // A run is reached as a whole, and so is what is beside it in four rows.
        let run = take_run(states, node, nx);
        let (j, k) = (node / nx % ny, node / (nx * ny));
        for (n, count, stride) in [(j, ny, nx), (k, nz, nx * ny)] {
            if n > 0 {
                enter(states, run.start - stride..run.end - stride, &mut front);
            }
            if n + 1 < count {
                enter(states, run.start + stride..run.end + stride, &mut front);
            }
        }
    }
    Ok(())
}

/// Marks the longest run of free nodes around one.
fn take_run(states: &mut [State], node: usize, nx: usize) -> Range<usize> {
    let row = node - node % nx..node - node % nx + nx;
    let (mut start, mut end) = (node, node + 1);
    while start > row.start && states[start - 1] == State::Free {
        start -= 1;
    }
    while end < row.end && states[end] == State::Free {
        end += 1;
    }
    states[start..end].fill(State::Reached);
    start..end
}

/// Adds one node of every free run among those beside a run.
fn enter(states: &[State], beside: Range<usize>, front: &mut Vec<usize>) {
    let mut was_free = false;
    for node in beside {
        let is_free = states[node] == State::Free;
        if is_free && !was_free {
            front.push(node);
        }
        was_free = is_free;
    }
}
