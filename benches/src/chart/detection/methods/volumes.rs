//! Faces that cross, by trees of volumes of any number of planes and the exact predicate.

use kdop::{DopTree, Leaves, Workspace};
use surface::{Meeting, triangles_meet};

use super::super::score::Answer;
use super::super::task::Task;
use super::{Built, Detector, Failure};

/// Detection of crossing faces by trees of volumes of `2 S` planes.
struct CrossingFaces<'a, const S: usize> {
    task: &'a Task<'a>,
    muscles: Vec<usize>,
    trees: Vec<DopTree<S>>,
    workspace: Workspace<S>,
    found: Vec<([usize; 2], Vec<[u32; 2]>)>,
}

/// Builds trees of volumes of a number of planes.
///
/// # Errors
///
/// When there are no such volumes, or a tree cannot be built.
pub(super) fn detector<'a>(task: &'a Task<'a>, planes: f64) -> Built<'a> {
    match super::whole(planes) {
        6 => build::<3>(task),
        14 => build::<7>(task),
        18 => build::<9>(task),
        26 => build::<13>(task),
        other => Err(format!("no volumes of {other} planes").into()),
    }
}

fn build<'a, const S: usize>(task: &'a Task<'a>) -> Built<'a> {
    let (mut trees, mut found) = (Vec::new(), Vec::new());
    for body in &task.moving.bodies {
        let leaves = Leaves::Triangles(body.surface().faces());
        trees.push(DopTree::<S>::build(leaves, body.positions().as_slice())?);
    }
    for &pair in &task.pairs {
        found.push((pair, Vec::new()));
    }
    let (muscles, workspace) = (task.muscles(), Workspace::new());
    Ok(Box::new(CrossingFaces { task, muscles, trees, workspace, found }))
}

impl<const S: usize> Detector for CrossingFaces<'_, S> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        let Self { task, muscles, trees, workspace, found } = self;
        for &muscle in &*muscles {
            trees[muscle].refit(task.positions(frame, muscle))?;
        }

        for (pair, crossing) in found {
            crossing.clear();
            let [x, y] = pair.map(|body| task.positions(frame, body));
            let [a, b] = pair.map(|body| task.moving.bodies[body].surface().faces());
            let [of_a, of_b] = *pair;
            trees[of_a].pairs(&trees[of_b], 0.0, workspace, |i, j| {
                let face_a = a[i as usize].map(|vertex| x[vertex as usize]);
                let face_b = b[j as usize].map(|vertex| y[vertex as usize]);
                if triangles_meet(face_a, face_b) == Meeting::Crossing {
                    crossing.push([i, j]);
                }
            });
        }
        Ok(())
    }

    fn answer(&self) -> Answer {
        Answer::Crossings(self.found.clone())
    }
}
