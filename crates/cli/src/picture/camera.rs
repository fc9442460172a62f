//! Parallel projection onto a picture: no perspective, so that a length means
//! the same number of pixels wherever it lies.

use glam::DVec3;

use super::number::{float, floor};

/// Where a picture is seen from and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Camera {
    /// Point that is shown in the middle.
    centre: DVec3,
    right: DVec3,
    up: DVec3,
    /// From the camera into the scene.
    forward: DVec3,
    /// Pixels a length unit.
    scale: f64,
    width: usize,
    height: usize,
    /// Length units behind `centre`: what is nearer is cut away.
    cut: f64,
}

/// Share of the picture's side that stays free around what is framed.
const MARGIN: f64 = 0.04;

impl Camera {
    /// Looks along `forward`, with `up` upwards as far as that allows, and
    /// shows `points` as large as `width` × `height` pixels take; a side that
    /// they leave empty is cut off.
    pub(crate) fn framing(
        points: impl Iterator<Item = DVec3> + Clone,
        forward: DVec3,
        up: DVec3,
        [width, height]: [usize; 2],
    ) -> Self {
        let [right, up, forward] = frame(forward, up);
        let [low, high] =
            extent(points.map(|p| DVec3::new(p.dot(right), p.dot(up), p.dot(forward))));
        let middle = (low + high) / 2.0;
        let room = 1.0 - 2.0 * MARGIN;
        let size = (high - low).max(DVec3::splat(f64::MIN_POSITIVE));
        let scale = (float(width) * room / size.x).min(float(height) * room / size.y);
        let centre = middle.x * right + middle.y * up + middle.z * forward;
        let [width, height] = [(width, size.x), (height, size.y)]
            .map(|(most, size)| most.min(floor(size * scale / room) + 1));
        Self { centre, right, up, forward, scale, width, height, cut: f64::NEG_INFINITY }
    }

    /// The same view without what is nearer than a plane through `point`.
    pub(crate) fn cut_before(self, point: DVec3) -> Self {
        Self { cut: (point - self.centre).dot(self.forward), ..self }
    }

    /// The same view with `samples` pixels for each along both sides.
    pub(super) fn with_samples(self, samples: usize) -> Self {
        Self {
            scale: self.scale * float(samples),
            width: self.width * samples,
            height: self.height * samples,
            ..self
        }
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// Width of what is shown, in length units.
    pub(crate) fn span(&self) -> f64 {
        float(self.width) / self.scale
    }

    /// Pixels into the picture from which on things are drawn.
    pub(super) fn nearest_drawn(&self) -> f64 {
        self.cut * self.scale
    }

    /// Pixels from the left, from the top, and pixels into the picture.
    pub(super) fn project(&self, point: DVec3) -> DVec3 {
        let from_centre = (point - self.centre) * self.scale;
        DVec3::new(
            float(self.width) / 2.0 + from_centre.dot(self.right),
            float(self.height) / 2.0 - from_centre.dot(self.up),
            from_centre.dot(self.forward),
        )
    }

    /// A direction as the viewer sees it: right, up, towards the viewer.
    pub(super) fn turn(&self, direction: DVec3) -> DVec3 {
        DVec3::new(direction.dot(self.right), direction.dot(self.up), -direction.dot(self.forward))
    }
}

/// Unit vectors right, up and forward; any up will do where the wished one is
/// along the view.
fn frame(forward: DVec3, up: DVec3) -> [DVec3; 3] {
    let forward = forward.normalize_or(DVec3::Y);
    let across = forward.cross(up);
    let right = if across.length() > 1e-6 * up.length() {
        across.normalize()
    } else {
        forward.any_orthonormal_vector()
    };
    [right, right.cross(forward), forward]
}

fn extent(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_what_it_is_given() {
        let points = [DVec3::new(-1.0, 5.0, 0.0), DVec3::new(3.0, 9.0, 2.0)];
        let camera = Camera::framing(points.iter().copied(), DVec3::Y, DVec3::Z, [200, 110]);
        assert_eq!((camera.width(), camera.height()), (200, 101));
        let [low, high] = points.map(|point| camera.project(point));
        assert!((high.x - low.x - 184.0).abs() < 1e-9, "{low} {high}");
        assert!((low.y - high.y - 92.0).abs() < 1e-9, "z points up: {low} {high}");
        assert!((low.x + high.x - 200.0).abs() < 1e-9, "centred: {low} {high}");
        assert!((camera.span() - 200.0 / 46.0).abs() < 1e-9, "{}", camera.span());
    }

    #[test]
    fn up_along_the_view_is_replaced() {
        let [right, up, forward] = frame(DVec3::Z, DVec3::Z);
        assert!((right.cross(forward) - up).length() < 1e-12, "{right} {up} {forward}");
    }
}
