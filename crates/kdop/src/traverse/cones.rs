//! Self pairs with neighbours culled by their normals: a heuristic.
//!
//! Source: P. Volino and N. Magnenat-Thalmann, "Efficient Self-Collision Detection on Smoothly
//! Discretized Surface Animations using Geometrical Shape Regularity", Computer Graphics Forum
//! 13(3), 1994; X. Provot, "Collision and Self-Collision Handling in Cloth Model Dedicated to Design
//! Garments", Graphics Interface 1997. A region of a surface does not meet itself if there is a
//! direction that makes an acute angle with all of its normals **and** its contour, projected along
//! that direction, does not cross itself.
//!
//! Differs from them in leaving out the second condition: for regions of sixteen triangles a test of
//! the contour costs more than the tests of triangles it would save. So this is a heuristic. What it
//! may leave out are pairs in two clusters that share points, or in one, where a small patch crosses
//! itself although it folds by less than a right angle either way: a patch that spirals.

use std::convert::Infallible;
use std::ops::ControlFlow;

use glam::DVec3;

use super::unbroken;
use crate::cluster::{CLUSTER, Cluster};
use crate::error::TreeError;
use crate::extents::check_length;
use crate::tree::DopTree;
use crate::workspace::Workspace;

impl<const S: usize> DopTree<S> {
    /// As [`self_pairs`](Self::self_pairs), but without pairs among neighbouring clusters whose
    /// normals all lie on one side of their mean.
    ///
    /// **This may lose pairs**, and says so in its name. The leaves must be the triangles of a
    /// consistently wound surface, and `points` (|P|) those of the last refit. What it may lose are
    /// crossings of neighbouring triangles in a patch that is nearly flat: of the crossings in
    /// generated muscles, straight, bent, twisted and wrung, of 300 to 80 000 faces, it missed one
    /// in fifty thousand, but that one was the only one in its muscle. On a smooth muscle of 6500
    /// faces it leaves out four to five candidates in six and takes half the time; on a wrung one it
    /// saves nothing. `kdop_peers cones` in the `benches` package prints all of this.
    ///
    /// # Errors
    ///
    /// [`TreeError::WrongLength`] when `points` are not as many as the tree has.
    pub fn self_pairs_unless_flat(
        &self,
        points: &[DVec3],
        margin: f64,
        workspace: &mut Workspace<S>,
        mut visit: impl FnMut(u32, u32),
    ) -> Result<(), TreeError> {
        check_length(points.len(), self.point_count())?;
        let margin = self.widening(margin);
        self.gather_self_pairs(margin.as_ref(), workspace);
        self.drop_flat_neighbours(points, workspace);
        unbroken(self.visit_leaf_self_pairs(margin.as_ref(), workspace, |a, b| {
            visit(a, b);
            ControlFlow::<Infallible>::Continue(())
        }));
        Ok(())
    }

    fn drop_flat_neighbours(&self, points: &[DVec3], workspace: &mut Workspace<S>) {
        let neighbours = self.neighbours();
        let Workspace { cluster_pairs, normals, .. } = workspace;
        normals.clear();
        normals.extend((0..).zip(&self.clusters).map(|(id, cluster)| {
            let connected = neighbours.is_connected(id);
            self.normals(cluster, connected, points)
        }));
        cluster_pairs.retain(|&(a, b)| {
            let (first, last) = (a.min(b), a.max(b));
            let near = a == b || neighbours.are_listed(first, last);
            !(near && is_flat(&normals[a as usize], &normals[b as usize]))
        });
    }

    fn normals(&self, cluster: &Cluster, connected: bool, points: &[DVec3]) -> Normals {
        let mut normals = [DVec3::ZERO; CLUSTER];
        for (i, normal) in normals.iter_mut().enumerate().take(cluster.leaf_count as usize) {
            let corners = cluster.corner_points(i, &self.cluster_points);
            let [a, b, c] = corners.map(|p| points[p as usize]);
            *normal = (b - a).cross(c - a);
        }
        let count = cluster.leaf_count as usize;
        Normals { connected, count, normals, sum: normals.iter().sum() }
    }
}

/// Normals of a cluster's triangles, as long as twice their areas, and their sum.
#[derive(Clone, Debug)]
pub(crate) struct Normals {
    /// Two sheets in one cluster may cross, however flat they are.
    connected: bool,
    count: usize,
    normals: [DVec3; CLUSTER],
    sum: DVec3,
}

/// Whether all normals of two clusters make acute angles with their mean. Triangles without area
/// have no normal, so a cluster with one is never flat.
fn is_flat(a: &Normals, b: &Normals) -> bool {
    let mean = a.sum + b.sum;
    let acute = |cluster: &Normals| {
        cluster.connected
            && cluster.normals[..cluster.count].iter().all(|normal| normal.dot(mean) > 0.0)
    };
    acute(a) && acute(b)
}
