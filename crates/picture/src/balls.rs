//! Picture of the balls in a surface, beside the surface in the colors of its distance
//! from them.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use medial::Ball;
use surface::{Aabb, vertex_normals};

use crate::{Appearance, Camera, Color, ContactPoint, ContactTriangle, Image, Subject, draw};

/// Maximum size of each of the two pictures, in pixels.
const MAX_SIZE: [usize; 2] = [520, 640];

/// Rings of a drawn ball from pole to pole, and corners of each ring: enough for a round
/// outline at the size of a ball among a hundred.
const RINGS: u16 = 14;
const CORNERS: u16 = 28;

/// Draws balls within the surface as glass, and the surface with the magnitude of
/// `distances` (|V|) in color, from dark for 0 to light for the maximum.
#[must_use]
pub fn draw_balls_and_error(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    balls: &[Ball],
    distances: &[f64],
) -> Image {
    // The balls in the surface.
    let camera = camera(positions);
    let normals = vertex_normals(faces, positions);
    let surface = Subject {
        positions,
        normals: &normals,
        faces,
        contact: &[],
        color: Color::from_srgb([0x8f, 0xae, 0xc8]),
        appearance: Appearance::Glass,
    };
    let spheres = Spheres::new(balls);
    let within = draw(&[spheres.subject(), surface], &camera, 1.0);

    // The whole surface is drawn like contact, in the colors of its distance.
    let mut points = Vec::with_capacity(positions.len());
    let mut max = 0.0_f64;
    for ((&at, &normal), distance) in positions.iter().zip(&normals).zip(distances) {
        let depth = distance.abs();
        points.push(ContactPoint { at, normal, depth });
        max = max.max(depth);
    }
    let mut contact: Vec<ContactTriangle> = Vec::with_capacity(faces.len());
    for face in faces {
        contact.push(face.map(|vertex| points[vertex as usize]));
    }
    let colored = Subject { contact: &contact, appearance: Appearance::Solid, ..surface };
    Image::beside(&[within, draw(&[colored], &camera, max)])
}

/// Returns a view along the shortest side of the box around the points, the longest
/// upright.
fn camera(points: &[DVec3]) -> Camera {
    let sides = Aabb::of_points(points.iter().copied()).sides();
    let mut axes = DVec3::AXES;
    axes.sort_by(|a, b| sides.dot(*a).total_cmp(&sides.dot(*b)));
    Camera::framing(points.iter().copied(), axes[0], axes[2], MAX_SIZE)
}

/// Triangulation of all balls as one surface.
#[derive(Default)]
struct Spheres {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

impl Spheres {
    fn new(balls: &[Ball]) -> Self {
        let (unit, corners) = unit_sphere();
        let mut all = Self::default();
        for (first, ball) in (0_u32..).step_by(unit.len()).zip(balls) {
            for &normal in &unit {
                all.positions.push(ball.center + ball.radius * normal);
            }
            all.normals.extend(&unit);
            for face in &corners {
                all.faces.push(face.map(|corner| first + corner));
            }
        }
        all
    }

    fn subject(&self) -> Subject<'_> {
        Subject {
            positions: &self.positions,
            normals: &self.normals,
            faces: &self.faces,
            contact: &[],
            color: Color::from_srgb([0xd6, 0x8c, 0x80]),
            appearance: Appearance::Solid,
        }
    }
}

/// Triangulates the unit sphere by meridians and parallels.
fn unit_sphere() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    // The first and last ring are the poles: their points coincide, and keep the numbering even.
    let mut points = Vec::new();
    for ring in 0..=RINGS {
        let (sin, cos) = (PI * f64::from(ring) / f64::from(RINGS)).sin_cos();
        for corner in 0..CORNERS {
            let (y, x) = (TAU * f64::from(corner) / f64::from(CORNERS)).sin_cos();
            points.push(DVec3::new(sin * x, sin * y, cos));
        }
    }

    // Two triangles per cell; the last cell of a ring ends at its first point.
    let mut faces = Vec::new();
    let around = u32::from(CORNERS);
    for ring in 0..u32::from(RINGS) {
        for corner in 0..around {
            let (from, next) = (ring * around + corner, ring * around + (corner + 1) % around);
            faces.push([from, from + around, next]);
            faces.push([next, from + around, next + around]);
        }
    }
    (points, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawn_ball_is_round_and_closed() {
        let (points, faces) = unit_sphere();
        assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 1e-12));
        let corner = |vertex: u32| points[vertex as usize];
        let volume: f64 =
            faces.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum();
        assert!((volume / (4.0 / 3.0 * PI) - 1.0).abs() < 0.04, "{volume}");
    }

    #[test]
    fn pictures_depend_on_balls_and_on_distances() {
        let (unit, faces) = unit_sphere();
        let distances: Vec<f64> = unit.iter().map(|p| 0.2 * p.z).collect();
        let draw = |radius: f64, distances: &[f64]| {
            let ball = Ball { center: DVec3::ZERO, radius };
            draw_balls_and_error(&unit, &faces, &[ball], distances)
        };
        let image = draw(0.5, &distances);
        assert_ne!(image, draw(0.4, &distances), "another ball");
        assert_ne!(image, draw(0.5, &vec![0.2; distances.len()]), "another error");
    }
}
