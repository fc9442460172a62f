//! Queries with a minimum separation, compared with densely sampled distances.

use arbitrary::{Result, Unstructured};
use ccd::CcdParams;
use glam::DVec3;

use crate::query_files::{self, Kind, LabeledQuery, read};
use crate::random::{check, point};

/// Returns the corners of the polygon of differences at a time.
fn polygon(kind: Kind, query: &LabeledQuery, t: f64) -> Vec<DVec3> {
    let x: Vec<DVec3> = (0..4).map(|i| query.x0[i] * (1.0 - t) + query.x1[i] * t).collect();
    match kind {
        Kind::VertexFace => vec![x[1] - x[0], x[2] - x[0], x[3] - x[0]],
        Kind::EdgeEdge => vec![x[2] - x[0], x[3] - x[0], x[3] - x[1], x[2] - x[1]],
    }
}

/// Computes the distance of a convex polygon from the origin.
fn distance(corners: &[DVec3]) -> f64 {
    let count = corners.len();
    let edges = || (0..count).map(|i| (corners[i], corners[(i + 1) % count]));
    let to_edge = |(a, b): (DVec3, DVec3)| {
        let ab = b - a;
        let share = (-a.dot(ab) / ab.length_squared()).clamp(0.0, 1.0);
        if share.is_nan() { a.length() } else { (a + share * ab).length() }
    };
    let to_edges = edges().map(to_edge).fold(f64::INFINITY, f64::min);
    let area = (corners[1] - corners[0]).cross(corners[count - 1] - corners[0]);
    let inside = edges().all(|(a, b)| area.dot(a.cross(b)) > 0.0);
    if inside { to_edges.min((area.dot(corners[0]) / area.length()).abs()) } else { to_edges }
}

/// Number of times at which distances are sampled before the minimum is refined.
const SAMPLES: u32 = 128;

/// Computes the minimum distance between two times: the smallest sample, then narrowed.
fn min_distance(kind: Kind, query: &LabeledQuery, from: f64, to: f64) -> f64 {
    let at = |t: f64| distance(&polygon(kind, query, t));
    let step = (to - from) / f64::from(SAMPLES);
    let times = (0..=SAMPLES).map(|i| from + f64::from(i) * step);
    let best = times.min_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(from);
    let (mut lo, mut hi) = ((best - step).max(from), (best + step).min(to));
    for _ in 0..60 {
        let (a, b) = (lo + 0.381_966 * (hi - lo), lo + 0.618_034 * (hi - lo));
        if at(a) < at(b) { hi = b } else { lo = a }
    }
    at(best).min(at(0.5 * (lo + hi)))
}

/// Excess distance of a contact that is allowed, relative to the separation.
const FALSE_ALARM: f64 = 1e-9;

/// Checks that a contact is neither late nor too far away.
fn check_query(kind: Kind, query: &LabeledQuery, d: f64) {
    let params = CcdParams { min_separation: d, ..CcdParams::DEFAULT };
    let contact = kind.query(query.x0, query.x1, &params).expect("the points are finite");
    // Nothing may come within the separation before the contact.
    let free_until = contact.map_or(1.0, |contact| contact.lo);
    let closest = min_distance(kind, query, 0.0, free_until);
    let from_start = contact.is_some_and(|contact| contact.at_start);
    assert!(
        from_start || closest >= d * (1.0 - 1e-9),
        "{closest:e} < {d:e} before {contact:?}: {query:?}"
    );
    // Something has to come within it during the contact.
    if let Some(contact) = contact {
        let size = query.x0.iter().chain(&query.x1).map(|x| x.length()).fold(0.0, f64::max);
        let closest = min_distance(kind, query, contact.lo, contact.hi);
        assert!(
            closest <= d * (1.0 + FALSE_ALARM) + 1e-14 * size,
            "{closest:e} > {d:e} during {contact:?}: {query:?}"
        );
    }
}

/// Draws four points of the cube −1..1 that move to four others.
fn query(u: &mut Unstructured<'_>) -> Result<LabeledQuery> {
    let mut points = || Ok([point(u, 1.0)?, point(u, 1.0)?, point(u, 1.0)?, point(u, 1.0)?]);
    Ok(LabeledQuery { x0: points()?, x1: points()?, time: f64::NAN, group: 0 })
}

#[test]
fn separations_agree_with_sampled_distances() {
    check(300, |u| {
        let query = query(u)?;
        for kind in [Kind::VertexFace, Kind::EdgeEdge] {
            for d in [0.2, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
                check_query(kind, &query, d);
            }
        }
        Ok(())
    });
}

/// Separations just below and just above the minimum distance of a step.
#[test]
fn a_separation_that_is_barely_kept_is_no_contact() {
    check(300, |u| {
        let query = query(u)?;
        for kind in [Kind::VertexFace, Kind::EdgeEdge] {
            let closest = min_distance(kind, &query, 0.0, 1.0);
            if closest < 1e-6 {
                continue;
            }
            for share in [1e-3, 1e-6, 1e-8, 1e-9] {
                check_query(kind, &query, closest * (1.0 - share));
                check_query(kind, &query, closest * (1.0 + share));
            }
        }
        Ok(())
    });
}

#[test]
fn separations_of_published_queries_agree_with_sampled_distances() {
    let Some(folder) = query_files::folder() else { return };
    for name in ["simbp_vf", "simhard_ee", "handcrafted_ee"] {
        let (kind, queries) = read(&folder.join(name).with_extension("ccdq"));
        for query in queries.iter().step_by(5) {
            for d in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
                check_query(kind, query, d);
            }
        }
    }
}
