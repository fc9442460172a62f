//! Number of times that a closed surface encloses points, and rules by which these are inside.

use glam::DVec3;
use surface::progress::{Interrupted, Progress};
use surface::{parallel, ray_crosses_triangle};

use crate::face_groups::FaceGroups;

/// Groups of faces per task.
const TASK: usize = 256;

/// Rule by which a point is inside, given the number of times that a closed surface encloses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InsideRule {
    /// Winding number above zero.
    Positive,
    /// Winding number below zero, of a surface that is taken reversed.
    Negative,
    /// Any other number than zero, whichever way the faces are oriented.
    NonZero,
}

impl InsideRule {
    /// Returns true if a point that is enclosed so many times is inside.
    pub(crate) fn holds(self, enclosures: i32) -> bool {
        match self {
            Self::Positive => enclosures > 0,
            Self::Negative => enclosures < 0,
            Self::NonZero => enclosures != 0,
        }
    }
}

/// Counts how many times a closed surface encloses each of some points: its winding numbers.
///
/// A point on the surface counts as one that is shifted by an infinitesimal amount.
pub(crate) fn enclosures(
    groups: &FaceGroups<'_>,
    points: &[DVec3],
    progress: Progress<'_>,
) -> Result<Vec<i32>, Interrupted> {
    // In the order of z, a group of faces finds the few points beside it by bisection.
    let mut sorted: Vec<(usize, DVec3)> = points.iter().copied().enumerate().collect();
    sorted.sort_by(|(_, a), (_, b)| a.z.total_cmp(&b.z));

    let tasks = groups.count().div_ceil(TASK);
    let steps = progress.steps(tasks);
    let crossings = parallel::map(tasks, |task| {
        steps.advance(1)?;
        let (mut crossings, mut candidates) = (Vec::new(), Vec::new());
        for group in task * TASK..((task + 1) * TASK).min(groups.count()) {
            let bounds = groups.bounds(group);
            candidates.clear();
            for &(point, p) in between(&sorted, bounds.min.z, bounds.max.z) {
                if p.y >= bounds.min.y && p.y <= bounds.max.y && p.x <= bounds.max.x {
                    candidates.push((point, p));
                }
            }
            if candidates.is_empty() {
                continue;
            }

            for (face, bounds) in groups.faces(group) {
                let corners = groups.x.corners(groups.surface.faces()[face]);
                for &(point, p) in between(&candidates, bounds.min.z, bounds.max.z) {
                    if let Some(outward) = ray_crosses_triangle(p, corners) {
                        crossings.push((point, outward));
                    }
                }
            }
        }
        Ok(crossings)
    });

    let mut counts = vec![0; points.len()];
    for (point, outward) in crossings.into_iter().collect::<Result<Vec<_>, _>>()?.concat() {
        counts[point] += outward;
    }
    Ok(counts)
}

/// Returns the points whose z is in `min..=max`, of points in the order of z.
fn between(sorted: &[(usize, DVec3)], min: f64, max: f64) -> &[(usize, DVec3)] {
    let first = sorted.partition_point(|(_, p)| p.z < min);
    let rest = &sorted[first..];
    let count = rest.iter().take_while(|(_, p)| p.z <= max).count();
    &rest[..count]
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::icosphere;

    use super::*;
    use crate::accuracy::quasirandom;

    /// Reference implementation: solid angles of all faces. Three shells, one of them reversed,
    /// one twice there, and points at the corners.
    #[test]
    fn counts_are_winding_numbers() {
        let (outer, inner) = (icosphere(9.0, 2), icosphere(5.0, 2).flipped());
        let twice = icosphere(4.0, 1).translated(DVec3::new(6.0, 1.0, -2.0));
        let mesh = outer.joined(&inner).joined(&twice).joined(&twice);
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).expect("finite positions");
        let groups = FaceGroups::new(&surface, x);
        let mut points: Vec<DVec3> = (0..500).map(|n| (quasirandom(n) - 0.5) * 24.0).collect();
        points.extend([DVec3::ZERO, DVec3::X, DVec3::splat(1e3)]);
        points.extend(mesh.positions.iter().map(|corner| 1.001 * *corner));

        let counts = enclosures(&groups, &points, Progress::none()).expect("not interrupted");
        let mut found = [0; 4];
        for (p, count) in points.into_iter().zip(counts) {
            let expected = surface::winding_number(&surface, x, p);
            assert!((f64::from(count) - expected).abs() < 1e-9, "{count} {expected} {p}");
            found[usize::try_from(count).expect("no shell is enclosed by a reversed one")] += 1;
        }
        assert!(found.iter().all(|&points| points > 5), "{found:?}");
    }
}
