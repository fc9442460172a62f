//! Exit directions that agree over a patch of a deep overlap.
//!
//! Inside vertices of both bodies that are joined by edges or by crossing faces are one patch. The
//! nearest ways out of a bone that tissue encloses, or of a tip of tissue in a bone, lead to all sides,
//! and some of them through the far side. A deep patch of which that holds leaves in one direction
//! instead. Tissue that embraces a bone faces it all around, and keeps its nearest ways out; where the
//! bone has come through the middle of a sheet, it goes back to the side that faces it.
//!
//! The direction of a patch is that of its vertices that have one from earlier rounds, else the one in
//! which its ways out are shortest together.

use glam::DVec3;
use kdop::Workspace;
use proximity::{NearVertex, SurfaceTree};
use surface::UnionFind;

use crate::exit_sides::ExitMemory;
use crate::seam_faces::SeamFaces;
use crate::tissue::Tissue;

/// Vertices per body whose directions are tried for a deep patch. Below, a patch may
/// leave by a longer way; above, its direction takes longer.
const PATCH_DIRECTIONS: usize = 16;

/// Vertices per body whose ways out are measured in each direction, likewise.
const PATCH_SAMPLES: usize = 48;

/// One body of a pair that overlaps.
#[derive(Clone, Copy)]
pub(crate) struct PatchSide<'a> {
    pub(crate) tissue: &'a Tissue,
    pub(crate) tree: &'a SurfaceTree,
    pub(crate) near: &'a [NearVertex],
    /// Piece of the body that is left.
    pub(crate) piece: u32,
    /// Faces of both bodies at which no way out ends.
    pub(crate) seam_faces: &'a SeamFaces,
}

/// Vertices of both bodies that leave together.
#[derive(Default)]
struct ExitPatch<'a> {
    vertices: [Vec<&'a NearVertex>; 2],
    max_depth: f64,
}

/// Sets the exit directions of all patches that need one, in the memories of both bodies. Patches
/// that have directions keep them, and give them to vertices new inside.
pub(crate) fn direct_patches(
    sides: [PatchSide<'_>; 2],
    crossing_faces: &[[u32; 2]],
    memories: &mut [ExitMemory; 2],
) {
    for patch in patches(sides, crossing_faces) {
        let is_far = patch.far_sides(sides);
        if is_far == [false; 2] {
            continue;
        }
        let known = patch.remembered(memories);
        let direction = known.unwrap_or_else(|| patch.shortest_way_out(sides));

        // Bone that comes through a sheet around it goes back by itself, if that is nearer.
        let is_soft_far = (0..2).any(|k| is_far[k] && !sides[k].tissue.is_rigid);
        if !is_soft_far && patch.ways_back(sides) < patch.way_out(sides, direction) {
            continue;
        }
        for (side, (memory, sign)) in memories.iter_mut().zip([1.0, -1.0]).enumerate() {
            memory.resize(sides[side].tissue.normals.len());
            for near in &patch.vertices[side] {
                let own = &mut memory.directions[near.vertex as usize];
                if *own == DVec3::ZERO {
                    *own = sign * direction;
                }
            }
        }
    }
}

/// Finds the patches of a pair, in the order of their first vertices.
fn patches<'a>(sides: [PatchSide<'a>; 2], crossing_faces: &[[u32; 2]]) -> Vec<ExitPatch<'a>> {
    // Vertices of the second body are numbered after those of the first.
    let counts = sides.map(|side| side.tissue.normals.len());
    let firsts = [0, u32::try_from(counts[0]).unwrap_or(u32::MAX)];
    let mut sets = joined_vertices(sides, firsts, crossing_faces);

    let mut patches: Vec<ExitPatch<'a>> = Vec::new();
    let mut numbers = vec![usize::MAX; counts[0] + counts[1]];
    for (k, (side, first)) in sides.iter().zip(firsts).enumerate() {
        for near in side.near {
            if near.gap >= 0.0 {
                continue;
            }
            let number = &mut numbers[sets.find(first + near.vertex) as usize];
            if *number == usize::MAX {
                *number = patches.len();
                patches.push(ExitPatch::default());
            }
            let patch = &mut patches[*number];
            patch.vertices[k].push(near);
            patch.max_depth = patch.max_depth.max(-near.gap);
        }
    }
    patches
}

/// Joins inside vertices along edges, and where faces cross. Those of each body are numbered from its
/// first number on.
fn joined_vertices(
    sides: [PatchSide<'_>; 2],
    firsts: [u32; 2],
    crossing_faces: &[[u32; 2]],
) -> UnionFind {
    let mut inside = sides.map(|side| vec![false; side.tissue.normals.len()]);
    let mut sets = UnionFind::new(inside[0].len() + inside[1].len());
    for (k, side) in sides.iter().enumerate() {
        for near in side.near {
            inside[k][near.vertex as usize] = near.gap < 0.0;
        }
        for near in side.near {
            for link in side.tissue.links(near.vertex) {
                if near.gap < 0.0 && inside[k][link.neighbor as usize] {
                    sets.join(firsts[k] + near.vertex, firsts[k] + link.neighbor);
                }
            }
        }
    }

    for faces in crossing_faces {
        let mut joined = None;
        for (k, &face) in faces.iter().enumerate() {
            for corner in sides[k].tissue.corners(face) {
                if inside[k][corner as usize] {
                    let number = firsts[k] + corner;
                    sets.join(number, *joined.get_or_insert(number));
                }
            }
        }
    }
    sets
}

impl PatchSide<'_> {
    /// Returns true if the nearest way out of a vertex points as its own surface does.
    fn is_outward(&self, near: &NearVertex) -> bool {
        self.tissue.agrees(self.tissue.normals[near.vertex as usize], near.normal)
    }
}

impl ExitPatch<'_> {
    /// Returns for each body whether nearest ways out lead through the far side of the other on more
    /// than a small share of its area: there they point as the own surface does.
    fn far_sides(&self, sides: [PatchSide<'_>; 2]) -> [bool; 2] {
        let mut is_far = [false; 2];
        for ((vertices, side), is_far) in self.vertices.iter().zip(sides).zip(&mut is_far) {
            let (mut far, mut all) = (0.0, 0.0);
            for near in vertices {
                let area = side.tissue.area(near.vertex);
                all += area;
                far += if side.is_outward(near) { area } else { 0.0 };
            }
            *is_far = far > sides[0].tissue.params.tuning.far_share * all;
        }
        is_far
    }

    /// Returns the mean of the directions that vertices remember, as that of the first body; `None`
    /// where none does.
    fn remembered(&self, memories: &[ExitMemory; 2]) -> Option<DVec3> {
        let mut sum = DVec3::ZERO;
        for ((vertices, memory), sign) in self.vertices.iter().zip(memories).zip([1.0, -1.0]) {
            for near in vertices {
                sum += sign * memory.direction(near.vertex);
            }
        }
        sum.try_normalize()
    }

    /// Finds the direction in which the first body leaves the second one on the shortest ways.
    fn shortest_way_out(&self, sides: [PatchSide<'_>; 2]) -> DVec3 {
        // Directions that some vertex would take, or that its own surface faces.
        let mut candidates = Vec::new();
        for ((vertices, side), sign) in self.vertices.iter().zip(sides).zip([1.0, -1.0]) {
            for near in sample(vertices, PATCH_DIRECTIONS) {
                candidates.push(sign * near.normal);
                candidates.push(-sign * side.tissue.normals[near.vertex as usize]);
            }
        }

        let mut shortest = (f64::INFINITY, DVec3::ZERO);
        for direction in candidates {
            let way = self.way_out(sides, direction);
            if way < shortest.0 {
                shortest = (way, direction);
            }
        }
        shortest.1
    }

    /// Computes the mean square of the ways out in a direction of the first body, summed over both.
    fn way_out(&self, sides: [PatchSide<'_>; 2], direction: DVec3) -> f64 {
        let directions = [direction, -direction];
        self.mean_square(sides, |k, _| Some(directions[k]))
    }

    /// Computes the mean square of the nearest ways out, or into the own body where they lead through
    /// the far side, summed over both bodies.
    fn ways_back(&self, sides: [PatchSide<'_>; 2]) -> f64 {
        self.mean_square(sides, |k, near| {
            let inward = -sides[k].tissue.normals[near.vertex as usize];
            sides[k].is_outward(near).then_some(inward)
        })
    }

    /// Computes the mean square of ways out in the directions of vertices, or of the nearest ones,
    /// summed over both bodies.
    fn mean_square(
        &self,
        sides: [PatchSide<'_>; 2],
        direction: impl Fn(usize, &NearVertex) -> Option<DVec3>,
    ) -> f64 {
        let workspace = &mut Workspace::default();
        let reach = sides[0].tissue.params.max_displacement * self.max_depth;
        let mut mean = 0.0;
        for (k, other) in [(0, sides[1]), (1, sides[0])] {
            let PatchSide { tissue, seam_faces, .. } = sides[k];
            let closed = |face| {
                seam_faces.closes(other.tissue.id, face, tissue.id)
                    || other.tissue.piece_of_face(face) != other.piece
            };
            let (mut sum, mut area) = (0.0, 0.0);
            for near in sample(&self.vertices[k], PATCH_SAMPLES) {
                let from = sides[k].tree.position(near.vertex);
                let way = match direction(k, near) {
                    Some(direction) => {
                        let tissue = other.tissue;
                        let exit =
                            tissue.find_exit(other.tree, from, closed, direction, reach, workspace);
                        exit.map_or(reach, |exit| exit.length())
                    }
                    None => -near.gap,
                };
                let weight = tissue.area(near.vertex);
                sum += weight * way * way;
                area += weight;
            }
            if area > 0.0 {
                mean += sum / area;
            }
        }
        mean
    }
}

/// Returns up to `count` vertices, evenly among all.
fn sample<'v, 'a>(
    vertices: &'v [&'a NearVertex],
    count: usize,
) -> impl Iterator<Item = &'v &'a NearVertex> {
    vertices.iter().step_by(vertices.len().div_ceil(count).max(1))
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::{BodyKind, PairId, Scene};

    use super::*;

    use crate::run::Run;
    use crate::tissue::fitted_tree;
    use crate::{Conditions, ResolveParams, Tie};

    /// A post is .9 deep in a soft cube, and .3 at most from a face behind which another one is tied.
    #[test]
    fn no_way_out_leads_through_a_face_at_a_seam() {
        let mut scene = Scene::new();
        let mut ids = Vec::new();
        let post = shapes::plate(DVec3::new(0.2, 0.2, 2.0), [1, 1]);
        for (name, kind, mesh, place) in [
            ("left", BodyKind::Deformable, shapes::cube(2.0), DVec3::new(-1.0, 0.0, 0.0)),
            ("right", BodyKind::Deformable, shapes::cube(2.0), DVec3::new(1.0, 0.0, 0.0)),
            ("post", BodyKind::Rigid, post, DVec3::new(-0.2, 0.0, 1.1)),
        ] {
            let mesh = mesh.translated(place);
            ids.push(scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body"));
        }
        for (is_tied, bounds) in [(false, 0.01..0.1), (true, 1.0..f64::INFINITY)] {
            let ties = vec![Tie { bodies: [ids[0], ids[1]], distance: f64::MIN_POSITIVE }];
            let ties = if is_tied { ties } else { Vec::new() };
            let conditions = Conditions { ties, ..Conditions::default() };
            let params = ResolveParams::with_smoothing(6.0);
            let run = Run::start(&mut scene, params, &conditions);
            let mut run = run.expect("a run");
            run.start_round();
            let pair = PairId::new(ids[0], ids[2]);
            let near = run.near.iter().find(|near| near.report.pair == pair).expect("a pair");
            let sides = near.sides().map(|(own, report)| PatchSide {
                tissue: &run.tissues[own.index()],
                tree: fitted_tree(run.scene.body(own)),
                near: &report.near,
                piece: 0,
                seam_faces: &run.near.seam_faces,
            });
            let patches = patches(sides, &[]);
            let patch = patches.iter().find(|patch| patch.vertices[1].len() == 4);
            let way = patch.expect("the lower end of the post").way_out(sides, -DVec3::X);
            assert!(bounds.contains(&way), "{is_tied}: {way}");
        }
    }
}
