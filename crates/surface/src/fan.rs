//! Triangulation of simplex surfaces: each polygon as a triangle fan about its center, and
//! contacts on the fan carried back to the polygon's vertices.
//!
//! The fan's particles are the vertices, then one center per polygon. A center is the
//! mean of its polygon's vertices, so its weight in a contact is theirs in equal parts.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2, which
//! fans polygons for collision.

use glam::DVec3;

use crate::{Positions, SimplexSurface, SurfaceError, Term, TriangleSurface};

impl SimplexSurface {
    /// Returns the polygons in triangles `[center, vertex, next vertex]`, in order.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::TooMany`] when 32-bit indices cannot number the triangles'
    /// corners.
    pub fn fan(&self) -> Result<TriangleSurface, SurfaceError> {
        let count = self.vertex_count() + self.polygon_count();
        let mut faces = Vec::new();
        for (polygon, center) in self.polygons().iter().zip(self.vertex_count()..) {
            let center = u32::try_from(center).unwrap_or(u32::MAX); // refused below
            let next = polygon.iter().cycle().skip(1);
            faces.extend(polygon.iter().zip(next).map(|(&from, &to)| [center, from, to]));
        }
        TriangleSurface::new(count, faces)
    }

    /// Computes the positions of the [fan](Self::fan)'s particles into `out`: the vertices'
    /// `x`, then the mean of each polygon.
    ///
    /// # Panics
    ///
    /// When `x` was checked against a surface with fewer vertices.
    pub fn fan_positions(&self, x: Positions<'_>, out: &mut Vec<DVec3>) {
        out.clear();
        out.extend(x.as_slice());
        out.extend(self.polygons().iter().map(|polygon| center(x, polygon)));
    }

    /// Carries terms over the [fan](Self::fan)'s particles to the vertices, into
    /// `out`: a center's weight goes to its polygon's vertices in equal parts, and
    /// each vertex occurs once, in order of first occurrence.
    ///
    /// The combination is the same, and so is the sum of the weights. Terms of
    /// other objects must be left out.
    ///
    /// ```
    /// use surface::{SimplexSurface, Term, TriangleSurface};
    ///
    /// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    /// let dual = SimplexSurface::dual_of(&TriangleSurface::new(4, faces)?)?;
    /// let [center, from, to] = dual.fan()?.faces()[0];
    /// let on_fan = [(center, 0.3), (from, 0.5), (to, 0.2)];
    /// let on_fan = on_fan.map(|(particle, weight)| Term { particle, weight });
    ///
    /// let mut terms = Vec::new();
    /// dual.spread(&on_fan, &mut terms);
    /// let weights: Vec<f64> = terms.iter().map(|term| term.weight).collect();
    /// assert_eq!(dual.polygon(0), [0, 1, 3]);
    /// assert_eq!(terms.iter().map(|term| term.particle).collect::<Vec<_>>(), [0, 1, 3]);
    /// assert!((weights[0] - 0.6).abs() < 1e-15 && (weights[2] - 0.1).abs() < 1e-15);
    /// # Ok::<(), surface::SimplexError>(())
    /// ```
    ///
    /// # Panics
    ///
    /// When a term refers to no particle of the fan.
    pub fn spread(&self, terms: &[Term], out: &mut Vec<Term>) {
        out.clear();
        for &Term { particle, weight } in terms {
            let Some(polygon) = self.polygon_of_center(particle) else {
                add(out, Term { particle, weight });
                continue;
            };

            // A center is the mean of its polygon.
            let vertices = self.polygon(polygon);
            let weight = weight / as_f64(vertices.len());
            for &particle in vertices {
                add(out, Term { particle, weight });
            }
        }
    }

    /// Returns the polygon whose center a particle of the fan is; `None` for a vertex.
    fn polygon_of_center(&self, particle: u32) -> Option<u32> {
        let polygon = (particle as usize).checked_sub(self.vertex_count())?;
        u32::try_from(polygon).ok()
    }
}

/// Adds a term, or its weight to the term of the same particle.
fn add(out: &mut Vec<Term>, term: Term) {
    match out.iter_mut().find(|other| other.particle == term.particle) {
        Some(other) => other.weight += term.weight,
        None => out.push(term),
    }
}

fn center(x: Positions<'_>, polygon: &[u32]) -> DVec3 {
    polygon.iter().map(|vertex| x.at(*vertex)).sum::<DVec3>() / as_f64(polygon.len())
}

#[expect(clippy::cast_precision_loss, reason = "polygons have far fewer than 2^52 vertices")]
fn as_f64(count: usize) -> f64 {
    count as f64
}
