//! Pictures of contact: shaded surfaces with depth in colour, as PNG.
//!
//! A small rasteriser of our own, because a renderer that needs a graphics
//! device would keep the program from machines without one. Surfaces are drawn
//! into layers that keep the nearest hit of each pixel (`layer`), the layers
//! are shaded and laid over each other (`compose`), and the finished image is
//! averaged down from several samples a pixel (`image`).
//!
//! Overlap is out of sight from everywhere: where one body enters another, the
//! other's surface hides it. So penetrating parts have a layer of their own
//! that shines through what lies before it.

mod balls;
mod camera;
mod colour;
mod compose;
mod image;
mod layer;
mod normals;
mod number;
mod slice;

use glam::DVec3;

pub(crate) use self::balls::balls_and_error;
pub(crate) use self::camera::Camera;
pub(crate) use self::colour::{Colour, viridis};
use self::compose::Layers;
pub(crate) use self::image::Image;
pub(crate) use self::normals::vertex_normals;
pub(crate) use self::slice::slices;

/// How a body is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Appearance {
    /// As a solid thing.
    Solid,
    /// As a pane that shows its outline and lets everything through.
    Glass,
}

/// A body as a picture takes it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Subject<'a> {
    /// |V| positions.
    pub(crate) positions: &'a [DVec3],
    /// |V| unit normals.
    pub(crate) normals: &'a [DVec3],
    /// |F| × 3 corners.
    pub(crate) faces: &'a [[u32; 3]],
    /// |V| signed distances to other bodies, negative inside.
    pub(crate) signed_gaps: &'a [f64],
    /// Faces that cross another body's, ascending: drawn as contact even where
    /// no corner is inside.
    pub(crate) crossing: &'a [u32],
    pub(crate) colour: Colour,
    pub(crate) appearance: Appearance,
}

/// Samples along each side of a pixel: two would leave visible steps on the
/// slanted outlines of bones, four costs twice as much for little.
const SAMPLES: usize = 3;

/// Draws the subjects as `camera` sees them; `deepest` is the depth that the
/// top of the colour scale stands for.
pub(crate) fn draw(subjects: &[Subject<'_>], camera: &Camera, deepest: f64) -> Image {
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
    layers.compose(subjects, &fine, deepest).averaged(SAMPLES)
}
