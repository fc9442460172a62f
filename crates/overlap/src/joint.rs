//! Joint contact: area, place, gap and pressure of one surface in contact with another.
//!
//! A point of A is in contact where its signed distance to B, its gap, is at most a margin: a joint
//! whose cartilage was segmented apart has contact at gaps above 0, one whose layers overlap below.
//! Faces are split into cells no larger than the resolution, and each cell is weighted by its area.
//!
//! The gap changes by no more than the way along the surface, so that a cell of radius r about a
//! center with gap g lies in contact as a whole if `g + r` is within the margin, and not at all if
//! `g − r` is beyond it. The contact area has proved bounds for that reason; means and pressures are
//! sums over cell centers, of second order in the resolution.
//!
//! Source: the measures are those of C. R. Smith et al., "Efficient Computation of Cartilage Contact
//! Pressures within Dynamic Simulations of Movement", Computer Methods in Biomechanics and Biomedical
//! Engineering: Imaging & Visualization 6(5), 2018. Differs in the gap, which is the distance to the
//! closest point there instead of along the normal of a face, and in splitting faces at the border of
//! contact.

use std::ops::Range;

use glam::DVec3;
use kdop::Workspace;
use proximity::{
    ClosestPoint, FaceBox, FaceBoxes, NearFaces, PairError, SurfaceTree, list_near_faces,
};
use surface::progress::{Interrupted, Polls, Progress};
use surface::triangle::{quarters, radius_about_center};
use surface::{Pseudonormals, triangle};

use crate::contact_sums::{CellValues, ContactSums, JointContact, collect};
use crate::error::JointContactError;
use crate::foundation::ElasticFoundation;
use crate::patches::Clipper;

/// Parameters of the contact of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointContactParams {
    /// Largest gap in contact, `>= 0`, in the length unit.
    pub margin: f64,
    /// Largest distance of a cell's corners from its center, `> 0`. Half of it makes four times as
    /// many cells, a quarter of the error of means, and half of the bracket of the area.
    pub resolution: f64,
    /// Layer that presses back where surfaces overlap; without it pressures are 0.
    pub foundation: Option<ElasticFoundation>,
}

impl JointContactParams {
    /// Checks that the parameters are in their ranges.
    ///
    /// # Errors
    ///
    /// [`JointContactError`], with the value that is out of range.
    pub fn validate(&self) -> Result<(), JointContactError> {
        let Self { margin, resolution, foundation } = *self;
        if !(margin.is_finite() && margin >= 0.0) {
            return Err(JointContactError::Margin { margin });
        }
        if !(resolution.is_finite() && resolution > 0.0) {
            return Err(JointContactError::Resolution { resolution });
        }
        foundation.map_or(Ok(()), |layer| layer.validate())
    }
}

/// Faces of A and of B that may be in contact, each with the faces of the other surface within the
/// margin.
#[derive(Debug, Default)]
pub(crate) struct JointFaces {
    pairs: Vec<[u32; 2]>,
    near: [NearFaces; 2],
}

impl JointFaces {
    /// Finds the faces within a margin of each other, in place of earlier ones.
    pub(crate) fn find(
        &mut self,
        bodies: [&SurfaceTree; 2],
        margin: f64,
        traversal: &mut Workspace,
        progress: Progress<'_>,
    ) -> Result<(), PairError> {
        let Self { pairs, near: [near_a, near_b] } = self;
        list_near_faces(bodies, margin, traversal, pairs, progress)?;

        let [count_a, count_b] = bodies.map(|body| body.surface().faces().len());

        // To sort millions of pairs takes a tenth of a second.
        progress.report(0.0)?;
        near_a.refill(count_a, pairs.iter().map(|&[face_a, face_b]| (face_a, face_b)));
        progress.report(0.0)?;
        near_b.refill(count_b, pairs.iter().map(|&[face_a, face_b]| (face_b, face_a)));
        Ok(())
    }
}

/// Computes the contact of a clipper's body with another.
pub(crate) fn joint_contact(
    clipper: &Clipper<'_>,
    other: &SurfaceTree,
    near: &JointFaces,
    params: &JointContactParams,
    traversal: &mut Workspace,
    progress: Progress<'_>,
) -> Result<JointContact, JointContactError> {
    let body = clipper.body;
    progress.report(0.0)?;
    let candidates = candidates(clipper, &near.near[clipper.side]);
    progress.report(0.0)?;
    check_cell_count(body, &candidates, params)?;

    let mut integral = Integral::new(body, other, params, traversal, progress);
    let mut faces: Vec<(u32, ContactSums)> = Vec::new();
    for candidate in &candidates {
        let sums = integral.over_face(candidate)?;
        if sums.area_upper > 0.0 {
            faces.push((candidate.face, sums));
        }
    }
    Ok(collect(body, &faces))
}

/// A face that may be in contact.
struct Candidate<'a> {
    face: u32,
    /// The faces of the other surface within the margin, in no order.
    near: &'a [u32],
    side: FaceSide,
}

/// Place of a face relative to the other body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FaceSide {
    /// No point of it is inside, or there is no inside.
    Outside,
    /// All points of it are inside.
    Inside,
    /// Parts of it may be inside.
    Unknown,
    /// Parts of it may be inside a body that covers a place more than once.
    Covered,
}

impl FaceSide {
    /// Classifies a face by the crossing curve and by the inside vertices.
    fn of(clipper: &Clipper<'_>, face: u32) -> Self {
        let Clipper { side, body, curve, inside, .. } = *clipper;
        if !inside.is_defined {
            return Self::Outside;
        }
        if inside.covers_twice {
            return Self::Covered;
        }
        if curve.cut_faces[side].binary_search(&face).is_ok() {
            return Self::Unknown;
        }

        // What the curve does not cut is on the side of its corners.
        let corners = body.surface().faces()[face as usize];
        match corners.map(|corner| inside.place(corner).is_some()) {
            [false, false, false] => Self::Outside,
            [true, true, true] => Self::Inside,
            _ => Self::Unknown,
        }
    }
}

/// Returns the faces within the margin of the other surface, and those inside it, ascending.
fn candidates<'a>(clipper: &Clipper<'_>, near: &'a NearFaces) -> Vec<Candidate<'a>> {
    let mut candidates = Vec::new();
    for (face, near) in near.iter() {
        candidates.push(Candidate { face, near, side: FaceSide::of(clipper, face) });
    }
    // Deep faces are within the margin of no other face.
    let mut whole_faces = Vec::new();
    clipper.collect_whole_faces(&mut whole_faces);
    for face in whole_faces {
        candidates.push(Candidate { face, near: &[], side: FaceSide::of(clipper, face) });
    }

    // Of a face that is listed twice, the first has its near faces.
    candidates.sort_by_key(|candidate| candidate.face);
    candidates.dedup_by_key(|candidate| candidate.face);
    candidates
}

/// Checks that the cells are few enough. A split halves the radius and makes four of one.
fn check_cell_count(
    body: &SurfaceTree,
    candidates: &[Candidate<'_>],
    params: &JointContactParams,
) -> Result<(), JointContactError> {
    /// Cells whose closest points take some minutes.
    const MAX_CELLS: f64 = 1e8;

    // Slivers are split as often as their length asks for.
    let mut cells = 0.0;
    for candidate in candidates {
        let splits = radius_about_center(body.corners(candidate.face)).1 / params.resolution;
        cells += 4.0 * splits.max(1.0).powi(2);
    }
    if cells > MAX_CELLS {
        let resolution = params.resolution;
        return Err(JointContactError::TooFine { resolution, cells, limit: MAX_CELLS });
    }
    Ok(())
}

/// Part of a face.
struct Cell {
    corners: [DVec3; 3],
    /// Faces of the other surface that are nearest to points of it, among those on the stack.
    near: Range<usize>,
    /// A face that is likely near.
    hint: u32,
}

/// A face of the other surface, and its box.
#[derive(Clone, Copy)]
struct NearFace {
    face: u32,
    bounds: FaceBox,
}

/// Sums over cells, face by face.
///
/// The face nearest to a point of a cell is no farther from its center than the nearest face of the
/// center and twice the radius: each split keeps these faces alone. Of a face outside the other body,
/// only points within the margin count, and what is nearest to these is within the margin of the
/// face: the list of such faces takes the place of the tree.
struct Integral<'a> {
    body: &'a SurfaceTree,
    other: &'a SurfaceTree,
    params: &'a JointContactParams,
    traversal: &'a mut Workspace,
    boxes: FaceBoxes,
    cells: Vec<Cell>,
    /// Faces near the cells on the stack: those of a cell end where those of its parts begin.
    near: Vec<NearFace>,
    /// Squared distances of the boxes of a cell's near faces from its center.
    distances: Vec<f64>,
    /// Polls among the cells.
    polls: Polls<'a>,
}

impl<'a> Integral<'a> {
    fn new(
        body: &'a SurfaceTree,
        other: &'a SurfaceTree,
        params: &'a JointContactParams,
        traversal: &'a mut Workspace,
        progress: Progress<'a>,
    ) -> Self {
        /// Cells between two polls for interruption: some milliseconds at most.
        const POLLED_CELLS: u32 = 64;

        let mut boxes = FaceBoxes::default();
        boxes.reset(other);
        let (cells, near, distances) = (Vec::new(), Vec::new(), Vec::new());
        let polls = progress.every(POLLED_CELLS);
        Self { body, other, params, traversal, boxes, cells, near, distances, polls }
    }

    /// Sums up the cells of one face.
    fn over_face(&mut self, candidate: &Candidate<'_>) -> Result<ContactSums, Interrupted> {
        let JointContactParams { margin, resolution, .. } = *self.params;
        let face = self.body.corners(candidate.face);
        let normal = outward(self.body, triangle::unit_normal(face));
        let mut sums = ContactSums::default();

        let Some(hint) = self.collect_near(face, candidate) else { return Ok(sums) };
        self.cells.push(Cell { corners: face, near: 0..self.near.len(), hint });
        while let Some(Cell { corners, near, hint }) = self.cells.pop() {
            self.near.truncate(near.end);
            self.polls.step()?;
            let (center, radius) = radius_about_center(corners);
            let nearest = self.nearest(center, near.clone(), hint);
            let gap = self.signed_distance(center, &nearest, candidate.side);
            if gap - radius > margin {
                continue;
            }
            if radius > resolution {
                let near = self.keep_near(near, center, nearest.distance + 2.0 * radius);
                for corners in quarters(corners) {
                    self.cells.push(Cell { corners, near: near.clone(), hint: nearest.face });
                }
                continue;
            }

            // The gap of the center stands for the cell; the radius bounds how wrong that is.
            let area = triangle::area(corners);
            sums.area_upper += area;
            if gap + radius <= margin {
                sums.area_lower += area;
            }
            if gap <= margin {
                let pressure = self.params.foundation.map_or(0.0, |layer| layer.pressure(-gap));
                sums.add(&CellValues { area, center, gap, pressure, normal });
            }
        }
        Ok(sums)
    }

    /// Collects the faces that are nearest to points of a face, as far as they count. Returns one of
    /// them, if there is one.
    fn collect_near(&mut self, corners: [DVec3; 3], candidate: &Candidate<'_>) -> Option<u32> {
        self.near.clear();
        let Self { other, traversal, boxes, near, .. } = self;
        let mut add = |face: u32| near.push(NearFace { face, bounds: *boxes.get(other, face) });
        if candidate.side == FaceSide::Outside {
            candidate.near.iter().copied().for_each(add);
            return candidate.near.first().copied();
        }

        // Points inside have nearest faces however far.
        let (center, radius) = radius_about_center(corners);
        let hint = Some(candidate.near.first().copied().unwrap_or(0));
        let found = other.closest_point(center, f64::INFINITY, hint, traversal)?;
        if radius <= self.params.resolution {
            add(found.face);
        } else {
            let limit = found.distance + 2.0 * radius;
            other.tree().nearest(center, limit, traversal, |face, _| {
                add(face);
                limit
            });
        }
        Some(found.face)
    }

    /// Finds the nearest face in a part of the list, and leaves the distances of all boxes.
    fn nearest(&mut self, point: DVec3, near: Range<usize>, hint: u32) -> ClosestPoint {
        let Self { other, near: list, distances, .. } = self;
        let mut nearest = other.closest_on_face(point, hint);
        let mut reach = FaceBox::squared_reach(point, nearest.distance);

        distances.clear();
        for NearFace { face, bounds } in &list[near] {
            let distance = bounds.distance_squared(point);
            distances.push(distance);
            if distance <= reach && *face != hint {
                let found = other.closest_on_face(point, *face);
                if found.is_before(&nearest) {
                    nearest = found;
                    reach = FaceBox::squared_reach(point, nearest.distance);
                }
            }
        }
        nearest
    }

    /// Appends the faces of a part of the list whose boxes are within a distance of the point that the
    /// nearest was found for.
    fn keep_near(&mut self, near: Range<usize>, point: DVec3, within: f64) -> Range<usize> {
        let first = self.near.len();
        let reach = FaceBox::squared_reach(point, within);
        for (place, &distance) in near.zip(&self.distances) {
            if distance <= reach {
                self.near.push(self.near[place]);
            }
        }
        first..self.near.len()
    }

    /// Signs the distance of a point from the other surface: negative inside, where there is an
    /// inside.
    fn signed_distance(&mut self, point: DVec3, found: &ClosestPoint, side: FaceSide) -> f64 {
        let is_inside = match side {
            FaceSide::Outside => false,
            FaceSide::Inside => true,
            // Normals decide, but those of faces without area; where a place is covered twice, parity
            // calls it outside.
            FaceSide::Unknown if self.is_on_thin_face(found) => {
                self.other.contains(point, self.traversal)
            }
            FaceSide::Unknown | FaceSide::Covered => self.is_behind(point, found),
        };
        if is_inside { -found.distance } else { found.distance }
    }

    /// Returns true if a face that holds a foot is so thin that its normal is hardly more than
    /// rounding.
    fn is_on_thin_face(&self, found: &ClosestPoint) -> bool {
        /// Area of a face whose normal is right to ten digits, relative to the square of its longest
        /// edge.
        const MIN_AREA: f64 = 1e-6;

        let around = self.other.surface().faces_around(&found.face, found.foot.feature);
        around.iter().any(|&face| {
            let [a, b, c] = self.other.corners(face);
            let squared = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
            let longest = squared.into_iter().fold(0.0, f64::max);
            triangle::area([a, b, c]) <= MIN_AREA * longest
        })
    }

    /// Returns true if a point is behind its foot, by the pseudonormal there.
    fn is_behind(&self, point: DVec3, found: &ClosestPoint) -> bool {
        let (surface, positions) = (self.other.surface(), self.other.positions());
        let feature = found.foot.feature;
        let normal = Pseudonormals::of_feature(surface, positions, found.face, feature);
        (point - found.foot.point).dot(outward(self.other, normal)) < 0.0
    }
}

/// Returns a normal of a body's faces so that it points outward.
fn outward(body: &SurfaceTree, normal: DVec3) -> DVec3 {
    if body.is_inside_out() { -normal } else { normal }
}
