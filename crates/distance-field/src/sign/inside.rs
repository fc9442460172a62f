//! Set of inside nodes, as runs along the rows of a grid.

use std::ops::Range;

/// Set of inside nodes.
///
/// Rows start outside and change sides at their turns.
#[derive(Debug, Default)]
pub(crate) struct Inside {
    /// Nodes per row.
    nx: usize,
    /// Row `r` has the turns `turns[starts[r]..starts[r + 1]]`, ascending.
    starts: Vec<usize>,
    turns: Vec<usize>,
    /// Nodes on the other side than their row says, by ascending number in memory.
    exceptions: Vec<usize>,
}

impl Inside {
    /// Returns the set with the given turns, row after row.
    pub(super) fn new(
        nx: usize,
        rows: impl Iterator<Item = Vec<usize>>,
        exceptions: Vec<usize>,
    ) -> Self {
        let mut inside = Self { nx, starts: vec![0], turns: Vec::new(), exceptions };
        for row in rows {
            inside.turns.extend(row);
            inside.starts.push(inside.turns.len());
        }
        inside
    }

    /// Returns the set of the nodes that are true in a mask.
    pub(crate) fn from_mask(mask: &[bool], nx: usize) -> Self {
        let turns = |row: &[bool]| {
            let is_turn = |&i: &usize| row[i] != (i > 0 && row[i - 1]);
            (0..row.len()).filter(is_turn).collect()
        };
        Self::new(nx, mask.chunks(nx).map(turns), Vec::new())
    }

    /// Counts the inside nodes.
    pub(crate) fn count(&self) -> usize {
        let mut count = 0;
        for r in 0..self.starts.len() - 1 {
            let in_runs: usize = self.runs(r).map(|run| run.len()).sum();
            let exceptions = self.exceptions(r);
            let removed = exceptions.clone().filter(|i| self.runs(r).any(|run| run.contains(i)));
            count += in_runs + exceptions.count() - 2 * removed.count();
        }
        count
    }

    /// Negates the values of the inside nodes of row `r`.
    pub(crate) fn negate(&self, r: usize, values: &mut [f32]) {
        for run in self.runs(r) {
            values[run].iter_mut().for_each(|value| *value = -*value);
        }
        for i in self.exceptions(r) {
            values[i] = -values[i];
        }
    }

    /// Returns the runs of inside nodes of row `r`, exceptions left out.
    fn runs(&self, r: usize) -> impl Iterator<Item = Range<usize>> {
        let turns = &self.turns[self.starts[r]..self.starts[r + 1]];
        turns.chunks(2).map(|run| run[0]..run.get(1).copied().unwrap_or(self.nx))
    }

    /// Returns the exceptions among the nodes of row `r`, as places along it.
    fn exceptions(&self, r: usize) -> impl Iterator<Item = usize> + Clone {
        let row = r * self.nx..(r + 1) * self.nx;
        let first = self.exceptions.partition_point(|&node| node < row.start);
        let rest = self.exceptions[first..].iter().take_while(move |&&node| node < row.end);
        rest.map(move |&node| node - r * self.nx)
    }
}
