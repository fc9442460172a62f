//! Layered depth images: layers at which parallel rays enter and leave two bodies.
//!
//! A grid of rays is laid along one axis over the intersection of the bounding boxes. Each ray
//! keeps, in order, the layers at which it passes the faces of a closed surface; between entering
//! and leaving it is inside. Two such images merge to the volume of the intersection. A vertex is
//! inside if the ray of its pixel is inside at its height, and its depth is the distance to the
//! surface along the ray.
//!
//! Sources: B. Heidelberger, M. Teschner and M. Gross, "Real-time volumetric intersections of
//! deforming objects", VMV 2003, and "Detection of collisions and self-collisions using
//! image-space techniques", WSCG 2004. Those render the layers on graphics hardware; here rays are
//! cast exactly, so that one through an edge passes one of its faces, and images have no holes.
//!
//! Geometry thinner than a pixel is missed. A vertex is classified wrongly if the surface passes
//! between it and the ray of its pixel. The error of the volume is in the pixels at the rim; it
//! converges with the resolution.
//!
//! # Example
//!
//! ```
//! use baselines::layered_depth::{self, LayeredDepthParams};
//! use baselines::{PlacedSurface, glam::DVec3};
//! use surface::TriangleSurface;
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let surface = TriangleSurface::new(4, faces)?;
//! let first = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let second = first.map(|x| 0.5 * x + DVec3::splat(0.1));
//! let a = PlacedSurface { surface: &surface, x: surface.positions(&first)? };
//! let b = PlacedSurface { surface: &surface, x: surface.positions(&second)? };
//!
//! let params = LayeredDepthParams { resolution: 200 };
//! let volume = layered_depth::detect(a, b, &params)?.volume.expect("images give volumes");
//! // Half as large, with its corner at (0.1, 0.1, 0.1): inside.
//! assert!((volume - 0.125 / 6.0).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use glam::DVec3;
use surface::{Aabb, ray_crosses_triangle, triangle};

use crate::error::{BaselineError, check};
use crate::findings::{PairFindings, PlacedSurface, VertexInside, clamp_cell, clamp_count, index};

/// Parameters of layered depth images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayeredDepthParams {
    /// Pixels along the longer side of the image, in `1..=8192`.
    pub resolution: u32,
}

/// Maximum number of pixels along a side.
const MAX_RESOLUTION: u32 = 8192;

impl LayeredDepthParams {
    /// 64 pixels, the middle of the papers' resolutions.
    pub const DEFAULT: Self = Self { resolution: 64 };

    /// Checks that all parameters are in range.
    ///
    /// # Errors
    ///
    /// Names the first parameter out of range.
    pub fn validate(&self) -> Result<(), BaselineError> {
        let Self { resolution } = *self;
        let is_in_range = (1..=MAX_RESOLUTION).contains(&resolution);
        check("resolution", resolution.into(), is_in_range, "in 1..=8192")
    }
}

/// Computes the volume of the intersection of two closed surfaces, and the vertices of each inside
/// the other, at the resolution of the images.
///
/// # Errors
///
/// When a parameter is out of range or a surface is open.
pub fn detect(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    params: &LayeredDepthParams,
) -> Result<PairFindings, BaselineError> {
    params.validate()?;
    a.surface.require_closed()?;
    b.surface.require_closed()?;
    let shared = a.bounds().intersection(b.bounds());
    if shared.is_empty() {
        let inside = Some([Vec::new(), Vec::new()]);
        return Ok(PairFindings { inside, volume: Some(0.0), ..PairFindings::default() });
    }

    // One image per body, on the same rays.
    let screen = Screen::new(shared, params);
    let (image_a, image_b) = (LayeredImage::new(&screen, a), LayeredImage::new(&screen, b));
    let volume = screen.pixel_area() * shared_length(&image_a, &image_b);
    let inside = [image_b.vertices_inside(&screen, a), image_a.vertices_inside(&screen, b)];
    Ok(PairFindings {
        overlap: volume > 0.0,
        inside: Some(inside),
        volume: Some(volume),
        tests: image_a.tests + image_b.tests,
        ..PairFindings::default()
    })
}

/// Grid of rays, one per pixel, along the axis of the shortest side; it is rotated to x.
struct Screen {
    /// Axis of the rays.
    axis: usize,
    /// Rotated intersection of the bounding boxes.
    bounds: Aabb,
    /// Pixels along y and z.
    pixels: [u32; 2],
    /// Sides of a pixel along y and z.
    sides: [f64; 2],
}

impl Screen {
    fn new(shared: Aabb, params: &LayeredDepthParams) -> Self {
        let sides = shared.sides().to_array();
        let axis = (0..3).min_by(|&i, &j| sides[i].total_cmp(&sides[j])).unwrap_or(0);
        let bounds = Aabb { min: rotated(shared.min, axis), max: rotated(shared.max, axis) };

        // Square pixels, as nearly as whole numbers of them allow.
        let across = [bounds.sides().y, bounds.sides().z];
        let per_length = f64::from(params.resolution) / across[0].max(across[1]);
        let pixels = across.map(|side| clamp_count((per_length * side).ceil(), params.resolution));
        let sides = [across[0] / f64::from(pixels[0]), across[1] / f64::from(pixels[1])];
        Self { axis, bounds, pixels, sides }
    }

    fn to_front(&self, p: DVec3) -> DVec3 {
        rotated(p, self.axis)
    }

    fn pixel_area(&self) -> f64 {
        self.sides[0] * self.sides[1]
    }

    fn pixel_count(&self) -> usize {
        self.pixels[0] as usize * self.pixels[1] as usize
    }

    /// Returns the start of the ray of a pixel.
    fn ray(&self, [i, j]: [u32; 2]) -> DVec3 {
        let y = self.bounds.min.y + (f64::from(i) + 0.5) * self.sides[0];
        let z = self.bounds.min.z + (f64::from(j) + 0.5) * self.sides[1];
        DVec3::new(f64::MIN, y, z)
    }

    fn number(&self, [i, j]: [u32; 2]) -> usize {
        i as usize * self.pixels[1] as usize + j as usize
    }

    /// Returns the pixel that holds a rotated point.
    fn pixel(&self, p: DVec3) -> [u32; 2] {
        let DVec3 { y, z, .. } = p - self.bounds.min;
        let ([dy, dz], [rows, columns]) = (self.sides, self.pixels);
        [clamp_cell(y / dy, rows), clamp_cell(z / dz, columns)]
    }
}

/// Rotates an axis to the first, which keeps orientations.
fn rotated(p: DVec3, axis: usize) -> DVec3 {
    DVec3::new(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3])
}

/// Part of a ray inside a body.
#[derive(Clone, Copy)]
struct Stretch {
    start: f64,
    end: f64,
}

/// Layered depth image of one body.
struct LayeredImage {
    /// Offsets of the pixels' stretches, and the number of stretches.
    offsets: Vec<usize>,
    stretches: Vec<Stretch>,
    tests: u64,
}

/// Point where the ray of a pixel passes a face.
struct Layer {
    pixel: usize,
    depth: f64,
    /// 1 where it enters, −1 where it leaves.
    turn: i32,
}

impl LayeredImage {
    fn new(screen: &Screen, body: PlacedSurface<'_>) -> Self {
        let (mut layers, tests) = layers(screen, body);
        layers.sort_by(|a, b| a.pixel.cmp(&b.pixel).then(a.depth.total_cmp(&b.depth)));

        // Layers are in the order of the pixels: each takes its own from the front.
        let (mut offsets, mut stretches) = (vec![0], Vec::new());
        let mut rest = layers.as_slice();
        for pixel in 0..screen.pixel_count() {
            let count = rest.partition_point(|layer| layer.pixel <= pixel);
            push_stretches(&rest[..count], &mut stretches);
            rest = &rest[count..];
            offsets.push(stretches.len());
        }
        Self { offsets, stretches, tests }
    }

    fn of_pixel(&self, pixel: usize) -> &[Stretch] {
        &self.stretches[self.offsets[pixel]..self.offsets[pixel + 1]]
    }

    /// Finds the vertices of another body in the stretches of this one.
    fn vertices_inside(&self, screen: &Screen, other: PlacedSurface<'_>) -> Vec<VertexInside> {
        let mut inside = Vec::new();
        for (vertex, p) in other.x.as_slice().iter().enumerate() {
            let p = screen.to_front(*p);
            if !screen.bounds.contains(p) {
                continue;
            }
            let stretches = self.of_pixel(screen.number(screen.pixel(p)));
            if let Some(holding) = stretches.iter().find(|s| s.start <= p.x && p.x <= s.end) {
                let depth = (p.x - holding.start).min(holding.end - p.x);
                inside.push(VertexInside { vertex: index(vertex), depth });
            }
        }
        inside
    }
}

/// Casts all rays; returns their layers, and the number of tests of rays against faces.
fn layers(screen: &Screen, body: PlacedSurface<'_>) -> (Vec<Layer>, u64) {
    let (mut layers, mut tests) = (Vec::new(), 0);
    let min = DVec3 { x: f64::NEG_INFINITY, ..screen.bounds.min };
    let max = DVec3 { x: f64::INFINITY, ..screen.bounds.max };
    let all_rays = Aabb { min, max };
    for face in 0..body.face_count() {
        let corners = body.corners(face).map(|p| screen.to_front(p));
        let bounds = Aabb::of_points(corners);
        if !bounds.overlaps(all_rays) {
            continue;
        }

        // All pixels in the box of the face.
        let ([i0, j0], [i1, j1]) = (screen.pixel(bounds.min), screen.pixel(bounds.max));
        for i in i0..=i1 {
            for j in j0..=j1 {
                tests += 1;
                let ray = screen.ray([i, j]);
                if let Some(sign) = ray_crosses_triangle(ray, corners) {
                    let depth = depth_on_face(ray, corners);
                    layers.push(Layer { pixel: screen.number([i, j]), depth, turn: -sign });
                }
            }
        }
    }
    (layers, tests)
}

/// Computes where a ray along x passes the plane of a face, clamped to the extent of the face.
fn depth_on_face(ray: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = triangle::normal(corners);
    let offset = normal.y * (ray.y - a.y) + normal.z * (ray.z - a.z);
    let depth = a.x - offset / normal.x;
    depth.max(a.x.min(b.x).min(c.x)).min(a.x.max(b.x).max(c.x))
}

/// Appends the stretches inside, from the layers of one pixel in order.
fn push_stretches(layers: &[Layer], stretches: &mut Vec<Stretch>) {
    let (mut nesting, mut start) = (0, 0.0);
    for layer in layers {
        let before = nesting;
        nesting += layer.turn;
        if before <= 0 && nesting > 0 {
            start = layer.depth;
        } else if before > 0 && nesting <= 0 {
            stretches.push(Stretch { start, end: layer.depth });
        }
    }
}

/// Sums the length of rays inside both images, over all pixels.
fn shared_length(a: &LayeredImage, b: &LayeredImage) -> f64 {
    let mut length = 0.0;
    for pixel in 0..a.offsets.len() - 1 {
        for of_a in a.of_pixel(pixel) {
            for of_b in b.of_pixel(pixel) {
                length += (of_a.end.min(of_b.end) - of_a.start.max(of_b.start)).max(0.0);
            }
        }
    }
    length
}
