//! Rasterizer of shaded surfaces with depth in color, as PNG.
//!
//! It needs no graphics device, so the program runs on machines without one. Band by band,
//! surfaces are drawn into depth-buffered layers of several samples per pixel (`layer`), which are
//! shaded, blended and averaged (`compose`) to an image (`image`).
//!
//! Overlap is hidden from every side: where one body enters another, the other's surface
//! covers it. So the parts inside another body, clipped at the curve in which the surfaces
//! cross, have a layer of their own, which shines through nearer surfaces.

mod balls;
mod camera;
mod cast;
mod color;
mod compose;
mod image;
mod layer;
mod slice;

use glam::DVec3;
use surface::parallel;

pub use self::balls::draw_balls_and_error;
pub use self::camera::Camera;
pub use self::color::{Color, viridis};
use self::compose::Layers;
pub use self::image::Image;
use self::layer::Projection;
pub use self::slice::draw_slices;

/// Material of a drawn surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Appearance {
    /// Opaque, with its contact in color.
    Solid,
    /// Transparent pane with an outline.
    Glass,
}

/// Surface of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// |V| positions.
    pub positions: &'a [DVec3],
    /// |V| unit normals.
    pub normals: &'a [DVec3],
    /// |F| × 3 corners.
    pub faces: &'a [[u32; 3]],
    /// Parts of the surface inside other bodies.
    pub contact: &'a [ContactTriangle],
    /// Color where nothing is in contact.
    pub color: Color,
    /// Material.
    pub appearance: Appearance,
}

/// Part of a surface inside another body, small enough for its depth to be interpolated.
pub type ContactTriangle = [ContactPoint; 3];

/// Point of a surface inside another body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Position.
    pub at: DVec3,
    /// Normal of the surface.
    pub normal: DVec3,
    /// Distance from the other body's surface.
    pub depth: f64,
}

/// Samples along each side of a pixel: two would leave visible steps on the slanted
/// outlines of bones, four take twice as long for little.
const SAMPLES: usize = 3;

/// Rows of pixels that a thread draws at once: the layers of their samples have the memory of a few pictures.
const BAND: usize = 64;

/// Draws surfaces; the top of the color map stands for `max_depth`.
#[must_use]
pub fn draw(subjects: &[Subject<'_>], camera: &Camera, max_depth: f64) -> Image {
    draw_in_bands(subjects, camera, max_depth, BAND)
}

fn draw_in_bands(subjects: &[Subject<'_>], camera: &Camera, max_depth: f64, rows: usize) -> Image {
    let fine = camera.with_samples(SAMPLES);
    let projections: Vec<Projection<'_>> =
        subjects.iter().map(|subject| Projection::new(subject, &fine)).collect();

    let draw_band = |band: usize| {
        let (first, end) = (band * rows, ((band + 1) * rows).min(camera.height()));
        let samples = SAMPLES * first..SAMPLES * end;
        let layers = Layers::draw(subjects, &projections, &fine, samples);
        layers.compose(subjects, &fine, max_depth, SAMPLES)
    };
    let mut image = Image::new(camera.width(), 0);
    for band in parallel::map(camera.height().div_ceil(rows), draw_band) {
        image.add_below(&band);
    }
    image
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::icosphere;

    use super::*;

    #[test]
    fn pixels_are_means_of_their_samples_in_linear_light() {
        let black = Color::from_srgb([0; 3]);
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Z, DVec3::X + DVec3::Z];
        let subject = Subject {
            positions: &positions,
            normals: &[DVec3::NEG_Y; 4],
            faces: &[[0, 1, 2], [1, 3, 2]],
            contact: &[],
            color: black,
            appearance: Appearance::Solid,
        };
        let share = |count| (Color::WHITE * (f64::from(count) / 9.0)).to_srgb();
        assert_eq!(share(3), [156; 3]);
        let mut shares = std::collections::BTreeSet::new();
        for size in 30..42 {
            let camera = Camera::framing(positions, DVec3::Y, DVec3::Z, [size, size]);
            for color in draw(&[subject], &camera, 0.0).pixels_mut() {
                let found = (0..=9).find(|count| share(*count) == color.to_srgb());
                shares.insert(found.expect("a number of white samples"));
            }
        }
        assert!(shares.len() > 3, "{shares:?}");
    }

    #[test]
    fn bands_are_parts_of_the_whole_picture() {
        let balls = [2.0, 1.4, 1.9].map(|radius| icosphere(radius, 2));
        let point = |p: &DVec3| ContactPoint { at: *p, normal: p.normalize(), depth: p.x.abs() };
        let contact: Vec<ContactTriangle> = balls[1]
            .faces
            .iter()
            .map(|face| face.map(|corner| point(&balls[1].positions[corner as usize])))
            .collect();
        let mut subjects = Vec::new();
        for (ball, appearance) in
            balls.iter().zip([Appearance::Glass, Appearance::Solid, Appearance::Solid])
        {
            subjects.push(Subject {
                positions: &ball.positions,
                normals: &ball.positions,
                faces: &ball.faces,
                contact: &contact,
                color: Color::WHITE,
                appearance,
            });
        }

        let points = balls[0].positions.iter().copied();
        let camera = Camera::framing(points, DVec3::new(1.0, 2.0, 0.5), DVec3::Z, [50, 41]);
        let whole = draw_in_bands(&subjects, &camera, 2.0, usize::MAX);
        for rows in [1, 2, 7, 40] {
            assert_eq!(draw_in_bands(&subjects, &camera, 2.0, rows), whole, "{rows} rows");
        }
    }
}
