//! Rasterizer of shaded surfaces with depth in color, as PNG.
//!
//! It needs no graphics device, so the program runs on machines without one. Surfaces are
//! drawn into depth-buffered layers (`layer`), the layers are shaded and blended
//! (`compose`), and the image is averaged down from several samples per pixel
//! (`image`).
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

pub use self::balls::draw_balls_and_error;
pub use self::camera::Camera;
pub use self::color::{Color, viridis};
use self::compose::Layers;
pub use self::image::Image;
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

/// Draws surfaces; the top of the color map stands for `max_depth`.
#[must_use]
pub fn draw(subjects: &[Subject<'_>], camera: &Camera, max_depth: f64) -> Image {
    // All surfaces into the layers of their materials.
    let fine = camera.with_samples(SAMPLES);
    let mut layers = Layers::new(&fine);
    for (number, subject) in (0..).zip(subjects) {
        match subject.appearance {
            Appearance::Solid => {
                layers.solid.draw_all(number, subject, &fine);
                layers.contact.draw_contact(number, subject, &fine);
            }
            Appearance::Glass => layers.glass.draw_all(number, subject, &fine),
        }
    }

    layers.compose(subjects, &fine, max_depth).averaged(SAMPLES)
}
