//! Measured error of a field near its surface, and the fraction of a solid that is thin beside its spacing.
//!
//! Samples are spread evenly over the area of the surface, and evenly up to two spacings to
//! either side. Distances there are exact: a face can only be nearer than the sample's own if
//! its box is, and few boxes are. So are their signs, where the surface is closed: a value of the
//! wrong sign is off by the sum of both distances.

use glam::DVec3;
use surface::progress::{Interrupted, Progress};
use surface::{Aabb, Csr, Positions, TriangleSurface, closest_on_triangle, parallel, triangle};

use crate::face_groups::FaceGroups;
use crate::num::{coordinate, floor_index};
use crate::sign::{InsideRule, enclosures};
use crate::{DistanceField, FieldGrid, Interpolation, MeasuredError};

/// Maximum height of a sample over the surface, in spacings.
pub(crate) const MAX_HEIGHT: f64 = 2.0;

/// Thickness, in spacings, below which nodes may miss the inside of a solid: a plate of this
/// thickness keeps all of its inside, one of 1 spacing 95 %.
pub(crate) const THIN: f64 = 1.5;

/// Cells along each side of a block, about the size of a sample's box.
const BLOCK: f64 = 4.0;

/// Groups of faces per task.
const TASK: usize = 256;

/// Result of a comparison with exact distances.
pub(crate) struct Accuracy {
    pub(crate) error: MeasuredError,
    /// Fraction of the samples below which the solid is thinner than [`THIN`].
    pub(crate) thin_fraction: f64,
}

/// Parameters of a comparison.
#[derive(Clone, Copy)]
pub(crate) struct AccuracyParams {
    /// Number of samples.
    pub(crate) samples: usize,
    /// Largest distance of the field.
    pub(crate) truncation: f64,
    /// Rule by which a sample is inside; `None` compares magnitudes only.
    pub(crate) rule: Option<InsideRule>,
    /// True if the normals of the surface point inward.
    pub(crate) is_inverted: bool,
}

/// Compares a field with exact distances; `None` where there is nothing to compare.
pub(crate) fn accuracy(
    field: &DistanceField,
    groups: &FaceGroups<'_>,
    params: AccuracyParams,
    progress: Progress<'_>,
) -> Result<Option<Accuracy>, Interrupted> {
    let FaceGroups { surface, x, .. } = *groups;
    let spacing = field.grid().spacing();
    let (near, late) = (progress.part(0.0, 0.9), progress.part(0.9, 1.0));
    let inward = if params.is_inverted { 1.0 } else { -1.0 };
    let depth = inward * THIN * spacing;
    let mut samples = samples(surface, x, params.samples, MAX_HEIGHT * spacing, depth);

    // Each sample is visited by the few faces that can change it.
    for (sample, face) in near_faces(&samples, groups, field.grid(), near)? {
        samples[sample as usize].visit(x.corners(surface.faces()[face]), depth);
    }
    let points: Vec<DVec3> = samples.iter().map(|sample| sample.point).collect();
    let signs = SampleSigns::new(groups, &points, params.rule, late)?;
    Ok(summary(field, &samples, &signs, params.truncation))
}

/// Returns the root mean square and the maximum of the errors.
fn summary(
    field: &DistanceField,
    samples: &[ErrorSample],
    signs: &SampleSigns,
    truncation: f64,
) -> Option<Accuracy> {
    // Points of samples beyond the grid have no value.
    let (mut squares, mut max, mut points, mut thin) = (0.0, 0.0_f64, 0, 0);
    for (n, sample) in samples.iter().enumerate() {
        thin += usize::from(sample.is_thin);
        if let Some(value) = field.evaluate(sample.point, Interpolation::Trilinear) {
            let error = signs.error(n, value.distance, sample.distance.min(truncation));
            squares += error * error;
            max = max.max(error);
            points += 1;
        }
    }

    let rms = (squares / coordinate(points)).sqrt();
    let thin_fraction = coordinate(thin) / coordinate(samples.len());
    (points > 0).then_some(Accuracy { error: MeasuredError { points, rms, max }, thin_fraction })
}

/// Exact signs of samples: per sample, true if it is inside; `None` where no inside is defined.
pub(crate) struct SampleSigns(Option<Vec<bool>>);

impl SampleSigns {
    /// Computes the signs of samples at some points.
    pub(crate) fn new(
        groups: &FaceGroups<'_>,
        points: &[DVec3],
        rule: Option<InsideRule>,
        progress: Progress<'_>,
    ) -> Result<Self, Interrupted> {
        let Some(rule) = rule else { return Ok(Self(None)) };
        let counts = enclosures(groups, points, progress)?;
        Ok(Self(Some(counts.into_iter().map(|count| rule.holds(count)).collect())))
    }

    /// Returns the error of the value at a sample whose exact distance is given: of its magnitude
    /// only where no inside is defined.
    pub(crate) fn error(&self, sample: usize, value: f64, distance: f64) -> f64 {
        match &self.0 {
            Some(is_inside) if is_inside[sample] => (value + distance).abs(),
            Some(_) => (value - distance).abs(),
            None => (value.abs() - distance).abs(),
        }
    }
}

/// Point over the surface, at which the field is compared.
struct ErrorSample {
    /// Point of the surface below it.
    foot: DVec3,
    normal: DVec3,
    point: DVec3,
    /// Distance of the point from the faces that were visited.
    distance: f64,
    /// Box that every face touches that could change the sample.
    bounds: Aabb,
    /// True if the solid below it is thin.
    is_thin: bool,
}

/// Spreads samples over the area of a surface.
fn samples(
    surface: &TriangleSurface,
    x: Positions<'_>,
    count: usize,
    max_height: f64,
    depth: f64,
) -> Vec<ErrorSample> {
    // Twice the area of the faces per sample.
    let faces = surface.faces();
    let normals = parallel::map(faces.len(), |f| triangle::normal(x.corners(faces[f])));
    let mut doubled_areas = 0.0;
    for normal in &normals {
        doubled_areas += normal.length();
    }
    let step = doubled_areas / coordinate(count);

    // A face takes each sample whose place in the row of all areas falls within its own.
    let mut samples = Vec::with_capacity(count);
    let mut passed = 0.0;
    for (&face, normal) in faces.iter().zip(normals) {
        let doubled_area = normal.length();
        passed += doubled_area;
        while samples.len() < count && passed > (coordinate(samples.len()) + 0.5) * step {
            let place = quasirandom(samples.len());
            let (corners, normal) = (x.corners(face), normal / doubled_area);
            samples.push(ErrorSample::new(corners, normal, place, max_height, depth));
        }
    }
    samples
}

/// Returns the `n`th point of a sequence that fills the unit cube evenly.
///
/// Source: M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018:
/// multiples of the powers of the root of g⁴ = g + 1.
pub(crate) fn quasirandom(n: usize) -> DVec3 {
    let g = 1.220_744_084_605_759_5_f64;
    let powers = DVec3::new(1.0 / g, 1.0 / (g * g), 1.0 / (g * g * g));
    (powers * (coordinate(n) + 0.5)).fract()
}

impl ErrorSample {
    /// Returns the sample at a place of a face, two coordinates of which select the foot and
    /// one the height.
    fn new(
        [a, b, c]: [DVec3; 3],
        normal: DVec3,
        place: DVec3,
        max_height: f64,
        depth: f64,
    ) -> Self {
        // The half of a unit square beyond its diagonal is folded onto the triangle.
        let (mut u, mut v) = (place.x, place.y);
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let foot = a + u * (b - a) + v * (c - a);

        let height = (2.0 * place.z - 1.0) * max_height;
        let (point, below) = (foot + height * normal, foot + depth * normal);

        // The foot is on the surface: no face farther than it can change the sample.
        let distance = point.distance(foot);
        let ball = Aabb { min: point, max: point }.inflate(distance);
        let bounds = ball.with_point(foot).with_point(below);
        Self { foot, normal, point, distance, bounds, is_thin: false }
    }

    /// Updates distance and thickness by a face; `depth` along the normal leads inside.
    fn visit(&mut self, corners: [DVec3; 3], depth: f64) {
        let distance = closest_on_triangle(self.point, corners).point.distance(self.point);
        self.distance = self.distance.min(distance);

        // Faces on the other side of the solid face the other way.
        let normal = triangle::normal(corners);
        let slope = normal.dot(self.normal);
        if slope < 0.0 && !self.is_thin {
            let t = normal.dot(corners[0] - self.foot) / slope;
            let hit = self.foot + t * self.normal;
            let miss = closest_on_triangle(hit, corners).point.distance(hit);
            self.is_thin = t * depth.signum() > 0.0
                && t.abs() < depth.abs()
                && miss <= f64::EPSILON.sqrt() * depth.abs();
        }
    }
}

/// Returns the faces that may change samples, each with its sample; a pair may occur twice.
fn near_faces(
    samples: &[ErrorSample],
    groups: &FaceGroups<'_>,
    grid: &FieldGrid,
    progress: Progress<'_>,
) -> Result<Vec<(u32, usize)>, Interrupted> {
    // Samples are listed by block, in which each face finds those near it.
    let blocks = Blocks::new(grid);
    let samples_in = blocks.samples(samples);
    let tasks = groups.count().div_ceil(TASK);
    let steps = progress.steps(tasks);

    let near = parallel::map(tasks, |task| {
        steps.advance(1)?;
        let (mut near, mut touched, mut candidates) = (Vec::new(), Vec::new(), Vec::new());
        for group in task * TASK..((task + 1) * TASK).min(groups.count()) {
            // Most groups of faces that follow each other are near no sample.
            let bounds = groups.bounds(group);
            blocks.within(bounds, &mut touched);
            candidates.clear();
            for &block in &touched {
                for &sample in samples_in.row(block) {
                    if samples[sample as usize].bounds.overlaps(bounds) {
                        candidates.push(sample);
                    }
                }
            }
            if candidates.is_empty() {
                continue;
            }

            for (face, bounds) in groups.faces(group) {
                for &sample in &candidates {
                    if samples[sample as usize].bounds.overlaps(bounds) {
                        near.push((sample, face));
                    }
                }
            }
        }
        Ok(near)
    });
    Ok(near.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
}

/// Blocks of cells of a grid.
struct Blocks {
    origin: DVec3,
    density: f64,
    /// Blocks along each axis.
    dims: [usize; 3],
}

impl Blocks {
    fn new(grid: &FieldGrid) -> Self {
        let dims = grid.dims().map(|n| floor_index(coordinate(n) / BLOCK) + 1);
        Self { origin: grid.origin(), density: 1.0 / (BLOCK * grid.spacing()), dims }
    }

    /// Lists the samples whose box touches each block.
    fn samples(&self, samples: &[ErrorSample]) -> Csr {
        let (mut pairs, mut touched) = (Vec::new(), Vec::new());
        for (n, sample) in (0..).zip(samples) {
            self.within(sample.bounds, &mut touched);
            for &block in &touched {
                pairs.push((block, n));
            }
        }
        Csr::new(self.dims.iter().product(), &pairs)
    }

    /// Lists the blocks that a box touches; what is beyond the grid belongs to its border.
    fn within(&self, bounds: Aabb, blocks: &mut Vec<u32>) {
        let [nx, ny, _] = self.dims;
        let (min, max) = (self.block(bounds.min), self.block(bounds.max));

        // The list is the caller's, as there is one per face.
        blocks.clear();
        for k in min[2]..=max[2] {
            for j in min[1]..=max[1] {
                for i in min[0]..=max[0] {
                    let block = i + nx * (j + ny * k);
                    blocks.push(u32::try_from(block).unwrap_or(u32::MAX));
                }
            }
        }
    }

    fn block(&self, p: DVec3) -> [usize; 3] {
        let u = (p - self.origin) * self.density;
        [0, 1, 2].map(|axis| floor_index(u[axis]).min(self.dims[axis] - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point outside a ball and one inside, each with the value of either sign.
    #[test]
    fn a_wrong_sign_is_off_by_both_distances() {
        let ball = fixtures::shapes::icosphere(9.0, 2);
        let surface = ball.surface();
        let x = surface.positions(&ball.positions).expect("finite positions");
        let groups = FaceGroups::new(&surface, x);
        let points = [12.0 * DVec3::Y, 6.0 * DVec3::Y];
        let errors = |rule: Option<InsideRule>| {
            let signs = SampleSigns::new(&groups, &points, rule, Progress::none());
            let signs = signs.expect("not interrupted");
            [0, 1].map(|sample| [3.5, -3.5].map(|value| signs.error(sample, value, 3.0)))
        };
        let expected = [[0.5, 6.5], [6.5, 0.5]];
        assert_eq!(errors(Some(InsideRule::Positive)), expected);
        assert_eq!(errors(Some(InsideRule::NonZero)), expected);
        assert_eq!(errors(Some(InsideRule::Negative)), [[0.5, 6.5]; 2]);
        assert_eq!(errors(None), [[0.5; 2]; 2]);
    }
}
