//! Report of a motion, step by step.

use musculo_collide::{BodyId, PairReport, PairSweep, PassThrough, Scene, SweepReport};
use serde::Serialize;

use super::check_tables::dash;
use super::table::{Table, left, right};
use super::text::{counted, grouped, length};
use crate::scene::Unit;

/// All steps of a motion.
#[derive(Debug, Serialize)]
pub(crate) struct MotionDocument {
    pub(crate) unit: Unit,
    pub(crate) steps: Vec<StepRecord>,
}

/// Step between two frames, and the later one.
#[derive(Debug, Serialize)]
pub(crate) struct StepRecord {
    /// Number of the later frame, from 0.
    pub(crate) frame: usize,
    /// Time of that frame, if the motion has one.
    pub(crate) time: Option<f64>,
    /// Number of pairs that overlap in the frame.
    overlapping_pairs: usize,
    /// Deepest overlap in the frame.
    deepest: Option<DepthRecord>,
    /// Number of queries between two primitives during the step.
    candidates: usize,
    /// Number of contacts that began during the step.
    contacts: usize,
    /// Number of proved ones among them.
    certain_contacts: usize,
    /// Fraction of the step before the first contact; none without contact.
    first_contact: Option<f64>,
    /// Fraction of the step that is free of any new contact, 1 without contact.
    largest_free_step: f64,
    /// The same among pairs that did not overlap at the start of the step.
    pub(crate) largest_free_step_of_free_pairs: f64,
    /// Pairs that met.
    pairs: Vec<MeetingRecord>,
}

/// Deepest overlap of a frame.
#[derive(Debug, Serialize)]
struct DepthRecord {
    a: String,
    b: String,
    depth: f64,
}

/// Two bodies that met during a step.
#[derive(Debug, Serialize)]
struct MeetingRecord {
    a: String,
    b: String,
    contacts: usize,
    first_contact: Option<f64>,
    /// True if the two overlap in neither frame.
    passes_through: bool,
    /// Number of vertices that met the other surface and are inside in neither frame.
    vertices_passing_through: usize,
}

/// State of a motion at a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameState<'a> {
    pub(crate) frame: usize,
    pub(crate) time: Option<f64>,
    /// Pairs in the frame before.
    pub(crate) before: &'a [PairReport],
    /// Pairs in the frame.
    pub(crate) after: &'a [PairReport],
}

impl MotionDocument {
    /// Returns true if nothing overlaps in a frame or meets between frames.
    pub(crate) fn is_clean(&self) -> bool {
        self.steps.iter().all(|step| step.overlapping_pairs == 0 && step.contacts == 0)
    }

    /// Writes one line per step, and a summary.
    pub(crate) fn to_text(&self) -> String {
        let mut table = Table::new([
            right("frame"),
            right("time"),
            right("overlaps"),
            right(format!("deepest [{}]", self.unit.symbol())),
            left("between"),
            right("new contacts"),
            right("first at"),
            right("free step"),
            right("pairs through"),
            right("vertices through"),
        ]);
        for step in &self.steps {
            let (depth, between) = match &step.deepest {
                Some(DepthRecord { a, b, depth }) => {
                    (length(*depth, self.unit), format!("{a} × {b}"))
                }
                None => (dash(), dash()),
            };
            table.row([
                step.frame.to_string(),
                step.time.map_or_else(dash, |time| format!("{time:.3}")),
                grouped(step.overlapping_pairs),
                depth,
                between,
                grouped(step.contacts),
                step.first_contact.map_or_else(dash, |fraction| format!("{fraction:.4}")),
                format!("{:.4}", step.largest_free_step_of_free_pairs),
                grouped(step.pairs.iter().filter(|pair| pair.passes_through).count()),
                grouped(step.vertices_passing_through()),
            ]);
        }
        format!("{}\n{}\n", table.to_text(), self.summary())
    }

    fn summary(&self) -> String {
        let unit = self.unit;
        let overlapping = self.steps.iter().filter(|step| step.overlapping_pairs > 0).count();
        let deepest = self.steps.iter().max_by(|p, q| p.depth().total_cmp(&q.depth()));
        let deepest = deepest.filter(|_| overlapping > 0).map_or_else(String::new, |step| {
            let (depth, symbol) = (length(step.depth(), unit), unit.symbol());
            format!(", the deepest {depth} {symbol} in frame {}", step.frame)
        });
        let contacts: usize = self.steps.iter().map(|step| step.contacts).sum();
        let through = self.steps.iter().map(StepRecord::vertices_passing_through).sum();
        format!(
            "{}: overlap in {}{deepest}; {} between frames, {} through a surface and out again.",
            counted(self.steps.len(), "frame"),
            grouped(overlapping),
            counted(contacts, "contact"),
            counted(through, "vertex path"),
        )
    }
}

impl StepRecord {
    pub(crate) fn new(scene: &Scene, sweep: &SweepReport, state: FrameState<'_>) -> Self {
        let FrameState { frame, time, before, after } = state;
        let through = sweep.pass_throughs(scene, before, after);
        let mut step = Self {
            frame,
            time,
            overlapping_pairs: after.iter().filter(|pair| pair.overlaps).count(),
            deepest: deepest(scene, after),
            candidates: sweep.candidates,
            contacts: 0,
            certain_contacts: 0,
            first_contact: None,
            largest_free_step: sweep.largest_free_step,
            largest_free_step_of_free_pairs: 1.0,
            pairs: Vec::new(),
        };

        for pair in &sweep.pairs {
            let meeting = MeetingRecord::new(scene, pair, &through);
            let first = meeting.first_contact.unwrap_or(1.0);
            step.contacts += meeting.contacts;
            step.certain_contacts += pair.contacts.iter().filter(|c| c.certain).count();
            step.first_contact = Some(first.min(step.first_contact.unwrap_or(1.0)));
            if !overlaps(before, pair) {
                step.largest_free_step_of_free_pairs =
                    step.largest_free_step_of_free_pairs.min(first);
            }
            step.pairs.push(meeting);
        }
        step
    }

    /// Returns the depth of the deepest overlap, 0 without one.
    pub(crate) fn depth(&self) -> f64 {
        self.deepest.as_ref().map_or(0.0, |deepest| deepest.depth)
    }

    fn vertices_passing_through(&self) -> usize {
        self.pairs.iter().map(|pair| pair.vertices_passing_through).sum()
    }
}

/// Returns true if a pair overlaps in a frame.
fn overlaps(reports: &[PairReport], pair: &PairSweep) -> bool {
    reports.iter().any(|report| report.overlaps && report.pair == pair.pair)
}

impl MeetingRecord {
    fn new(scene: &Scene, pair: &PairSweep, through: &[PassThrough]) -> Self {
        let through = through.iter().find(|through| through.pair == pair.pair);
        Self {
            a: name(scene, pair.pair.a),
            b: name(scene, pair.pair.b),
            contacts: pair.contacts.len(),
            first_contact: pair.first_time(),
            passes_through: through.is_some_and(|through| through.overlaps_in_neither),
            vertices_passing_through: through.map_or(0, |through| through.particles.len()),
        }
    }
}

fn deepest(scene: &Scene, reports: &[PairReport]) -> Option<DepthRecord> {
    let overlapping = reports.iter().filter(|pair| pair.overlaps);
    let pair = overlapping.max_by(|p, q| p.max_depth.total_cmp(&q.max_depth))?;
    Some(DepthRecord {
        a: name(scene, pair.pair.a),
        b: name(scene, pair.pair.b),
        depth: pair.max_depth,
    })
}

fn name(scene: &Scene, id: BodyId) -> String {
    scene.body(id).name().to_owned()
}
