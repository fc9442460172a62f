//! Corners of cells that the surface of a volume mesh holds by itself.
//!
//! Where the four nodes of a corner are on the surface, no place of the nodes inside keeps the cell from being inverted
//! once the corner is. Such corners are held open as bodies are held apart: the vertex stays over the plane of the
//! other three. The gradient of its height is that of the distance of a vertex from a face, or of two edges, by the
//! barycentric coordinates of its foot.

use glam::DVec3;
use surface::{Contact, ContactSide, Term};

use crate::detection::clearance;
use crate::run::Run;
use crate::tissue::{CellCorner, Tissue};

/// Scaled Jacobian that rounds leave a corner, between its limit and that at the start. Below, what rounds miss breaks
/// the limit; above, surfaces are held stiff.
const KEPT_SHARE: f64 = 0.18;

/// Scaled Jacobian below which a corner is held, likewise. Below, a step passes by the limit; above, more rows.
const HELD_SHARE: f64 = 0.55;

impl CellCorner {
    /// Returns the determinant at a share of the way from the limit to rest.
    fn at_share(&self, share: f64) -> f64 {
        self.limit + share * (self.at_rest - self.limit)
    }
}

/// Shape of a corner.
#[derive(Clone, Copy, Debug)]
struct CornerShape {
    /// Determinant of the edges over the product of their lengths.
    jacobian: f64,
    /// Unit normal of the plane through the ends of the edges, toward the vertex.
    normal: DVec3,
    /// Height of the vertex over that plane.
    height: f64,
    /// Height at which the determinant is the product of the lengths.
    full_height: f64,
    /// Barycentric coordinates of the foot of the height: one is negative where it is beside the face.
    weights: [f64; 3],
}

impl CornerShape {
    /// Measures a corner; `None` where the ends of its edges are on a line.
    fn new([p, a, b, c]: [DVec3; 4]) -> Option<Self> {
        let doubled = (b - a).cross(c - a);
        let normal = -doubled.try_normalize()?;
        let height = (p - a).dot(normal);
        let full_height = p.distance(a) * p.distance(b) * p.distance(c) / doubled.length();
        let foot = p - height * normal;
        let weight =
            |b: DVec3, c: DVec3| (b - foot).cross(c - foot).dot(-normal) / doubled.length();
        let weights = [weight(b, c), weight(c, a), weight(a, b)];
        Some(Self { jacobian: height / full_height, normal, height, full_height, weights })
    }

    /// Makes the contact of the vertices that increase the height with those that decrease it, which misses a part
    /// of the height. Corners that are far lower than the clearance are held by their own height alone.
    fn contact(&self, particles: [u32; 4], missing: f64, clearance: f64) -> Contact {
        let [a, b, c] = self.weights;
        let weights = [1.0, -a, -b, -c];
        let total: f64 = weights.iter().map(|weight| weight.max(0.0)).sum();
        let side = |sign: f64| -> Vec<Term> {
            let terms = particles.into_iter().zip(weights.map(|weight| sign * weight / total));
            let terms = terms.filter(|(_, weight)| *weight > 0.0);
            terms.map(|(particle, weight)| Term { particle, weight }).collect()
        };
        let (above, below) = (side(1.0), side(-1.0));
        let (above, below) = (ContactSide::Particles(&above), ContactSide::Particles(&below));
        let gap = clearance - missing / total;
        let offset = self.height / total - gap;
        Contact { offset, ..Contact::between(above, below, self.normal, gap) }
    }
}

impl Tissue {
    /// Holds corners open; those that are flat at rest are left.
    pub(crate) fn hold_corners(&mut self, corners: &[[u32; 4]], min_jacobian_share: f64) {
        for &vertices in corners {
            let shape = CornerShape::new(vertices.map(|vertex| self.rest[vertex as usize]));
            if let Some(shape) = shape.filter(|shape| shape.jacobian > 0.0) {
                let (at_rest, limit) = (shape.jacobian, min_jacobian_share * shape.jacobian);
                self.cell_corners.push(CellCorner { vertices, at_rest, limit });
            }
        }
    }

    /// Counts the corners of cells that are flat at `x`.
    pub(crate) fn count_flat_corners(&self, x: &[DVec3]) -> usize {
        let is_flat = |corner: &&CellCorner| {
            let shape = CornerShape::new(corner.vertices.map(|vertex| x[vertex as usize]));
            shape.is_none_or(|shape| shape.jacobian.is_nan() || shape.jacobian < corner.limit)
        };
        self.cell_corners.iter().filter(is_flat).count()
    }
}

impl Run<'_> {
    /// Makes the contacts of corners of cells that are nearly flat.
    pub(crate) fn corner_contacts(&self) -> Vec<Contact> {
        let (mut contacts, clearance) = (Vec::new(), clearance(&self.params));
        for (tissue, body) in self.tissues.iter().zip(self.scene.bodies()) {
            let (x, first) = (body.positions(), body.particles().start);
            for corner in &tissue.cell_corners {
                let shape = CornerShape::new(corner.vertices.map(|vertex| x[vertex as usize]));
                let held = corner.at_share(HELD_SHARE);
                let Some(shape) = shape.filter(|shape| shape.jacobian < held) else { continue };
                let particles = corner.vertices.map(|vertex| first + vertex);
                let missing = corner.at_share(KEPT_SHARE) * shape.full_height - shape.height;
                contacts.push(shape.contact(particles, missing, clearance));
            }
        }
        contacts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNER: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];

    #[test]
    fn corners_are_measured_by_their_determinant() {
        let full = CornerShape::new(CORNER).expect("a corner");
        let third = 3.0_f64.sqrt().recip();
        assert!((full.jacobian - 1.0).abs() < 1e-12, "{full:?}");
        assert!((full.height - third).abs() < 1e-12, "{full:?}");
        assert!((full.normal + DVec3::splat(third)).length() < 1e-12, "{full:?}");

        // Moved through the plane, to where the cell is inverted.
        let pressed = [DVec3::splat(0.5), DVec3::X, DVec3::Y, DVec3::Z];
        let inverted = CornerShape::new(pressed).expect("a corner");
        assert!(inverted.jacobian < 0.0 && inverted.height < 0.0, "{inverted:?}");
        let missing = inverted.full_height - inverted.height;
        let opened = CornerShape::new([
            pressed[0] + missing * inverted.normal,
            pressed[1],
            pressed[2],
            pressed[3],
        ]);
        assert!(opened.expect("a corner").jacobian > 0.0, "pushed the right way: {opened:?}");
        assert!(CornerShape::new([DVec3::Y, DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]).is_none());
    }

    /// Above the middle of a face, beside it where edges cross, and beyond a vertex of it.
    #[test]
    fn contacts_open_corners_as_their_height_grows() {
        for foot in [[0.3, 0.3], [0.7, 0.8], [1.6, -0.3]] {
            let p = DVec3::new(foot[0], foot[1], 0.01);
            let corner = [p, DVec3::ZERO, DVec3::Y, DVec3::X];
            let shape = CornerShape::new(corner).expect("a corner");
            assert!((shape.height - 0.01).abs() < 1e-12, "{shape:?}");
            let contact = shape.contact([0, 1, 2, 3], 0.004, 0.5);
            assert!(contact.identity_error(|k| corner[k as usize]) < 1e-12, "{contact:?}");

            // What is missing beyond the clearance opens the height by as much, as each vertex does by its weight.
            let (mut opened, mut total) = (corner, 0.0);
            for term in contact.stencil.terms() {
                let step = -1e-6 * term.weight * contact.normal;
                opened[term.particle as usize] += step;
                total += term.weight * term.weight;
            }
            let opened = CornerShape::new(opened).expect("a corner");
            let share = (opened.height - shape.height) / (1e-6 * total);
            let missing = (0.5 - contact.gap) * share;
            assert!((missing - 0.004).abs() < 1e-6, "{foot:?}: {missing}");
        }
    }
}
