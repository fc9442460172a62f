//! What a motion showed, step by step, and its table.

use musculo_collide::{BodyId, PairReport, PairSweep, PassThrough, SweepReport};
use serde::Serialize;

use super::text::{Align, TextTable, counted, grouped, length};
use crate::scene::Unit;

/// All steps of a motion.
#[derive(Debug, Serialize)]
pub(crate) struct MotionDocument {
    pub(crate) unit: Unit,
    pub(crate) steps: Vec<StepRecord>,
}

/// A step to a frame, and the frame.
#[derive(Debug, Serialize)]
pub(crate) struct StepRecord {
    /// The frame it ends in, from 0.
    pub(crate) frame: usize,
    /// That frame's time, as the motion tells it.
    pub(crate) time: Option<f64>,
    /// Pairs that overlap in the frame.
    pub(crate) overlapping_pairs: usize,
    /// Deepest overlap in the frame.
    pub(crate) deepest: Option<DepthRecord>,
    /// Questions asked of two primitives on the way.
    pub(crate) candidates: usize,
    /// Contacts that began on the way.
    pub(crate) contacts: usize,
    /// Those among them that are proven.
    pub(crate) certain_contacts: usize,
    /// Share of the step before the first contact; none where nothing met.
    pub(crate) first_contact: Option<f64>,
    /// Share of the step that is free of any new contact, 1 where nothing met.
    pub(crate) largest_free_step: f64,
    /// The same among pairs that did not overlap at the start of the step.
    pub(crate) largest_free_step_of_free_pairs: f64,
    /// Pairs that met.
    pub(crate) pairs: Vec<MeetingRecord>,
}

/// The deepest overlap of a frame.
#[derive(Debug, Serialize)]
pub(crate) struct DepthRecord {
    a: String,
    b: String,
    pub(crate) depth: f64,
}

/// Two bodies that met during a step.
#[derive(Debug, Serialize)]
pub(crate) struct MeetingRecord {
    a: String,
    b: String,
    contacts: usize,
    first_contact: Option<f64>,
    /// Whether the two overlap in neither frame.
    unseen_pair: bool,
    /// Vertices that met the other surface and are inside in neither frame.
    unseen_vertices: usize,
}

impl MotionDocument {
    /// Whether nothing overlaps in a frame or meets between frames.
    pub(crate) fn is_clean(&self) -> bool {
        self.steps.iter().all(|step| step.overlapping_pairs == 0 && step.contacts == 0)
    }
}

impl StepRecord {
    pub(crate) fn new(
        (frame, time): (usize, Option<f64>),
        scene: &musculo_collide::Scene,
        sweep: &SweepReport,
        [before, after]: [&[PairReport]; 2],
    ) -> Self {
        let contacts = || sweep.pairs.iter().flat_map(|pair| &pair.contacts);
        let unseen = sweep.pass_throughs(scene, before, after);
        let first_contact = sweep.pairs.iter().filter_map(PairSweep::first_time);
        Self {
            frame,
            time,
            overlapping_pairs: after.iter().filter(|pair| pair.overlaps).count(),
            deepest: deepest(scene, after),
            candidates: sweep.candidates,
            contacts: contacts().count(),
            certain_contacts: contacts().filter(|contact| contact.certain).count(),
            first_contact: first_contact.min_by(f64::total_cmp),
            largest_free_step: sweep.largest_free_step,
            largest_free_step_of_free_pairs: free_step_of_free_pairs(sweep, before),
            pairs: sweep
                .pairs
                .iter()
                .map(|pair| MeetingRecord::new(scene, pair, &unseen))
                .collect(),
        }
    }

    fn unseen_pairs(&self) -> usize {
        self.pairs.iter().filter(|pair| pair.unseen_pair).count()
    }

    fn unseen_vertices(&self) -> usize {
        self.pairs.iter().map(|pair| pair.unseen_vertices).sum()
    }
}

impl MeetingRecord {
    fn new(scene: &musculo_collide::Scene, pair: &PairSweep, unseen: &[PassThrough]) -> Self {
        let unseen = unseen.iter().find(|unseen| unseen.pair == pair.pair);
        Self {
            a: name(scene, pair.pair.a),
            b: name(scene, pair.pair.b),
            contacts: pair.contacts.len(),
            first_contact: pair.first_time(),
            unseen_pair: unseen.is_some_and(|unseen| unseen.overlaps_in_neither),
            unseen_vertices: unseen.map_or(0, |unseen| unseen.particles.len()),
        }
    }
}

fn name(scene: &musculo_collide::Scene, id: BodyId) -> String {
    scene.body(id).name().to_owned()
}

fn deepest(scene: &musculo_collide::Scene, reports: &[PairReport]) -> Option<DepthRecord> {
    let overlapping = reports.iter().filter(|pair| pair.overlaps);
    let pair = overlapping.max_by(|p, q| p.max_depth.total_cmp(&q.max_depth))?;
    Some(DepthRecord {
        a: name(scene, pair.pair.a),
        b: name(scene, pair.pair.b),
        depth: pair.max_depth,
    })
}

fn free_step_of_free_pairs(sweep: &SweepReport, before: &[PairReport]) -> f64 {
    let overlapped =
        |pair: &&PairSweep| before.iter().any(|report| report.overlaps && report.pair == pair.pair);
    let free = sweep.pairs.iter().filter(|pair| !overlapped(pair));
    free.filter_map(PairSweep::first_time).fold(1.0, f64::min)
}

/// A line a step, and what the single frames did not show.
pub(crate) fn motion_table(document: &MotionDocument) -> String {
    let mut table = TextTable::new(&[
        ("FRAME", Align::Right),
        ("TIME", Align::Right),
        ("OVERLAPS", Align::Right),
        (&format!("DEEPEST {}", document.unit.symbol()), Align::Right),
        ("BETWEEN", Align::Left),
        ("NEW CONTACTS", Align::Right),
        ("FIRST AT", Align::Right),
        ("FREE STEP", Align::Right),
        ("UNSEEN PAIRS", Align::Right),
        ("UNSEEN VERTICES", Align::Right),
    ]);
    for step in &document.steps {
        let dash = || "-".to_owned();
        table.row(vec![
            step.frame.to_string(),
            step.time.map_or_else(dash, |time| format!("{time:.3}")),
            grouped(step.overlapping_pairs),
            step.deepest.as_ref().map_or_else(dash, |deep| length(deep.depth, document.unit)),
            step.deepest.as_ref().map_or_else(dash, |deep| format!("{} x {}", deep.a, deep.b)),
            grouped(step.contacts),
            step.first_contact.map_or_else(dash, |share| format!("{share:.4}")),
            format!("{:.4}", step.largest_free_step_of_free_pairs),
            grouped(step.unseen_pairs()),
            grouped(step.unseen_vertices()),
        ]);
    }
    format!("{}\n{}\n", table.render(), summary(document))
}

fn summary(document: &MotionDocument) -> String {
    let depth = |step: &&StepRecord| step.deepest.as_ref().map_or(0.0, |deepest| deepest.depth);
    let deepest = document.steps.iter().max_by(|p, q| depth(p).total_cmp(&depth(q)));
    let deepest = deepest.map_or_else(String::new, |step| {
        format!(
            ", the deepest {} {} in frame {}",
            length(depth(&step), document.unit),
            document.unit.symbol(),
            step.frame
        )
    });
    let overlapping = document.steps.iter().filter(|step| step.overlapping_pairs > 0).count();
    let contacts: usize = document.steps.iter().map(|step| step.contacts).sum();
    let unseen: usize = document.steps.iter().map(StepRecord::unseen_vertices).sum();
    format!(
        "{}: overlap in {} of them{deepest}; {} between them, {} on which the frames alone show nothing.",
        counted(document.steps.len(), "frame"),
        grouped(overlapping),
        counted(contacts, "contact"),
        counted(unseen, "vertex path"),
    )
}
