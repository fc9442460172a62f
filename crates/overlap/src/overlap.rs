//! The overlap of two bodies: what is measured, and what each body allows to be measured.

use glam::DVec3;
use kdop::Workspace;
use proximity::{NearVertex, NoInside, SurfaceTree};
use surface::progress::{Interrupted, Progress};

use crate::cavities::Cavities;
use crate::contact_sums::JointContact;
use crate::curve::{Curve, index};
use crate::depth::{Depth, DepthMemory, DepthParams, depth};
use crate::error::JointContactError;
use crate::inside::Inside;
use crate::joint::{JointContactParams, JointFaces, joint_contact};
use crate::located::{Located, OverlapMeasures};
use crate::measures::{Parts, Sums, sum_regions};
use crate::patches::{ClippedFace, Clipper};
use crate::regions::{NO_REGION, Regions};

/// A connected part of the curve in which two surfaces cross.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurveChain {
    /// Its points in order; the first is not repeated where the chain is closed.
    pub points: Vec<DVec3>,
    /// True for a loop, false for an arc between borders of open surfaces.
    pub is_closed: bool,
}

/// The overlap of two bodies.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Overlap {
    /// Measures of the whole.
    pub total: OverlapMeasures,
    /// Measures of each separate contact region, by falling volume. Each is a connected part of
    /// the intersection; the volume of a cavity is taken off the region around it.
    pub regions: Vec<OverlapMeasures>,
    /// Reasons for which A, and B, have no inside.
    pub no_inside: [Option<NoInside>; 2],
    /// True if A covers some place of the overlap more than once, or inside out; and the same for B.
    /// Volumes and areas then count a place as often as it is covered. Of parts of A that cross each
    /// other, or themselves, only what vertices of B are in is found.
    pub covers_twice: [bool; 2],
    /// True if the surfaces touch without crossing, or coincide, somewhere: length and loops there are
    /// those of bodies moved by an infinitesimal.
    pub has_ties: bool,
}

/// Measures overlaps, pair after pair, in memory that is reused.
///
/// ```
/// use overlap::OverlapDetector;
/// use overlap::glam::DVec3;
/// use proximity::{NearVertex, NoInside, SurfaceTree};
///
/// let cube = fixtures::shapes::cube(1.0);
/// let other = cube.clone().translated(DVec3::splat(0.75));
/// let a = SurfaceTree::new(cube.surface(), cube.positions)?;
/// let b = SurfaceTree::new(other.surface(), other.positions)?;
///
/// let overlap = OverlapDetector::default().measure(&a, &b);
/// let volume = overlap.total.volume.ok_or("both are closed")?;
/// assert!((volume - 1.0 / 64.0).abs() < 1e-15);
/// assert!((overlap.total.curve_length - 1.5).abs() < 1e-15);
/// assert_eq!(overlap.regions.len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Default)]
pub struct OverlapDetector {
    pub(crate) traversal: Workspace,
    pub(crate) curve: Curve,
    pub(crate) inside: [Inside; 2],
    pub(crate) regions: Regions,
    candidates: Vec<[u32; 2]>,
    joint_faces: JointFaces,
    sums: Vec<Sums>,
    located: Vec<Located>,
    /// Bound on the rounding of the whole volume.
    volume_rounding: f64,
    /// One per region: the region that it belongs to, another one for a cavity.
    owners: Vec<usize>,
    cavities: Cavities,
    depths: DepthMemory,
}

impl OverlapDetector {
    /// Measures the overlap of two bodies.
    pub fn measure(&mut self, a: &SurfaceTree, b: &SurfaceTree) -> Overlap {
        let mut overlap = Overlap::default();
        self.measure_into([a, b], &mut overlap);
        overlap
    }

    /// As [`measure`](Self::measure), in the memory of an earlier answer. Allocates nothing once
    /// the memory of a few pairs has been taken, but for cavities with several regions around them.
    pub fn measure_into(&mut self, bodies: [&SurfaceTree; 2], out: &mut Overlap) {
        // Without a handler nothing interrupts.
        let _ = self.try_measure_into(bodies, out, Progress::none());
    }

    /// As [`measure_into`](Self::measure_into), where a handler may end the call.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when `progress` ends the call; nothing is measured then.
    pub fn try_measure_into(
        &mut self,
        bodies: [&SurfaceTree; 2],
        out: &mut Overlap,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.clear();
        let [a, b] = bodies.map(SurfaceTree::tree);
        a.pairs(b, 0.0, &mut self.traversal, |fa, fb| candidates.push([fa, fb]));
        let measured = self.measure_candidates(bodies, &candidates, out, progress);
        self.candidates = candidates;
        measured
    }

    /// As [`try_measure_into`](Self::try_measure_into), where the pairs of faces that may meet are known.
    ///
    /// `candidates` holds (face of A, face of B), every pair that shares a point among them.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when `progress` ends the call; nothing is measured then.
    pub fn measure_candidates(
        &mut self,
        bodies: [&SurfaceTree; 2],
        candidates: &[[u32; 2]],
        out: &mut Overlap,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        let measured = self.measure_whole(bodies, candidates, out, progress);
        if measured.is_err() {
            // Nor of the pair before: a part of it is overwritten.
            (self.curve, self.inside, self.regions) = Default::default();
            *out = Overlap::default();
        }
        measured
    }

    /// As [`measure_candidates`](Self::measure_candidates); leaves a part where it is interrupted.
    fn measure_whole(
        &mut self,
        bodies: [&SurfaceTree; 2],
        candidates: &[[u32; 2]],
        out: &mut Overlap,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        out.no_inside = bodies.map(|body| body.has_winding_number().err());

        // The curve settles by exact signs which vertices are inside; rays only check it.
        self.curve.find(bodies, candidates, progress)?;
        for side in 0..2 {
            progress.report(0.0)?;
            if out.no_inside[1 - side].is_none() {
                self.inside[side].find(side, bodies, &self.curve, &mut self.traversal);
            } else {
                self.inside[side].find_none(bodies[side]);
            }
        }
        for (side, body) in bodies.into_iter().enumerate() {
            let meets =
                !self.curve.stretches.is_empty() || !self.inside[1 - side].vertices.is_empty();
            if (body.is_inside_out() && meets) || self.has_doubled_part(side, body) {
                self.inside[1 - side].note_covered_place();
            }
        }
        self.regions.find(bodies, &self.curve, &self.inside);

        // Positions enter here, for the first time.
        progress.report(0.0)?;
        let Self { curve, inside, regions, sums, .. } = self;
        sum_regions(Parts { bodies, curve, inside, regions }, sums);
        self.count_chains();
        self.report(bodies, out);
        Ok(())
    }

    /// Returns true if a part of a body beside a place that it covers twice is in the overlap. Where that
    /// place alone is, the vertices of the other body show it.
    fn has_doubled_part(&self, side: usize, body: &SurfaceTree) -> bool {
        if body.inverted_parts().is_empty() {
            return false;
        }
        let of_faces = self.curve.cut_faces[side].iter().map(|&face| {
            let [first, ..] = body.surface().faces()[face as usize];
            first
        });
        let of_inside = self.inside[side].vertices.iter().map(|inside| inside.vertex);
        of_faces.chain(of_inside).any(|vertex| body.is_beside_doubled_place(vertex))
    }

    /// Brackets the depth of A's surface in B and of B's surface in A, for the bodies measured last.
    ///
    /// `None` where nothing of the surface is inside, where the other body has no inside, and where
    /// it covers a place more than once. Allocates nothing once the memory of a few pairs has been
    /// taken.
    pub fn depths(
        &mut self,
        bodies: [&SurfaceTree; 2],
        params: &DepthParams,
    ) -> [Option<Depth>; 2] {
        // Without a handler nothing interrupts.
        self.depths_from(bodies, [&[]; 2], params, Progress::none()).unwrap_or_default()
    }

    /// As [`depths`](Self::depths), where closest points of vertices are known: those of A's vertices
    /// on B, and of B's on A, ascending. They are not computed again.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when `progress` ends the call.
    pub fn depths_from(
        &mut self,
        bodies: [&SurfaceTree; 2],
        known: [&[NearVertex]; 2],
        params: &DepthParams,
        progress: Progress<'_>,
    ) -> Result<[Option<Depth>; 2], Interrupted> {
        self.depths_within(None, bodies, known, params, progress)
    }

    /// As [`depths`](Self::depths), within one of the regions that were reported last.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when `progress` ends the call.
    pub fn depths_in_region(
        &mut self,
        region: u32,
        bodies: [&SurfaceTree; 2],
        params: &DepthParams,
        progress: Progress<'_>,
    ) -> Result<[Option<Depth>; 2], Interrupted> {
        self.depths_within(Some(region), bodies, [&[]; 2], params, progress)
    }

    fn depths_within(
        &mut self,
        region: Option<u32>,
        bodies: [&SurfaceTree; 2],
        known: [&[NearVertex]; 2],
        params: &DepthParams,
        progress: Progress<'_>,
    ) -> Result<[Option<Depth>; 2], Interrupted> {
        let mut found = [None; 2];
        for (side, found) in found.iter_mut().enumerate() {
            let Self { curve, inside, regions, depths, .. } = &mut *self;
            let (body, other, inside) = (bodies[side], bodies[1 - side], &inside[side]);
            if inside.is_defined && !inside.covers_twice {
                let clipper = Clipper { side, body, curve, inside, regions, region };
                *found = depth(&clipper, other, known[side], params, depths, progress)?;
            }
        }
        Ok(found)
    }

    /// Measures the contact of A's surface with B's and of B's with A's, within a margin, for the
    /// bodies measured last.
    ///
    /// Gaps are signed where the other body has an inside, and should not cross itself; else they are
    /// distances.
    ///
    /// ```
    /// use overlap::glam::DVec3;
    /// use overlap::{JointContactParams, OverlapDetector};
    /// use proximity::SurfaceTree;
    /// use surface::progress::Progress;
    ///
    /// // Two cubes with a joint space of 0.1.
    /// let cube = fixtures::shapes::cube(1.0);
    /// let other = cube.clone().translated(1.1 * DVec3::X);
    /// let a = SurfaceTree::new(cube.surface(), cube.positions)?;
    /// let b = SurfaceTree::new(other.surface(), other.positions)?;
    /// let mut detector = OverlapDetector::default();
    /// detector.measure(&a, &b);
    ///
    /// let params = JointContactParams { margin: 0.15, resolution: 0.05, foundation: None };
    /// let [contact, _] = detector.joint_contact([&a, &b], &params, Progress::none())?;
    /// assert_eq!(contact.regions.len(), 1);
    /// assert!((contact.total.min_gap - 0.1).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`JointContactError`] when a parameter is out of range, the resolution is too fine, more than 2²⁶
    /// pairs of faces are within the margin, or `progress` ends the call.
    pub fn joint_contact(
        &mut self,
        bodies: [&SurfaceTree; 2],
        params: &JointContactParams,
        progress: Progress<'_>,
    ) -> Result<[JointContact; 2], JointContactError> {
        params.validate()?;
        let Self { curve, inside, regions, traversal, joint_faces, .. } = self;
        joint_faces.find(bodies, params.margin, traversal, progress)?;
        let mut contacts = <[JointContact; 2]>::default();
        for (side, contact) in contacts.iter_mut().enumerate() {
            let (body, other) = (bodies[side], bodies[1 - side]);
            let inside = &inside[side];
            let clipper = Clipper { side, body, curve, inside, regions, region: None };
            *contact = joint_contact(&clipper, other, joint_faces, params, traversal, progress)?;
        }
        Ok(contacts)
    }

    /// Returns the parts of the faces of A inside B, region by region of a face: those that the
    /// curve cuts, then the faces that are inside as a whole. For `side` 1, those of B inside A.
    /// For the bodies measured last; none where the other body has no inside, or covers a place more
    /// than once.
    #[must_use]
    pub fn patches(&self, side: usize, body: &SurfaceTree) -> Vec<ClippedFace> {
        let Self { curve, inside, regions, .. } = self;
        let inside = &inside[side];
        if !inside.is_defined || inside.covers_twice {
            return Vec::new();
        }
        let clipper = Clipper { side, body, curve, inside, regions, region: None };
        clipper.patches()
    }

    /// Returns a bound on the rounding of the whole volume, for the bodies measured last: bodies with a volume
    /// beyond it share more than a touch. It is 0 where nothing touches, but all that meets crosses.
    #[must_use]
    pub const fn volume_rounding(&self) -> f64 {
        self.volume_rounding
    }

    /// Returns the curve in which the surfaces cross, for the bodies measured last: arcs first, then
    /// loops.
    #[must_use]
    pub fn curve(&mut self) -> Vec<CurveChain> {
        let mut chains = Vec::new();
        let regions = &self.regions;
        self.curve.visit_chains(|passings, is_closed| {
            let points = passings.iter().map(|&passing| regions.position(passing)).collect();
            chains.push(CurveChain { points, is_closed });
        });
        chains
    }

    /// Counts the loops and arcs of each region; a chain without length is a point of touch.
    fn count_chains(&mut self) {
        let Self { curve, regions, sums, .. } = self;
        curve.visit_chains(|passings, is_closed| {
            let at = |passing: &u32| regions.points[*passing as usize];
            if passings.iter().all(|passing| at(passing) == at(&passings[0])) {
                return;
            }
            let sums = &mut sums[regions.of_passing(passings[0])];
            if is_closed { sums.loops += 1 } else { sums.arcs += 1 }
        });
        for sums in sums {
            sums.drop_curve_of_touch();
        }
    }

    /// Writes the measures of the whole and of each region.
    fn report(&mut self, bodies: [&SurfaceTree; 2], out: &mut Overlap) {
        // The last sums are of no region: their origin is the scene's.
        self.located.clear();
        for (number, sums) in self.sums.iter().enumerate() {
            let origin = self.regions.origins.get(number).copied().unwrap_or(DVec3::ZERO);
            self.located.push(Located::new(number, *sums, origin));
        }

        // Cavities have negative volume; the total takes them off wherever they stand.
        let has_inside = [out.no_inside[0].is_none(), out.no_inside[1].is_none()];
        let mut total = Located::default();
        for region in &self.located {
            total = total.with(region);
        }
        self.owners.clear();
        self.owners.extend(0..self.located.len());
        if has_inside == [true; 2] {
            self.join_cavities(bodies);
        }
        self.located.retain(|region| !region.sums.is_nothing());
        self.located.sort_by(|p, q| q.sums.volume.total_cmp(&p.sums.volume));
        self.number_reported();

        out.total = total.measures(has_inside);
        self.volume_rounding = total.sums.rounding;
        out.regions.clear();
        for region in &self.located {
            out.regions.push(region.measures(has_inside));
        }
        out.covers_twice = [self.inside[1].covers_twice, self.inside[0].covers_twice];
        out.has_ties = total.sums.has_ties || !self.curve.coplanar.is_empty();
    }

    /// Joins each cavity to the region around it.
    fn join_cavities(&mut self, bodies: [&SurfaceTree; 2]) {
        // For now each region is under its own number.
        let Self { curve, inside, regions, located, owners, cavities, .. } = self;
        regions.reported.clear();
        regions.reported.extend(0..index(located.len()));
        cavities.find(Parts { bodies, curve, inside, regions }, located, owners);

        for number in 0..located.len() {
            let owner = owners[number];
            if owner != number {
                located[owner] = located[owner].with(&located[number]);
            }
        }
        located.retain(|region| owners[region.number] == region.number);
    }

    /// Notes the place of each region among those reported; a cavity has that of its solid.
    fn number_reported(&mut self) {
        let reported = &mut self.regions.reported;
        reported.clear();
        reported.resize(self.owners.len(), NO_REGION);
        for (place, region) in (0..).zip(&self.located) {
            reported[region.number] = place;
        }
        for (number, &owner) in self.owners.iter().enumerate() {
            if owner != number {
                reported[number] = reported[owner];
            }
        }
    }
}
