//! Nodes inside that move to where the cells around them are less flat.
//!
//! The elastic equilibrium knows nothing of flat cells. Where one is in the way, its nodes inside are moved, one by one, so
//! that the least scaled Jacobian of the cells around each of them rises over its limit: by a compass search, since the
//! least of several has no gradient.
//!
//! Sources: L. A. Freitag and C. Ollivier-Gooch, "Tetrahedral mesh improvement using swapping and smoothing",
//! International Journal for Numerical Methods in Engineering 40, 1997 (one node at a time); T. G. Kolda, R. M. Lewis and
//! V. Torczon, "Optimization by direct search", SIAM Review 45, 2003 (compass search).

use std::collections::BTreeMap;

use glam::DVec3;

use crate::follow::NEARLY_FLAT;
use crate::quality::scaled_jacobian;
use crate::{Cell, VolumeMesh};

/// Passes over all nodes of nearly flat cells. Below, cells with several nodes inside stay flat; above, cells without a
/// way out take longer.
const PASSES: usize = 4;

/// Maximum number of moves of a node in one search, which far fewer end.
const MAX_MOVES: usize = 256;

/// First step of a search, and the last one \[the longest way from the node to another one of its cells\].
const STEPS: [f64; 2] = [0.25, 0.004];

/// Directions of a search, as those from the middle of a cube to its sides and corners.
const DIRECTIONS: [[f64; 3]; 14] = [
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [-1.0, 1.0, -1.0],
    [1.0, -1.0, -1.0],
    [-1.0, -1.0, -1.0],
];

impl VolumeMesh {
    /// Moves nodes that are not given, of cells that are nearly flat, to where these are less so.
    pub(crate) fn open_cells(&self, positions: &mut [DVec3], is_given: &[bool], limits: &[f64]) {
        let mut around = self.cells_around_flat(positions, is_given, limits);
        if around.is_empty() {
            return;
        }
        self.add_neighbors(&mut around);
        for _ in 0..PASSES {
            let mut has_moved = false;
            for (&node, cells) in &around {
                has_moved |= self.open_around(node as usize, cells, positions, limits);
            }
            if !has_moved {
                return;
            }
        }
    }

    /// Lists the nodes that can move of cells that are nearly flat, without cells.
    fn cells_around_flat(
        &self,
        positions: &[DVec3],
        is_given: &[bool],
        limits: &[f64],
    ) -> BTreeMap<u32, Vec<usize>> {
        let mut around = BTreeMap::new();
        for (number, jacobian) in self.scaled_jacobians(positions).into_iter().enumerate() {
            if jacobian < NEARLY_FLAT * limits[number] {
                let nodes = self.cells()[number].nodes().iter();
                around.extend(nodes.filter(|n| !is_given[**n as usize]).map(|n| (*n, Vec::new())));
            }
        }
        around
    }

    /// Adds all cells of each node.
    fn add_neighbors(&self, around: &mut BTreeMap<u32, Vec<usize>>) {
        for (number, cell) in self.cells().iter().enumerate() {
            for node in cell.nodes() {
                if let Some(cells) = around.get_mut(node) {
                    cells.push(number);
                }
            }
        }
    }

    /// Moves a node to where the least quality of the cells around it is larger. Returns false where it stays.
    fn open_around(
        &self,
        node: usize,
        cells: &[usize],
        positions: &mut [DVec3],
        limits: &[f64],
    ) -> bool {
        let quality = |positions: &[DVec3]| {
            let excess = cells
                .iter()
                .map(|&cell| scaled_jacobian(&self.cells()[cell], positions) - limits[cell]);
            excess.fold(f64::INFINITY, f64::min)
        };
        let mut longest: f64 = 0.0;
        for &cell in cells {
            longest = longest.max(longest_way(&self.cells()[cell], node, positions));
        }

        // The best of all directions, or a step half as long.
        let start = positions[node];
        let mut best = quality(positions);
        let mut step = STEPS[0] * longest;
        for _ in 0..MAX_MOVES {
            if step < STEPS[1] * longest {
                break;
            }
            let from = positions[node];
            let mut end = from;
            for direction in DIRECTIONS {
                positions[node] = from + step * DVec3::from(direction).normalize();
                let found = quality(positions);
                if found > best {
                    (best, end) = (found, positions[node]);
                }
            }
            positions[node] = end;
            if end == from {
                step *= 0.5;
            }
        }
        positions[node] != start
    }
}

/// Returns the longest way from a node to another one of its cell.
fn longest_way(cell: &Cell, node: usize, positions: &[DVec3]) -> f64 {
    let others = cell.nodes().iter();
    others.map(|other| positions[*other as usize].distance(positions[node])).fold(0.0, f64::max)
}
