//! Faces and pairs of edges so thin that the squares of their areas underflow.

use ccd::{CcdContact, CcdParams, MovingPoints, edge_edge, vertex_face};
use glam::DVec3;

/// Coordinates of a query at a height over the plane of its second primitive.
type Query = fn(f64, f64) -> [DVec3; 4];

/// A vertex over a face of two short edges.
fn small_face(height: f64, thickness: f64) -> [DVec3; 4] {
    let short = thickness.sqrt();
    [height * DVec3::Z, DVec3::ZERO, short * DVec3::X, short * DVec3::Y]
}

/// A vertex over the middle of a needle.
fn needle(height: f64, thickness: f64) -> [DVec3; 4] {
    let middle = 0.5 * DVec3::X;
    [middle + height * DVec3::Z, DVec3::ZERO, DVec3::X, middle + thickness * DVec3::Y]
}

/// Two edges above each other, nearly parallel.
fn parallel_edges(height: f64, thickness: f64) -> [DVec3; 4] {
    let up = height * DVec3::Z;
    [up - DVec3::X, up + DVec3::X, thickness * DVec3::Y - DVec3::X, DVec3::X]
}

/// Returns the contact of a query whose height falls from one number to another, alone and in a
/// batch, which agree.
fn falling(query: Query, [from, to]: [f64; 2], thickness: f64, d: f64) -> Option<CcdContact> {
    let (x0, x1) = (query(from, thickness), query(to, thickness));
    let params = CcdParams { min_separation: d, ..CcdParams::DEFAULT };
    let motion = MovingPoints::new(&x0, &x1).expect("finite points");
    let all = [[0, 1, 2, 3]];
    let is_edges = query as usize == parallel_edges as Query as usize;
    let (alone, batch) = if is_edges {
        (edge_edge(x0, x1, &params), motion.edge_edge_contacts(&all, &params))
    } else {
        (vertex_face(x0, x1, &params), motion.vertex_face_contacts(&all, &params))
    };
    let alone = alone.expect("valid");
    let batch = batch.expect("valid").first().map(|found| found.contact);
    assert_eq!(alone, batch, "{from} to {to} at a thickness of {thickness:e}");
    alone
}

const QUERIES: [Query; 3] = [small_face, needle, parallel_edges];

const THICKNESSES: [f64; 6] = [1e-120, 1e-155, 1e-161, 1e-163, 1e-170, 1e-300];

#[test]
fn separations_from_thin_polygons_are_kept() {
    for query in QUERIES {
        for thickness in THICKNESSES {
            let contact = falling(query, [2.0, 0.5], thickness, 1.0).expect("within 1 at 2/3");
            assert!(contact.lo <= 2.0 / 3.0 && contact.lo > 0.66, "{contact:?} at {thickness:e}");
            assert_eq!(falling(query, [2.0, 1.5], thickness, 1.0), None, "{thickness:e}");
        }
    }
}

#[test]
fn contacts_with_thin_polygons_have_weights_and_a_normal() {
    for query in QUERIES {
        for thickness in THICKNESSES {
            let contact = falling(query, [1.0, -1.0], thickness, 0.0).expect("it falls through");
            let CcdContact { lo, weights, normal, .. } = contact;
            let sum: f64 = weights.iter().sum();
            assert!(lo <= 0.5 && lo > 0.49, "{contact:?} at {thickness:e}");
            assert!(sum.abs() < 1e-12 && weights[0] <= 0.0, "{contact:?} at {thickness:e}");
            assert!((normal.length() - 1.0).abs() < 1e-12, "{contact:?} at {thickness:e}");
        }
    }
}
