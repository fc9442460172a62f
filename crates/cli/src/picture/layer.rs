//! One layer of a picture: for each sample the nearest surface, if any.

use glam::{DVec2, DVec3};

use super::number::{float, floor, single};
use super::{Camera, Subject};

/// The surface that a sample shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    /// Samples into the picture; infinite where there is no surface.
    pub(super) distance: f32,
    /// As the viewer sees it: right, up, towards the viewer.
    pub(super) normal: [f32; 3],
    /// Inside another body, where positive.
    pub(super) depth: f32,
    /// Number of the subject.
    pub(super) subject: u32,
}

impl Hit {
    const NONE: Self = Self { distance: f32::INFINITY, normal: [0.0; 3], depth: 0.0, subject: 0 };

    pub(super) fn is_some(&self) -> bool {
        self.distance < f32::INFINITY
    }
}

/// Nearest hits of a grid of samples, row by row from the top.
#[derive(Debug)]
pub(super) struct Layer {
    width: usize,
    height: usize,
    hits: Vec<Hit>,
    /// What is nearer is not drawn.
    nearest_drawn: f32,
}

/// A corner of a triangle on its way into the picture.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: DVec3,
    normal: DVec3,
    depth: f64,
}

impl Layer {
    /// An empty layer of a camera's picture.
    pub(super) fn new(camera: &Camera) -> Self {
        let (width, height) = (camera.width(), camera.height());
        let nearest_drawn = single(camera.nearest_drawn());
        Self { width, height, hits: vec![Hit::NONE; width * height], nearest_drawn }
    }

    pub(super) fn hits(&self) -> &[Hit] {
        &self.hits
    }

    /// Draws the whole surface of a subject.
    pub(super) fn draw_all(&mut self, number: u32, subject: &Subject<'_>, camera: &Camera) {
        for face in subject.faces {
            let corners = face.map(|vertex| corner(subject, vertex, camera));
            self.draw(number, corners, |_| true);
        }
    }

    /// Draws where a subject is inside another, by interpolated gaps; of faces
    /// that cross another body without a corner inside, the whole.
    pub(super) fn draw_contact(&mut self, number: u32, subject: &Subject<'_>, camera: &Camera) {
        let enters = |face: [u32; 3]| face.iter().any(|&v| subject.signed_gaps[v as usize] < 0.0);
        for face in subject.faces.iter().filter(|face| enters(**face)) {
            let corners = face.map(|vertex| corner(subject, vertex, camera));
            self.draw(number, corners, |depth| depth > 0.0);
        }
        let crossing = subject.crossing.iter().map(|face| subject.faces[*face as usize]);
        for face in crossing.filter(|face| !enters(*face)) {
            let corners = face.map(|vertex| corner(subject, vertex, camera));
            self.draw(number, corners, |_| true);
        }
    }

    /// Draws the samples of a triangle whose interpolated depth passes.
    fn draw(&mut self, subject: u32, corners: [Corner; 3], shows: impl Fn(f64) -> bool) {
        let [a, b, c] = corners.map(|corner| corner.at.truncate());
        let area = (b - a).perp_dot(c - a);
        let Some((columns, rows)) = self.samples_in([a, b, c]).filter(|_| area != 0.0) else {
            return;
        };
        for row in rows {
            for column in columns.clone() {
                let p = DVec2::new(float(column) + 0.5, float(row) + 0.5);
                let weights = [
                    (b - p).perp_dot(c - p) / area,
                    (c - p).perp_dot(a - p) / area,
                    (a - p).perp_dot(b - p) / area,
                ];
                if weights.iter().all(|weight| *weight >= 0.0) {
                    self.keep(row * self.width + column, subject, &corners, weights, &shows);
                }
            }
        }
    }

    fn keep(
        &mut self,
        sample: usize,
        subject: u32,
        corners: &[Corner; 3],
        weights: [f64; 3],
        shows: impl Fn(f64) -> bool,
    ) {
        let blend = |value: fn(&Corner) -> f64| {
            weights.iter().zip(corners).map(|(weight, corner)| weight * value(corner)).sum::<f64>()
        };
        let distance = single(blend(|corner| corner.at.z));
        let depth = blend(|corner| corner.depth);
        let is_nearer = (self.nearest_drawn..self.hits[sample].distance).contains(&distance);
        if is_nearer && shows(depth) {
            let normal = [
                blend(|corner| corner.normal.x),
                blend(|corner| corner.normal.y),
                blend(|corner| corner.normal.z),
            ];
            let normal = normal.map(single);
            self.hits[sample] = Hit { distance, normal, depth: single(depth), subject };
        }
    }

    /// Columns and rows whose samples a triangle may cover.
    fn samples_in(
        &self,
        [a, b, c]: [DVec2; 3],
    ) -> Option<(std::ops::Range<usize>, std::ops::Range<usize>)> {
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let columns = floor(low.x)..floor(high.x + 1.0).min(self.width);
        let rows = floor(low.y)..floor(high.y + 1.0).min(self.height);
        (!columns.is_empty() && !rows.is_empty()).then_some((columns, rows))
    }
}

fn corner(subject: &Subject<'_>, vertex: u32, camera: &Camera) -> Corner {
    let vertex = vertex as usize;
    Corner {
        at: camera.project(subject.positions[vertex]),
        normal: camera.turn(subject.normals[vertex]),
        depth: -subject.signed_gaps[vertex],
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Appearance, Colour};
    use super::*;

    /// Which subject each sample shows, by looking along its ray at every face.
    fn slow(subjects: &[Subject<'_>], camera: &Camera) -> Vec<Option<u32>> {
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
            signed_gaps: &[1.0; 5],
            crossing: &[],
            colour: Colour::WHITE,
            appearance: Appearance::Solid,
        };
        let subjects = [face(&[[0, 1, 2]]), face(&[[0, 3, 2], [4, 1, 3]])];
        let camera = Camera::framing(positions.into_iter(), DVec3::Y, DVec3::Z, [64, 48]);
        let expected = slow(&subjects, &camera);
        for order in [[0, 1], [1, 0]] {
            let mut layer = Layer::new(&camera);
            for number in order {
                layer.draw_all(number, &subjects[number as usize], &camera);
            }
            let shown: Vec<Option<u32>> =
                layer.hits().iter().map(|hit| hit.is_some().then_some(hit.subject)).collect();
            assert_eq!(shown, expected);
            assert!(shown.contains(&Some(0)) && shown.contains(&Some(1)) && shown.contains(&None));
        }
    }

    #[test]
    fn only_what_is_inside_or_crosses_is_contact() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::X + DVec3::Z];
        let subject = Subject {
            positions: &positions,
            normals: &[DVec3::NEG_Y; 4],
            faces: &[[0, 1, 2], [1, 3, 2]],
            signed_gaps: &[-1.0, 1.0, 1.0, 1.0],
            crossing: &[],
            colour: Colour::WHITE,
            appearance: Appearance::Solid,
        };
        let camera = Camera::framing(positions.into_iter(), DVec3::Y, DVec3::Z, [100, 100]);
        let count = |subject: &Subject<'_>| {
            let mut layer = Layer::new(&camera);
            layer.draw_contact(0, subject, &camera);
            layer.hits().iter().filter(|hit| hit.is_some()).count()
        };
        // The square is 92 pixels wide; depth is positive in the quarter of the
        // first triangle within half an edge of its corner: an eighth of it.
        let eighth = 92 * 92 / 8;
        assert!(count(&subject).abs_diff(eighth) < 60, "{}", count(&subject));
        let crossing = Subject { crossing: &[1], ..subject };
        assert!(count(&crossing).abs_diff(5 * eighth) < 120, "{}", count(&crossing));
    }
}
