//! Balls in a surface, and beside it the surface in the colours of its distance
//! from them.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{Appearance, Camera, Colour, Image, Subject, draw, vertex_normals};

/// Pixels that each of the two pictures may take.
const SIZE: [usize; 2] = [520, 640];

/// Rings of a drawn ball from pole to pole, and corners of each: outlines look
/// round at the size that a ball has among a hundred.
const RINGS: u16 = 14;
const CORNERS: u16 = 28;

/// Draws `balls` (centres and radii) within the surface as a pane, and the surface
/// with the size of `distances` (|V|) in colour, from dark for none to light for the
/// largest.
pub(crate) fn balls_and_error(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    balls: &[(DVec3, f64)],
    distances: &[f64],
) -> Image {
    let normals = vertex_normals(positions, faces);
    let nowhere = vec![1.0; positions.len()];
    let surface = Subject {
        positions,
        normals: &normals,
        faces,
        signed_gaps: &nowhere,
        crossing: &[],
        colour: Colour::from_srgb([0x8f, 0xae, 0xc8]),
        appearance: Appearance::Glass,
    };
    let balls = Balls::new(balls);
    let camera = camera(positions);
    let within = draw(&[balls.subject(), surface], &camera, 1.0);

    let sizes: Vec<f64> = distances.iter().map(|distance| distance.abs()).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    // What is drawn as contact has a depth above 0.
    let least = largest.max(f64::MIN_POSITIVE) * 1e-6;
    let depths: Vec<f64> = sizes.iter().map(|size| -size.max(least)).collect();
    let coloured = Subject { signed_gaps: &depths, appearance: Appearance::Solid, ..surface };
    Image::beside(&[within, draw(&[coloured], &camera, largest)])
}

/// Along the shortest side of the box around the points, the longest upright.
fn camera(points: &[DVec3]) -> Camera {
    let low = points.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let size = high - low;
    let mut axes = DVec3::AXES;
    axes.sort_by(|a, b| size.dot(*a).total_cmp(&size.dot(*b)));
    Camera::framing(points.iter().copied(), axes[0], axes[2], SIZE)
}

/// All balls as one surface.
struct Balls {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    nowhere: Vec<f64>,
}

impl Balls {
    fn new(balls: &[(DVec3, f64)]) -> Self {
        let (unit, corners) = sphere();
        let mut all = Self {
            positions: Vec::new(),
            normals: Vec::new(),
            faces: Vec::new(),
            nowhere: vec![1.0; unit.len() * balls.len()],
        };
        for (first, &(center, radius)) in (0_u32..).step_by(unit.len()).zip(balls) {
            all.positions.extend(unit.iter().map(|normal| center + radius * *normal));
            all.normals.extend(&unit);
            all.faces.extend(corners.iter().map(|face| face.map(|corner| first + corner)));
        }
        all
    }

    fn subject(&self) -> Subject<'_> {
        Subject {
            positions: &self.positions,
            normals: &self.normals,
            faces: &self.faces,
            signed_gaps: &self.nowhere,
            crossing: &[],
            colour: Colour::from_srgb([0xd6, 0x8c, 0x80]),
            appearance: Appearance::Solid,
        }
    }
}

/// A unit sphere of meridians and parallels.
fn sphere() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut points = Vec::new();
    for ring in 0..=RINGS {
        let (sin, cos) = (PI * f64::from(ring) / f64::from(RINGS)).sin_cos();
        for corner in 0..CORNERS {
            let (y, x) = (TAU * f64::from(corner) / f64::from(CORNERS)).sin_cos();
            points.push(DVec3::new(sin * x, sin * y, cos));
        }
    }
    let mut faces = Vec::new();
    for ring in 0..u32::from(RINGS) {
        for corner in 0..u32::from(CORNERS) {
            let around = u32::from(CORNERS);
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
        let (points, faces) = sphere();
        assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 1e-12));
        let corner = |vertex: u32| points[vertex as usize];
        let volume: f64 =
            faces.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum();
        assert!((volume / (4.0 / 3.0 * PI) - 1.0).abs() < 0.04, "{volume}");
    }

    #[test]
    fn errors_are_told_apart_and_balls_show() {
        let (unit, faces) = sphere();
        let distances: Vec<f64> = unit.iter().map(|p| 0.2 * p.z).collect();
        let draw = |balls: &[(DVec3, f64)], distances: &[f64]| {
            balls_and_error(&unit, &faces, balls, distances)
        };
        let image = draw(&[(DVec3::ZERO, 0.5)], &distances);
        assert_ne!(image, draw(&[(DVec3::ZERO, 0.4)], &distances), "another ball");
        let even = vec![0.2; distances.len()];
        assert_ne!(image, draw(&[(DVec3::ZERO, 0.5)], &even), "another error");
    }
}
