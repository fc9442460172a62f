//! Results of overlap removal.

use musculo_collide::Scene;
use musculo_collide::resolve::Resolution;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::point_array;
use crate::record::{dict, pair};

/// Returns the record of a resolution.
pub(crate) fn record<'py>(
    py: Python<'py>,
    found: &Resolution,
    scene: &Scene,
) -> PyResult<Bound<'py, PyDict>> {
    let mut bodies = Vec::new();
    for change in &found.bodies {
        bodies.push(dict!(py, {
            name: scene.body(change.body).name(),
            displacements: point_array(py, &change.displacements),
            moved: change.moved,
            max_displacement: change.max_displacement,
            strain: change.strain,
            volume_ratio: change.volume_ratio,
            flipped_faces: change.flipped_faces,
            self_crossings: (change.self_crossings[0], change.self_crossings[1]),
        }));
    }

    let mut remaining = Vec::new();
    for left in &found.remaining {
        let [a, b] = scene.names(left.pair);
        remaining.push(dict!(py, {
            a: a,
            b: b,
            depth: (left.depth.lower, left.depth.upper),
            crossing_faces: left.crossing_faces,
            at_first: left.at_first,
            reason: left.obstacle.to_string(),
        }));
    }

    let mut short_gaps = Vec::new();
    for short in &found.gap.short {
        let [a, b] = scene.names(short.pair);
        short_gaps.push(dict!(py, {
            a: a,
            b: b,
            distance: (short.distance.lower, short.distance.upper),
            reason: short.obstacle.to_string(),
        }));
    }

    let mut self_overlaps = Vec::new();
    for body in &found.self_overlaps {
        self_overlaps.push(scene.body(*body).name());
    }

    let mut broken_limits = Vec::new();
    for broken in &found.broken_limits {
        broken_limits.push(dict!(py, {
            name: scene.body(broken.body).name(),
            volume_change: broken.volume_change,
            max_displacement: broken.max_displacement,
            displacement_limit: broken.displacement_limit,
            strain: broken.strain,
            flipped_faces: broken.flipped_faces,
            flat_corners: broken.flat_corners,
            self_crossings: broken.self_crossings,
        }));
    }

    let mut ties = Vec::new();
    for tie in &found.ties {
        ties.push(dict!(py, {
            a: scene.body(tie.follower).name(),
            b: scene.body(tie.leader).name(),
            tied: tie.tied,
            crossing: tie.crossing,
            loose: tie.loose,
            distance: tie.distance,
            max_distance: tie.max_distance,
        }));
    }

    let pairs = |reports: &[musculo_collide::PairReport]| -> PyResult<Vec<Bound<'py, PyDict>>> {
        reports.iter().map(|report| pair(py, report, scene)).collect()
    };
    Ok(dict!(py, {
        resolved: found.resolved,
        rounds: found.rounds.len().saturating_sub(1),
        final_round: found.final_round,
        is_continued: found.is_continued,
        before: pairs(&found.before)?,
        after: pairs(&found.after)?,
        bodies: bodies,
        remaining: remaining,
        gap: found.gap.gap,
        short_gaps: short_gaps,
        broken_limits: broken_limits,
        ties: ties,
        self_overlaps: self_overlaps,
    }))
}
