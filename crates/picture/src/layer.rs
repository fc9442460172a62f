//! Depth-buffered layer of a picture: the nearest surface per sample.

use std::ops::{Add, Mul, Range};

use glam::{DVec2, DVec3, Vec3};
use surface::Aabb;

use crate::cast::{float, floor, single};
use crate::{Camera, ContactPoint, Subject};

/// Surface at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// Distance into the picture, in samples.
    pub(crate) distance: f32,
    /// Normal in the view: right, up, towards the viewer.
    pub(crate) normal: Vec3,
    /// Depth inside another body, where positive.
    pub(crate) depth: f32,
    /// Number of the subject.
    pub(crate) subject: u32,
}

/// Nearest triangles of some rows of samples, row by row from the top.
///
/// What else a sample needs is interpolated when it is shown: most triangles are hidden later.
#[derive(Debug)]
pub(crate) struct Layer<'a> {
    projections: &'a [Projection<'a>],
    part: Part,
    width: usize,
    /// Numbers of the rows in the picture.
    rows: Range<usize>,
    /// Empty until something is drawn.
    samples: Vec<Sample>,
    /// Distance of the near plane.
    near: f32,
}

/// Part of subjects that a layer shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Whole surfaces.
    Whole,
    /// Parts inside other bodies.
    Contact,
}

/// Nearest triangle at a sample.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Infinite without a surface.
    distance: f32,
    /// Number of the triangle among those of its subject.
    triangle: u32,
    /// Number of the subject.
    subject: u32,
}

impl Sample {
    const NONE: Self = Self { distance: f32::INFINITY, triangle: 0, subject: 0 };
}

/// Surface of a subject, in samples.
#[derive(Debug)]
pub(crate) struct Projection<'a> {
    faces: &'a [[u32; 3]],
    /// |V| corners.
    corners: Vec<Corner>,
    /// |F| first rows and ends of faces.
    face_rows: Vec<[usize; 2]>,
    /// Parts inside other bodies.
    contact: Vec<[Corner; 3]>,
    /// Their first rows and ends.
    contact_rows: Vec<[usize; 2]>,
}

/// Projected corner of a triangle.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: DVec3,
    normal: DVec3,
    depth: f64,
}

impl<'a> Projection<'a> {
    pub(crate) fn new(subject: &Subject<'a>, camera: &Camera) -> Self {
        let mut corners = Vec::with_capacity(subject.positions.len());
        for (&at, &normal) in subject.positions.iter().zip(subject.normals) {
            corners.push(Corner::new(&ContactPoint { at, normal, depth: 0.0 }, camera));
        }
        let mut face_rows = Vec::with_capacity(subject.faces.len());
        for face in subject.faces {
            face_rows.push(rows_of(&face.map(|vertex| corners[vertex as usize].at)));
        }
        let mut contact = Vec::with_capacity(subject.contact.len());
        for triangle in subject.contact {
            contact.push(triangle.each_ref().map(|point| Corner::new(point, camera)));
        }
        let mut contact_rows = Vec::with_capacity(contact.len());
        for triangle in &contact {
            contact_rows.push(rows_of(&triangle.map(|corner| corner.at)));
        }
        Self { faces: subject.faces, corners, face_rows, contact, contact_rows }
    }

    /// Returns the first rows and ends of triangles.
    fn rows(&self, part: Part) -> &[[usize; 2]] {
        match part {
            Part::Whole => &self.face_rows,
            Part::Contact => &self.contact_rows,
        }
    }

    /// Returns the corners of a triangle.
    fn corners(&self, part: Part, triangle: u32) -> [Corner; 3] {
        match part {
            Part::Whole => {
                self.faces[triangle as usize].map(|vertex| self.corners[vertex as usize])
            }
            Part::Contact => self.contact[triangle as usize],
        }
    }
}

/// Returns the first row of a triangle and the end of its rows.
fn rows_of(corners: &[DVec3; 3]) -> [usize; 2] {
    let [a, b, c] = corners.map(|corner| corner.y);
    [floor(a.min(b).min(c)), floor(a.max(b).max(c) + 1.0)]
}

impl<'a> Layer<'a> {
    /// Returns an empty layer of some rows of a camera's picture.
    pub(crate) fn new(
        projections: &'a [Projection<'a>],
        part: Part,
        camera: &Camera,
        rows: Range<usize>,
    ) -> Self {
        let (width, near) = (camera.width(), single(camera.near()));
        Self { projections, part, width, rows, samples: Vec::new(), near }
    }

    /// Returns the distance at a sample into the picture, in samples; infinite without a surface,
    /// `None` beyond the rows, and where nothing is drawn in any.
    pub(crate) fn distance(&self, sample: usize) -> Option<f32> {
        self.samples.get(sample).map(|sample| sample.distance)
    }

    /// Returns the surface at a sample, if there is one.
    pub(crate) fn hit(&self, sample: usize) -> Option<Hit> {
        let &Sample { distance, triangle, subject } = self.samples.get(sample)?;
        if distance == f32::INFINITY {
            return None;
        }
        let corners = self.projections[subject as usize].corners(self.part, triangle);
        let (row, column) = (self.rows.start + sample / self.width, sample % self.width);
        let outline = Outline::new(corners.map(|corner| corner.at))?;
        let weights = outline.weights(middle(column, row))?;
        let normal = blend(weights, corners.map(|corner| corner.normal)).as_vec3();
        let depth = single(blend(weights, corners.map(|corner| corner.depth)));
        Some(Hit { distance, normal, depth, subject })
    }

    /// Draws a subject.
    pub(crate) fn draw(&mut self, subject: u32) {
        let projection = &self.projections[subject as usize];
        for (triangle, rows) in (0..).zip(projection.rows(self.part)) {
            if rows[0] < self.rows.end && self.rows.start < rows[1] {
                let corners = projection.corners(self.part, triangle);
                self.draw_triangle(subject, triangle, corners.map(|corner| corner.at));
            }
        }
    }

    /// Draws the samples of a triangle.
    fn draw_triangle(&mut self, subject: u32, triangle: u32, corners: [DVec3; 3]) {
        // Columns and rows of the triangle's box, within the layer.
        let frame = Aabb::of_points(corners);
        let columns = floor(frame.min.x)..floor(frame.max.x + 1.0).min(self.width);
        let [first, end] = rows_of(&corners);
        let rows = first.max(self.rows.start)..end.min(self.rows.end);

        // Beside the picture or before the near plane, there is nothing to draw.
        if columns.is_empty() || single(frame.max.z) < self.near {
            return;
        }
        let Some(outline) = Outline::new(corners) else { return };
        if self.samples.is_empty() {
            self.samples = vec![Sample::NONE; self.width * self.rows.len()];
        }

        // Samples are at the middles of their cells.
        let edges = outline.edges();
        for row in rows {
            let near = columns_at(&edges, middle(0, row).y);
            let start = (row - self.rows.start) * self.width;
            for column in near.start.max(columns.start)..near.end.min(columns.end) {
                let Some(weights) = outline.weights(middle(column, row)) else { continue };

                // A near plane cuts away what is before it.
                let distance = single(blend(weights, corners.map(|corner| corner.z)));
                let sample = &mut self.samples[start + column];
                if (self.near..sample.distance).contains(&distance) {
                    *sample = Sample { distance, triangle, subject };
                }
            }
        }
    }
}

/// Returns the middle of a cell.
fn middle(column: usize, row: usize) -> DVec2 {
    DVec2::new(float(column) + 0.5, float(row) + 0.5)
}

/// Outline of a projected triangle.
struct Outline {
    corners: [DVec2; 3],
    /// Reciprocal of twice its area, which is negative where it runs clockwise.
    share: f64,
}

impl Outline {
    /// Returns the outline of a triangle, or `None` where it is seen from its edge, and covers nothing.
    fn new(corners: [DVec3; 3]) -> Option<Self> {
        let corners @ [a, b, c] = corners.map(DVec3::truncate);
        let share = (b - a).perp_dot(c - a).recip();
        share.is_finite().then_some(Self { corners, share })
    }

    /// Returns the weights of the corners at a point; `None` outside.
    fn weights(&self, p: DVec2) -> Option<[f64; 3]> {
        let [a, b, c] = self.corners.map(|corner| corner - p);
        let opposite = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let weights = opposite.map(|area| area * self.share);
        weights.iter().all(|weight| *weight >= 0.0).then_some(weights)
    }

    /// Returns the edges, one after the other.
    fn edges(&self) -> [Edge; 3] {
        let [a, b, c] = self.corners;
        [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)]
    }
}

/// Edge of a projected triangle.
struct Edge {
    from: DVec2,
    /// Rows that it meets.
    low: f64,
    high: f64,
    /// Columns per row; not finite along a row.
    slope: f64,
}

impl Edge {
    fn new(from: DVec2, to: DVec2) -> Self {
        let slope = (to.x - from.x) / (to.y - from.y);
        Self { from, low: from.y.min(to.y), high: from.y.max(to.y), slope }
    }
}

/// Fraction of a sample beside a triangle that is tried as well: far more than rounding.
const MARGIN: f64 = 1e-3;

/// Returns the columns of the samples of a row that a triangle may cover.
fn columns_at(edges: &[Edge; 3], y: f64) -> Range<usize> {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for edge in edges {
        // Where the row meets the edge. An edge along it gives no number, which counts for nothing:
        // the other two end there.
        if edge.low <= y && y <= edge.high {
            let x = edge.from.x + (y - edge.from.y) * edge.slope;
            (left, right) = (left.min(x), right.max(x));
        }
    }
    // Samples are at the middles of their cells.
    floor(left + 0.5 - MARGIN)..floor(right + 0.5 + MARGIN)
}

/// Interpolates between values at the corners of a triangle.
fn blend<T: Mul<f64, Output = T> + Add<Output = T>>(weights: [f64; 3], values: [T; 3]) -> T {
    let [a, b, c] = values;
    a * weights[0] + b * weights[1] + c * weights[2]
}

impl Corner {
    fn new(point: &ContactPoint, camera: &Camera) -> Self {
        Self {
            at: camera.project(point.at),
            normal: camera.view_direction(point.normal),
            depth: point.depth,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Appearance, Color};
    use super::*;

    /// Finds the subject at each sample by intersecting its ray with every face.
    fn brute_force(subjects: &[Subject<'_>], camera: &Camera) -> Vec<Option<u32>> {
        let samples =
            (0..camera.height()).flat_map(|row| (0..camera.width()).map(move |c| (c, row)));
        samples
            .map(|(column, row)| {
                let p = DVec2::new(float(column) + 0.5, float(row) + 0.5);
                let mut nearest = (f64::INFINITY, None);
                for (number, subject) in (0..).zip(subjects) {
                    for face in subject.faces {
                        let at = face.map(|v| camera.project(subject.positions[v as usize]));
                        let [a, b, c] = at.map(DVec3::truncate);
                        let normal = (at[1] - at[0]).cross(at[2] - at[0]);
                        let sides = [
                            (b - a).perp_dot(p - a),
                            (c - b).perp_dot(p - b),
                            (a - c).perp_dot(p - c),
                        ];
                        let within =
                            sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
                        let depth = at[0].z - (normal.truncate()).dot(p - a) / normal.z;
                        if within && normal.z != 0.0 && depth < nearest.0 {
                            nearest = (depth, Some(number));
                        }
                    }
                }
                nearest.1
            })
            .collect()
    }

    #[test]
    fn the_nearest_surface_wins_whatever_the_order() {
        let positions = [
            DVec3::new(0.0, 0.0, 0.0),
            DVec3::new(4.0, 1.0, 1.0),
            DVec3::new(1.0, -1.0, 5.0),
            DVec3::new(4.0, -1.0, 4.0),
            DVec3::new(0.5, 0.5, 2.0),
        ];
        let normals = [DVec3::Z; 5];
        let face = |faces| Subject {
            positions: &positions,
            normals: &normals,
            faces,
            contact: &[],
            color: Color::WHITE,
            appearance: Appearance::Solid,
        };
        let subjects = [face(&[[0, 1, 2]]), face(&[[0, 3, 2], [4, 1, 3]])];
        let camera = Camera::framing(positions, DVec3::Y, DVec3::Z, [64, 48]);
        let expected = brute_force(&subjects, &camera);
        for order in [[0, 1], [1, 0]] {
            let projections = subjects.each_ref().map(|subject| Projection::new(subject, &camera));
            let mut layer = Layer::new(&projections, Part::Whole, &camera, 0..camera.height());
            for number in order {
                layer.draw(number);
            }
            let samples = 0..camera.width() * camera.height();
            let shown: Vec<Option<u32>> =
                samples.map(|sample| layer.hit(sample).map(|hit| hit.subject)).collect();
            assert_eq!(shown, expected);
            assert!(shown.contains(&Some(0)) && shown.contains(&Some(1)) && shown.contains(&None));
        }
    }

    #[test]
    fn contact_is_drawn_as_clipped() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::X + DVec3::Z];
        let point = |at: DVec3, depth| ContactPoint { at, normal: DVec3::NEG_Y, depth };
        let (deep, shallow) = (point(DVec3::ZERO, 1.0), |at| point(0.5 * at, 0.0));
        let subject = Subject {
            positions: &positions,
            normals: &[DVec3::NEG_Y; 4],
            faces: &[[0, 1, 2], [1, 3, 2]],
            contact: &[[deep, shallow(DVec3::X), shallow(DVec3::Z)]],
            color: Color::WHITE,
            appearance: Appearance::Solid,
        };
        let camera = Camera::framing(positions, DVec3::Y, DVec3::Z, [100, 100]);
        let projections = [Projection::new(&subject, &camera)];
        let mut layer = Layer::new(&projections, Part::Contact, &camera, 0..camera.height());
        layer.draw(0);

        // The square is 92 pixels wide; half an edge along both legs is an eighth of it, and the
        // mean depth over a triangle is that of its center.
        let samples = 0..camera.width() * camera.height();
        let hits: Vec<Hit> = samples.filter_map(|sample| layer.hit(sample)).collect();
        assert!(hits.len().abs_diff(92 * 92 / 8) < 60, "{}", hits.len());
        let mean = hits.iter().map(|hit| f64::from(hit.depth)).sum::<f64>() / float(hits.len());
        assert!((mean - 1.0 / 3.0).abs() < 0.01, "{mean}");
    }
}
