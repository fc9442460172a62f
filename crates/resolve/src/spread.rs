//! Spreading of a push from some vertices to the tissue around them.
//!
//! Vertices that are not pushed take the displacement of a membrane on an elastic
//! foundation, `Δu = u / ℓ²` with the smoothing length ℓ. It fades along the surface, and is
//! cut to exactly 0 a few ℓ away. Struts take part, so that thin sheets move as one and keep
//! their volume.

use std::collections::VecDeque;

use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use surface::progress::{Interrupted, Progress};

use crate::tissue::Tissue;

/// Gauss–Seidel sweeps over the vertices around a push. Below, the displacement is rough,
/// which later rounds have to smooth; above, rounds take longer.
const SPREAD_SWEEPS: usize = 8;

/// Share of the largest displacement below which one counts as none: the vertex stays where it is, or
/// goes back to rest. Below, vertices far away lose their bits; above, the cut is a visible step.
pub(crate) const NEGLIGIBLE_SHARE: f64 = 1e-3;

/// Vertices visited between two polls for interruption: each casts a ray, some microseconds.
const POLL_INTERVAL: usize = 1024;

impl Tissue {
    /// Spreads the displacement of this round to vertices that have none.
    pub(crate) fn spread(
        &mut self,
        tree: &SurfaceTree,
        smoothing: f64,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        // The pushed vertices, and how far they are pushed.
        let (mut pushed, mut strongest) = (Vec::new(), 0.0_f64);
        for (vertex, &u) in (0..).zip(&self.u) {
            if u != DVec3::ZERO {
                pushed.push(vertex);
                strongest = strongest.max(u.length());
            }
        }

        // The length to spread over grows with the push, so that no tissue strains more.
        let length = smoothing.max(self.params.tuning.spread_radius * strongest);
        let free = self.vertices_around(&pushed, tree, length, progress)?;

        // The membrane on its foundation, relaxed around the pushed vertices.
        let foundation = (length * length).recip();
        symmetric_sweeps(&free, SPREAD_SWEEPS, |&vertex| {
            let u = self.equilibrium(vertex, |next| self.u[next as usize], foundation);
            self.u[vertex as usize] = u.unwrap_or(self.u[vertex as usize]);
        });

        // What is too small to matter keeps its bits.
        for vertex in free {
            let u = &mut self.u[vertex as usize];
            if u.length() < NEGLIGIBLE_SHARE * strongest {
                *u = DVec3::ZERO;
            }
        }
        Ok(())
    }

    /// Finds the vertices around pushed ones, along the surface or through the body, that are
    /// not pushed themselves, ascending.
    pub(crate) fn vertices_around(
        &mut self,
        pushed: &[u32],
        tree: &SurfaceTree,
        length: f64,
        progress: Progress<'_>,
    ) -> Result<Vec<u32>, Interrupted> {
        let workspace = &mut Workspace::default();
        let max_distance = self.params.tuning.spread_radius * length;
        let mut is_visited = vec![false; self.rest.len()];
        let mut queue = VecDeque::new();
        for &vertex in pushed {
            is_visited[vertex as usize] = true;
            queue.push_back((vertex, vertex));
        }

        // Breadth first, each vertex from the pushed one that it was reached from.
        let mut free = Vec::new();
        let mut visited_count: usize = 0;
        while let Some((vertex, source)) = queue.pop_front() {
            visited_count += 1;
            if visited_count.is_multiple_of(POLL_INTERVAL) {
                progress.report(0.0)?;
            }
            self.find_strut(tree, vertex, self.params.tuning.spread_radius * length, workspace);
            let along = self.links(vertex).iter().map(|link| link.neighbor);
            let through = self.strut(vertex).map_or([vertex; 3], |strut| strut.corners);
            for next in along.chain(through) {
                let distance = self.rest[next as usize].distance(self.rest[source as usize]);
                if !is_visited[next as usize] && distance <= max_distance {
                    is_visited[next as usize] = true;
                    free.push(next);
                    queue.push_back((next, source));
                }
            }
        }
        free.sort_unstable();
        Ok(free)
    }
}

/// Relaxes all items `sweeps` times, forward and backward in turn (symmetric Gauss–Seidel).
pub(crate) fn symmetric_sweeps<T>(items: &[T], sweeps: usize, mut relax: impl FnMut(&T)) {
    for sweep in 0..sweeps {
        if sweep % 2 == 0 {
            items.iter().for_each(&mut relax);
        } else {
            items.iter().rev().for_each(&mut relax);
        }
    }
}
