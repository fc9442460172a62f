//! Report of overlap removal in every frame of a motion.

use std::collections::BTreeSet;

use musculo_collide::{
    Conditions, DepthBracket, DistanceBracket, PairId, Remaining, Resolution, ResolveParams, Scene,
    ShortGap,
};
use serde::Serialize;

use super::attachment_record::AttachmentRecord;
use super::frame_times::FrameTimes;
use super::resolution::{
    gap_obstacle_text, ignored_pairs, left_out_text, obstacle_text, remaining_text,
};
use super::resolution_document::BrokenRecord;
use super::table::{Table, right};
use super::text::{counted, depth, grouped, length, measure};
use super::tie_record::TieRecord;
use crate::scene::Unit;

/// All frames of a motion.
#[derive(Debug, Serialize)]
pub(crate) struct ResolvedDocument {
    unit: Unit,
    /// Distance that was asked for between all surfaces; 0 for none.
    gap: f64,
    /// Depth up to which overlaps of the start may be left.
    tolerance: f64,
    /// True if every frame is resolved.
    pub(crate) resolved: bool,
    /// Pairs that the gap is not asked of, in words.
    #[serde(skip)]
    left_out: String,
    /// Ties and fixed vertices of soft bodies of pairs that do not come apart in some frame.
    attachments: Vec<AttachmentRecord>,
    frames: Vec<ResolvedFrame>,
}

/// Frame before and after overlap removal.
#[derive(Debug, Serialize)]
pub(crate) struct ResolvedFrame {
    frame: usize,
    /// Time, if the motion has one.
    time: Option<f64>,
    /// True if no overlap exceeds the tolerance or is new, and the gap is proved for all pairs.
    resolved: bool,
    before: OverlapRecord,
    after: OverlapRecord,
    /// True if displacements of the frame before were not the start, where there were any: tissue may be on another
    /// side of a bone than in that frame.
    starts_anew: bool,
    /// Number of pairs that overlap and did not at the start.
    new_pairs: usize,
    remaining: Vec<RemainingRecord>,
    /// Pairs that are not proved to keep the gap, the nearest first.
    short_gaps: Vec<ShortGapRecord>,
    /// Bodies that a better state would bring beyond their limits.
    broken_limits: Vec<BrokenRecord>,
    ties: Vec<TieRecord>,
    /// Bodies that were to be uncrossed and still cross themselves.
    self_overlaps: Vec<String>,
    /// Number of rounds of detection and pushing.
    rounds: usize,
    /// Number of the round whose state is kept.
    final_round: usize,
    /// Length of the longest displacement.
    max_displacement: f64,
    /// Largest relative change of a body's volume.
    max_volume_change: f64,
    flipped_faces: usize,
    /// Number of pairs of faces of one body that cross, before and after.
    self_crossings: [usize; 2],
    /// Time of computation.
    #[serde(skip)]
    seconds: f64,
}

/// Number and depth of overlaps.
#[derive(Debug, Serialize)]
struct OverlapRecord {
    pairs: usize,
    deepest: f64,
}

/// Pair that still overlaps.
#[derive(Debug, Serialize)]
struct RemainingRecord {
    a: String,
    b: String,
    depth: DepthBracket,
    crossing_face_pairs: usize,
    at_first: bool,
    reason: String,
    /// The same in words.
    #[serde(skip)]
    text: String,
}

/// Pair that is not proved to keep the gap.
#[derive(Debug, Serialize)]
struct ShortGapRecord {
    a: String,
    b: String,
    /// Certified distance of the surfaces; 0 where they overlap.
    distance: DistanceBracket,
    reason: String,
}

/// Frame of a motion, with the time that its computation took.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameInfo {
    pub(crate) frame: usize,
    pub(crate) time: Option<f64>,
    pub(crate) seconds: f64,
}

impl ResolvedFrame {
    /// Marks the frame as one that goes on from one before it, unless that had displacements which it has not.
    pub(crate) fn follow(&mut self, before: Option<&Self>) {
        self.starts_anew &= before.is_some_and(|before| before.max_displacement > 0.0);
    }

    pub(crate) fn new(
        info: FrameInfo,
        scene: &Scene,
        unit: Unit,
        params: &ResolveParams,
        resolution: &Resolution,
    ) -> Self {
        // Before and after, depth is that of surfaces as far as it is certain. Without a pair it
        // would be that of a body in itself.
        let start = &resolution.rounds[0];
        let pairs = resolution.before.iter().filter(|report| report.overlaps).count();
        let deepest = start.surface_depth.map_or(start.max_depth, |depth| depth.lower);
        let before = OverlapRecord { pairs, deepest: if pairs > 0 { deepest } else { 0.0 } };
        let names = resolution.self_overlaps.iter().map(|id| scene.body(*id).name().to_owned());
        let mut record = Self {
            frame: info.frame,
            time: info.time,
            resolved: resolution.resolved,
            before,
            after: OverlapRecord { pairs: resolution.remaining.len(), deepest: 0.0 },
            starts_anew: !resolution.is_continued,
            new_pairs: 0,
            remaining: Vec::new(),
            short_gaps: Vec::new(),
            broken_limits: Vec::new(),
            ties: Vec::new(),
            self_overlaps: names.collect(),
            rounds: resolution.rounds.len() - 1,
            final_round: resolution.final_round,
            max_displacement: 0.0,
            max_volume_change: 0.0,
            flipped_faces: 0,
            self_crossings: [0; 2],
            seconds: info.seconds,
        };

        // The worst of all pairs and of all bodies.
        for pair in &resolution.remaining {
            record.after.deepest = record.after.deepest.max(pair.depth.lower);
            record.new_pairs += usize::from(!pair.at_first);
            record.remaining.push(RemainingRecord::new(pair, scene, unit));
        }
        for short in &resolution.gap.short {
            record.short_gaps.push(ShortGapRecord::new(short, scene, unit));
        }
        for broken in &resolution.broken_limits {
            record.broken_limits.push(BrokenRecord::new(broken, params, scene));
        }
        for tie in &resolution.ties {
            record.ties.push(TieRecord::new(tie, scene, unit, params));
        }
        for change in &resolution.bodies {
            // An open body has no volume that could change.
            let volume_change = change.volume_ratio.map_or(0.0, |ratio| (ratio - 1.0).abs());
            record.max_displacement = record.max_displacement.max(change.max_displacement);
            record.max_volume_change = record.max_volume_change.max(volume_change);
            record.flipped_faces += change.flipped_faces;
            record.self_crossings[0] += change.self_crossings[0];
            record.self_crossings[1] += change.self_crossings[1];
        }

        record
    }
}

impl ResolvedFrame {
    /// Returns true if a pair of a body overlaps, or is not proved to keep the gap.
    fn is_left(&self, body: &str) -> bool {
        self.remaining.iter().any(|pair| body == pair.a || body == pair.b)
            || self.short_gaps.iter().any(|pair| body == pair.a || body == pair.b)
    }

    /// Writes the number of rounds, after that of an earlier one whose state is kept.
    fn rounds_text(&self) -> String {
        if self.final_round < self.rounds {
            format!("{} of {}", self.final_round, self.rounds)
        } else {
            grouped(self.rounds)
        }
    }
}

impl OverlapRecord {
    fn depth_text(&self, unit: Unit) -> String {
        if self.pairs > 0 { depth(self.deepest, unit) } else { length(0.0, unit) }
    }
}

impl RemainingRecord {
    fn new(pair: &Remaining, scene: &Scene, unit: Unit) -> Self {
        let [a, b] = scene.names(pair.pair);
        Self {
            a: a.to_owned(),
            b: b.to_owned(),
            depth: pair.depth,
            crossing_face_pairs: pair.crossing_faces,
            at_first: pair.at_first,
            reason: obstacle_text(&pair.obstacle, unit),
            text: remaining_text(pair, unit),
        }
    }
}

impl ShortGapRecord {
    fn new(short: &ShortGap, scene: &Scene, unit: Unit) -> Self {
        let [a, b] = scene.names(short.pair).map(str::to_owned);
        let reason = gap_obstacle_text(&short.obstacle, unit);
        Self { a, b, distance: short.distance, reason }
    }
}

impl ResolvedDocument {
    /// Gathers the frames of a scene under conditions.
    pub(crate) fn new(
        unit: Unit,
        params: &ResolveParams,
        scene: &Scene,
        conditions: &Conditions,
        frames: Vec<ResolvedFrame>,
    ) -> Self {
        let resolved = frames.iter().all(|frame| frame.resolved);
        let ties = conditions.ties.iter().map(|tie| PairId::new(tie.bodies[0], tie.bodies[1]));
        let tied: BTreeSet<PairId> = ties.collect();
        let left_out = left_out_text(tied.len(), ignored_pairs(scene).len());
        let is_left = |name: &str| frames.iter().any(|frame| frame.is_left(name));
        let attachments = AttachmentRecord::list(conditions, scene, is_left);
        let &ResolveParams { gap, tolerance, .. } = params;
        Self { unit, gap, tolerance, resolved, left_out, attachments, frames }
    }

    /// Writes one line per frame, the pairs that are left with their reasons, and a summary.
    pub(crate) fn to_text(&self) -> String {
        let mut text = self.table().to_text() + "\n";

        for frame in &self.frames {
            for RemainingRecord { a, b, text: pair, .. } in &frame.remaining {
                text += &format!("frame {}: {a} × {b}: {pair}", frame.frame);
                text += &if frame.resolved { self.within_tolerance() } else { String::new() };
                text += "\n";
            }

            // Pairs that overlap are named above.
            let is_near = |short: &&ShortGapRecord| short.distance.upper > 0.0;
            for ShortGapRecord { a, b, distance, reason } in frame.short_gaps.iter().filter(is_near)
            {
                let (number, unit) = (frame.frame, self.unit.symbol());
                let distance = length(distance.lower, self.unit);
                text += &format!("frame {number}: {a} × {b}: {distance} {unit} apart: {reason}\n");
            }
            for broken in &frame.broken_limits {
                text += &format!("frame {}: {}\n", frame.frame, broken.text(self.unit));
            }
            if frame.starts_anew {
                text += &format!(
                    "frame {}: starts anew, without the displacements of the frame before: tissue may be on \
                     another side of a bone than there\n",
                    frame.frame
                );
            }
            for torn in frame.ties.iter().filter_map(TieRecord::torn_text) {
                text += &format!("frame {}: {torn}\n", frame.frame);
            }
            for body in &frame.self_overlaps {
                text += &format!("frame {}: {body} still crosses itself\n", frame.frame);
            }
        }

        for attachment in &self.attachments {
            text += &format!("{}.\n", attachment.text());
        }
        text += &self.summary();
        if self.gap > 0.0 && self.resolved {
            text += &format!(
                "The gap of {} {} is proved in every frame for all pairs{}, faces and edges \
                 included.\n",
                measure(self.gap),
                self.unit.symbol(),
                self.left_out,
            );
        } else if !self.resolved {
            text += "Files of frames that are not resolved have '_unproved' in their names.\n";
        }
        text
    }

    fn within_tolerance(&self) -> String {
        format!("; within the tolerance of {} {}", measure(self.tolerance), self.unit.symbol())
    }

    fn table(&self) -> Table {
        let unit = self.unit.symbol();

        // What overlaps before, what is left after, and what the removal changed and cost.
        let mut table = Table::new([
            right("frame"),
            right("time"),
            right("overlaps"),
            right(format!("deepest [{unit}]")),
            right("remaining"),
            right("new"),
            right(format!("deepest [{unit}]")),
            right(format!("max displacement [{unit}]")),
            right("volume [%]"),
            right("flipped faces"),
            right("self-crossings"),
            right("rounds"),
            right("removal [s]"),
        ]);

        let times = FrameTimes::new(self.frames.iter().map(|frame| frame.time));
        for frame in &self.frames {
            let [before, after] = frame.self_crossings;
            table.row([
                frame.frame.to_string(),
                times.text(frame.time),
                grouped(frame.before.pairs),
                frame.before.depth_text(self.unit),
                grouped(frame.after.pairs),
                grouped(frame.new_pairs),
                frame.after.depth_text(self.unit),
                length(frame.max_displacement, self.unit),
                format!("{:.2}", 100.0 * frame.max_volume_change),
                grouped(frame.flipped_faces),
                format!("{before} -> {after}"),
                frame.rounds_text(),
                format!("{:.2}", frame.seconds),
            ]);
        }
        table
    }

    fn summary(&self) -> String {
        let (mut before, mut after, mut unresolved) = (0.0_f64, 0.0_f64, 0);
        let mut seconds = Vec::new();

        for frame in &self.frames {
            before = before.max(frame.before.deepest);
            after = after.max(frame.after.deepest);
            unresolved += usize::from(!frame.resolved);
            seconds.push(frame.seconds);
        }

        // The upper median, which is one of the times.
        seconds.sort_by(f64::total_cmp);
        let median = seconds.get(seconds.len() / 2).copied().unwrap_or_default();
        let max = seconds.last().copied().unwrap_or_default();

        format!(
            "{}, {} not resolved: deepest {} {unit} before, {} {unit} after; \
             {:.2} s of overlap removal, per frame {median:.2} s in the median and {max:.2} s at \
             most.\n",
            counted(self.frames.len(), "frame"),
            grouped(unresolved),
            length(before, self.unit),
            length(after, self.unit),
            seconds.iter().sum::<f64>(),
            unit = self.unit.symbol(),
        )
    }
}
