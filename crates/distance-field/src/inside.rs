//! Which nodes are inside, as the places along each row where that changes.

use std::ops::Range;

/// Rows start outside; `turns` are the nodes from which on it is the other way.
#[derive(Debug, Default)]
pub(crate) struct Inside {
    /// Row `r` has `turns[starts[r]..starts[r + 1]]`, ascending.
    starts: Vec<usize>,
    turns: Vec<usize>,
    /// Nodes, by their number in memory and ascending, that are the other way
    /// than their row says.
    exceptions: Vec<usize>,
}

impl Inside {
    /// From the turns of each row in turn.
    pub(crate) fn from_rows<R: IntoIterator<Item = usize>>(
        rows: impl Iterator<Item = R>,
        exceptions: Vec<usize>,
    ) -> Self {
        let mut inside = Self { starts: vec![0], turns: Vec::new(), exceptions };
        for row in rows {
            inside.turns.extend(row);
            inside.starts.push(inside.turns.len());
        }
        inside
    }

    /// From one truth a node, rows of `nx`.
    pub(crate) fn from_mask(mask: &[bool], nx: usize) -> Self {
        let turns_of = |row: &[bool]| {
            let changed = |&i: &usize| row[i] != (i > 0 && row[i - 1]);
            (0..row.len()).filter(changed).collect::<Vec<usize>>()
        };
        Self::from_rows(mask.chunks(nx).map(turns_of), Vec::new())
    }

    /// The runs of inside nodes of row `r` of `nx` nodes.
    pub(crate) fn runs(&self, r: usize, nx: usize) -> impl Iterator<Item = Range<usize>> {
        let turns = &self.turns[self.starts[r]..self.starts[r + 1]];
        turns.chunks(2).map(move |run| run[0]..run.get(1).copied().unwrap_or(nx))
    }

    /// Inside nodes of a grid with rows of `nx`.
    pub(crate) fn count(&self, nx: usize) -> usize {
        let rows = self.starts.len() - 1;
        let in_runs = |r: usize, i: usize| self.runs(r, nx).any(|run| run.contains(&i));
        let of_row = |r: usize| {
            let all: usize = self.runs(r, nx).map(|run| run.len()).sum();
            let (mut out, mut more) = (0, 0);
            for i in self.exceptions(r, nx) {
                *(if in_runs(r, i) { &mut out } else { &mut more }) += 1;
            }
            all + more - out
        };
        (0..rows).map(of_row).sum()
    }

    /// Exceptions among the nodes of row `r`, as places along it.
    pub(crate) fn exceptions(&self, r: usize, nx: usize) -> impl Iterator<Item = usize> {
        let range = r * nx..(r + 1) * nx;
        let first = self.exceptions.partition_point(|&node| node < range.start);
        self.exceptions[first..]
            .iter()
            .take_while(move |&&node| node < range.end)
            .map(move |&node| node - r * nx)
    }

    /// Makes the values of inside nodes negative; `values` are row `r`, none negative.
    pub(crate) fn sign(&self, r: usize, values: &mut [f32]) {
        let nx = values.len();
        for run in self.runs(r, nx) {
            values[run].iter_mut().for_each(|value| *value = -*value);
        }
        for i in self.exceptions(r, nx) {
            values[i] = -values[i];
        }
    }
}
