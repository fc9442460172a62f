//! Measures of regions from their sums.

use glam::DVec3;

use crate::measures::Sums;

/// Measures of the intersection of two bodies A and B, or of one separate contact region of it.
///
/// Volume and centroid need an inside of both bodies, the area of one inside the other an inside
/// of that other; what lacks it is `None`, and [`Overlap::no_inside`](crate::Overlap::no_inside) has the reason.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OverlapMeasures {
    /// Volume of the intersection.
    pub volume: Option<f64>,
    /// Center of mass of the intersection; `None` without volume.
    pub centroid: Option<DVec3>,
    /// Area of A's surface strictly inside B: coinciding faces are left out.
    pub area_of_a_inside_b: Option<f64>,
    /// Area of B's surface strictly inside A.
    pub area_of_b_inside_a: Option<f64>,
    /// Area in which faces of opposite normals coincide: the bodies touch from outside.
    pub touching_area: f64,
    /// Area in which faces of equal normals coincide.
    pub flush_area: f64,
    /// Length of the curve in which the surfaces cross.
    pub curve_length: f64,
    /// Closed loops of that curve.
    pub curve_loops: usize,
    /// Open arcs of that curve, which end at the border of an open surface.
    pub curve_arcs: usize,
    /// Area-weighted mean normal of A's surface inside B, of unit length; zero where the normals
    /// cancel.
    pub normal: DVec3,
    /// Vertices of A inside B, and of B inside A. Both are 0 where the surfaces cross by edges
    /// alone.
    pub inside_vertices: [usize; 2],
}

/// Sums of a region, or of all, with the first moment about the scene's origin.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Located {
    /// Number among the regions as they were found.
    pub(crate) number: usize,
    pub(crate) sums: Sums,
    first_moment: DVec3,
}

impl Located {
    /// Moves the moment of a region from its origin to the scene's.
    pub(crate) fn new(number: usize, sums: Sums, origin: DVec3) -> Self {
        Self { number, sums, first_moment: sums.moment + sums.volume * origin }
    }

    /// Returns two regions together, under the number of the first.
    pub(crate) fn with(&self, other: &Self) -> Self {
        Self {
            number: self.number,
            sums: self.sums.with(&other.sums),
            first_moment: self.first_moment + other.first_moment,
        }
    }

    /// Returns the measures, each where the bodies with an inside define it.
    pub(crate) fn measures(&self, has_inside: [bool; 2]) -> OverlapMeasures {
        let Sums { areas, normal, volume, length, loops, arcs, touching, flush, vertices, .. } =
            self.sums;
        let both = has_inside == [true; 2];
        OverlapMeasures {
            volume: both.then_some(volume),
            centroid: (both && volume > 0.0).then(|| self.first_moment / volume),
            area_of_a_inside_b: has_inside[1].then_some(areas[0]),
            area_of_b_inside_a: has_inside[0].then_some(areas[1]),
            touching_area: touching,
            flush_area: flush,
            curve_length: length,
            curve_loops: loops,
            curve_arcs: arcs,
            normal: normal.normalize_or_zero(),
            inside_vertices: vertices,
        }
    }
}
