//! A grid in bricks, of which those that hold one and the same value are kept once.
//!
//! Each brick has all nodes of its cells, those on its border too, so that the
//! corners of a cell are in one brick, close together in memory.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::grid::Grid;
use crate::num::whole_index;
use crate::store::{Nodes, corners};

/// Cells along each side of a brick. Fewer leave out more of the grid, but keep
/// more nodes twice: a brick of 8 has 9 nodes a side, 1.4 times its share.
const BRICK: usize = 8;
const SIDE: usize = BRICK + 1;
const VOLUME: usize = SIDE * SIDE * SIDE;

/// 16-bit steps in bricks of 8³ cells.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bricks {
    step: f64,
    /// Bricks along each axis.
    bricks: [usize; 3],
    /// For each brick, which of the kept ones it is.
    table: Vec<u32>,
    values: Vec<i16>,
}

impl Bricks {
    pub(crate) fn new(values: &[i16], grid: &Grid, step: f64) -> Self {
        let bricks @ [bx, by, bz] = grid.dims().map(|n| (n - 1).div_ceil(BRICK));
        let (mut table, mut kept) = (Vec::new(), Kept::default());
        let mut nodes = [0; VOLUME];
        for brick in 0..bx * by * bz {
            let first = [brick % bx, brick / bx % by, brick / (bx * by)].map(|b| b * BRICK);
            for (place, value) in nodes.iter_mut().enumerate() {
                let offset = [place % SIDE, place / SIDE % SIDE, place / (SIDE * SIDE)];
                // Beyond the grid the last node repeats; no cell reads it.
                let at = |axis: usize| (first[axis] + offset[axis]).min(grid.dims()[axis] - 1);
                *value = values[grid.index([at(0), at(1), at(2)])];
            }
            table.push(kept.number(&nodes));
        }
        Self { step, bricks, table, values: kept.values }
    }

    /// Bytes that the values take.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.values[..]) + size_of_val(&self.table[..])
    }

    /// Where the values of a brick begin.
    #[inline]
    fn start(&self, [x, y, z]: [usize; 3]) -> usize {
        let [bx, by, _] = self.bricks;
        self.table[x + bx * (y + by * z)] as usize * VOLUME
    }
}

/// Bricks while they are collected.
#[derive(Default)]
struct Kept {
    count: u32,
    values: Vec<i16>,
    /// Values of which a whole brick has been kept, and its number.
    uniform: BTreeMap<i16, u32>,
}

impl Kept {
    fn number(&mut self, nodes: &[i16; VOLUME]) -> u32 {
        let is_uniform = nodes.iter().all(|value| *value == nodes[0]);
        if let Some(&known) = self.uniform.get(&nodes[0]).filter(|_| is_uniform) {
            return known;
        }
        let number = self.count;
        if is_uniform {
            self.uniform.insert(nodes[0], number);
        }
        self.values.extend_from_slice(nodes);
        self.count += 1;
        number
    }
}

impl Nodes for Bricks {
    type Value = i16;

    #[inline]
    fn step(&self) -> f64 {
        self.step
    }

    #[inline]
    fn node(&self, node: [usize; 3]) -> i16 {
        let brick = [0, 1, 2].map(|axis| (node[axis] / BRICK).min(self.bricks[axis] - 1));
        let [x, y, z] = [0, 1, 2].map(|axis| node[axis] - brick[axis] * BRICK);
        self.values[self.start(brick) + x + SIDE * (y + SIDE * z)]
    }

    #[inline]
    fn cell(&self, cell: DVec3) -> [[i16; 4]; 2] {
        let cell = cell.to_array().map(whole_index);
        let [x, y, z] = cell.map(|n| n % BRICK);
        let first = self.start(cell.map(|n| n / BRICK)) + x + SIDE * (y + SIDE * z);
        corners(&self.values, first, [SIDE, SIDE * SIDE])
    }
}
