//! Trees of boxes by peers: leaf boxes and a tree from vertices, refits, pairs.

use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};

use super::other_tree::OtherTree;

/// Converts points for `parry3d`.
pub(super) fn parry_points(points: &[DVec3]) -> Vec<Vector> {
    let mut converted = Vec::new();
    for p in points {
        converted.push(Vector::from_array(p.as_vec3().to_array()));
    }
    converted
}

/// Converts points for `obvhs`.
pub(super) fn sweep_points(points: &[DVec3]) -> Vec<Vec3A> {
    points.iter().map(|p| p.as_vec3a()).collect()
}

/// Tree of `parry3d` over the boxes of triangles.
pub(super) struct ParryTree {
    bvh: Bvh,
    workspace: BvhWorkspace,
    triangles: Vec<[u32; 3]>,
}

impl ParryTree {
    fn update(&mut self, boxes: impl Fn([u32; 3]) -> Aabb) {
        for (leaf, &t) in (0..).zip(&self.triangles) {
            self.bvh.insert_or_update_partially(boxes(t), leaf, 0.0);
        }
    }
}

impl OtherTree for ParryTree {
    const NAME: &'static str = "parry";

    type Point = Vector;

    fn points(points: &[DVec3]) -> Vec<Vector> {
        parry_points(points)
    }

    fn build(triangles: &[[u32; 3]], points: &[Vector]) -> Self {
        let mut boxes = Vec::new();
        for &triangle in triangles {
            boxes.push(parry_box(points, triangle));
        }
        let bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        Self { bvh, workspace: BvhWorkspace::default(), triangles: triangles.to_vec() }
    }

    fn leaf_count(&self) -> usize {
        self.bvh.leaf_count() as usize
    }

    /// Refits and reorders nodes depth first.
    fn refit(&mut self, points: &[Vector]) -> usize {
        self.update(|t| parry_box(points, t));
        self.bvh.refit(&mut self.workspace);
        self.triangles.len()
    }

    /// Refits in the order of the build, as its triangle mesh does when vertices are set.
    fn refit_in_place(&mut self, points: &[Vector]) -> usize {
        self.update(|t| parry_box(points, t));
        self.bvh.refit_without_opt();
        self.triangles.len()
    }

    fn refit_swept(&mut self, [x0, x1]: [&[Vector]; 2]) -> usize {
        self.update(|t| parry_box(x0, t).merged(&parry_box(x1, t)));
        self.bvh.refit(&mut self.workspace);
        self.triangles.len()
    }

    fn pairs(&mut self, other: &Self, out: &mut Vec<(u32, u32)>) -> usize {
        out.clear();
        out.extend(self.bvh.leaf_pairs(&other.bvh, |a, b| a.intersects(b)));
        out.len()
    }

    fn self_pairs(&mut self, out: &mut Vec<(u32, u32)>) -> usize {
        out.clear();
        let triangles = &self.triangles;
        self.bvh.traverse_bvtt_single_tree::<false>(&mut self.workspace, &mut |i, j| {
            let (a, b) = (triangles[i as usize], triangles[j as usize]);
            if !a.iter().any(|p| b.contains(p)) {
                out.push((i, j));
            }
        });
        out.len()
    }
}

fn parry_box(points: &[Vector], triangle: [u32; 3]) -> Aabb {
    let [a, b, c] = triangle.map(|i| points[i as usize]);
    Aabb::new(a.min(b).min(c), a.max(b).max(c))
}

/// Binary tree of `obvhs`, whose refit is one sweep over an array of boxes.
pub(super) struct SweepTree {
    bvh: Bvh2,
    triangles: Vec<[u32; 3]>,
}

impl SweepTree {
    pub(super) fn build(triangles: &[[u32; 3]], points: &[Vec3A]) -> Self {
        let mut boxes = Vec::new();
        for &triangle in triangles {
            boxes.push(sweep_box(points, triangle));
        }

        // One triangle per leaf, so that leaves can be updated by their number.
        let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
        let mut bvh = build_bvh2(&boxes, params, &mut Duration::default());
        bvh.reorder_in_stack_traversal_order();
        bvh.init_primitives_to_nodes_if_uninit();
        Self { bvh, triangles: triangles.to_vec() }
    }

    pub(super) fn refit(&mut self, points: &[Vec3A]) -> usize {
        for (leaf, &t) in self.triangles.iter().enumerate() {
            let node = self.bvh.primitives_to_nodes[leaf] as usize;
            self.bvh.nodes[node].set_aabb(sweep_box(points, t));
        }
        self.bvh.refit_all();
        self.triangles.len()
    }
}

fn sweep_box(points: &[Vec3A], triangle: [u32; 3]) -> obvhs::aabb::Aabb {
    let [a, b, c] = triangle.map(|i| points[i as usize]);
    obvhs::aabb::Aabb::new(a.min(b).min(c), a.max(b).max(c))
}
