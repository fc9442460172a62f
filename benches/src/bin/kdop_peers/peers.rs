//! The peers, made to do the same work: leaf boxes and a tree from vertices, refits, pairs.

use glam::DVec3;

/// A tree of parry3d in one precision, over the boxes of triangles.
macro_rules! parry {
    ($module:ident, $parry:ident, $round:path) => {
        pub(crate) mod $module {
            use glam::DVec3;
            use $parry::bounding_volume::Aabb;
            use $parry::math::Vector;
            use $parry::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};

            /// A tree and the triangles it bounds.
            pub(crate) struct Tree {
                pub(crate) bvh: Bvh,
                pub(crate) workspace: BvhWorkspace,
                triangles: Vec<[u32; 3]>,
            }

            /// Vertices in this precision; the conversion is not part of what is timed.
            pub(crate) fn vertices(points: &[DVec3]) -> Vec<Vector> {
                points.iter().map(|p| Vector::from_array(p.to_array().map($round))).collect()
            }

            fn aabb(points: &[Vector], t: [u32; 3]) -> Aabb {
                let [a, b, c] = t.map(|i| points[i as usize]);
                Aabb::new(a.min(b).min(c), a.max(b).max(c))
            }

            fn swept(x0: &[Vector], x1: &[Vector], t: [u32; 3]) -> Aabb {
                let (a, b) = (aabb(x0, t), aabb(x1, t));
                Aabb::new(a.mins.min(b.mins), a.maxs.max(b.maxs))
            }

            impl Tree {
                pub(crate) fn build(triangles: &[[u32; 3]], points: &[Vector]) -> Self {
                    let boxes: Vec<Aabb> = triangles.iter().map(|&t| aabb(points, t)).collect();
                    let bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
                    Self { bvh, workspace: BvhWorkspace::default(), triangles: triangles.to_vec() }
                }

                fn update(&mut self, boxes: impl Fn([u32; 3]) -> Aabb) {
                    for (leaf, &t) in (0..).zip(&self.triangles) {
                        self.bvh.insert_or_update_partially(boxes(t), leaf, 0.0);
                    }
                }

                /// Refits in place, as its triangle mesh does when vertices are set.
                pub(crate) fn refit_in_place(&mut self, points: &[Vector]) -> usize {
                    self.update(|t| aabb(points, t));
                    self.bvh.refit_without_opt();
                    self.triangles.len()
                }

                /// Refits with nodes put in depth-first order.
                pub(crate) fn refit(&mut self, points: &[Vector]) -> usize {
                    self.update(|t| aabb(points, t));
                    self.bvh.refit(&mut self.workspace);
                    self.triangles.len()
                }

                pub(crate) fn refit_swept(&mut self, x0: &[Vector], x1: &[Vector]) -> usize {
                    self.update(|t| swept(x0, x1, t));
                    self.bvh.refit(&mut self.workspace);
                    self.triangles.len()
                }

                pub(crate) fn pairs(&self, other: &Self, out: &mut Vec<(u32, u32)>) -> usize {
                    out.clear();
                    out.extend(self.bvh.leaf_pairs(&other.bvh, |a, b| a.intersects(b)));
                    out.len()
                }

                /// Self pairs that share no vertex.
                pub(crate) fn self_pairs(&mut self, out: &mut Vec<(u32, u32)>) -> usize {
                    out.clear();
                    let triangles = &self.triangles;
                    self.bvh.traverse_bvtt_single_tree::<false>(
                        &mut self.workspace,
                        &mut |i, j| {
                            let (a, b) = (triangles[i as usize], triangles[j as usize]);
                            if !a.iter().any(|p| b.contains(p)) {
                                out.push((i, j));
                            }
                        },
                    );
                    out.len()
                }
            }
        }
    };
}

parry!(single, parry3d, super::to_single);
parry!(double, parry3d_f64, std::convert::identity);

#[expect(clippy::cast_possible_truncation, reason = "wanted in single precision")]
const fn to_single(x: f64) -> f32 {
    x as f32
}

/// A binary tree of f32 boxes whose refit is a bare sweep over an array.
pub(crate) mod sweep {
    use super::DVec3;
    use obvhs::BvhBuildParams;
    use obvhs::aabb::Aabb;
    use obvhs::bvh2::Bvh2;
    use obvhs::bvh2::builder::build_bvh2;
    use std::time::Duration;

    /// A tree and the triangles it bounds.
    pub(crate) struct Tree {
        bvh: Bvh2,
        triangles: Vec<[u32; 3]>,
    }

    /// A vertex as the peer holds it.
    pub(crate) type Vertex = glam::Vec3A;

    /// Vertices in single precision; the conversion is not part of what is timed.
    pub(crate) fn vertices(points: &[DVec3]) -> Vec<Vertex> {
        points.iter().map(|p| p.as_vec3a()).collect()
    }

    fn aabb(points: &[Vertex], t: [u32; 3]) -> Aabb {
        let [a, b, c] = t.map(|i| points[i as usize]);
        Aabb::new(a.min(b).min(c), a.max(b).max(c))
    }

    impl Tree {
        pub(crate) fn build(triangles: &[[u32; 3]], points: &[Vertex]) -> Self {
            let boxes: Vec<Aabb> = triangles.iter().map(|&t| aabb(points, t)).collect();
            // One triangle a leaf, so that leaves can be updated by their number.
            let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
            let mut bvh = build_bvh2(&boxes, params, &mut Duration::default());
            bvh.reorder_in_stack_traversal_order();
            bvh.init_primitives_to_nodes_if_uninit();
            Self { bvh, triangles: triangles.to_vec() }
        }

        pub(crate) fn refit(&mut self, points: &[Vertex]) -> usize {
            for (leaf, &t) in self.triangles.iter().enumerate() {
                let node = self.bvh.primitives_to_nodes[leaf] as usize;
                self.bvh.nodes[node].set_aabb(aabb(points, t));
            }
            self.bvh.refit_all();
            self.triangles.len()
        }
    }
}
