//! Shading and blending of layers: light, outlines, glass, and contact that shines
//! through.

use std::ops::Range;

use glam::DVec3;

use crate::cast::{float, single};
use crate::color::{Color, viridis};
use crate::image::Image;
use crate::layer::{Hit, Layer, Part, Projection};
use crate::{Appearance, Camera, Subject};

/// Layers of a band of a picture, ordered at each sample by distance alone.
#[derive(Debug)]
pub(crate) struct Layers<'a> {
    solid: Layer<'a>,
    glass: Layer<'a>,
    contact: Layer<'a>,
    /// Samples of the band, without those around it that its outlines need.
    shown: Range<usize>,
}

/// Opacity of contact behind a solid: high enough to read the color map, low enough to
/// show that the contact is hidden.
const HIDDEN_CONTACT_OPACITY: f64 = 0.82;

/// Opacity of glass at normal and at grazing incidence.
const GLASS_FACE_ON: f64 = 0.16;
const GLASS_EDGE_ON: f64 = 0.75;

/// Minimum jump in distance between neighboring samples that is outlined, as a fraction of
/// the picture's height: more than a fold of a surface, less than a gap between bodies.
const OUTLINE_JUMP: f32 = 0.004;

/// Brightness of an outline.
const OUTLINE_SHADE: f64 = 0.45;

impl<'a> Layers<'a> {
    /// Draws surfaces into the layers of their materials, within some rows of the picture.
    pub(crate) fn draw(
        subjects: &[Subject<'_>],
        projections: &'a [Projection<'a>],
        camera: &Camera,
        rows: Range<usize>,
    ) -> Self {
        // Outlines look at the rows above and below.
        let drawn = rows.start.saturating_sub(1)..(rows.end + 1).min(camera.height());
        let shown = [rows.start, rows.end].map(|row| (row - drawn.start) * camera.width());
        let layer = |part| Layer::new(projections, part, camera, drawn.clone());
        let (mut solid, mut glass) = (layer(Part::Whole), layer(Part::Whole));
        let mut contact = layer(Part::Contact);

        for (number, subject) in (0..).zip(subjects) {
            match subject.appearance {
                Appearance::Solid => {
                    solid.draw(number);
                    contact.draw(number);
                }
                Appearance::Glass => glass.draw(number),
            }
        }
        Self { solid, glass, contact, shown: shown[0]..shown[1] }
    }

    /// Computes the colors of pixels, each the mean of `side` × `side` samples in linear light.
    pub(crate) fn compose(
        &self,
        subjects: &[Subject<'_>],
        camera: &Camera,
        max_depth: f64,
        side: usize,
    ) -> Image {
        let (width, columns) = (camera.width(), camera.width() / side);
        let share = 1.0 / float(side * side);
        let mut image = Image::new(columns, self.shown.len() / width / side);
        for (pixel, color) in image.pixels_mut().iter_mut().enumerate() {
            let first = self.shown.start + pixel / columns * side * width + pixel % columns * side;
            let mut sum = Color::WHITE * 0.0;
            for row in 0..side {
                for sample in first + row * width..first + row * width + side {
                    sum = sum + self.color(sample, subjects, camera, max_depth);
                }
            }
            *color = sum * share;
        }
        image
    }

    /// Computes the color of a sample.
    fn color(
        &self,
        sample: usize,
        subjects: &[Subject<'_>],
        camera: &Camera,
        max_depth: f64,
    ) -> Color {
        // What is opaque first, with its outline.
        let mut color = Color::WHITE;
        let solid = self.solid.hit(sample);
        if let Some(solid) = &solid {
            color = lit(subjects[solid.subject as usize].color, solid);
            let jump = OUTLINE_JUMP * single(float(camera.height()));
            if is_outline(&self.solid, sample, camera.width(), jump) {
                color = color * OUTLINE_SHADE;
            }
        }

        // Contact shines through it, and glass may be before both.
        let distance = solid.map_or(f32::INFINITY, |solid| solid.distance);
        if let Some(contact) = self.contact.hit(sample) {
            color = under_contact(color, distance, &contact, max_depth);
        }
        if let Some(glass) = self.glass.hit(sample).filter(|glass| glass.distance <= distance) {
            color = under_glass(color, &glass, subjects);
        }
        color
    }
}

/// Blends contact over what is behind it, or before it at some distance.
fn under_contact(color: Color, distance: f32, contact: &Hit, max_depth: f64) -> Color {
    // Half lit, so that both the color map and the shape stay legible.
    let fraction = if max_depth > 0.0 { f64::from(contact.depth) / max_depth } else { 0.0 };
    let map = viridis(fraction);
    let map = (map + lit(map, contact)) * 0.5;

    // A sample's width before the contact counts as its own surface.
    let is_hidden = distance < contact.distance - 0.5;
    color.under(map, if is_hidden { HIDDEN_CONTACT_OPACITY } else { 1.0 })
}

/// Blends glass over what is behind it.
fn under_glass(color: Color, glass: &Hit, subjects: &[Subject<'_>]) -> Color {
    // The outline of glass is denser than its middle.
    let grazing = 1.0 - f64::from(glass.normal.z).abs().min(1.0);
    let opacity = GLASS_FACE_ON + (GLASS_EDGE_ON - GLASS_FACE_ON) * grazing.powi(3);
    color.under(subjects[glass.subject as usize].color, opacity)
}

/// Directions to the lights (right, up, towards the viewer) with their strengths: one at
/// the upper left, a weaker one at the right.
const LIGHTS: [(DVec3, f64); 2] =
    [(DVec3::new(-0.45, 0.62, 0.64), 0.62), (DVec3::new(0.80, 0.05, 0.60), 0.22)];

/// Shades a matt surface under two lights and an even sky.
///
/// Both sides of a face are lit alike, since open sheets show both.
fn lit(color: Color, hit: &Hit) -> Color {
    let normal = hit.normal.as_dvec3().normalize_or_zero();
    let normal = if normal.z < 0.0 { -normal } else { normal };

    // The sky is a little brighter than the ground.
    let mut light = 0.26 + 0.08 * normal.y;
    for (direction, strength) in LIGHTS {
        light += strength * direction.dot(normal).max(0.0);
    }
    color * light
}

/// Returns true on the farther side of a jump in distance.
fn is_outline(layer: &Layer<'_>, sample: usize, width: usize, jump: f32) -> bool {
    let Some(here) = layer.distance(sample) else { return false };
    for neighbor in [sample.wrapping_sub(1), sample + 1, sample.wrapping_sub(width), sample + width]
    {
        // Beyond the picture there is no neighbor.
        let Some(distance) = layer.distance(neighbor) else { continue };
        if here - distance > jump || distance == f32::INFINITY {
            return true;
        }
    }
    false
}
