//! What resolving every frame of a motion did, frame by frame, and its table.

use musculo_collide::{BodyId, Resolution};
use serde::Serialize;

use super::text::{Align, TextTable, counted, grouped, length};
use crate::scene::Unit;

/// All frames of a motion.
#[derive(Debug, Serialize)]
pub(crate) struct ResolvedDocument {
    pub(crate) unit: Unit,
    pub(crate) frames: Vec<ResolvedFrame>,
}

/// One frame, before and after.
#[derive(Debug, Serialize)]
pub(crate) struct ResolvedFrame {
    frame: usize,
    /// As the motion tells it.
    time: Option<f64>,
    /// Whether nothing overlaps by more than the tolerance, and nothing new.
    resolved: bool,
    before: OverlapRecord,
    after: OverlapRecord,
    /// Pairs that overlap and did not at first.
    new_pairs: usize,
    remaining: Vec<RemainingRecord>,
    /// Rounds of detection and pushing.
    rounds: usize,
    /// Length of the longest displacement.
    max_displacement: f64,
    /// Largest change of a body's volume, as a share.
    max_volume_change: f64,
    flipped_faces: usize,
    /// Pairs of faces of one body that cross, before and after.
    self_crossings: [usize; 2],
}

/// How much overlaps.
#[derive(Debug, Serialize)]
struct OverlapRecord {
    pairs: usize,
    deepest: f64,
}

/// A pair that still overlaps.
#[derive(Debug, Serialize)]
struct RemainingRecord {
    a: String,
    b: String,
    depth: f64,
    crossing_face_pairs: usize,
    at_first: bool,
    why: String,
}

impl ResolvedDocument {
    /// Whether every frame is resolved.
    pub(crate) fn is_resolved(&self) -> bool {
        self.frames.iter().all(|frame| frame.resolved)
    }
}

impl ResolvedFrame {
    pub(crate) fn new(
        (frame, time): (usize, Option<f64>),
        scene: &musculo_collide::Scene,
        resolution: &Resolution,
    ) -> Self {
        let bodies = || resolution.bodies.iter();
        let name = |id: BodyId| scene.body(id).name().to_owned();
        let remaining: Vec<RemainingRecord> = resolution
            .remaining
            .iter()
            .map(|pair| RemainingRecord {
                a: name(pair.pair.a),
                b: name(pair.pair.b),
                depth: pair.depth,
                crossing_face_pairs: pair.crossing_faces,
                at_first: pair.at_first,
                why: pair.obstacle.to_string(),
            })
            .collect();
        let first = &resolution.rounds[0];
        let deepest = remaining.iter().map(|pair| pair.depth).fold(0.0, f64::max);
        let volume_changes = bodies().filter_map(|change| Some((change.volume_ratio? - 1.0).abs()));
        let crossings = |when: usize| bodies().map(|change| change.self_crossings[when]).sum();
        Self {
            frame,
            time,
            resolved: resolution.resolved,
            before: OverlapRecord { pairs: first.overlapping_pairs, deepest: first.max_depth },
            after: OverlapRecord { pairs: remaining.len(), deepest },
            new_pairs: remaining.iter().filter(|pair| !pair.at_first).count(),
            remaining,
            rounds: resolution.rounds.len() - 1,
            max_displacement: bodies().map(|change| change.max_displacement).fold(0.0, f64::max),
            max_volume_change: volume_changes.fold(0.0, f64::max),
            flipped_faces: bodies().map(|change| change.flipped_faces).sum(),
            self_crossings: [crossings(0), crossings(1)],
        }
    }
}

/// A line a frame with the seconds it took, what remains and why, and a summary.
pub(crate) fn resolved_table(document: &ResolvedDocument, seconds: &[f64]) -> String {
    let unit = document.unit;
    let symbol = unit.symbol();
    let mut table = TextTable::new(&[
        ("FRAME", Align::Right),
        ("TIME", Align::Right),
        ("OVERLAPS", Align::Right),
        (&format!("DEEPEST {symbol}"), Align::Right),
        ("LEFT", Align::Right),
        ("NEW", Align::Right),
        (&format!("DEEPEST {symbol}"), Align::Right),
        (&format!("FARTHEST {symbol}"), Align::Right),
        ("VOLUME %", Align::Right),
        ("FLIPPED", Align::Right),
        ("SELF-CROSSINGS", Align::Right),
        ("ROUNDS", Align::Right),
        ("SECONDS", Align::Right),
    ]);
    for (frame, seconds) in document.frames.iter().zip(seconds) {
        table.row(vec![
            frame.frame.to_string(),
            frame.time.map_or_else(|| "-".to_owned(), |time| format!("{time:.3}")),
            grouped(frame.before.pairs),
            length(frame.before.deepest, unit),
            grouped(frame.after.pairs),
            grouped(frame.new_pairs),
            length(frame.after.deepest, unit),
            length(frame.max_displacement, unit),
            format!("{:.2}", 100.0 * frame.max_volume_change),
            grouped(frame.flipped_faces),
            format!("{} -> {}", frame.self_crossings[0], frame.self_crossings[1]),
            grouped(frame.rounds),
            format!("{seconds:.2}"),
        ]);
    }
    format!("{}\n{}{}\n", table.render(), remaining(document), summary(document, seconds))
}

/// What still overlaps, frame by frame.
fn remaining(document: &ResolvedDocument) -> String {
    let symbol = document.unit.symbol();
    let lines = document.frames.iter().flat_map(|frame| {
        frame.remaining.iter().map(move |pair| {
            format!(
                "frame {}: {} and {}: {} {symbol} deep, {} crossing{}: {}\n",
                frame.frame,
                pair.a,
                pair.b,
                length(pair.depth, document.unit),
                counted(pair.crossing_face_pairs, "face pair"),
                if pair.at_first { "" } else { " (not at first)" },
                pair.why
            )
        })
    });
    lines.collect()
}

fn summary(document: &ResolvedDocument, seconds: &[f64]) -> String {
    let frames = || document.frames.iter();
    let deepest =
        |of: fn(&ResolvedFrame) -> f64| length(frames().map(of).fold(0.0, f64::max), document.unit);
    let unresolved = frames().filter(|frame| !frame.resolved).count();
    let mut sorted = seconds.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.get(sorted.len() / 2).copied().unwrap_or_default();
    let slowest = sorted.last().copied().unwrap_or_default();
    format!(
        "{}, {} not resolved: deepest {} {symbol} before, {} {symbol} after; {:.2} s, at most {slowest:.2} s a frame, in the middle {middle:.2} s.",
        counted(document.frames.len(), "frame"),
        grouped(unresolved),
        deepest(|frame| frame.before.deepest),
        deepest(|frame| frame.after.deepest),
        seconds.iter().sum::<f64>(),
        symbol = document.unit.symbol(),
    )
}
