//! A finished field beside exact distances, and how thick the solid is beside
//! its spacing.
//!
//! Places are spread evenly over the area of the surface, and heights over them
//! evenly up to two spacings to either side. Distances there are exact: a face
//! can only be nearer than the place itself if its box is, and few boxes are.

use glam::DVec3;
use surface::{Positions, TriangleSurface, closest_on_triangle};

use crate::field::DistanceField;
use crate::grid::FieldGrid;
use crate::num::{coordinate, floor_index};
use crate::par;
use crate::query::Interpolation;
use crate::report::MeasuredError;

/// Heights over the surface that are compared, in spacings.
const REACH: f64 = 2.0;

/// Thickness below which nodes may miss the inside of a solid, in spacings: a
/// plate of this thickness keeps all of its inside, one of 1 spacing 95 %.
pub(crate) const THIN: f64 = 1.5;

/// What the places told.
pub(crate) struct Compared {
    pub(crate) error: MeasuredError,
    /// Share of the places under which the solid is thinner than [`THIN`].
    pub(crate) thin: f64,
}

/// A place of the surface and a point over it.
struct Place {
    on: DVec3,
    normal: DVec3,
    point: DVec3,
    /// Distance from the point to the surface, as far as known.
    distance: f64,
    /// Corners of a box that no face may miss and still matter.
    lo: DVec3,
    hi: DVec3,
    is_thin: bool,
}

/// Distances are compared up to `limit`; `inward` is −1 where the surface's
/// normals point out, 1 where they point in.
pub(crate) fn compare(
    field: &DistanceField,
    (surface, x): (&TriangleSurface, Positions<'_>),
    points: usize,
    limit: f64,
    inward: f64,
) -> Option<Compared> {
    let spacing = field.grid().spacing();
    let depth = inward * THIN * spacing;
    let mut places = places(surface, x, points, REACH * spacing, depth);
    for (place, face) in meetings(&places, (surface, x), field.grid()) {
        places[place].meet(x.corners(surface.faces()[face]), depth);
    }
    summary(field, &places, limit)
}

/// Faces that are looked at together.
const BATCH: usize = 4096;

/// Which faces may matter to which places; some pairs may come twice.
fn meetings(
    places: &[Place],
    (surface, x): (&TriangleSurface, Positions<'_>),
    grid: &FieldGrid,
) -> Vec<(usize, usize)> {
    let near = Near::new(places, grid);
    let faces = surface.faces();
    let of_batch = |batch: usize| {
        let mut pairs = Vec::new();
        let first = batch * BATCH;
        for (face, &corners) in (first..).zip(&faces[first..faces.len().min(first + BATCH)]) {
            let [a, b, c] = x.corners(corners);
            let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
            near.each_block(lo, hi, |block| {
                let close = near.places(block).iter().filter(|&&place| places[place].meets(lo, hi));
                pairs.extend(close.map(|&place| (place, face)));
            });
        }
        pairs
    };
    par::map(faces.len().div_ceil(BATCH), of_batch).concat()
}

/// Which places have part of their box in which block of cells.
struct Near<'a> {
    grid: &'a FieldGrid,
    dims: [usize; 3],
    per_block: f64,
    /// Block `b` has `list[starts[b]..starts[b + 1]]`.
    starts: Vec<usize>,
    list: Vec<usize>,
}

/// Cells along each side of a block, about the size of a place's box.
const BLOCK: f64 = 4.0;

impl<'a> Near<'a> {
    fn new(places: &[Place], grid: &'a FieldGrid) -> Self {
        let dims = grid.dims().map(|n| floor_index(coordinate(n) / BLOCK) + 1);
        let per_block = 1.0 / (BLOCK * grid.spacing());
        let mut near = Self { grid, dims, per_block, starts: Vec::new(), list: Vec::new() };
        let mut pairs = Vec::new();
        for (n, place) in places.iter().enumerate() {
            near.each_block(place.lo, place.hi, |block| pairs.push((block, n)));
        }
        pairs.sort_unstable();
        let mut starts = vec![0; dims.iter().product::<usize>() + 1];
        for (block, _) in &pairs {
            starts[block + 1] += 1;
        }
        let mut before = 0;
        for start in &mut starts {
            before += *start;
            *start = before;
        }
        near.list = pairs.into_iter().map(|(_, place)| place).collect();
        near.starts = starts;
        near
    }

    fn places(&self, block: usize) -> &[usize] {
        &self.list[self.starts[block]..self.starts[block + 1]]
    }

    fn block(&self, p: DVec3) -> [usize; 3] {
        let u = (p - self.grid.origin()) * self.per_block;
        [0, 1, 2].map(|axis| floor_index(u[axis]).min(self.dims[axis] - 1))
    }

    /// Visits the blocks that a box meets; what is beyond the grid belongs to its border.
    #[inline]
    fn each_block(&self, lo: DVec3, hi: DVec3, mut visit: impl FnMut(usize)) {
        let [nx, ny, _] = self.dims;
        let [lo, hi] = [lo, hi].map(|p| self.block(p));
        for k in lo[2]..=hi[2] {
            for j in lo[1]..=hi[1] {
                for i in lo[0]..=hi[0] {
                    visit(i + nx * (j + ny * k));
                }
            }
        }
    }
}

fn summary(field: &DistanceField, places: &[Place], limit: f64) -> Option<Compared> {
    let (mut squares, mut worst, mut count) = (0.0, 0.0_f64, 0);
    for place in places {
        if let Some(sample) = field.evaluate(place.point, Interpolation::Trilinear) {
            let error = (sample.distance.abs() - place.distance.min(limit)).abs();
            squares += error * error;
            worst = worst.max(error);
            count += 1;
        }
    }
    let thin = coordinate(places.iter().filter(|place| place.is_thin).count());
    let rms = (squares / coordinate(count)).sqrt();
    let error = MeasuredError { points: count, rms, max: worst };
    (count > 0).then(|| Compared { error, thin: thin / coordinate(places.len()) })
}

fn places(
    surface: &TriangleSurface,
    x: Positions<'_>,
    points: usize,
    reach: f64,
    depth: f64,
) -> Vec<Place> {
    let doubled_area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
    let faces = surface.faces();
    let areas = par::map(faces.len(), |f| doubled_area(x.corners(faces[f])).length());
    let step = areas.iter().sum::<f64>() / coordinate(points);
    let mut places = Vec::with_capacity(points);
    let mut passed = 0.0;
    for (&face, area) in faces.iter().zip(areas) {
        passed += area;
        while places.len() < points && passed > (coordinate(places.len()) + 0.5) * step {
            let corners = x.corners(face);
            let normal = doubled_area(corners) / area;
            places.push(Place::new(corners, normal, spread(places.len()), reach, depth));
        }
    }
    places
}

/// The `n`th of numbers that fill the unit cube evenly.
///
/// Source: M. Roberts, "The unreasonable effectiveness of quasirandom
/// sequences", 2018: multiples of the powers of the root of g⁴ = g + 1.
fn spread(n: usize) -> DVec3 {
    let g = 1.220_744_084_605_759_5_f64;
    let powers = DVec3::new(1.0 / g, 1.0 / (g * g), 1.0 / (g * g * g));
    (powers * (coordinate(n) + 0.5)).fract()
}

impl Place {
    fn new([a, b, c]: [DVec3; 3], normal: DVec3, at: DVec3, reach: f64, depth: f64) -> Self {
        let (mut u, mut v) = (at.x, at.y);
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let on = a + u * (b - a) + v * (c - a);
        let height = (2.0 * at.z - 1.0) * reach;
        let (point, below) = (on + height * normal, on + depth * normal);
        // The place is on the surface, so nothing farther than it matters.
        let distance = point.distance(on);
        let lo = (point - distance).min(on).min(below);
        let hi = (point + distance).max(on).max(below);
        Self { on, normal, point, distance, lo, hi, is_thin: false }
    }

    /// Whether a box may hold a face that matters.
    #[inline]
    fn meets(&self, lo: DVec3, hi: DVec3) -> bool {
        self.lo.cmple(hi).all() && self.hi.cmpge(lo).all()
    }

    /// Takes notice of a face; `depth` along the normal leads inside.
    fn meet(&mut self, corners: [DVec3; 3], depth: f64) {
        let distance = closest_on_triangle(self.point, corners).point.distance(self.point);
        self.distance = self.distance.min(distance);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let slope = normal.dot(self.normal);
        if slope < 0.0 && !self.is_thin {
            // Where the line through the place meets the face's plane.
            let t = normal.dot(a - self.on) / slope;
            let hit = self.on + t * self.normal;
            let apart = closest_on_triangle(hit, corners).point.distance(hit);
            self.is_thin = t * depth.signum() > 0.0
                && t.abs() < depth.abs()
                && apart <= f64::EPSILON.sqrt() * depth.abs();
        }
    }
}
