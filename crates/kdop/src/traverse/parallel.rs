//! Pairs on several threads, in the order of one.
//!
//! The descent is unrolled from the top into a list of tasks that stand in the order in which one
//! thread would meet them; their results are then set one after the other.

use std::convert::Infallible;
use std::ops::ControlFlow;

use rayon::prelude::*;

use super::unbroken;
use crate::tree::DopTree;
use crate::workspace::Workspace;

/// Tasks a traversal is cut into: enough that threads which finish early find more to do, few enough
/// that each is worth a workspace.
const TASKS: usize = 128;

/// A part of a traversal.
enum Task {
    /// Two nodes, to be descended.
    Nodes((u32, u32)),
    /// Pairs of clusters, whose leaves are to be tested.
    Clusters(Vec<(u32, u32)>),
}

impl<const S: usize> DopTree<S> {
    /// The pairs that [`pairs`](Self::pairs) visits, in the same order, found on the threads of the
    /// current pool.
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
        let widening = self.widening(margin);
        let widening = widening.as_ref();
        self.run_tasks(other, widening, |workspace, out| {
            unbroken(self.visit_leaf_pairs(other, widening, workspace, push_to(out)));
        })
    }

    /// The pairs that [`self_pairs`](Self::self_pairs) visits, in the same order, found on the
    /// threads of the current pool.
    #[must_use]
    pub fn par_self_pairs(&self, margin: f64) -> Vec<(u32, u32)> {
        self.neighbours();
        let widening = self.widening(margin);
        let widening = widening.as_ref();
        self.run_tasks(self, widening, |workspace, out| {
            unbroken(self.visit_leaf_self_pairs(widening, workspace, push_to(out)));
        })
    }

    fn run_tasks(
        &self,
        other: &Self,
        margin: Option<&[f32; S]>,
        visit: impl Fn(&mut Workspace<S>, &mut Vec<(u32, u32)>) + Sync,
    ) -> Vec<(u32, u32)> {
        let tasks = self.unrolled(other, margin);
        let run = |workspace: &mut Workspace<S>, task: Task| {
            let mut out = Vec::new();
            workspace.cluster_pairs.clear();
            match task {
                Task::Nodes(pair) => {
                    workspace.node_pairs.push(pair);
                    self.gather_cluster_pairs(other, margin, workspace);
                }
                Task::Clusters(pairs) => workspace.cluster_pairs.extend(pairs),
            }
            visit(workspace, &mut out);
            out
        };
        let parts: Vec<_> = tasks.into_par_iter().map_init(Workspace::new, run).collect();
        parts.concat()
    }

    /// The tasks of a traversal. A pair of nodes is replaced by the clusters found below it and
    /// then, last first as on a stack, the nodes.
    fn unrolled(&self, other: &Self, margin: Option<&[f32; S]>) -> Vec<Task> {
        let mut workspace = Workspace::new();
        let mut tasks = Vec::new();
        if !self.nodes.is_empty() && !other.nodes.is_empty() {
            tasks.push(Task::Nodes((0, 0)));
        }
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

fn push_to(out: &mut Vec<(u32, u32)>) -> impl FnMut(u32, u32) -> ControlFlow<Infallible> {
    |a, b| {
        out.push((a, b));
        ControlFlow::Continue(())
    }
}
