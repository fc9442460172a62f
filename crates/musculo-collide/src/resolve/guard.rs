//! Keeps triangles from turning over.

use glam::DVec3;
use surface::TriangleSurface;

use super::tissue::Tissue;

/// Smallest cosine between a face's normal before and after: 0 would be a face
/// that stands on its edge, from where rounding turns it over.
const UPRIGHT: f64 = 0.2;

/// Passes over faces that lean too far. Each halves what tells their corners
/// from their surroundings.
const PASSES: usize = 20;

/// Smooths the displacement around faces that lean over, until none does.
pub(super) fn unfold(surface: &TriangleSurface, tissue: &Tissue, x: &mut [DVec3]) {
    let mut leaning = leaning(surface, tissue, x, UPRIGHT);
    for _ in 0..PASSES {
        if leaning.is_empty() {
            return;
        }
        let mut corners: Vec<u32> =
            leaning.iter().flat_map(|&face| surface.faces()[face as usize]).collect();
        corners.sort_unstable();
        corners.dedup();
        smooth(tissue, &corners, x);
        leaning = self::leaning(surface, tissue, x, UPRIGHT);
    }
}

/// How many faces are turned by a right angle and more.
pub(super) fn flipped(surface: &TriangleSurface, tissue: &Tissue, x: &[DVec3]) -> usize {
    leaning(surface, tissue, x, 0.0).len()
}

/// Faces whose normal has turned so far that the cosine is at most `limit`.
fn leaning(surface: &TriangleSurface, tissue: &Tissue, x: &[DVec3], limit: f64) -> Vec<u32> {
    let moved = |v: u32| x[v as usize] != tissue.rest[v as usize];
    let normal = |x: &[DVec3], face: [u32; 3]| {
        let [p, q, r] = face.map(|v| x[v as usize]);
        (q - p).cross(r - p)
    };
    let leans = |face: [u32; 3]| {
        let (before, after) = (normal(&tissue.rest, face), normal(x, face));
        before != DVec3::ZERO && before.dot(after) <= limit * before.length() * after.length()
    };
    let faces = (0..).zip(surface.faces());
    faces
        .filter(|&(_, &face)| face.into_iter().any(moved) && leans(face))
        .map(|(face, _)| face)
        .collect()
}

/// Takes each vertex halfway to the mean displacement of its neighbours.
fn smooth(tissue: &Tissue, vertices: &[u32], x: &mut [DVec3]) {
    for &vertex in vertices {
        let of = |v: u32| x[v as usize] - tissue.rest[v as usize];
        let links = tissue.neighbours(vertex);
        let stiffness: f64 = links.iter().map(|(_, k)| k).sum();
        if stiffness > 0.0 {
            let mean = links.iter().map(|&(v, k)| k * of(v)).sum::<DVec3>() / stiffness;
            let u = 0.5 * (of(vertex) + mean);
            x[vertex as usize] = tissue.rest[vertex as usize] + u;
        }
    }
}
