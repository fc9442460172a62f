//! The overlap of two bodies: what is measured, and what each body allows to be measured.

use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use surface::SurfaceError;

use crate::curve::{Chain, Curve};
use crate::depth::{Depth, DepthParams, depth};
use crate::inside::Inside;
use crate::measures::{Parts, Sums, sum_regions};
use crate::patches::{ClippedFace, Clipper};
use crate::regions::Regions;

/// Measures of the intersection of two bodies A and B, or of one separate contact region of it.
///
/// Volume and centroid need an inside of both bodies, the area of one inside the other an inside
/// of that other; what lacks it is `None`, and [`Overlap::no_inside`] has the reason.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
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
}

/// A connected part of the curve in which two surfaces cross.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveChain {
    /// Its points in order; the first is not repeated where the chain is closed.
    pub points: Vec<DVec3>,
    /// True for a loop, false for an arc between borders of open surfaces.
    pub is_closed: bool,
}

/// The overlap of two bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// Measures of the whole.
    pub total: OverlapMeasures,
    /// Measures of each separate contact region, by falling volume. Each is a connected part of
    /// the intersection; the volume of a cavity is taken off the region around it.
    pub regions: Vec<OverlapMeasures>,
    /// Reasons for which A, and B, have no inside.
    pub no_inside: [Option<SurfaceError>; 2],
    /// True if A covers some place at a vertex of B more than once, or inside out; and the same for
    /// B. Volumes and areas then count a place as often as it is covered.
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
/// use proximity::SurfaceTree;
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
    sums: Vec<Sums>,
}

impl OverlapDetector {
    /// Measures the overlap of two bodies.
    pub fn measure(&mut self, a: &SurfaceTree, b: &SurfaceTree) -> Overlap {
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.clear();
        a.tree().pairs(b.tree(), 0.0, &mut self.traversal, |fa, fb| candidates.push([fa, fb]));
        let overlap = self.measure_candidates([a, b], &candidates);
        self.candidates = candidates;
        overlap
    }

    /// Measures the overlap of two bodies whose pairs of faces that may meet are known.
    ///
    /// `candidates` holds (face of A, face of B), each pair that shares a point among them.
    pub fn measure_candidates(
        &mut self,
        bodies: [&SurfaceTree; 2],
        candidates: &[[u32; 2]],
    ) -> Overlap {
        let no_inside = bodies.map(|body| require_inside(body).err());

        // The curve settles by exact signs which vertices are inside; rays only check it.
        self.curve.find(bodies, candidates.iter().copied());
        for side in 0..2 {
            if no_inside[1 - side].is_none() {
                self.inside[side].find(side, bodies, &self.curve, &mut self.traversal);
            } else {
                self.inside[side].find_none(bodies[side]);
            }
        }
        self.regions.find(bodies, &self.curve, &self.inside);

        // Positions enter here, for the first time.
        let Self { curve, inside, regions, sums, .. } = self;
        sum_regions(Parts { bodies, curve, inside, regions }, sums);
        self.add_chains();
        self.report(no_inside)
    }

    /// Brackets the depth of A's surface in B and of B's surface in A, for the bodies measured last.
    ///
    /// `None` where nothing of the surface is inside, where the other body has no inside, and where
    /// it covers a place more than once.
    pub fn depths(
        &mut self,
        bodies: [&SurfaceTree; 2],
        params: &DepthParams,
    ) -> [Option<Depth>; 2] {
        [0, 1].map(|side| {
            if self.inside[side].covers_twice {
                return None;
            }
            let Self { curve, inside, regions, traversal, .. } = &mut *self;
            let clipper =
                Clipper { side, body: bodies[side], curve, inside: &inside[side], regions };
            depth(&clipper, bodies[1 - side], params, traversal)
        })
    }

    /// Returns the parts of the faces of A inside B that the curve cuts, and the faces that are
    /// inside as a whole; for `side` 1 those of B inside A. For the bodies measured last.
    #[must_use]
    pub fn patches(&self, side: usize, body: &SurfaceTree) -> (Vec<ClippedFace>, Vec<u32>) {
        let Self { curve, inside, regions, .. } = self;
        let clipper = Clipper { side, body, curve, inside: &inside[side], regions };
        (clipper.cut_faces(), clipper.whole_faces())
    }

    /// Returns the curve in which the surfaces cross, for the bodies measured last: arcs first, then
    /// loops.
    #[must_use]
    pub fn curve(&mut self) -> Vec<CurveChain> {
        let mut chains = Vec::new();
        for Chain { passings, is_closed } in self.curve.chains() {
            let points = passings.iter().map(|&passing| self.regions.position(passing)).collect();
            chains.push(CurveChain { points, is_closed });
        }
        chains
    }

    /// Counts the loops and arcs of each region; a chain without length is a point of touch.
    fn add_chains(&mut self) {
        for chain in self.curve.chains() {
            let region = self.regions.of_passing(chain.passings[0]);
            let points = &self.regions.points;
            let at = |i: usize| points[chain.passings[i % chain.passings.len()] as usize];
            if (1..chain.passings.len()).all(|i| at(i) == at(0)) {
                continue;
            }
            let sums = &mut self.sums[region];
            if chain.is_closed { sums.loops += 1 } else { sums.arcs += 1 }
        }
        self.sums.iter_mut().for_each(Sums::drop_curve_of_touch);
    }

    fn report(&mut self, no_inside: [Option<SurfaceError>; 2]) -> Overlap {
        let has_inside = [no_inside[0].is_none(), no_inside[1].is_none()];
        let origins = &self.regions.origins;
        let mut bodies: Vec<Located> = Vec::with_capacity(origins.len());
        for (sums, &origin) in self.sums.iter().zip(origins.iter().chain([&DVec3::ZERO])) {
            bodies.push(Located { sums: *sums, first_moment: sums.moment + sums.volume * origin });
        }
        // Cavities have negative volume; the total takes them off wherever they stand.
        let total = bodies.iter().fold(Located::default(), |all, one| all.with(one));
        if has_inside == [true; 2] {
            join_cavities(&mut bodies);
        }
        bodies.retain(|region| !region.sums.is_nothing());
        bodies.sort_by(|p, q| q.sums.volume.total_cmp(&p.sums.volume));

        let measures = |located: &Located| located.measures(has_inside);
        Overlap {
            total: measures(&total),
            regions: bodies.iter().map(measures).collect(),
            no_inside,
            covers_twice: [self.inside[1].covers_twice, self.inside[0].covers_twice],
            has_ties: total.sums.has_ties || !self.curve.coplanar.is_empty(),
        }
    }
}

/// Sums of a region, or of all, with the moment about the scene's origin.
#[derive(Clone, Copy, Debug, Default)]
struct Located {
    sums: Sums,
    first_moment: DVec3,
}

impl Located {
    fn with(&self, other: &Self) -> Self {
        Self {
            sums: self.sums.with(&other.sums),
            first_moment: self.first_moment + other.first_moment,
        }
    }

    fn measures(&self, has_inside: [bool; 2]) -> OverlapMeasures {
        let Sums { areas, normal, volume, length, loops, arcs, touching, flush, .. } = self.sums;
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
        }
    }
}

/// Joins each region of negative volume, the border of a cavity, to the smallest region around it.
fn join_cavities(regions: &mut Vec<Located>) {
    let (cavities, mut solids): (Vec<Located>, Vec<Located>) =
        regions.iter().partition(|region| region.sums.volume < 0.0);
    for cavity in cavities {
        let volume = |region: &Located| region.sums.volume;
        let around = solids
            .iter_mut()
            .filter(|region| region.sums.holds(&cavity.sums))
            .min_by(|p, q| volume(p).total_cmp(&volume(q)));
        match around {
            Some(region) => *region = region.with(&cavity),
            None => solids.push(cavity),
        }
    }
    *regions = solids;
}

/// Refuses a body whose winding numbers are not defined.
fn require_inside(body: &SurfaceTree) -> Result<(), SurfaceError> {
    body.surface().require_closed()?;
    body.surface().require_oriented()
}
