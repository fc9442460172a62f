//! Bounding volumes of several kinds in one hierarchy: halves of the faces by their places, down to
//! single ones.

use std::fmt::Write;

use fixtures::muscle::{Muscle, Placement, scene};
use glam::DVec3;
use kdop::Dop;
use parry3d::bounding_volume::{
    BoundingSphere, BoundingVolume, details::point_cloud_bounding_sphere,
};
use parry3d::math::{Pose, Vector};
use parry3d::query::details::intersection_test_cuboid_cuboid;
use parry3d::shape::Cuboid;
use parry3d::utils::obb;
use surface::Aabb;

use crate::measure::interleave;

/// Faces of each muscle, and budget of each measurement \[ms\].
const FACES: u32 = 6500;
const BUDGET: u64 = 200;

/// A volume around points.
trait Volume {
    fn around(points: &[DVec3]) -> Self;
    fn meets(&self, other: &Self) -> bool;
}

/// Volume of a part of the faces, and of its halves; a face alone has none.
struct Node<V> {
    volume: V,
    halves: Option<Box<[Self; 2]>>,
}

/// Box with axes of its own.
struct OrientedBox {
    pose: Pose,
    cuboid: Cuboid,
}

/// Pairs that a traversal tests, and pairs of faces that it leaves.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    tests: usize,
    left: usize,
}

/// Writes a row per kind of volume, for two muscles in contact at an angle.
pub(super) fn rows(text: &mut String) {
    let scene = scene(FACES, Placement::Oblique);
    let muscles = [&scene.a, &scene.b];
    row::<BoundingSphere>(text, "sphere", 4, muscles);
    row::<Dop<3>>(text, "box along the axes", 6, muscles);
    row::<OrientedBox>(text, "oriented box", 15, muscles);
    row::<Dop<7>>(text, "14 planes", 14, muscles);
    row::<Dop<9>>(text, "18 planes", 18, muscles);
    row::<Dop<13>>(text, "26 planes", 26, muscles);
}

fn row<V: Volume>(text: &mut String, name: &str, numbers: u32, muscles: [&Muscle; 2]) {
    let faces = muscles.map(|muscle| {
        let corners = |face: &[u32; 3]| face.map(|corner| muscle.states[1][corner as usize]);
        muscle.triangles.iter().map(corners).collect::<Vec<_>>()
    });
    let [a, b] = faces.clone().map(|mut faces| Node::<V>::new(&mut faces));
    let counts = || {
        let mut counts = Counts::default();
        a.pairs(&b, &mut counts);
        counts
    };
    let [mut again, _] = faces;
    let [time, fitted] = interleave(
        BUDGET,
        [
            ("pairs", &mut || counts().left),
            ("fitted", &mut || usize::from(Node::<V>::new(&mut again).halves.is_some())),
        ],
    );
    let Counts { tests, left } = counts();
    let (time, fitted) = (1e-3 * time, 1e-6 * fitted);
    let _ = writeln!(text, "| {name} | {numbers} | {tests} | {left} | {time:.0} | {fitted:.1} |");
}

impl<V: Volume> Node<V> {
    /// Fits volumes to faces and to their halves, which change places.
    fn new(faces: &mut [[DVec3; 3]]) -> Self {
        let points = faces.as_flattened();
        let (volume, extent) = (V::around(points), Aabb::of_points(points.iter().copied()));
        if faces.len() < 2 {
            return Self { volume, halves: None };
        }

        // Along the longest side, at the middle face.
        let size = (extent.max - extent.min).to_array();
        let longest =
            if size[0] >= size[1].max(size[2]) { 0 } else { 1 + usize::from(size[2] > size[1]) };
        let place = |face: &[DVec3; 3]| face.iter().map(|corner| corner[longest]).sum::<f64>();
        let middle = faces.len() / 2;
        faces.select_nth_unstable_by(middle, |p, q| place(p).total_cmp(&place(q)));
        let (lower, upper) = faces.split_at_mut(middle);
        Self { volume, halves: Some(Box::new([Self::new(lower), Self::new(upper)])) }
    }

    /// Descends both sides where their volumes meet.
    fn pairs(&self, other: &Self, counts: &mut Counts) {
        counts.tests += 1;
        if !self.volume.meets(&other.volume) {
            return;
        }
        match (&self.halves, &other.halves) {
            (None, None) => counts.left += 1,
            (Some(own), None) => own.iter().for_each(|half| half.pairs(other, counts)),
            (None, Some(others)) => others.iter().for_each(|half| self.pairs(half, counts)),
            (Some(own), Some(others)) => {
                for half in own.iter() {
                    others.iter().for_each(|other| half.pairs(other, counts));
                }
            }
        }
    }
}

impl<const S: usize> Volume for Dop<S> {
    fn around(points: &[DVec3]) -> Self {
        Self::from_points(points)
    }

    fn meets(&self, other: &Self) -> bool {
        self.overlaps(other)
    }
}

impl Volume for BoundingSphere {
    fn around(points: &[DVec3]) -> Self {
        point_cloud_bounding_sphere(&single(points))
    }

    fn meets(&self, other: &Self) -> bool {
        self.intersects(other)
    }
}

impl Volume for OrientedBox {
    fn around(points: &[DVec3]) -> Self {
        let (pose, cuboid) = obb(&single(points));
        Self { pose, cuboid }
    }

    fn meets(&self, other: &Self) -> bool {
        let between = self.pose.inv_mul(&other.pose);
        intersection_test_cuboid_cuboid(&between, &self.cuboid, &other.cuboid)
    }
}

/// Rounds points to the precision of `parry3d`.
fn single(points: &[DVec3]) -> Vec<Vector> {
    points.iter().map(|p| Vector::from_array(p.as_vec3().to_array())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No volume loses a pair of faces that touch, and tighter ones leave fewer.
    #[test]
    fn tighter_volumes_leave_fewer_pairs() {
        let scene = scene(500, Placement::Oblique);
        let faces = |muscle: &Muscle| -> Vec<[DVec3; 3]> {
            let corners = |face: &[u32; 3]| face.map(|corner| muscle.states[1][corner as usize]);
            muscle.triangles.iter().map(corners).collect()
        };
        fn left<V: Volume>(a: &[[DVec3; 3]], b: &[[DVec3; 3]]) -> usize {
            let mut counts = Counts::default();
            Node::<V>::new(&mut a.to_vec()).pairs(&Node::new(&mut b.to_vec()), &mut counts);
            counts.left
        }
        let (a, b) = (faces(&scene.a), faces(&scene.b));
        let planes = [left::<Dop<3>>(&a, &b), left::<Dop<9>>(&a, &b), left::<Dop<13>>(&a, &b)];
        assert!(planes[0] > planes[1] && planes[1] >= planes[2] && planes[2] > 0, "{planes:?}");
        assert!(left::<BoundingSphere>(&a, &b) > left::<OrientedBox>(&a, &b));
    }
}
