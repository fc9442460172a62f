//! Orthographic projection onto a picture: a length has the same number of pixels
//! wherever it lies.

use glam::DVec3;
use surface::Aabb;

use crate::cast::{float, floor};

/// Orthographic camera, with the size of its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Point in the middle of the picture.
    center: DVec3,
    right: DVec3,
    up: DVec3,
    /// From the camera into the scene.
    forward: DVec3,
    /// Pixels per length unit.
    scale: f64,
    width: usize,
    height: usize,
    /// Depth of the near plane behind `center`, in length units.
    near: f64,
}

/// Free margin around the framed points, as a fraction of the picture's side.
const MARGIN: f64 = 0.04;

/// Maximum scale, in pixels per length unit: a point alone has none.
const MAX_SCALE: f64 = 1e300;

impl Camera {
    /// Builds a camera that looks along `forward`, with `up` upwards as far as possible,
    /// and shows `points` as large as `max_size` pixels (width, height) allow.
    ///
    /// A side of the picture that the points leave empty is cut off.
    #[must_use]
    pub fn framing(
        points: impl IntoIterator<Item = DVec3>,
        forward: DVec3,
        up: DVec3,
        max_size: [usize; 2],
    ) -> Self {
        // The box around the points, in the camera's axes.
        let [right, up, forward] = camera_axes(forward, up);
        let to_camera = |p: DVec3| DVec3::new(p.dot(right), p.dot(up), p.dot(forward));
        let frame = Aabb::of_points(points.into_iter().map(to_camera));
        let middle = frame.center();
        let center = middle.x * right + middle.y * up + middle.z * forward;

        // The largest scale at which the box fits, and the pixels that it then needs.
        let room = 1.0 - 2.0 * MARGIN;
        let sides = frame.sides().max(DVec3::splat(f64::MIN_POSITIVE));
        let [max_width, max_height] = max_size;
        let scale = (float(max_width) * room / sides.x).min(float(max_height) * room / sides.y);
        let scale = scale.min(MAX_SCALE);
        let pixels = |max: usize, side: f64| max.min(floor(side * scale / room) + 1);
        let (width, height) = (pixels(max_width, sides.x), pixels(max_height, sides.y));
        Self { center, right, up, forward, scale, width, height, near: f64::NEG_INFINITY }
    }

    /// Returns the same view with a near plane through `point`.
    #[must_use]
    pub fn with_near_plane(self, point: DVec3) -> Self {
        Self { near: (point - self.center).dot(self.forward), ..self }
    }

    /// Returns the same view with `samples` times as many pixels along both sides.
    pub(crate) fn with_samples(self, samples: usize) -> Self {
        Self {
            scale: self.scale * float(samples),
            width: self.width * samples,
            height: self.height * samples,
            ..self
        }
    }

    /// Returns the number of pixels across.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of pixels from top to bottom.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns the width of the view, in length units.
    #[must_use]
    pub fn span(&self) -> f64 {
        float(self.width) / self.scale
    }

    /// Returns the depth of the near plane, in pixels.
    pub(crate) fn near(&self) -> f64 {
        self.near * self.scale
    }

    /// Projects a point to pixels from the left, from the top, and into the picture.
    pub(crate) fn project(&self, point: DVec3) -> DVec3 {
        let from_center = (point - self.center) * self.scale;
        DVec3::new(
            float(self.width) / 2.0 + from_center.dot(self.right),
            float(self.height) / 2.0 - from_center.dot(self.up),
            from_center.dot(self.forward),
        )
    }

    /// Rotates a direction into the view: right, up, towards the viewer.
    pub(crate) fn view_direction(&self, direction: DVec3) -> DVec3 {
        DVec3::new(direction.dot(self.right), direction.dot(self.up), -direction.dot(self.forward))
    }
}

/// Returns the unit vectors right, up and forward; any up where `up` is along the view.
fn camera_axes(forward: DVec3, up: DVec3) -> [DVec3; 3] {
    let forward = forward.normalize_or(DVec3::Y);
    let across = forward.cross(up);
    let right = if across.length() > 1e-6 * up.length() {
        across.normalize()
    } else {
        forward.any_orthonormal_vector()
    };
    [right, right.cross(forward), forward]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fill_the_picture() {
        let points = [DVec3::new(-1.0, 5.0, 0.0), DVec3::new(3.0, 9.0, 2.0)];
        let camera = Camera::framing(points, DVec3::Y, DVec3::Z, [200, 110]);
        assert_eq!((camera.width(), camera.height()), (200, 101));
        let [low, high] = points.map(|point| camera.project(point));
        assert!((high.x - low.x - 184.0).abs() < 1e-9, "{low} {high}");
        assert!((low.y - high.y - 92.0).abs() < 1e-9, "z points up: {low} {high}");
        assert!((low.x + high.x - 200.0).abs() < 1e-9, "centered: {low} {high}");
        assert!((camera.span() - 200.0 / 46.0).abs() < 1e-9, "{}", camera.span());
    }

    #[test]
    fn a_point_alone_is_a_pixel() {
        let camera = Camera::framing([DVec3::ONE; 3], DVec3::Y, DVec3::Z, [200, 110]);
        assert_eq!((camera.width(), camera.height()), (1, 1));
        assert!(camera.span() > 0.0 && camera.project(DVec3::ONE).is_finite());
    }

    #[test]
    fn up_along_the_view_is_replaced() {
        let [right, up, forward] = camera_axes(DVec3::Z, DVec3::Z);
        assert!((right.cross(forward) - up).length() < 1e-12, "{right} {up} {forward}");
    }
}
