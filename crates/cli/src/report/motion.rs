//! Report of a motion, frame by frame.

use musculo_collide::{
    BodyId, JointContactParams, PairReport, PairSweep, PassThrough, Scene, SweepReport,
};
use serde::{Deserialize, Serialize};

use super::frame_pair::FramePair;
use super::frame_times::FrameTimes;
use super::joint_contact::{
    ContactTable, JointContactRecord, PairContact, SurfaceContact, joint_title,
};
use super::pair_record::rounding;
use super::table::{Table, dash, left, right};
use super::text::{bound, counted, depth, grouped, measure};
use crate::motion::{RestReason, RestingBody};
use crate::scene::Unit;

/// All frames of a motion.
#[derive(Debug, Serialize)]
pub(crate) struct MotionDocument {
    pub(crate) unit: Unit,
    /// Bodies that rest in all frames.
    pub(crate) resting: Vec<RestingBody>,
    /// Parameters of joint contact, where it is measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) joint_contact: Option<JointContactParams>,
    pub(crate) frames: Vec<FrameRecord>,
}

/// Frame of a motion, and the step that leads to it.
#[derive(Debug, Serialize)]
pub(crate) struct FrameRecord {
    /// Number of the frame, from 0.
    pub(crate) frame: usize,
    /// Time of the frame, if the motion has one.
    pub(crate) time: Option<f64>,
    /// Number of pairs that overlap in the frame.
    overlapping_pairs: usize,
    /// Deepest overlap in the frame.
    deepest: Option<DepthRecord>,
    /// Volume of all overlaps in the frame; none where the inside of a body that overlaps is undefined.
    pub(crate) volume: Option<f64>,
    /// Pairs that overlap in the frame.
    pairs: Vec<FramePair>,
    /// Joint contact of each surface with another, where it is measured and there is some.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    joint_contact: Vec<SurfaceContact>,
    /// Step from the frame before; none to the first frame.
    pub(crate) step: Option<StepRecord>,
}

/// Step between two frames.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct StepRecord {
    /// Number of queries between two primitives during the step.
    candidates: usize,
    /// Number of contacts that began during the step.
    contacts: usize,
    /// Number of proved ones among them.
    certain_contacts: usize,
    /// Fraction of the step before the first contact of a pair that did not overlap at its
    /// start; none without such a contact.
    first_contact: Option<f64>,
    /// Fraction of the step that is free of such contacts: `first_contact`, or else 1.
    pub(crate) free_step: f64,
    /// Pairs that met.
    pub(crate) pairs: Vec<MeetingRecord>,
}

/// Deepest overlap of a frame.
#[derive(Debug, Serialize)]
struct DepthRecord {
    a: String,
    b: String,
    depth: f64,
    /// Depth that rounding alone makes.
    #[serde(skip)]
    rounding: f64,
    /// True if it is that of the surfaces, of vertices otherwise.
    #[serde(skip)]
    is_of_surfaces: bool,
}

/// Two bodies that met during a step.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct MeetingRecord {
    a: String,
    b: String,
    contacts: usize,
    first_contact: Option<f64>,
    /// True if the two overlap in neither frame.
    passes_through: bool,
    /// Number of vertices that met the other surface and are inside in neither frame.
    vertices_passing_through: usize,
}

impl MotionDocument {
    /// Returns true if nothing overlaps in a frame or meets between frames.
    pub(crate) fn is_clean(&self) -> bool {
        self.frames.iter().all(|frame| frame.overlapping_pairs == 0 && frame.contacts() == 0)
    }

    /// Writes one line per frame, a summary, and the bodies that rest.
    pub(crate) fn to_text(&self) -> String {
        let (table, rests) = (self.table().to_text(), rest_text(&self.resting));
        format!("{table}\n{}{}\n{rests}", self.joint_text(), self.summary())
    }

    /// Returns a table with a line per frame, which it shares with the step that leads to it.
    pub(super) fn table(&self) -> Table {
        let mut table = Table::new([
            right("frame"),
            right("time"),
            right("overlaps"),
            right(format!("deepest [{}]", self.unit.symbol())),
            left("between"),
            right(format!("volume [{}³]", self.unit.symbol())),
            right("new contacts"),
            right("first at"),
            right("free step"),
            right("pairs through"),
            right("vertices through"),
        ]);

        let times = FrameTimes::new(self.frames.iter().map(|frame| frame.time));
        for frame in &self.frames {
            let of_frame = frame.state_entries(self.unit, times);
            let of_step = match &frame.step {
                Some(step) => step.entries(),
                None => [dash(), dash(), dash(), dash(), dash()],
            };
            table.row(of_frame.into_iter().chain(of_step));
        }
        table
    }

    /// Writes a line per frame and surface in contact; nothing where joint contact is not measured.
    fn joint_text(&self) -> String {
        let Some(JointContactParams { margin, foundation, .. }) = self.joint_contact else {
            return String::new();
        };
        let mut table = ContactTable::new([right("frame")], self.unit, foundation.is_some());
        for frame in &self.frames {
            for contact in &frame.joint_contact {
                table.total([frame.frame.to_string()], contact);
            }
        }
        let title = joint_title(margin, self.unit);
        format!("{title}\n{}\n", table.finish().to_text())
    }

    /// Returns the counts over all frames, and the deepest overlap, in words.
    pub(super) fn summary(&self) -> String {
        // Counts over all frames, and the frame of the deepest overlap.
        let (mut overlapping, mut contacts, mut through) = (0, 0, 0);
        let mut deepest: Option<&FrameRecord> = None;
        for frame in &self.frames {
            contacts += frame.contacts();
            through += frame.step.as_ref().map_or(0, StepRecord::vertices_passing_through);
            if frame.overlapping_pairs > 0 {
                overlapping += 1;
                if deepest.is_none_or(|deepest| frame.depth() > deepest.depth()) {
                    deepest = Some(frame);
                }
            }
        }

        // Where nothing has an inside there is no depth to name.
        let deepest = match deepest {
            None => String::new(),
            Some(frame) if frame.depth() > 0.0 || frame.has_depth_of_surfaces() => format!(
                ", the deepest {} {} in frame {}",
                frame.deepest.as_ref().map_or_else(dash, |deepest| deepest.text(self.unit)),
                self.unit.symbol(),
                frame.frame
            ),
            Some(_) => ", of surfaces without an inside".to_owned(),
        };
        format!(
            "{}: overlap in {}{deepest}; {} between frames, {} through a surface and out again.\n\
             Free step: the part of the step before the first contact of pairs that did not \
             overlap at its start.",
            counted(self.frames.len(), "frame"),
            grouped(overlapping),
            counted(contacts, "contact"),
            counted(through, "vertex path"),
        )
    }
}

/// Writes the bodies that rest in all frames, a line per reason.
pub(crate) fn rest_text(resting: &[RestingBody]) -> String {
    let reasons = [
        (RestReason::NoMap, "no map has their name"),
        (RestReason::NoSkin, "they are soft, and the motion has no skin"),
        (RestReason::Attached, "they are attached to bodies at rest"),
        (RestReason::AttachedToMany, "they are attached to more than two bodies that move apart"),
    ];
    let mut text = String::new();
    for (reason, words) in reasons {
        let mut names = Vec::new();
        for body in resting {
            if body.reason == reason {
                names.push(body.body.as_str());
            }
        }
        if !names.is_empty() {
            text += &format!("At rest, as {words}: {}\n", names.join(", "));
        }
    }
    text
}

impl FrameRecord {
    /// Records the overlaps of a frame.
    pub(crate) fn new(
        scene: &Scene,
        frame: usize,
        time: Option<f64>,
        reports: &[PairReport],
    ) -> Self {
        let mut volume = Some(0.0);
        for report in reports {
            if let Some(overlap) = &report.overlap {
                let of_pair = overlap.measures.total.volume;
                volume = volume.zip(of_pair).map(|(others, of_pair)| others + of_pair);
            }
        }
        let (deepest, pairs) = (deepest(scene, reports), FramePair::list(scene, reports));
        let (overlapping_pairs, joint_contact) = (pairs.len(), Vec::new());
        Self { frame, time, overlapping_pairs, deepest, volume, pairs, joint_contact, step: None }
    }

    /// Adds the joint contact of pairs.
    pub(crate) fn add_joint_contacts(&mut self, contacts: &[PairContact], scene: &Scene) {
        for contact in contacts {
            let JointContactRecord { of_a, of_b } = JointContactRecord::new(contact, scene);
            self.joint_contact.extend([of_a, of_b]);
        }
    }

    /// Returns the depth of the deepest overlap, 0 without one.
    pub(crate) fn depth(&self) -> f64 {
        self.deepest.as_ref().map_or(0.0, |deepest| deepest.depth)
    }

    /// Returns true if the deepest overlap has a depth, be it 0.
    fn has_depth_of_surfaces(&self) -> bool {
        self.deepest.as_ref().is_some_and(|deepest| deepest.is_of_surfaces)
    }

    fn contacts(&self) -> usize {
        self.step.as_ref().map_or(0, |step| step.contacts)
    }

    /// Returns the entries of a table that show the frame.
    fn state_entries(&self, unit: Unit, times: FrameTimes) -> [String; 6] {
        let (depth, between) = match &self.deepest {
            Some(deepest) => (deepest.text(unit), format!("{} × {}", deepest.a, deepest.b)),
            None => (dash(), dash()),
        };
        let time = times.text(self.time);
        let volume = self.volume.map_or_else(|| "?".to_owned(), measure);
        [self.frame.to_string(), time, grouped(self.overlapping_pairs), depth, between, volume]
    }
}

impl StepRecord {
    /// Records a step between the states `before` and `after`.
    pub(crate) fn new(
        scene: &Scene,
        sweep: &SweepReport,
        before: &[PairReport],
        after: &[PairReport],
    ) -> Self {
        // Passing through shows in neither state, only in the sweep between them.
        let through = sweep.pass_throughs(scene, before, after);
        let mut step = Self {
            candidates: sweep.candidates,
            contacts: 0,
            certain_contacts: 0,
            first_contact: None,
            free_step: 1.0,
            pairs: Vec::new(),
        };

        for pair in &sweep.pairs {
            let meeting = MeetingRecord::new(scene, pair, &through);
            step.contacts += meeting.contacts;
            for contact in &pair.contacts {
                step.certain_contacts += usize::from(contact.certain);
            }

            // A pair that overlaps already has no time of first contact.
            if let Some(first) = meeting.first_contact
                && !overlaps(before, pair)
            {
                step.free_step = step.free_step.min(first);
                step.first_contact = Some(step.free_step);
            }
            step.pairs.push(meeting);
        }
        step
    }

    fn vertices_passing_through(&self) -> usize {
        let mut count = 0;
        for pair in &self.pairs {
            count += pair.vertices_passing_through;
        }
        count
    }

    /// Returns the entries of a table that show the step.
    fn entries(&self) -> [String; 5] {
        let mut through = 0;
        for pair in &self.pairs {
            through += usize::from(pair.passes_through);
        }
        [
            grouped(self.contacts),
            self.first_contact.map_or_else(dash, |fraction| bound(fraction, 4)),
            bound(self.free_step, 4),
            grouped(through),
            grouped(self.vertices_passing_through()),
        ]
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
    // Of equal depths, the first pair counts.
    let mut deepest: Option<&PairReport> = None;
    for report in reports {
        let max_depth = deepest.map_or(-1.0, depth_of);
        if report.overlaps && depth_of(report) > max_depth {
            deepest = Some(report);
        }
    }

    let report = deepest?;
    let [a, b] = scene.names(report.pair).map(str::to_owned);
    let rounding = rounding(report.pair, scene);
    let is_of_surfaces = report.max_depth().is_some();
    Some(DepthRecord { a, b, depth: depth_of(report), rounding, is_of_surfaces })
}

impl DepthRecord {
    /// Writes the depth, 0 where it is that of rounding.
    fn text(&self, unit: Unit) -> String {
        let is_known = self.is_of_surfaces || self.depth > 0.0;
        let is_rounding = is_known && self.depth <= self.rounding;
        if is_rounding { "0".to_owned() } else { depth(self.depth, unit) }
    }
}

/// Returns the depth of an overlap as far as it is certain; of vertices, where surfaces have none.
fn depth_of(report: &PairReport) -> f64 {
    report.max_depth().map_or(report.max_vertex_depth, |depth| depth.lower)
}

fn name(scene: &Scene, id: BodyId) -> String {
    scene.body(id).name().to_owned()
}
