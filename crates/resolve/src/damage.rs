//! Damage to shape that a state does: turned faces, flat corners of cells, self-crossings, strain, and changes of volume.

use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use surface::progress::{Interrupted, Progress};

use crate::tissue::{Damage, Tissue};

impl Tissue {
    /// Assesses the damage at `x`. Self-crossings take long: without `counts_crossings`, their
    /// last count stays.
    pub(crate) fn assess(
        &mut self,
        tree: &SurfaceTree,
        counts_crossings: bool,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        let x = tree.positions().as_slice();
        let volume_change = self.volume_change(x);
        let (flipped_faces, flat_corners) = (self.count_flipped(x), self.count_flat_corners(x));
        let mut self_crossings = self.damage.self_crossings;
        if counts_crossings {
            self_crossings = self.count_crossings_once(tree, progress)?;
        }
        let (strain, max_displacement) = (self.strain(x), self.max_displacement(x));
        self.damage = Damage {
            flipped_faces,
            flat_corners,
            volume_change,
            self_crossings,
            strain,
            max_displacement,
        };
        Ok(())
    }

    /// Returns the number of new self-crossings, which is counted once for each state of the body.
    pub(crate) fn count_crossings_once(
        &mut self,
        tree: &SurfaceTree,
        progress: Progress<'_>,
    ) -> Result<usize, Interrupted> {
        let count = match self.counted_crossings {
            Some(count) => count,
            None => self.count_new_self_crossings(tree, progress)?,
        };
        self.counted_crossings = Some(count);
        Ok(count)
    }

    /// Computes the largest strain of an edge at `x`: the change of its length over its length at rest,
    /// or over the mean edge of the body where that is longer. Splinters say nothing of the tissue.
    pub(crate) fn strain(&self, x: &[DVec3]) -> f64 {
        let mut strain: f64 = 0.0;
        for &[p, q] in self.surface.edges() {
            let [p, q] = [p as usize, q as usize];
            if x[p] - self.rest[p] == x[q] - self.rest[q] {
                continue;
            }
            let before = self.rest[p].distance(self.rest[q]);
            let change = (x[p].distance(x[q]) - before).abs();
            strain = strain.max(change / before.max(self.mean_edge));
        }
        strain
    }

    /// Returns the length of the longest displacement at `x`.
    pub(crate) fn max_displacement(&self, x: &[DVec3]) -> f64 {
        let mut longest: f64 = 0.0;
        for (x, rest) in x.iter().zip(&self.rest) {
            longest = longest.max(x.distance(*rest));
        }
        longest
    }

    /// Counts the pairs of the body's own faces that cross where they are written and do not at rest; all
    /// of them where they are to be resolved.
    pub(crate) fn count_new_self_crossings(
        &self,
        tree: &SurfaceTree,
        progress: Progress<'_>,
    ) -> Result<usize, Interrupted> {
        let is_at_rest = tree.positions().as_slice() == self.rest;
        if is_at_rest && self.crossings_to_resolve.is_none() {
            return Ok(0);
        }
        let now = self.self_crossings(tree, progress)?;
        if now.is_empty() || self.crossings_to_resolve.is_some() {
            return Ok(now.len());
        }
        let mut at_rest = self_crossings_at(&self.rest, tree, progress)?;
        at_rest.sort_unstable();
        Ok(now.iter().filter(|pair| at_rest.binary_search(pair).is_err()).count())
    }

    /// Computes the relative change of the volume; 0 where the body has no inside.
    pub(crate) fn volume_change(&self, x: &[DVec3]) -> f64 {
        match self.volume {
            Some(volume) if volume != 0.0 => (self.volume_at(x) / volume - 1.0).abs(),
            _ => 0.0,
        }
    }

    /// Counts the faces that are turned by a right angle or more at `x`.
    pub(crate) fn count_flipped(&self, x: &[DVec3]) -> usize {
        self.turned_faces(x, 0.0).len()
    }

    /// Returns positions as they are written.
    pub(crate) fn written(&self, x: Vec<DVec3>) -> Vec<DVec3> {
        if self.is_written_single { rounded_to_single(&x) } else { x }
    }

    /// Finds the pairs of the body's own faces that cross where they are written.
    pub(crate) fn self_crossings(
        &self,
        tree: &SurfaceTree,
        progress: Progress<'_>,
    ) -> Result<Vec<[u32; 2]>, Interrupted> {
        if self.is_written_single {
            self_crossings_at(&rounded_to_single(tree.positions().as_slice()), tree, progress)
        } else {
            tree.self_crossings(&mut Workspace::default(), progress)
        }
    }
}

/// Finds the pairs of a body's own faces that would cross at `x`.
pub(crate) fn self_crossings_at(
    x: &[DVec3],
    tree: &SurfaceTree,
    progress: Progress<'_>,
) -> Result<Vec<[u32; 2]>, Interrupted> {
    let mut moved = tree.clone();
    match moved.set_positions(x.iter().copied()) {
        Ok(()) => moved.self_crossings(&mut Workspace::default(), progress),
        Err(_) => Ok(Vec::new()),
    }
}

/// Rounds coordinates to 32-bit floating point.
pub(crate) fn rounded_to_single(x: &[DVec3]) -> Vec<DVec3> {
    x.iter().map(|x| x.as_vec3().as_dvec3()).collect()
}
