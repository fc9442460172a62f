//! Area that two triangles of one plane have in common.

use glam::DVec3;

/// Computes the common area of two triangles that lie in one plane exactly.
///
/// Source: I. E. Sutherland and G. W. Hodgman, "Reentrant Polygon Clipping", Communications of the
/// ACM 17(1), 1974: the first triangle is clipped by the edges of the second.
pub(crate) fn common_area(a: [DVec3; 3], b: [DVec3; 3]) -> f64 {
    let [origin, ..] = b;
    let normal = (b[1] - b[0]).cross(b[2] - b[0]).normalize_or_zero();
    let mut polygon = vec![a[0] - origin, a[1] - origin, a[2] - origin];
    let mut clipped = Vec::with_capacity(6);

    // What is left lies on the inner side of every edge.
    for k in 0..3 {
        let from = b[k] - origin;
        let inward = normal.cross(b[(k + 1) % 3] - b[k]);
        clip(&polygon, from, inward, &mut clipped);
        std::mem::swap(&mut polygon, &mut clipped);
    }

    // Area vector of the polygon about the origin.
    let mut twice_area = DVec3::ZERO;
    for (i, &from) in polygon.iter().enumerate() {
        twice_area += from.cross(polygon[(i + 1) % polygon.len()]);
    }
    0.5 * twice_area.dot(normal).abs()
}

/// Keeps the part of a convex polygon on the inner side of a line.
fn clip(polygon: &[DVec3], on_line: DVec3, inward: DVec3, out: &mut Vec<DVec3>) {
    out.clear();
    for (i, &from) in polygon.iter().enumerate() {
        let to = polygon[(i + 1) % polygon.len()];
        // Corners on the inner side stay; an edge that passes the line gets a corner on it.
        let (height, next) = (inward.dot(from - on_line), inward.dot(to - on_line));
        if height >= 0.0 {
            out.push(from);
        }
        if (height > 0.0 && next < 0.0) || (height < 0.0 && next > 0.0) {
            out.push(from + height / (height - next) * (to - from));
        }
    }
}
