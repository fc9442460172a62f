//! Depth-buffered layer of a picture: the nearest surface per sample.

use std::ops::{Add, Mul, Range};

use glam::{DVec2, DVec3, Vec3};
use surface::Aabb;

use crate::cast::{float, floor, single};
use crate::{Camera, ContactPoint, Subject};

/// Surface at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// Distance into the picture, in samples; infinite without a surface.
    pub(crate) distance: f32,
    /// Normal in the view: right, up, towards the viewer.
    pub(crate) normal: Vec3,
    /// Depth inside another body, where positive.
    pub(crate) depth: f32,
    /// Number of the subject.
    pub(crate) subject: u32,
}

impl Hit {
    const NONE: Self = Self { distance: f32::INFINITY, normal: Vec3::ZERO, depth: 0.0, subject: 0 };

    pub(crate) fn is_some(&self) -> bool {
        self.distance < f32::INFINITY
    }
}

/// Nearest hits of some rows of samples, row by row from the top.
#[derive(Debug)]
pub(crate) struct Layer {
    width: usize,
    /// Numbers of the rows in the picture.
    rows: Range<usize>,
    hits: Vec<Hit>,
    /// Distance of the near plane.
    near: f32,
}

/// Surface of a subject, in samples.
#[derive(Debug)]
pub(crate) struct Projection<'a> {
    subject: &'a Subject<'a>,
    /// |V| corners.
    corners: Vec<Corner>,
    /// |F| first rows and ends of faces.
    rows: Vec<[usize; 2]>,
    /// Parts inside other bodies.
    contact: Vec<[Corner; 3]>,
}

/// Projected corner of a triangle.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: DVec3,
    normal: DVec3,
    depth: f64,
}

impl<'a> Projection<'a> {
    pub(crate) fn new(subject: &'a Subject<'a>, camera: &Camera) -> Self {
        let mut corners = Vec::with_capacity(subject.positions.len());
        for (&at, &normal) in subject.positions.iter().zip(subject.normals) {
            corners.push(Corner::new(&ContactPoint { at, normal, depth: 0.0 }, camera));
        }
        let mut rows = Vec::with_capacity(subject.faces.len());
        for face in subject.faces {
            rows.push(rows_of(&face.map(|vertex| corners[vertex as usize])));
        }
        let mut contact = Vec::with_capacity(subject.contact.len());
        for triangle in subject.contact {
            contact.push(triangle.each_ref().map(|point| Corner::new(point, camera)));
        }
        Self { subject, corners, rows, contact }
    }
}

/// Returns the first row of a triangle and the end of its rows.
fn rows_of(corners: &[Corner; 3]) -> [usize; 2] {
    let [a, b, c] = corners.each_ref().map(|corner| corner.at.y);
    [floor(a.min(b).min(c)), floor(a.max(b).max(c) + 1.0)]
}

impl Layer {
    /// Returns an empty layer of some rows of a camera's picture.
    pub(crate) fn new(camera: &Camera, rows: Range<usize>) -> Self {
        let width = camera.width();
        let hits = vec![Hit::NONE; width * rows.len()];
        Self { width, rows, hits, near: single(camera.near()) }
    }

    pub(crate) fn hits(&self) -> &[Hit] {
        &self.hits
    }

    /// Draws the whole surface of a subject.
    pub(crate) fn draw_all(&mut self, number: u32, projection: &Projection<'_>) {
        for (face, rows) in projection.subject.faces.iter().zip(&projection.rows) {
            if rows[0] < self.rows.end && self.rows.start < rows[1] {
                self.draw(number, face.map(|vertex| projection.corners[vertex as usize]));
            }
        }
    }

    /// Draws the parts of a subject inside other bodies.
    pub(crate) fn draw_contact(&mut self, number: u32, projection: &Projection<'_>) {
        for &corners in &projection.contact {
            self.draw(number, corners);
        }
    }

    /// Draws the samples of a triangle.
    fn draw(&mut self, subject: u32, corners: [Corner; 3]) {
        // Columns and rows of the triangle's box, within the layer.
        let frame = Aabb::of_points(corners.map(|corner| corner.at));
        let columns = floor(frame.min.x)..floor(frame.max.x + 1.0).min(self.width);
        let [first, end] = rows_of(&corners);
        let rows = first.max(self.rows.start)..end.min(self.rows.end);

        // A triangle seen from its edge covers nothing, nor does one before the near plane.
        let [a, b, c] = corners.map(|corner| corner.at.truncate());
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 || single(frame.max.z) < self.near {
            return;
        }

        // Samples are at the middles of their cells, with the areas opposite as weights.
        let side = area.signum();
        for row in rows {
            let y = float(row) + 0.5;
            let near = columns_at([a, b, c], y);
            for column in near.start.max(columns.start)..near.end.min(columns.end) {
                let p = DVec2::new(float(column) + 0.5, y);
                let areas =
                    [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)];
                if areas.iter().all(|part| part * side >= 0.0) {
                    let sample = (row - self.rows.start) * self.width + column;
                    self.keep_nearer(sample, subject, &corners, areas.map(|part| part / area));
                }
            }
        }
    }

    /// Replaces the hit of a sample by a nearer point of a triangle that is not before the near
    /// plane.
    fn keep_nearer(
        &mut self,
        sample: usize,
        subject: u32,
        corners: &[Corner; 3],
        weights: [f64; 3],
    ) {
        // A near plane cuts away what is before it.
        let distance = single(blend(weights, corners.map(|corner| corner.at.z)));
        if (self.near..self.hits[sample].distance).contains(&distance) {
            let normal = blend(weights, corners.map(|corner| corner.normal)).as_vec3();
            let depth = single(blend(weights, corners.map(|corner| corner.depth)));
            self.hits[sample] = Hit { distance, normal, depth, subject };
        }
    }
}

/// Returns the columns of the samples of a row that a triangle may cover, with one more to either
/// side, which is far more than rounding.
fn columns_at([a, b, c]: [DVec2; 3], y: f64) -> Range<usize> {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for [from, to] in [[a, b], [b, c], [c, a]] {
        // Where the row meets an edge. An edge along it gives no number, which counts for nothing:
        // the other two end there.
        if from.y.min(to.y) <= y && y <= from.y.max(to.y) {
            let x = from.x + (y - from.y) / (to.y - from.y) * (to.x - from.x);
            (left, right) = (left.min(x), right.max(x));
        }
    }
    floor(left - 1.0)..floor(right + 2.0)
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
            let mut layer = Layer::new(&camera, 0..camera.height());
            for number in order {
                let projection = Projection::new(&subjects[number as usize], &camera);
                layer.draw_all(number, &projection);
            }
            let shown: Vec<Option<u32>> =
                layer.hits().iter().map(|hit| hit.is_some().then_some(hit.subject)).collect();
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
        let mut layer = Layer::new(&camera, 0..camera.height());
        layer.draw_contact(0, &Projection::new(&subject, &camera));

        // The square is 92 pixels wide; half an edge along both legs is an eighth of it, and the
        // mean depth over a triangle is that of its center.
        let hits: Vec<&Hit> = layer.hits().iter().filter(|hit| hit.is_some()).collect();
        assert!(hits.len().abs_diff(92 * 92 / 8) < 60, "{}", hits.len());
        let mean = hits.iter().map(|hit| f64::from(hit.depth)).sum::<f64>() / float(hits.len());
        assert!((mean - 1.0 / 3.0).abs() < 0.01, "{mean}");
    }
}
