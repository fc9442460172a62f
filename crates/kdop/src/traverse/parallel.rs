//! Pairs on several threads, in the order of one.
//!
//! The descent is unrolled from the top into a list of tasks, in the order in which one thread would
//! come to them. Their results are then concatenated.

use rayon::prelude::*;

use crate::tree::DopTree;
use crate::workspace::Workspace;

/// Number of tasks into which a traversal is divided.
///
/// With fewer, threads that finish early find nothing more to do; with more, a task is not worth
/// its workspace.
const TASKS: usize = 128;

/// Part of a traversal.
enum Task {
    /// Two nodes to be descended.
    Nodes((u32, u32)),
    /// Pairs of clusters whose leaves are to be tested.
    Clusters(Vec<(u32, u32)>),
}

impl<const S: usize> DopTree<S> {
    /// Returns the pairs that [`pairs`](Self::pairs) visits, in the same order, found on the
    /// threads of the current pool.
    ///
    /// ```
    /// use glam::DVec3;
    /// use kdop::{Leaves, Tree};
    ///
    /// let a = Tree::build(Leaves::Points, &[DVec3::ZERO, DVec3::X])?;
    /// assert_eq!(a.par_pairs(&a.clone(), 0.5), [(0, 0), (1, 1)]);
    /// # Ok::<(), kdop::TreeError>(())
    /// ```
    #[must_use]
    pub fn par_pairs(&self, other: &Self, margin: f64) -> Vec<(u32, u32)> {
        let margin = self.widening(margin);
        self.run_tasks(other, margin.as_ref(), |workspace, out| {
            self.visit_leaf_pairs(other, margin.as_ref(), workspace, |a, b| out.push((a, b)));
        })
    }

    /// Returns the pairs that [`self_pairs`](Self::self_pairs) visits, in the same order, found on
    /// the threads of the current pool.
    #[must_use]
    pub fn par_self_pairs(&self, margin: f64) -> Vec<(u32, u32)> {
        // The adjacency is found once, before the tasks need it.
        self.neighbors();
        let margin = self.widening(margin);
        self.run_tasks(self, margin.as_ref(), |workspace, out| {
            self.visit_leaf_self_pairs(margin.as_ref(), workspace, |a, b| out.push((a, b)));
        })
    }

    /// Runs a traversal in parallel; `visit` tests the leaves of the clusters in a workspace.
    fn run_tasks(
        &self,
        other: &Self,
        margin: Option<&[f32; S]>,
        visit: impl Fn(&mut Workspace<S>, &mut Vec<(u32, u32)>) + Sync,
    ) -> Vec<(u32, u32)> {
        let run = |workspace: &mut Workspace<S>, task: Task| {
            workspace.cluster_pairs.clear();
            match task {
                Task::Nodes(pair) => {
                    workspace.node_pairs.push(pair);
                    self.gather_cluster_pairs(other, margin, workspace);
                }
                Task::Clusters(pairs) => workspace.cluster_pairs.extend(pairs),
            }
            let mut out = Vec::new();
            visit(workspace, &mut out);
            out
        };

        // Results are collected in the order of the tasks, whichever thread runs them.
        let tasks = self.unrolled(other, margin).into_par_iter();
        let parts: Vec<_> = tasks.map_init(Workspace::new, run).collect();
        parts.concat()
    }

    /// Divides a traversal into tasks.
    ///
    /// A pair of nodes is replaced by the clusters found below it and then, last first as on a
    /// stack, the nodes.
    fn unrolled(&self, other: &Self, margin: Option<&[f32; S]>) -> Vec<Task> {
        let mut workspace = Workspace::new();
        let mut tasks = Vec::new();
        if !self.nodes.is_empty() && !other.nodes.is_empty() {
            tasks.push(Task::Nodes((0, 0)));
        }

        // Descend all pairs of nodes by one level until there are enough tasks.
        let has_nodes = |tasks: &[Task]| tasks.iter().any(|task| matches!(task, Task::Nodes(_)));
        while tasks.len() < TASKS && has_nodes(&tasks) {
            let mut next = Vec::new();
            for task in tasks {
                let Task::Nodes(pair) = task else {
                    next.push(task);
                    continue;
                };
                workspace.cluster_pairs.clear();
                self.descend(other, margin, pair, &mut workspace);
                if !workspace.cluster_pairs.is_empty() {
                    next.push(Task::Clusters(workspace.cluster_pairs.clone()));
                }
                next.extend(workspace.node_pairs.drain(..).rev().map(Task::Nodes));
            }
            tasks = next;
        }
        tasks
    }
}
