//! Layered depth images: where parallel rays enter and leave two bodies.
//!
//! Over the overlap of two boxes a grid of rays is laid along one axis. Each
//! ray keeps, in order, where it passes the faces of a closed surface; between
//! entering and leaving it is inside. Two such images merge to the volume that
//! the bodies share, and tell for a vertex whether it is inside and how far it
//! is from the surface along its ray.
//!
//! Sources: B. Heidelberger, M. Teschner and M. Gross, "Real-time volumetric
//! intersections of deforming objects", VMV 2003, and "Detection of collisions
//! and self-collisions using image-space techniques", WSCG 2004. Those render
//! the layers on graphics hardware; here rays are cast exactly, so that one
//! through an edge passes one of its faces, and images have no holes.
//!
//! What is thinner than a pixel is missed. A vertex is judged by the ray in the
//! middle of its pixel: it is placed wrongly if the surface passes between the
//! two. The volume is off by what the pixels at the rim hold; it converges with
//! the resolution.
//!
//! # Example
//!
//! ```
//! use glam::DVec3;
//! use surface::TriangleSurface;
//! use baselines::{PlacedSurface, layered_depth};
//!
//! let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let surface = TriangleSurface::new(4, faces)?;
//! let first = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let second = first.map(|x| 0.5 * x + DVec3::splat(0.1));
//! let (x, y) = (surface.positions(&first)?, surface.positions(&second)?);
//! let params = layered_depth::LayeredDepthParams { resolution: 200, ..layered_depth::LayeredDepthParams::DEFAULT };
//! let (a, b) = (PlacedSurface { surface: &surface, x }, PlacedSurface { surface: &surface, x: y });
//! let volume = layered_depth::detect(a, b, &params)?.volume.expect("images give volumes");
//! // Half as large, and its corner at 0.1 three times: it is inside.
//! assert!((volume - 0.125 / 6.0).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use glam::DVec3;
use surface::ray_crosses_triangle;

use crate::boxes::Bounds;
use crate::error::{BaselineError, check_count};
use crate::findings::{PairFindings, PlacedSurface, VertexInside, index};

/// Along what, and how finely, rays are laid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayeredDepthParams {
    /// Pixels along the longer side of the image, in `1..=8192`.
    pub resolution: u32,
    /// Which coordinate rays run along; `None` for that in which the overlap
    /// of the boxes is shortest.
    pub axis: Option<RayAxis>,
}

impl LayeredDepthParams {
    /// 64 pixels, the middle of what the papers use.
    pub const DEFAULT: Self = Self { resolution: 64, axis: None };
}

impl Default for LayeredDepthParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayAxis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

impl RayAxis {
    const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Turns the axis to the first, keeping orientations.
    fn to_front(self, p: DVec3) -> DVec3 {
        match self {
            Self::X => p,
            Self::Y => DVec3::new(p.y, p.z, p.x),
            Self::Z => DVec3::new(p.z, p.x, p.y),
        }
    }
}

const MOST_PIXELS_A_SIDE: u64 = 8192;

/// Finds the volume that two closed bodies share, and the vertices of each
/// inside the other, as far as the pixels tell.
///
/// # Errors
///
/// When a parameter is out of range or a surface is open.
pub fn detect(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    params: &LayeredDepthParams,
) -> Result<PairFindings, BaselineError> {
    check_count("resolution", params.resolution.into(), MOST_PIXELS_A_SIDE)?;
    a.surface.require_closed()?;
    b.surface.require_closed()?;
    let shared = Bounds::of(a.x.as_slice()).intersection(Bounds::of(b.x.as_slice()));
    if shared.is_empty() {
        let inside = Some([Vec::new(), Vec::new()]);
        return Ok(PairFindings { inside, volume: Some(0.0), ..PairFindings::default() });
    }
    let screen = Screen::new(shared, params);
    let (image_a, image_b) = (Image::new(&screen, a), Image::new(&screen, b));
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

/// The rays: a grid of pixels across the axis, which is turned to x.
struct Screen {
    axis: RayAxis,
    /// The overlap of the boxes.
    bounds: Bounds,
    /// Pixels along y and z.
    pixels: [u32; 2],
    /// Sides of a pixel, along y and z.
    sides: [f64; 2],
}

impl Screen {
    fn new(shared: Bounds, params: &LayeredDepthParams) -> Self {
        let length = |axis: RayAxis| axis.to_front(shared.sides()).x;
        let shortest = || RayAxis::ALL.into_iter().min_by(|a, b| length(*a).total_cmp(&length(*b)));
        let axis = params.axis.or_else(shortest).unwrap_or(RayAxis::X);
        let bounds = Bounds { low: axis.to_front(shared.low), high: axis.to_front(shared.high) };
        let across = [bounds.sides().y, bounds.sides().z];
        let longer = across[0].max(across[1]);
        let most = f64::from(params.resolution);
        let pixels = across.map(|side| whole((most * side / longer).ceil(), params.resolution));
        let sides = [across[0] / f64::from(pixels[0]), across[1] / f64::from(pixels[1])];
        Self { axis, bounds, pixels, sides }
    }

    fn pixel_area(&self) -> f64 {
        self.sides[0] * self.sides[1]
    }

    fn count(&self) -> usize {
        self.pixels[0] as usize * self.pixels[1] as usize
    }

    /// Where the ray of a pixel is.
    fn ray(&self, [i, j]: [u32; 2]) -> DVec3 {
        let low = self.bounds.low;
        let at = |place: u32, side: f64| (f64::from(place) + 0.5) * side;
        DVec3::new(f64::MIN, low.y + at(i, self.sides[0]), low.z + at(j, self.sides[1]))
    }

    fn number(&self, [i, j]: [u32; 2]) -> usize {
        i as usize * self.pixels[1] as usize + j as usize
    }

    /// Pixel that holds a point of the overlap, which is turned already.
    fn pixel(&self, p: DVec3) -> [u32; 2] {
        let from = p - self.bounds.low;
        let place = |x: f64, k: usize| whole((x / self.sides[k]).floor() + 1.0, self.pixels[k]) - 1;
        [place(from.y, 0), place(from.z, 1)]
    }
}

/// A whole number brought into `1..=most`; 1 for what is not a number.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the range")]
fn whole(x: f64, most: u32) -> u32 {
    x.max(1.0).min(f64::from(most)) as u32
}

/// The layers of one body: stretches of each ray that are inside.
struct Image {
    /// Where the stretches of each pixel start, and one more.
    starts: Vec<usize>,
    stretches: Vec<[f64; 2]>,
    tests: u64,
}

/// Where a ray passes a face of a pixel.
struct Layer {
    pixel: usize,
    depth: f64,
    /// 1 where it enters, -1 where it leaves.
    turn: i32,
}

impl Image {
    fn new(screen: &Screen, body: PlacedSurface<'_>) -> Self {
        let (mut layers, tests) = layers(screen, body);
        layers.sort_by(|a, b| a.pixel.cmp(&b.pixel).then(a.depth.total_cmp(&b.depth)));
        let (mut starts, mut stretches) = (vec![0], Vec::new());
        let mut rest = layers.as_slice();
        for pixel in 0..screen.count() {
            let count = rest.partition_point(|layer| layer.pixel <= pixel);
            push_stretches(&rest[..count], &mut stretches);
            rest = &rest[count..];
            starts.push(stretches.len());
        }
        Self { starts, stretches, tests }
    }

    fn of_pixel(&self, pixel: usize) -> &[[f64; 2]] {
        &self.stretches[self.starts[pixel]..self.starts[pixel + 1]]
    }

    /// Vertices of another body in the stretches of this one.
    fn vertices_inside(&self, screen: &Screen, other: PlacedSurface<'_>) -> Vec<VertexInside> {
        let depth = |p: DVec3| {
            let stretches = self.of_pixel(screen.number(screen.pixel(p)));
            let of = stretches.iter().find(|[from, to]| *from <= p.x && p.x <= *to)?;
            Some((p.x - of[0]).min(of[1] - p.x))
        };
        let each = other.x.as_slice().iter().map(|p| screen.axis.to_front(*p)).enumerate();
        each.filter(|(_, p)| screen.bounds.holds(*p))
            .filter_map(|(v, p)| Some(VertexInside { vertex: index(v), depth: depth(p)? }))
            .collect()
    }
}

/// All layers of a body, and the rays tested against faces.
fn layers(screen: &Screen, body: PlacedSurface<'_>) -> (Vec<Layer>, u64) {
    let (mut layers, mut tests) = (Vec::new(), 0);
    for face in 0..body.face_count() {
        let corners = body.corners(face).map(|p| screen.axis.to_front(p));
        let bounds = Bounds::of(&corners);
        let (low, high) = (screen.bounds.low, screen.bounds.high);
        if bounds.high.y < low.y
            || bounds.high.z < low.z
            || bounds.low.y > high.y
            || bounds.low.z > high.z
        {
            continue;
        }
        let ([i0, j0], [i1, j1]) = (screen.pixel(bounds.low), screen.pixel(bounds.high));
        for pixel in (i0..=i1).flat_map(|i| (j0..=j1).map(move |j| [i, j])) {
            tests += 1;
            let ray = screen.ray(pixel);
            if let Some(sign) = ray_crosses_triangle(ray, corners) {
                let depth = depth_of(ray, corners);
                layers.push(Layer { pixel: screen.number(pixel), depth, turn: -sign });
            }
        }
    }
    (layers, tests)
}

/// Where a ray along x passes the plane of a face, kept within the face's extent.
fn depth_of(ray: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let off = normal.y * (ray.y - a.y) + normal.z * (ray.z - a.z);
    let depth = a.x - off / normal.x;
    depth.max(a.x.min(b.x).min(c.x)).min(a.x.max(b.x).max(c.x))
}

/// Where the layers of one pixel, in order, are inside.
fn push_stretches(layers: &[Layer], stretches: &mut Vec<[f64; 2]>) {
    let (mut depth_of_nesting, mut entered) = (0, 0.0);
    for layer in layers {
        let before = depth_of_nesting;
        depth_of_nesting += layer.turn;
        if before <= 0 && depth_of_nesting > 0 {
            entered = layer.depth;
        } else if before > 0 && depth_of_nesting <= 0 {
            stretches.push([entered, layer.depth]);
        }
    }
}

/// Length of rays that is inside both, over all pixels.
fn shared_length(a: &Image, b: &Image) -> f64 {
    let mut length = 0.0;
    for pixel in 0..a.starts.len() - 1 {
        for [from, to] in a.of_pixel(pixel) {
            let with = |[low, high]: &[f64; 2]| (to.min(*high) - from.max(*low)).max(0.0);
            length += b.of_pixel(pixel).iter().map(with).sum::<f64>();
        }
    }
    length
}
