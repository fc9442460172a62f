//! Boxes and centers of the faces of a surface, each computed once.

use glam::DVec3;
use surface::Aabb;

use crate::SurfaceTree;

/// Boxes and centers of the faces of one surface, computed when they are first needed, in memory
/// that is reused.
///
/// A query that compares many points with the same few faces rejects most of them by these.
#[derive(Debug, Default)]
pub struct FaceBoxes {
    /// One per face: 1 + its place in `list`, or 0.
    places: Vec<u32>,
    list: Vec<FaceBox>,
    /// Faces of `list`.
    faces: Vec<u32>,
}

/// Box and center of a face.
#[derive(Clone, Copy, Debug)]
pub struct FaceBox {
    /// The box around its corners.
    pub bounds: Aabb,
    /// The mean of its corners.
    pub center: DVec3,
}

impl FaceBoxes {
    /// Forgets all boxes, for another surface or another state of it.
    pub fn reset(&mut self, surface: &SurfaceTree) {
        for face in self.faces.drain(..) {
            self.places[face as usize] = 0;
        }
        self.list.clear();
        let count = surface.surface().faces().len();
        if self.places.len() < count {
            self.places.resize(count, 0);
        }
    }

    /// Returns the box of a face of the surface that the boxes were last reset for.
    ///
    /// # Panics
    ///
    /// When `face` is not below its face count.
    #[inline]
    #[must_use]
    pub fn get(&mut self, surface: &SurfaceTree, face: u32) -> &FaceBox {
        if self.places[face as usize] == 0 {
            self.compute(surface, face);
        }
        &self.list[self.places[face as usize] as usize - 1]
    }

    #[inline(never)]
    fn compute(&mut self, surface: &SurfaceTree, face: u32) {
        let [a, b, c] = surface.corners(face);
        let bounds = Aabb { min: a.min(b).min(c), max: a.max(b).max(c) };
        self.list.push(FaceBox { bounds, center: (a + b + c) / 3.0 });
        self.faces.push(face);
        // There are no more boxes than faces, which are numbered in 32 bits.
        self.places[face as usize] = u32::try_from(self.list.len()).unwrap_or(u32::MAX);
    }
}

impl FaceBox {
    /// Computes the squared distance of a point from the box.
    #[inline]
    #[must_use]
    pub fn distance_squared(&self, point: DVec3) -> f64 {
        let Aabb { min, max } = self.bounds;
        (min - point).max(point - max).max(DVec3::ZERO).length_squared()
    }

    /// Returns the squared distance from a point up to which a box may have a face within
    /// `distance` of it, rounding included.
    #[inline]
    #[must_use]
    pub fn squared_reach(point: DVec3, distance: f64) -> f64 {
        /// Bound on the rounding of a computed distance, relative to the largest length.
        const ROUNDING: f64 = 1e-12;

        let size = distance + point.abs().max_element();
        let reach = distance + ROUNDING * size;
        reach * reach
    }
}
