//! `motion --until-contact`: the first contact of each pair in a motion.

use std::collections::BTreeSet;

use musculo_collide::{
    BodyId, CheckParams, PairId, PairSweep, PathMove, Progress, Scene, SceneError, ccd,
};

use crate::failure::Failure;
use crate::motion::Replay;
use crate::phase::Phase;
use crate::report::{MeetingTimeRecord, UntilContactDocument};
use crate::scene::Unit;

/// Finds the first contact of each pair that does not overlap in the first frame.
///
/// No contact is missed, and no time is after the true one, on the paths of the motion.
pub(super) fn first_contacts(
    scene: &mut Scene,
    replay: &Replay,
    unit: Unit,
) -> Result<UntilContactDocument, Failure> {
    replay.place(scene, 0)?;
    let overlapping = overlapping_pairs(scene)?;
    for pair in &overlapping {
        scene.ignore(pair.a, pair.b);
    }

    let frames = replay.frame_count();
    let phase = Phase::with_steps("replaying", frames - 1);
    let ids: Vec<BodyId> = scene.ids().collect();
    let mut contacts = Vec::new();
    for frame in 0..frames - 1 {
        replay.place(scene, frame)?;
        let mut paths = Vec::new();
        for body in 0..ids.len() {
            paths.push(replay.path(body, frame));
        }
        let mut moves = Vec::new();
        for (&body, path) in ids.iter().zip(&paths) {
            moves.push(PathMove { body, path });
        }
        let swept = scene.first_contacts(&moves, &ccd::CcdParams::EXACT, Progress::none())?;

        // A pair that has met has no other first contact.
        let begin = contacts.len();
        for pair in &swept.pairs {
            contacts.extend(record(scene, replay, frame, pair, &moves));
            scene.ignore(pair.pair.a, pair.pair.b);
        }
        contacts[begin..].sort_by(|p, q| p.fraction.total_cmp(&q.fraction));
        phase.step();
    }
    let overlapping = names(scene, &overlapping);
    Ok(UntilContactDocument { unit, frames, overlapping, contacts })
}

/// Records the first contact of a pair on the way from a frame to the next.
fn record(
    scene: &Scene,
    replay: &Replay,
    frame: usize,
    pair: &PairSweep,
    moves: &[PathMove<'_>],
) -> Option<MeetingTimeRecord> {
    let first = pair.contacts.first()?;
    let fraction = first.contact.time.unwrap_or(1.0);
    let times = replay.time(frame).zip(replay.time(frame + 1));
    let [a, b] = scene.names(pair.pair).map(str::to_owned);
    Some(MeetingTimeRecord {
        a,
        b,
        frame,
        fraction,
        time: times.map(|(from, to)| from + fraction * (to - from)),
        certain: first.certain,
        at: scene.contact_place(pair.pair, first, moves).to_array(),
    })
}

/// Returns the pairs that overlap in the present state.
pub(super) fn overlapping_pairs(scene: &mut Scene) -> Result<BTreeSet<PairId>, SceneError> {
    let params = CheckParams { measures: false, ..CheckParams::new(0.0) };
    let mut overlapping = BTreeSet::new();
    for report in scene.check(&params, Progress::none())? {
        if report.overlaps {
            overlapping.insert(report.pair);
        }
    }
    Ok(overlapping)
}

/// Returns the names of pairs.
pub(super) fn names(scene: &Scene, pairs: &BTreeSet<PairId>) -> Vec<[String; 2]> {
    let mut names = Vec::new();
    for &pair in pairs {
        names.push(scene.names(pair).map(str::to_owned));
    }
    names
}
