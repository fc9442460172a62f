//! Passes over a grid that are separable by axes: along x, then y, then z.

use surface::parallel;
use surface::progress::{Interrupted, Progress};

/// Row of nodes along x: the label of the seed that is nearest so far, and how near it is.
pub(crate) struct Row<'a, L, D> {
    pub(crate) labels: &'a mut [L],
    pub(crate) nearness: &'a mut [D],
}

/// Runs `within` on the rows of every plane across z, then `across` on the rows of every
/// plane across y, in parallel.
pub(crate) fn passes<L: Send, D: Send>(
    labels: &mut [L],
    nearness: &mut [D],
    [nx, ny, nz]: [usize; 3],
    progress: Progress<'_>,
    within: impl Fn(&mut [Row<'_, L, D>]) + Sync + Send,
    across: impl Fn(&mut [Row<'_, L, D>]) + Sync + Send,
) -> Result<(), Interrupted> {
    let steps = progress.steps(nz + ny);
    let mut planes = rows(labels, nearness, nx * ny);
    parallel::try_for_each_mut(&mut planes, |_, plane| {
        steps.advance(1)?;
        within(&mut rows(plane.labels, plane.nearness, nx));
        Ok(())
    })?;

    // A wall holds the rows of one y, across z.
    let mut walls: Vec<Vec<_>> = (0..ny).map(|_| Vec::with_capacity(nz)).collect();
    for (r, row) in rows(labels, nearness, nx).into_iter().enumerate() {
        walls[r % ny].push(row);
    }
    parallel::try_for_each_mut(&mut walls, |_, wall| {
        steps.advance(1)?;
        across(wall);
        Ok(())
    })
}

/// Cuts a grid into rows of `length` nodes.
fn rows<'a, L, D>(labels: &'a mut [L], nearness: &'a mut [D], length: usize) -> Vec<Row<'a, L, D>> {
    let mut rows = Vec::with_capacity(labels.len() / length);
    for (labels, nearness) in labels.chunks_mut(length).zip(nearness.chunks_mut(length)) {
        rows.push(Row { labels, nearness });
    }
    rows
}
