//! Colors of bodies in pictures.

use musculo_collide::{BodyKind, Scene};

use picture::Color;

/// Returns a color per body: bone, flesh or sheet, neighbors of one kind in different
/// shades.
pub(super) fn colors(scene: &Scene) -> Vec<Color> {
    const SHADES: [f64; 5] = [1.0, 0.80, 1.16, 0.90, 0.72];
    let mut colors = Vec::new();
    for (body, shade) in scene.bodies().iter().zip(SHADES.into_iter().cycle()) {
        colors.push(match body.kind() {
            BodyKind::Rigid => Color::from_srgb([0xe8, 0xde, 0xc6]),
            BodyKind::Deformable => Color::from_srgb([0xd6, 0x8c, 0x80]) * shade,
            BodyKind::Open => Color::from_srgb([0x8f, 0xae, 0xc8]) * shade,
        });
    }
    colors
}
