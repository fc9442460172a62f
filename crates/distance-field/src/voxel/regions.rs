//! Connected regions of the nodes that a flood from outside does not reach.
//!
//! Runs of nodes along x are joined where they are beside each other: far fewer than the nodes.

use std::ops::Range;

use surface::UnionFind;

/// Nodes of a row that are tested at once.
const BLOCK: usize = 16;

/// Run of enclosed nodes along x, a range of nodes in memory.
type NodeRun = Range<usize>;

/// Connected regions of enclosed nodes.
pub(super) struct EnclosedRegions {
    runs: Vec<NodeRun>,
    /// Number of the region of each run.
    region_of: Vec<usize>,
    count: usize,
}

impl EnclosedRegions {
    /// Finds the 6-connected regions; `None` for more runs than 32-bit numbers count.
    pub(super) fn new(enclosed: &[bool], [nx, ny, _]: [usize; 3]) -> Option<Self> {
        // Rows follow each other as in memory.
        let (mut runs, mut rows) = (Vec::new(), Vec::new());
        for (r, row) in enclosed.chunks(nx).enumerate() {
            let first = runs.len();
            push_runs(row, r * nx, &mut runs);
            rows.push(first..runs.len());
        }
        u32::try_from(runs.len()).ok()?;

        // Every row is joined to the one before it in its plane, and to the same one in the
        // plane before.
        let mut sets = UnionFind::new(runs.len());
        for r in 0..rows.len() {
            if rows[r].is_empty() {
                continue;
            }
            if r % ny > 0 {
                join(&runs, [&rows[r - 1], &rows[r]], nx, &mut sets);
            }
            if r >= ny {
                join(&runs, [&rows[r - ny], &rows[r]], nx * ny, &mut sets);
            }
        }

        // The root of a set is its first run.
        let (mut region_of, mut count) = (Vec::with_capacity(runs.len()), 0);
        for (run, number) in (0..runs.len()).zip(0..) {
            let root = sets.find(number) as usize;
            if root == run {
                region_of.push(count);
                count += 1;
            } else {
                region_of.push(region_of[root]);
            }
        }
        Some(Self { runs, region_of, count })
    }

    /// Returns a node deep in each region: of the middles of its runs, the first one that is
    /// farthest from the surface.
    pub(super) fn deep_nodes(&self, squared: &[f32]) -> Vec<usize> {
        let mut deep_nodes = vec![(0, -1.0); self.count];
        for (run, &region) in self.runs.iter().zip(&self.region_of) {
            let middle = middle(run);
            if squared[middle] > deep_nodes[region].1 {
                deep_nodes[region] = (middle, squared[middle]);
            }
        }
        deep_nodes.into_iter().map(|(node, _)| node).collect()
    }

    /// Returns the middles of all runs of some regions, one flag per region, each with its region.
    pub(super) fn middles(&self, is_chosen: &[bool]) -> (Vec<usize>, Vec<usize>) {
        let runs = self.runs.iter().zip(&self.region_of).filter(|&(_, &region)| is_chosen[region]);
        runs.map(|(run, &region)| (middle(run), region)).unzip()
    }

    /// Takes the nodes of some regions, one flag per region, from those that are enclosed.
    pub(super) fn remove(&self, is_removed: &[bool], enclosed: &mut [bool]) {
        for (run, &region) in self.runs.iter().zip(&self.region_of) {
            if is_removed[region] {
                enclosed[run.clone()].fill(false);
            }
        }
    }
}

fn middle(run: &NodeRun) -> usize {
    run.start + (run.end - run.start) / 2
}

/// Appends the runs of a row that begins at node `first`.
fn push_runs(row: &[bool], first: usize, runs: &mut Vec<NodeRun>) {
    // Most rows have none, and most blocks of the others no end of one: tests of a whole row and of
    // a whole block vectorize.
    if !contains(row, true) {
        return;
    }
    let (mut start, mut is_within) = (first, false);
    for (first, block) in (first..).step_by(BLOCK).zip(row.chunks(BLOCK)) {
        if !contains(block, !is_within) {
            continue;
        }
        for (node, &is_enclosed) in (first..).zip(block) {
            if is_enclosed != is_within {
                if is_within {
                    runs.push(start..node);
                }
                (start, is_within) = (node, is_enclosed);
            }
        }
    }
    if is_within {
        runs.push(start..first + row.len());
    }
}

/// Returns true if one of some nodes is `enclosed`, without an early end.
fn contains(nodes: &[bool], enclosed: bool) -> bool {
    nodes.iter().fold(false, |any, &is_enclosed| any | (is_enclosed == enclosed))
}

/// Joins the runs of two rows that are beside each other, `stride` nodes apart.
fn join(runs: &[NodeRun], [before, row]: [&Range<usize>; 2], stride: usize, sets: &mut UnionFind) {
    let (mut b, mut r) = (before.start, row.start);
    while b < before.end && r < row.end {
        let (beside, run) = (&runs[b], &runs[r]);
        let (start, end) = (beside.start + stride, beside.end + stride);
        if start < run.end && run.start < end {
            sets.join(number(b), number(r));
        }

        // The run that ends first has no more beside it.
        if end <= run.end {
            b += 1;
        } else {
            r += 1;
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "more runs are refused")]
fn number(run: usize) -> u32 {
    run as u32
}

#[cfg(test)]
mod tests {
    use fixtures::random::Random;

    use super::*;

    /// Reference implementation: a flood from node to node.
    #[test]
    fn regions_equal_those_of_a_flood() {
        let (dims, mut random) = ([7, 5, 6], Random(11));
        let strides = [1, 7, 35];
        let mut most = 0;
        for filled in [0.2, 0.4, 0.6, 0.9] {
            let mut enclosed = Vec::new();
            for _ in 0..210 {
                enclosed.push(random.unit() < filled);
            }
            let mut squared = Vec::new();
            for node in 0..210_u8 {
                squared.push(f32::from(node.wrapping_mul(37)));
            }
            let regions = EnclosedRegions::new(&enclosed, dims).expect("few runs");

            // Without the regions, one by one, nothing is left but the others.
            let nodes = regions.deep_nodes(&squared);
            let mut left = enclosed.clone();
            for (region, &node) in nodes.iter().enumerate() {
                let mut is_removed = vec![false; nodes.len()];
                is_removed[region] = true;
                let mut rest = left.clone();
                regions.remove(&is_removed, &mut rest);

                let (mut front, mut flooded) = (vec![node], left.clone());
                while let Some(node) = front.pop() {
                    if !std::mem::replace(&mut flooded[node], false) {
                        continue;
                    }
                    for axis in 0..3 {
                        let place = node / strides[axis] % dims[axis];
                        if place > 0 {
                            front.push(node - strides[axis]);
                        }
                        if place + 1 < dims[axis] {
                            front.push(node + strides[axis]);
                        }
                    }
                }
                assert!(left[node] && rest == flooded, "region {region} at {filled}");
                left = rest;
            }
            assert!(!left.contains(&true), "{filled}");
            most = most.max(nodes.len());
        }
        assert!(most > 10, "{most}");
    }
}
