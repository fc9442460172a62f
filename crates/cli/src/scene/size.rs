//! Boxes around bodies, and the suspicion that one is in another unit.

use glam::DVec3;
use serde::Serialize;

/// The box around a body, along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Bounds {
    pub(crate) min: [f64; 3],
    pub(crate) max: [f64; 3],
}

/// How many times longer a box's diagonal must be than another's before it
/// looks like a mistake of unit. The bodies of one limb differ from the middle
/// one by up to twenty, metres and millimetres by a thousand: a larger ratio
/// would miss a long bone in metres beside a kneecap in millimetres, a smaller
/// one would suspect small ligaments.
const SUSPICIOUS_RATIO: f64 = 50.0;

impl Bounds {
    /// The box around the points, of which there is at least one.
    pub(crate) fn of(positions: &[DVec3]) -> Self {
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (min, max) = positions.iter().fold(empty, |(min, max), &p| (min.min(p), max.max(p)));
        Self { min: min.to_array(), max: max.to_array() }
    }

    pub(crate) fn diagonal(&self) -> f64 {
        DVec3::from_array(self.min).distance(DVec3::from_array(self.max))
    }
}

impl std::fmt::Display for Bounds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let corner = |[x, y, z]: [f64; 3]| format!("({x:.4}, {y:.4}, {z:.4})");
        write!(f, "{} to {}", corner(self.min), corner(self.max))
    }
}

/// One warning for each body whose size is far from that of the median body.
pub(crate) fn unit_warnings(bodies: &[(&str, Bounds)]) -> Vec<String> {
    let mut by_size: Vec<&(&str, Bounds)> = bodies.iter().collect();
    by_size.sort_by(|a, b| a.1.diagonal().total_cmp(&b.1.diagonal()));
    let Some((median_name, median)) = by_size.get(by_size.len() / 2).copied() else {
        return Vec::new();
    };
    let is_suspicious = |bounds: &Bounds| {
        let [small, large] =
            if bounds.diagonal() < median.diagonal() { [bounds, median] } else { [median, bounds] };
        large.diagonal() > SUSPICIOUS_RATIO * small.diagonal()
    };
    let warning = |(name, bounds): &(&str, Bounds)| {
        format!(
            "'{name}' may be in another unit than '{median_name}': \
             its box is {bounds}, that of '{median_name}' is {median}"
        )
    };
    bodies.iter().filter(|(_, bounds)| is_suspicious(bounds)).map(warning).collect()
}
