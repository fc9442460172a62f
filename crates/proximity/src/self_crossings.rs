//! Crossings of a surface with itself.

use glam::DVec3;
use kdop::Workspace;
use surface::progress::{Interrupted, Progress};
use surface::{Meeting, triangles_meet};

use crate::SurfaceTree;

/// Pairs of faces, or vertices, between two polls for interruption: a millisecond.
const POLL_INTERVAL: u32 = 4096;

/// Number of faces at a vertex up to which all pairs of them are compared. Above, sorting them is faster.
const SMALL_FAN: usize = 32;

/// Cosine or sine above which a sign is certain, however its terms were rounded. Far below, it is not; far above, more
/// fans are tested face by face.
const CERTAIN: f64 = 1e-12;

impl SurfaceTree {
    /// Finds pairs of faces that cross, ascending. Faces with a common corner cross where they share more than it:
    /// an edge of one goes through the other.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when the handler of `progress` ends the call.
    pub fn self_crossings(
        &self,
        workspace: &mut Workspace,
        progress: Progress<'_>,
    ) -> Result<Vec<[u32; 2]>, Interrupted> {
        let (mut crossing, mut polls) = (Vec::new(), progress.every(POLL_INTERVAL));
        let cross = |a, b| triangles_meet(self.corners(a), self.corners(b)) == Meeting::Crossing;
        self.tree().try_self_pairs(0.0, workspace, |a, b| {
            polls.step()?;
            if cross(a, b) {
                crossing.push([a.min(b), a.max(b)]);
            }
            Ok(())
        })?;

        let mut fan = Vec::new();
        for vertex in (0..).take(self.surface().vertex_count()) {
            polls.step()?;
            self.gather_fan(vertex, &mut fan);
            if is_flat(&fan) {
                continue;
            }
            for (number, a) in fan.iter().enumerate() {
                for b in &fan[number + 1..] {
                    polls.step()?;
                    if !a.has_edge_of(b) && cross(a.face, b.face) {
                        crossing.push([a.face.min(b.face), a.face.max(b.face)]);
                    }
                }
            }
        }
        crossing.sort_unstable();
        Ok(crossing)
    }

    /// Lists the faces at a vertex.
    fn gather_fan(&self, vertex: u32, fan: &mut Vec<FanFace>) {
        let (faces, apex) = (self.surface().faces(), self.position(vertex));
        fan.clear();
        for &face in self.surface().vertex_faces(vertex) {
            let ends = match faces[face as usize] {
                [apex, from, to] if apex == vertex => [from, to],
                [to, apex, from] if apex == vertex => [from, to],
                [from, to, _] => [from, to],
            };
            let spokes = ends.map(|end| self.position(end) - apex);
            fan.push(FanFace { face, ends, spokes, normal: spokes[0].cross(spokes[1]) });
        }
    }
}

/// Face at a vertex, with the spokes from there to its other corners.
struct FanFace {
    face: u32,
    ends: [u32; 2],
    spokes: [DVec3; 2],
    normal: DVec3,
}

impl FanFace {
    /// Returns true if both have an edge at the vertex in common.
    fn has_edge_of(&self, other: &Self) -> bool {
        self.ends.iter().any(|end| other.ends.contains(end))
    }
}

/// Returns true if the faces at a vertex certainly go once around it and look the same way, so that they are flat
/// on a plane side by side: none of them crosses another.
fn is_flat(fan: &[FanFace]) -> bool {
    let axis: DVec3 = fan.iter().map(|face| face.normal).sum();
    let Some(axis) = axis.try_normalize() else { return false };

    // Faces go around as often as they pass a half-plane, in a direction that no grid has.
    let (first, second) = axis.any_orthonormal_pair();
    let aside = 0.83 * second - 0.56 * first;
    let mut passes = 0;
    for FanFace { spokes, normal, .. } in fan {
        let [from, to] = spokes;
        let least = CERTAIN * CERTAIN * from.length_squared();
        let (up, before) = (axis.dot(*normal), aside.dot(*from));
        let is_certain =
            up > 0.0 && up * up > least * to.length_squared() && before * before > least;
        if !is_certain {
            return false;
        }
        passes += u32::from(before < 0.0 && aside.dot(*to) > 0.0);
    }
    passes == 1 && is_closed(fan)
}

/// Returns true if each spoke begins one face and ends one.
fn is_closed(fan: &[FanFace]) -> bool {
    if fan.len() <= SMALL_FAN {
        let nexts = |end: u32| fan.iter().filter(|next| next.ends[0] == end).count();
        return fan.iter().all(|face| nexts(face.ends[1]) == 1);
    }
    let [mut begins, mut ends] =
        [0, 1].map(|k| -> Vec<u32> { fan.iter().map(|face| face.ends[k]).collect() });
    begins.sort_unstable();
    ends.sort_unstable();
    begins == ends && begins.windows(2).all(|pair| pair[0] != pair[1])
}
