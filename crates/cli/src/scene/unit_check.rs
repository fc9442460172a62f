//! Detection of bodies in another unit than the rest of the scene.

use musculo_collide::surface::Aabb;

/// Minimum ratio of two boxes' diagonals that indicates different units. Diagonals in one
/// limb differ from the median by up to twenty, in meters and millimeters by a thousand.
/// A larger ratio would miss a long bone in meters beside a kneecap in millimeters, a
/// smaller one would suspect small ligaments.
const SUSPICIOUS_RATIO: f64 = 50.0;

/// Returns a warning for each body whose size differs much from that of the median body.
pub(crate) fn unit_warnings(bodies: &[(&str, Aabb)]) -> Vec<String> {
    // The median is that of the scene's unit if fewer than half of the bodies are in another.
    let mut by_size = bodies.to_vec();
    by_size.sort_by(|a, b| a.1.diagonal().total_cmp(&b.1.diagonal()));
    let Some(&(median_name, median)) = by_size.get(by_size.len() / 2) else {
        return Vec::new();
    };

    let mut warnings = Vec::new();
    for &(name, bounds) in bodies {
        // Much larger is as suspicious as much smaller.
        let (size, median_size) = (bounds.diagonal(), median.diagonal());
        if size.max(median_size) > SUSPICIOUS_RATIO * size.min(median_size) {
            warnings.push(format!(
                "'{name}' may have another unit than '{median_name}': its box is {}, that of \
                 '{median_name}' is {}",
                corners(bounds),
                corners(median)
            ));
        }
    }
    warnings
}

fn corners(Aabb { min, max }: Aabb) -> String {
    format!(
        "({:.4}, {:.4}, {:.4}) to ({:.4}, {:.4}, {:.4})",
        min.x, min.y, min.z, max.x, max.y, max.z
    )
}
