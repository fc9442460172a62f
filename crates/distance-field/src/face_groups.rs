//! Faces in groups that follow each other, each with its box: what is far from most of a surface
//! compares few of its faces.

use glam::DVec3;
use surface::{Aabb, Positions, TriangleSurface, closest_on_triangle, parallel};

/// Faces per group, and groups per larger one: fewer have tighter boxes, and more of them to compare.
const GROUP: usize = 16;

/// Faces of a surface in groups.
pub(crate) struct FaceGroups<'a> {
    pub(crate) surface: &'a TriangleSurface,
    pub(crate) x: Positions<'a>,
    /// Boxes of the groups.
    bounds: Vec<Aabb>,
    /// Boxes of [`GROUP`] groups each.
    larger: Vec<Aabb>,
}

impl<'a> FaceGroups<'a> {
    pub(crate) fn new(surface: &'a TriangleSurface, x: Positions<'a>) -> Self {
        let groups: Vec<&[[u32; 3]]> = surface.faces().chunks(GROUP).collect();
        let bounds = parallel::map(groups.len(), |group| {
            Aabb::of_points(groups[group].as_flattened().iter().map(|&corner| x.at(corner)))
        });
        let around = |boxes: &[Aabb]| boxes[1..].iter().fold(boxes[0], |all, it| all.union(*it));
        let larger = bounds.chunks(GROUP).map(around).collect();
        Self { surface, x, bounds, larger }
    }

    /// Returns the number of groups.
    pub(crate) fn count(&self) -> usize {
        self.bounds.len()
    }

    /// Returns the box of a group.
    pub(crate) fn bounds(&self, group: usize) -> Aabb {
        self.bounds[group]
    }

    /// Returns the faces of a group, each with its box.
    pub(crate) fn faces(&self, group: usize) -> impl Iterator<Item = (usize, Aabb)> {
        let first = group * GROUP;
        let faces = self.surface.faces()[first..].iter().take(GROUP);
        (first..)
            .zip(faces)
            .map(|(face, corners)| (face, Aabb::of_points(self.x.corners(*corners))))
    }

    /// Computes the distance of a point from the nearest face, at most `bound`.
    pub(crate) fn distance(&self, point: DVec3, bound: f64) -> f64 {
        // Boxes of most groups are farther than the bound, and cost one comparison.
        let mut nearest = bound;
        let is_far = |bounds: &Aabb, nearest: f64| {
            let beside = point - point.clamp(bounds.min, bounds.max);
            beside.length_squared() > nearest * nearest
        };
        let groups = self.bounds.chunks(GROUP).zip(self.surface.faces().chunks(GROUP * GROUP));
        for (larger, (bounds, faces)) in self.larger.iter().zip(groups) {
            if is_far(larger, nearest) {
                continue;
            }
            for (bounds, faces) in bounds.iter().zip(faces.chunks(GROUP)) {
                if is_far(bounds, nearest) {
                    continue;
                }
                for &face in faces {
                    let foot = closest_on_triangle(point, self.x.corners(face)).point;
                    nearest = nearest.min(foot.distance(point));
                }
            }
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::quasirandom;

    /// Reference implementation: all faces, one by one.
    #[test]
    fn groups_skip_no_nearest_face() {
        let mesh = fixtures::shapes::ellipsoid(DVec3::new(9.0, 4.0, 2.0), 3);
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).expect("finite positions");
        let groups = FaceGroups::new(&surface, x);
        for n in 0..500 {
            let point = (quasirandom(n) - 0.5) * 24.0;
            let foot = |&face| closest_on_triangle(point, x.corners(face)).point;
            let feet = surface.faces().iter().map(foot);
            let expected = feet.map(|foot| foot.distance(point)).fold(f64::INFINITY, f64::min);
            let found = [groups.distance(point, f64::INFINITY), groups.distance(point, expected)];
            assert!(
                found.iter().all(|found| (found - expected).abs() < 1e-12),
                "{found:?} {point}"
            );
            assert!(groups.distance(point, 0.5 * expected) <= 0.5 * expected, "{point}");
        }
    }
}
