//! Volume, areas, moments and lengths as sums over the pieces of the shared border.
//!
//! The part of a face inside the other body is bordered by directed pieces: stretches of the curve
//! and parts of the face's own edges. With `n` the unit normal of the face, `o` a point of its
//! plane and `O` the origin of the region, a piece from `p` to `q` contributes
//!
//! ```text
//! w = ½ n · ((p − o) × (q − o))                area
//! n w                                          area vector
//! h/3 w,  h = n · (o − O)                      volume
//! h/4 (w/3 ((p − o) + (q − o)) + (o − O) w)    first moment of the volume about O
//! ```
//!
//! by Green's theorem in the plane and the cone from `O`. Pieces need no order, and none has to be
//! linked to the next. Since `w` is additive along a line, an edge from `u` to `v` contributes
//! `in(u) w(u→v) + Σ ± w(x→v)` over its passings `x`, plus where it enters.

use glam::DVec3;
use proximity::SurfaceTree;

use crate::coplanar::common_area;
use crate::curve::{Curve, Passing};
use crate::inside::Inside;
use crate::regions::Regions;

/// Sums over the pieces of one region.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    /// Area of A inside B, and of B inside A, ties counted by the infinitesimal move.
    pub(crate) areas: [f64; 2],
    /// Area vector of A inside B.
    pub(crate) normal: DVec3,
    pub(crate) volume: f64,
    /// Bound on the rounding of the volume, where there are ties.
    pub(crate) rounding: f64,
    /// First moment of the volume about the region's origin.
    pub(crate) moment: DVec3,
    /// Length of the curve.
    pub(crate) length: f64,
    /// Closed chains of the curve, and open ones.
    pub(crate) loops: usize,
    pub(crate) arcs: usize,
    /// True if some stretch of the curve is there by the infinitesimal move only.
    pub(crate) has_ties: bool,
    /// True if some stretch of any region is, so that the rounding is bounded.
    bounds_rounding: bool,
    /// Area in which faces of opposite normals coincide.
    pub(crate) touching: f64,
    /// Area in which faces of equal normals coincide.
    pub(crate) flush: f64,
    /// Vertices of A inside B, and of B inside A.
    pub(crate) vertices: [usize; 2],
    /// Corners of the box of its passings and inside vertices, from the scene's origin.
    pub(crate) lower: DVec3,
    pub(crate) upper: DVec3,
}

/// A face as the sums of one region take it.
struct Plane {
    side: usize,
    /// Unit normal.
    normal: DVec3,
    /// First corner, from the region's origin.
    origin: DVec3,
}

/// Input of the sums of a pair.
#[derive(Clone, Copy)]
pub(crate) struct Parts<'a> {
    pub(crate) bodies: [&'a SurfaceTree; 2],
    pub(crate) curve: &'a Curve,
    pub(crate) inside: &'a [Inside; 2],
    pub(crate) regions: &'a Regions,
}

/// Sums up every region, one entry per region, and one more for faces that coincide where the
/// infinitesimal move leaves no region.
pub(crate) fn sum_regions(parts: Parts<'_>, out: &mut Vec<Sums>) {
    let empty = Sums {
        lower: DVec3::INFINITY,
        upper: DVec3::NEG_INFINITY,
        bounds_rounding: parts.curve.stretches.iter().any(|stretch| stretch.is_tie),
        ..Sums::default()
    };
    out.clear();
    out.resize(parts.regions.origins.len() + 1, empty);

    add_stretches(parts, out);
    for side in 0..2 {
        add_whole_faces(parts, side, out);
        add_corners_of_cut_faces(parts, side, out);
    }
    subtract_coplanar(parts, out);
}

/// Adds the stretches of the curve, and the parts of edges behind their ends.
fn add_stretches(parts: Parts<'_>, out: &mut [Sums]) {
    let Parts { bodies, curve, regions, .. } = parts;
    for stretch in &curve.stretches {
        let region = regions.of_passing(stretch.ends[0]);
        let origin = regions.origins[region];
        // All positions are relative to the region's origin.
        let sums = &mut out[region];
        let [begin, end] = stretch.ends;
        let [p, q] = [regions.points[begin as usize], regions.points[end as usize]];
        sums.length += p.distance(q);
        sums.has_ties |= stretch.is_tie;
        sums.cover(p + origin);
        sums.cover(q + origin);

        // Each of the two faces has the stretch with the other's inside on its left, and the part
        // of its own edge behind each end.
        for (side, (body, face)) in bodies.into_iter().zip(stretch.faces).enumerate() {
            let Some(plane) = Plane::of(side, body, face, origin) else { continue };
            let [from, to] = if side == 0 { [p, q] } else { [q, p] };
            sums.add_piece(&plane, from, to, 1.0);
            for end in stretch.ends {
                let passing = &curve.passings[end as usize];
                if usize::from(passing.name.side) == side {
                    let x = regions.points[end as usize];
                    let (to, sign) = behind(body, face, passing);
                    sums.add_piece(&plane, x, to - origin, sign);
                }
            }
        }
    }
}

/// Returns the end of a passing's edge, as a face runs along it, and +1 where the edge enters.
fn behind(body: &SurfaceTree, face: u32, passing: &Passing) -> (DVec3, f64) {
    let surface = body.surface();
    let edges = surface.face_edges()[face as usize];
    let k = edges.iter().position(|&edge| edge == passing.name.edge).unwrap_or(0);
    let corners = surface.faces()[face as usize];
    let (from, to) = (corners[k], corners[(k + 1) % 3]);
    let enters = passing.enters == (from < to);
    (body.position(to), if enters { 1.0 } else { -1.0 })
}

/// Adds the faces whose corners are all inside and in one cluster.
fn add_whole_faces(parts: Parts<'_>, side: usize, out: &mut [Sums]) {
    let Parts { bodies, inside, regions, .. } = parts;
    let (body, inside) = (bodies[side], &inside[side]);
    for (cluster, (vertices, faces)) in (0..).zip(inside.clusters()) {
        let region = regions.of_cluster(side, cluster);
        let sums = &mut out[region];
        sums.vertices[side] += vertices.len();
        for found in vertices {
            sums.cover(body.position(found.vertex));
        }
        let origin = regions.origins[region];
        sums.add_faces(side, &WholeFaces::of(body, faces, inside, origin));
        if sums.bounds_rounding {
            sums.rounding += whole_faces_rounding(body, faces, origin);
        }
    }
}

/// Adds `in(u) w(u→v)` for the edges of the faces that the curve cuts: whatever other face has a
/// corner inside is inside as a whole.
fn add_corners_of_cut_faces(parts: Parts<'_>, side: usize, out: &mut [Sums]) {
    let Parts { bodies, curve, inside, regions } = parts;
    let (body, inside) = (bodies[side], &inside[side]);
    for &face in &curve.cut_faces[side] {
        let corners = body.surface().faces()[face as usize];
        if inside.holds_face(corners) {
            continue;
        }
        for (k, &corner) in corners.iter().enumerate() {
            let Some(found) = inside.vertex(corner) else { continue };
            let region = regions.of_cluster(side, found.cluster);
            let origin = regions.origins[region];
            let Some(plane) = Plane::of(side, body, face, origin) else { continue };
            let from = body.position(corner) - origin;
            let to = body.position(corners[(k + 1) % 3]) - origin;
            out[region].add_piece(&plane, from, to, f64::from(found.winding));
        }
    }
}

/// Takes coinciding areas out of the areas inside: the infinitesimal move has counted them to one
/// body, to both or to none.
fn subtract_coplanar(parts: Parts<'_>, out: &mut [Sums]) {
    let Parts { bodies, curve, .. } = parts;
    if curve.coplanar.is_empty() {
        return;
    }
    let face_regions = FaceRegions::new(parts);
    for pair in &curve.coplanar {
        let [a, b] = [bodies[0].corners(pair.faces[0]), bodies[1].corners(pair.faces[1])];
        let area = common_area(a, b);
        let region = face_regions.of(pair.faces).unwrap_or(out.len() - 1);
        let sums = &mut out[region];
        let normal = (a[1] - a[0]).cross(a[2] - a[0]).normalize_or_zero();

        // The move has put A's face in front of B's or behind it.
        let counted = match (pair.same_normal, pair.a_moves_outward) {
            (true, true) => [false, true],
            (true, false) => [true, false],
            (false, moves_outward) => [moves_outward; 2],
        };
        for (sum, counted) in sums.areas.iter_mut().zip(counted) {
            if counted {
                *sum -= area;
            }
        }
        if counted[0] {
            sums.normal -= area * normal;
        }
        if pair.same_normal { sums.flush += area } else { sums.touching += area }
    }
    out.iter_mut().for_each(Sums::drop_rounded_areas);
}

/// Regions by the faces that hold pieces of them, for a few faces at most.
struct FaceRegions<'a> {
    parts: Parts<'a>,
    /// Faces of A and of B with a stretch, ascending, each with its first stretch.
    first_stretch: [Vec<(u32, u32)>; 2],
}

impl<'a> FaceRegions<'a> {
    fn new(parts: Parts<'a>) -> Self {
        let mut first_stretch = [Vec::new(), Vec::new()];
        for (side, first) in first_stretch.iter_mut().enumerate() {
            for (number, stretch) in (0..).zip(&parts.curve.stretches) {
                first.push((stretch.faces[side], number));
            }
            first.sort_unstable();
            first.dedup_by_key(|(face, _)| *face);
        }
        Self { parts, first_stretch }
    }

    /// Returns a region that has a piece on one of two faces, if there is one; of several, that of
    /// the first stretch.
    fn of(&self, faces: [u32; 2]) -> Option<usize> {
        (0..2).find_map(|side| self.of_face(side, faces[side]))
    }

    fn of_face(&self, side: usize, face: u32) -> Option<usize> {
        let Parts { bodies, curve, inside, regions } = self.parts;
        let list = &self.first_stretch[side];
        if let Ok(i) = list.binary_search_by_key(&face, |(face, _)| *face) {
            let stretch = &curve.stretches[list[i].1 as usize];
            return Some(regions.of_passing(stretch.ends[0]));
        }
        let corners = bodies[side].surface().faces()[face as usize];
        let cluster = corners.iter().find_map(|&corner| inside[side].cluster(corner))?;
        Some(regions.of_cluster(side, cluster))
    }
}

/// Sums over whole faces, from the region's origin, without the factors that all faces share.
#[derive(Default)]
struct WholeFaces {
    doubled_area: f64,
    doubled_normal: DVec3,
    sixfold_volume: f64,
    /// First moment of the volume, 24 times.
    moment: DVec3,
}

impl WholeFaces {
    fn of(body: &SurfaceTree, faces: &[u32], inside: &Inside, origin: DVec3) -> Self {
        let mut sums = Self::default();
        for &face in faces {
            let [a, b, c] = body.corners(face);
            let (p, u, v) = (a - origin, b - a, c - a);
            let winding = f64::from(inside.face_winding(body, face));

            let normal = u.cross(v);
            let volume = winding * normal.dot(p);
            sums.doubled_area += winding * normal.length();
            sums.doubled_normal += winding * normal;
            sums.sixfold_volume += volume;
            sums.moment += volume * (3.0 * p + u + v);
        }
        sums
    }
}

impl Plane {
    /// Returns the plane of a face, `None` without area.
    fn of(side: usize, body: &SurfaceTree, face: u32, region_origin: DVec3) -> Option<Self> {
        let [a, b, c] = body.corners(face);
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some(Self { side, normal, origin: a - region_origin })
    }
}

impl Sums {
    /// Adds a directed piece of a face's border, from the region's origin.
    #[inline]
    fn add_piece(&mut self, plane: &Plane, from: DVec3, to: DVec3, factor: f64) {
        let (p, q) = (from - plane.origin, to - plane.origin);
        let w = 0.5 * factor * plane.normal.dot(p.cross(q));
        let height = plane.normal.dot(plane.origin);

        self.areas[plane.side] += w;
        self.volume += height * w / 3.0;
        if self.bounds_rounding {
            self.rounding += piece_rounding([from, to, plane.origin], [p, q]);
        }
        self.moment += height / 4.0 * (w / 3.0 * (p + q) + w * plane.origin);
        if plane.side == 0 {
            self.normal += w * plane.normal;
        }
    }

    /// Adds the sums of whole faces.
    fn add_faces(&mut self, side: usize, faces: &WholeFaces) {
        self.areas[side] += faces.doubled_area / 2.0;
        self.volume += faces.sixfold_volume / 6.0;
        self.moment += faces.moment / 24.0;
        if side == 0 {
            self.normal += faces.doubled_normal / 2.0;
        }
    }

    fn cover(&mut self, point: DVec3) {
        self.lower = self.lower.min(point);
        self.upper = self.upper.max(point);
    }

    /// Returns the sums of two regions together.
    pub(crate) fn with(&self, other: &Self) -> Self {
        Self {
            areas: [self.areas[0] + other.areas[0], self.areas[1] + other.areas[1]],
            normal: self.normal + other.normal,
            volume: self.volume + other.volume,
            rounding: self.rounding + other.rounding,
            moment: self.moment + other.moment,
            length: self.length + other.length,
            loops: self.loops + other.loops,
            arcs: self.arcs + other.arcs,
            has_ties: self.has_ties | other.has_ties,
            bounds_rounding: self.bounds_rounding | other.bounds_rounding,
            touching: self.touching + other.touching,
            flush: self.flush + other.flush,
            vertices: [self.vertices[0] + other.vertices[0], self.vertices[1] + other.vertices[1]],
            lower: self.lower.min(other.lower),
            upper: self.upper.max(other.upper),
        }
    }

    /// Takes the curve out of a region that is a touch: the move makes one of it, of no volume.
    pub(crate) fn drop_curve_of_touch(&mut self) {
        if self.has_ties && self.volume.abs() <= self.rounding {
            (self.length, self.loops, self.arcs) = (0.0, 0, 0);
            self.volume = 0.0;
        }
    }

    /// Takes out areas that are only what coinciding areas leave by rounding.
    fn drop_rounded_areas(&mut self) {
        /// Rounding of a sum of areas, relative.
        const ROUNDING: f64 = 1e-12;

        for area in &mut self.areas {
            if area.abs() <= ROUNDING * (self.touching + self.flush) {
                *area = 0.0;
            }
        }
    }

    /// Returns true if the box of a region holds that of another.
    pub(crate) fn holds(&self, other: &Self) -> bool {
        self.lower.cmple(other.lower).all() && self.upper.cmpge(other.upper).all()
    }

    /// Returns true for a region without volume, area or length: a touch in points.
    pub(crate) fn is_nothing(&self) -> bool {
        let Self { areas, volume, length, touching, flush, .. } = *self;
        [areas[0], areas[1], volume, length, touching, flush].iter().all(|x| *x == 0.0)
    }
}

/// Bounds the rounding of a piece's share of a volume, by its ends and the origin of its plane in the region, and the
/// ends in the plane: each coordinate is rounded several times.
fn piece_rounding(points: [DVec3; 3], [p, q]: [DVec3; 2]) -> f64 {
    let [a, b, c] = points.map(DVec3::length_squared);
    let around = p.abs().element_sum() + q.abs().element_sum();
    4.0 * f64::EPSILON * a.max(b).max(c) * around
}

/// Bounds the rounding of the shares of whole faces in a volume.
fn whole_faces_rounding(body: &SurfaceTree, faces: &[u32], origin: DVec3) -> f64 {
    let mut rounding = 0.0;
    for &face in faces {
        let [a, b, c] = body.corners(face);
        let edges_squared = a.distance_squared(b) + a.distance_squared(c);
        rounding += f64::EPSILON * edges_squared * (a - origin).abs().element_sum();
    }
    rounding
}
