//! Simplex surfaces in triangles: each polygon as a fan about its center, and
//! contacts with the fan carried back to the polygon's vertices.
//!
//! The fan's particles are the vertices, then one center for each polygon. A
//! center is the mean of its polygon's vertices, so its share of a contact is
//! theirs in equal parts.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2, which
//! fans polygons for collision. The lift differs from a search for the height of
//! equal curvature: it is that of a sphere through the polygon, in closed form.

use std::ops::Range;

use glam::DVec3;

use crate::{NO_NEIGHBOR, Positions, SimplexSurface, SurfaceError, Term, TriangleSurface};

impl SimplexSurface {
    /// The polygons in triangles `[center, vertex, next vertex]`, in order.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::TooMany`] when 32-bit indices cannot number the triangles'
    /// corners.
    pub fn fan(&self) -> Result<TriangleSurface, SurfaceError> {
        let count = self.vertex_count() + self.polygon_count();
        let faces =
            self.polygons().iter().zip(self.vertex_count()..).flat_map(|(polygon, center)| {
                let center = u32::try_from(center).unwrap_or(u32::MAX); // out of range is refused below
                let next = polygon.iter().cycle().skip(1);
                polygon.iter().zip(next).map(move |(from, to)| [center, *from, *to])
            });
        TriangleSurface::new(count, faces.collect())
    }

    /// Faces of the [fan](Self::fan) that make up a polygon.
    ///
    /// # Panics
    ///
    /// When there is no such polygon.
    #[must_use]
    pub fn fan_faces(&self, polygon: u32) -> Range<u32> {
        self.polygons().range(polygon)
    }

    /// Positions of the [fan](Self::fan)'s particles, into `out`: the vertices'
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

    /// As [`fan_positions`](Self::fan_positions), with each center lifted by its
    /// [`lifts`](Self::lifts).
    ///
    /// A contact on a lifted fan spreads to the same weights. They combine to the
    /// foot less `b₀` times the lift along the polygon's normal, with `b₀` the
    /// weight of the center: the part along the contact's normal belongs in its
    /// offset.
    ///
    /// # Panics
    ///
    /// When `x` was checked against a surface with fewer vertices.
    pub fn lifted_fan_positions(&self, x: Positions<'_>, out: &mut Vec<DVec3>) {
        self.fan_positions(x, out);
        let centers = out[self.vertex_count()..].iter_mut();
        for ((center, polygon), lift) in centers.zip(self.polygons().iter()).zip(self.lifts(x)) {
            *center += lift * normal(x, polygon);
        }
    }

    /// How far the surface bulges over each polygon's mean, |P|, along the normal
    /// of the polygon: the height of a sphere through its vertices, of the mean
    /// curvature that these have towards their neighbors.
    ///
    /// On a sphere the lifted centers are on it where the polygon is regular;
    /// vertices on the border count as flat.
    ///
    /// # Panics
    ///
    /// When `x` was checked against a surface with fewer vertices.
    #[must_use]
    pub fn lifts(&self, x: Positions<'_>) -> Vec<f64> {
        let curvatures: Vec<f64> = (0..)
            .zip(self.neighbors())
            .map(|(vertex, around)| curvature(x, vertex, *around))
            .collect();
        let height = |polygon: &[u32]| {
            let mean = |value: &dyn Fn(u32) -> f64| {
                polygon.iter().map(|v| value(*v)).sum::<f64>() / as_f64(polygon.len())
            };
            let center = center(x, polygon);
            let rho_squared = mean(&|v| x.at(v).distance_squared(center));
            sagitta(mean(&|v| curvatures[v as usize]), rho_squared)
        };
        self.polygons().iter().map(height).collect()
    }

    /// Carries terms over the [fan](Self::fan)'s particles to the vertices, into
    /// `out`: a center's weight goes to its polygon's vertices in equal parts, and
    /// each vertex is named once, in the order of its first mention.
    ///
    /// The combination is the same, and so is the sum of the weights. Terms of
    /// other objects must be kept out.
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
    /// When a term is of no particle of the fan.
    pub fn spread(&self, terms: &[Term], out: &mut Vec<Term>) {
        out.clear();
        for &Term { particle, weight } in terms {
            let polygon = (particle as usize).checked_sub(self.vertex_count());
            match polygon.and_then(|polygon| u32::try_from(polygon).ok()) {
                None => add(out, Term { particle, weight }),
                Some(polygon) => {
                    let vertices = self.polygon(polygon);
                    let weight = weight / as_f64(vertices.len());
                    vertices.iter().for_each(|vertex| add(out, Term { particle: *vertex, weight }));
                }
            }
        }
    }
}

fn add(out: &mut Vec<Term>, term: Term) {
    match out.iter_mut().find(|known| known.particle == term.particle) {
        Some(known) => known.weight += term.weight,
        None => out.push(term),
    }
}

fn center(x: Positions<'_>, polygon: &[u32]) -> DVec3 {
    polygon.iter().map(|vertex| x.at(*vertex)).sum::<DVec3>() / as_f64(polygon.len())
}

/// Of the polygon's area vector; zero without one.
fn normal(x: Positions<'_>, polygon: &[u32]) -> DVec3 {
    let center = center(x, polygon);
    let next = polygon.iter().cycle().skip(1);
    let area = |(from, to): (&u32, &u32)| (x.at(*from) - center).cross(x.at(*to) - center);
    polygon.iter().zip(next).map(area).sum::<DVec3>().normalize_or_zero()
}

/// Inverse radius of the sphere through a vertex and its three neighbors,
/// positive where the surface bulges outward; 0 where they are in one plane.
fn curvature(x: Positions<'_>, vertex: u32, around: [u32; 3]) -> f64 {
    if around.contains(&NO_NEIGHBOR) {
        return 0.0;
    }
    let [u, v, w] = around.map(|k| x.at(k) - x.at(vertex));
    let (vw, wu, uv) = (v.cross(w), w.cross(u), u.cross(v));
    let to_center = u.length_squared() * vw + v.length_squared() * wu + w.length_squared() * uv;
    let length = to_center.length();
    if length > 0.0 { -2.0 * u.dot(vw) / length } else { 0.0 }
}

/// Height of a sphere's cap of that curvature over a circle of that squared
/// radius; of a hemisphere at most.
fn sagitta(curvature: f64, rho_squared: f64) -> f64 {
    let sine_squared = (curvature * curvature * rho_squared).min(1.0);
    curvature * rho_squared / (1.0 + (1.0 - sine_squared).sqrt())
}

#[expect(clippy::cast_precision_loss, reason = "polygons have far fewer than 2^52 vertices")]
fn as_f64(count: usize) -> f64 {
    count as f64
}
