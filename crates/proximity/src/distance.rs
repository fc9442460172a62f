//! Distance between two surfaces that do not meet, edges included.

use glam::DVec3;
use kdop::Workspace;
use surface::progress::{Interrupted, Progress};
use surface::{closest_between_triangles, triangle};

use crate::SurfaceTree;

/// Computes the smallest distance between points of two surfaces, if it is at most
/// `max_distance`.
///
/// The smaller that is, the fewer pairs of faces are compared: the smallest distance of a vertex
/// is a good one.
pub(crate) fn distance_between(
    a: &SurfaceTree,
    b: &SurfaceTree,
    max_distance: f64,
    workspace: &mut Workspace,
    progress: Progress<'_>,
) -> Result<Option<f64>, Interrupted> {
    /// Pairs of faces between two polls for interruption: a millisecond.
    const POLL_INTERVAL: u32 = 4096;

    // The traversal keeps its margin; pairs beyond the best so far cost one comparison each.
    let mut best = None;
    let mut bound = max_distance;
    let mut polls = progress.every(POLL_INTERVAL);
    a.tree().try_pairs(b.tree(), max_distance, workspace, |face_a, face_b| {
        polls.step()?;
        let (corners_a, corners_b) = (a.corners(face_a), b.corners(face_b));
        if are_farther(corners_a, corners_b, bound) {
            return Ok(());
        }
        let closest = closest_between_triangles(corners_a, corners_b);
        let distance = closest.distance();
        if distance <= bound {
            bound = distance;
            best = Some(distance);
        }
        Ok(())
    })?;
    Ok(best)
}

/// Returns true if planes across the normal of one of two triangles keep them farther apart than a
/// distance, by more than rounding.
///
/// Surfaces that run beside each other have many pairs of faces that are little farther than the
/// nearest, and nearly all of them are told by these planes.
#[inline]
pub(crate) fn are_farther(a: [DVec3; 3], b: [DVec3; 3], distance: f64) -> bool {
    /// Bound on the rounding of a height, relative to the largest length.
    const ROUNDING: f64 = 1e-12;

    /// Square of the shortest normal whose square keeps its digits: those of shorter ones underflow.
    const MIN_SQUARED_NORMAL: f64 = 1e-290;

    let mut size = distance;
    for corner in a.into_iter().chain(b) {
        size = size.max(corner.abs().max_element());
    }
    let limit = distance + ROUNDING * size;
    [(a, b), (b, a)].into_iter().any(|(own, other)| {
        // Any direction bounds the distance by the interval between both triangles along it: the
        // normal of a sliver, which is hardly more than rounding, too.
        let normal = triangle::normal(own);
        let [p, q, r] = other.map(|corner| normal.dot(corner - own[0]));
        let [s, t] = [own[1], own[2]].map(|corner| normal.dot(corner - own[0]));
        let (low, high) = (s.min(t).min(0.0), s.max(t).max(0.0));
        let height = (p.min(q).min(r) - high).max(low - p.max(q).max(r));
        let squared = normal.length_squared();
        squared > MIN_SQUARED_NORMAL && height > 0.0 && height * height > limit * limit * squared
    })
}

#[cfg(test)]
mod tests {
    use surface::closest_between_triangles;

    use super::*;

    #[test]
    fn slivers_are_not_kept_apart_by_rounding() {
        // Corners on a line, but for rounding, whose normal is no normal of theirs.
        let sliver = [
            DVec3::new(59.598604492944375, 17.447592453358453, 44.80426146773543),
            DVec3::new(59.84805839789636, 17.72990957888571, 44.5612534148998),
            DVec3::new(59.83530718830879, 17.715478516608087, 44.57367513511208),
        ];
        let other = [
            DVec3::new(59.85805839789636, 17.72990957888571, 44.5612534148998),
            DVec3::new(59.94560848756357, 17.87072001111008, 44.57120984617005),
            DVec3::new(60.00728043121951, 17.817833006930364, 44.693215968449756),
        ];
        assert!(closest_between_triangles(sliver, other).distance() < 0.011);
        assert!(!are_farther(sliver, other, 0.05) && !are_farther(other, sliver, 0.05));

        // Triangles that stand apart are told, by the normal of either.
        let far = other.map(|corner| corner + DVec3::new(-3.0, 3.0, 0.0));
        let distance = closest_between_triangles(sliver, far).distance();
        assert!(!are_farther(sliver, far, distance));
        assert!(are_farther(other, far, 0.05) || are_farther(far, other, 0.05));
    }

    #[test]
    fn faces_too_small_for_the_square_of_their_normal_are_kept_apart_by_nothing() {
        for size in [1e-40, 1e-72, 1e-75, 1e-80, 1.2e-81, 1e-81, 1e-85, 1e-90] {
            let small = [DVec3::ZERO, size * DVec3::X, size * DVec3::Y];
            let over = DVec3::new(0.5, 0.0, 2.0);
            let other = [over, over + DVec3::X, over + DVec3::new(1.0, 1.0, 0.5)];
            let distance = closest_between_triangles(small, other).distance();
            for limit in [distance, 3.0, 100.0] {
                assert!(!are_farther(small, other, limit), "{limit} at {size:e}");
                assert!(!are_farther(other, small, limit), "{limit} at {size:e}");
            }
        }
    }
}
