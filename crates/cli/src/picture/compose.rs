//! Layers into colours: light, outlines, glass, and contact that shines
//! through.

use super::colour::{Colour, viridis};
use super::image::Image;
use super::layer::{Hit, Layer};
use super::number::{float, single};
use super::{Camera, Subject};

/// What a picture is made of, front and back of each other by distance alone.
#[derive(Debug)]
pub(super) struct Layers {
    pub(super) solid: Layer,
    pub(super) glass: Layer,
    pub(super) contact: Layer,
}

/// How strongly contact shows through a solid that hides it: enough to read
/// the scale, little enough to see that it is hidden.
const SHINES_THROUGH: f64 = 0.82;

/// How much of the glass's own colour lies on what is behind it, seen face on
/// and seen along the pane.
const GLASS_FACE_ON: f64 = 0.16;
const GLASS_EDGE_ON: f64 = 0.75;

/// A jump between neighbouring samples above which an outline is drawn, as a
/// share of the picture's height: between folds of a surface and gaps between
/// bodies.
const OUTLINE_JUMP: f32 = 0.004;

impl Layers {
    pub(super) fn new(camera: &Camera) -> Self {
        let layer = || Layer::new(camera);
        Self { solid: layer(), glass: layer(), contact: layer() }
    }

    /// The colour of every sample.
    pub(super) fn compose(&self, subjects: &[Subject<'_>], camera: &Camera, deepest: f64) -> Image {
        let width = camera.width();
        let jump = OUTLINE_JUMP * single(float(camera.height()));
        let mut image = Image::new(width, camera.height());
        for (sample, colour) in image.samples_mut().iter_mut().enumerate() {
            let solid = self.solid.hits()[sample];
            *colour = Colour::WHITE;
            if solid.is_some() {
                let outline = outline(self.solid.hits(), sample, width, jump);
                *colour = lit(subjects[solid.subject as usize].colour, &solid) * outline;
            }
            *colour = self.with_contact(*colour, sample, deepest);
            *colour = self.with_glass(*colour, sample, subjects);
        }
        image
    }

    fn with_contact(&self, behind: Colour, sample: usize, deepest: f64) -> Colour {
        let (contact, solid) = (self.contact.hits()[sample], self.solid.hits()[sample]);
        if !contact.is_some() {
            return behind;
        }
        let share = if deepest > 0.0 { f64::from(contact.depth) / deepest } else { 0.0 };
        // Half lit: the scale must stay legible, the shape too.
        let colour = viridis(share);
        let colour = (colour + lit(colour, &contact)) * 0.5;
        let is_hidden = solid.distance < contact.distance - 0.5;
        behind.under(colour, if is_hidden { SHINES_THROUGH } else { 1.0 })
    }

    fn with_glass(&self, behind: Colour, sample: usize, subjects: &[Subject<'_>]) -> Colour {
        let (glass, solid) = (self.glass.hits()[sample], self.solid.hits()[sample]);
        if !glass.is_some() || glass.distance > solid.distance {
            return behind;
        }
        let grazing = 1.0 - f64::from(glass.normal[2]).abs().min(1.0);
        let share = GLASS_FACE_ON + (GLASS_EDGE_ON - GLASS_FACE_ON) * grazing.powi(3);
        behind.under(subjects[glass.subject as usize].colour, share)
    }
}

/// Directions from which light comes, right, up and towards the viewer, and
/// how strong it is: one from the upper left, a weaker one from the right.
const LIGHTS: [([f64; 3], f64); 2] = [([-0.45, 0.62, 0.64], 0.62), ([0.80, 0.05, 0.60], 0.22)];

/// A matt surface under two lights and an even sky. Both sides of a face are
/// lit alike: open sheets are seen from both.
fn lit(colour: Colour, hit: &Hit) -> Colour {
    let normal = hit.normal.map(f64::from);
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    let side = if normal[2] < 0.0 { -1.0 } else { 1.0 };
    let normal = normal.map(|x| side * x / length);
    let direct: f64 = LIGHTS
        .iter()
        .map(|(direction, strength)| {
            let cosine: f64 = direction.iter().zip(normal).map(|(l, n)| l * n).sum();
            strength * cosine.max(0.0)
        })
        .sum();
    let sky = 0.26 + 0.08 * normal[1];
    colour * (direct + sky)
}

/// Darkens the farther side of a jump in distance.
fn outline(hits: &[Hit], sample: usize, width: usize, jump: f32) -> f64 {
    let here = hits[sample].distance;
    let neighbours =
        [sample.checked_sub(1), Some(sample + 1), sample.checked_sub(width), Some(sample + width)];
    let is_behind = neighbours
        .into_iter()
        .flatten()
        .filter_map(|neighbour| hits.get(neighbour))
        .any(|neighbour| here - neighbour.distance > jump || !neighbour.is_some());
    if is_behind { 0.45 } else { 1.0 }
}
