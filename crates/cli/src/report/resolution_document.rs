//! Result of overlap removal in the files that are written: pairs with their distances, bodies with
//! their changes, and one verdict.
//!
//! Serialized as it stands, this is the JSON output, which a pipeline can gate on.

use std::collections::BTreeMap;

use musculo_collide::kdop::Workspace;
use musculo_collide::proximity::SeparationBounds;
use musculo_collide::{
    BodyChange, BrokenLimit, CheckParams, Conditions, DepthBracket, DistanceBracket, Obstacle,
    PairId, PairReport, Progress, Resolution, ResolveParams, Scene, SceneError,
};
use serde::Serialize;

use super::attachment_record::AttachmentRecord;
use super::resolution::{bracket, gap_obstacle_text, ignored_pairs, left_out_text, obstacle_text};
use super::text::{counted, length, measure};
use super::tie_record::TieRecord;
use super::volume_record::QualityRecord;
use crate::scene::Unit;

/// Result of overlap removal.
#[derive(Debug, Serialize)]
pub(crate) struct ResolutionDocument {
    pub(crate) unit: Unit,
    /// Distance that was asked for between all surfaces; 0 for none.
    pub(crate) gap: f64,
    /// True if all pairs keep the gap in the files, no overlap remains beyond the tolerance, and no
    /// element is inverted.
    pub(crate) resolved: bool,
    /// True if the meshes are written.
    pub(crate) written: bool,
    /// Number of rounds of detection and pushing.
    rounds: usize,
    /// Pairs of which nothing was asked, by their names.
    ignored_pairs: Vec<[String; 2]>,
    /// Pairs that overlapped, are tied, or are nearer than the gap.
    pub(crate) pairs: Vec<PairState>,
    pub(crate) bodies: Vec<BodyState>,
    /// Bodies that the best state brings beyond their limits; an earlier one is kept, unless by
    /// `--keep-going`.
    broken_limits: Vec<BrokenRecord>,
    /// Attachments of the bodies of pairs that are not proved.
    attachments: Vec<AttachmentRecord>,
    /// Vertices that ties hold.
    ties: Vec<TieRecord>,
    /// Bodies that were to be uncrossed and still cross themselves.
    self_overlaps: Vec<String>,
}

/// Body that the best state brings beyond its limits.
#[derive(Debug, Serialize)]
pub(super) struct BrokenRecord {
    body: String,
    /// Relative change of its volume.
    volume_change: f64,
    volume_change_limit: f64,
    max_displacement: f64,
    displacement_limit: f64,
    strain: f64,
    strain_limit: f64,
    /// No face may turn over.
    flipped_faces: usize,
    flat_corners: usize,
    /// No pair of faces may cross anew.
    new_self_crossings: usize,
    /// True if the state is kept all the same.
    #[serde(skip)]
    is_kept: bool,
}

/// Distance below which pairs are listed, relative to the gap.
const NEAR_GAP: f64 = 1.001;

/// Remedy for tied bodies with common nodes whose surfaces have other diagonals in the squares between these.
const IGNORE_TIED: &str = "leave the pair out ([[ignore]]): nodes in common stay so";

/// State of a pair in the files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PairStatus {
    /// The surfaces do not cross, and the gap is proved.
    Apart,
    /// The surfaces do not cross, and are nearer than the gap.
    Near,
    /// Attached on purpose: no gap is asked for.
    Tied,
    /// The surfaces cross, no deeper than the tolerance, and no gap is asked for, or they are attached on purpose.
    WithinTolerance,
    /// The surfaces cross, or one body is inside the other.
    Overlaps,
}

/// Pair of bodies in the files.
#[derive(Debug, Serialize)]
pub(crate) struct PairState {
    a: String,
    b: String,
    status: PairStatus,
    /// True if the distance is proved to be at least the gap, or none is asked for.
    proved: bool,
    /// Certified distance of the surfaces; `None` where it is more than the gap.
    distance: Option<DistanceBracket>,
    /// Depth of the overlap at the start, certified.
    depth_before: Option<DepthBracket>,
    /// Reason why the pair is not apart, with lengths in the unit.
    reason: Option<String>,
}

/// Change of a body.
#[derive(Debug, Serialize)]
pub(crate) struct BodyState {
    name: String,
    /// Number of vertices that moved.
    moved: usize,
    max_displacement: f64,
    strain: f64,
    volume_ratio: Option<f64>,
    flipped_faces: usize,
    /// Number of pairs of the body's own faces that cross, at the start and now.
    self_crossings: [usize; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    elements: Option<ElementsRecord>,
}

/// Elements of a volume mesh that followed its surface.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ElementsRecord {
    pub(crate) count: usize,
    /// Share of the surface's displacement that the elements allowed, 1 for all of it.
    pub(crate) followed_share: f64,
    pub(crate) steps: u32,
    pub(crate) before: QualityRecord,
    pub(crate) after: QualityRecord,
    /// Element that allowed no more.
    pub(crate) blocking_element: Option<u64>,
}

impl ElementsRecord {
    fn is_whole(&self) -> bool {
        self.followed_share >= 1.0 && self.after.inverted_elements == 0
    }
}

/// Overlap removal with what was asked of it, and the scene in its end.
struct Removal<'a> {
    unit: Unit,
    gap: f64,
    resolution: &'a Resolution,
    conditions: &'a Conditions,
    scene: &'a Scene,
}

impl ResolutionDocument {
    /// Detects the pairs of a scene as they are in the files, and judges them.
    pub(crate) fn new(
        unit: Unit,
        params: &ResolveParams,
        resolution: &Resolution,
        conditions: &Conditions,
        scene: &mut Scene,
        elements: &[Option<ElementsRecord>],
    ) -> Result<Self, SceneError> {
        let gap = params.gap;
        // Pairs that may be nearer than the gap by rounding, of which certified distances decide.
        let margin = NEAR_GAP * gap;
        let after = scene.check(&CheckParams::without_measures(margin), Progress::none())?;
        scene.fit_all()?;
        let pairs = PairState::list(&Removal { unit, gap, resolution, conditions, scene }, &after);
        let mut bodies = Vec::new();
        for (change, elements) in resolution.bodies.iter().zip(elements) {
            bodies.push(BodyState::new(change, scene, elements.clone()));
        }

        let are_whole = elements.iter().flatten().all(ElementsRecord::is_whole);
        let are_proved = pairs.iter().all(|pair| pair.proved);
        let resolved = resolution.resolved && are_proved && are_whole;
        let rounds = resolution.rounds.len() - 1;
        let mut broken_limits = Vec::new();
        for broken in &resolution.broken_limits {
            broken_limits.push(BrokenRecord::new(broken, params, scene));
        }
        let is_left = |name: &str| pairs.iter().any(|pair| !pair.proved && pair.contains(name));
        let attachments = AttachmentRecord::list(conditions, scene, is_left);
        let mut ties = Vec::new();
        for count in &resolution.ties {
            ties.push(TieRecord::new(count, scene, unit, params));
        }
        let mut self_overlaps = Vec::new();
        for body in &resolution.self_overlaps {
            self_overlaps.push(scene.body(*body).name().to_owned());
        }
        let names = |pair| scene.names(pair).map(str::to_owned);
        Ok(Self {
            unit,
            gap,
            resolved,
            written: false,
            rounds,
            ignored_pairs: ignored_pairs(scene).into_iter().map(names).collect(),
            pairs,
            bodies,
            broken_limits,
            attachments,
            ties,
            self_overlaps,
        })
    }

    /// Counts the pairs that overlap in the files.
    pub(crate) fn overlaps_in_files(&self) -> usize {
        self.pairs.iter().filter(|pair| pair.status == PairStatus::Overlaps).count()
    }

    /// Returns warnings of ties that hold nothing.
    pub(crate) fn tie_warnings(&self) -> impl Iterator<Item = String> {
        self.ties.iter().filter_map(TieRecord::warning)
    }

    /// Writes elements, pairs that fall short with their reasons, and the verdict.
    pub(crate) fn to_text(&self) -> String {
        let mut text = String::new();
        for BodyState { name, elements, .. } in &self.bodies {
            if let Some(elements) = elements {
                text += &format!("{name}: {}\n", elements.text());
            }
        }

        for broken in &self.broken_limits {
            text += &format!("{}\n", broken.text(self.unit));
        }

        // Without a gap there is nothing to prove for pairs that no longer overlap.
        let unit = self.unit.symbol();
        let short: Vec<&PairState> = self.pairs.iter().filter(|pair| !pair.proved).collect();
        let needs_none = |pair: &&PairState| {
            matches!(pair.status, PairStatus::Tied | PairStatus::WithinTolerance)
        };
        let tied = self.pairs.iter().filter(needs_none).count();
        if self.gap > 0.0 && self.bodies.len() == 1 {
            text += "The scene has one body: there is no gap to prove.\n";
        } else if self.gap > 0.0 && short.is_empty() {
            text += &format!(
                "The gap of {} {unit} is proved for all pairs{}, faces and edges included, in the \
                 precision of the files.\n",
                measure(self.gap),
                left_out_text(tied, self.ignored_pairs.len()),
            );
        } else if !short.is_empty() {
            let pairs = counted(short.len(), "pair");
            text += &format!("Not proved for {pairs}, of a gap of {} {unit}:\n", measure(self.gap));
            for pair in short {
                text += &format!("  {}\n", pair.text(self.unit));
            }
        }
        for tie in self.ties.iter().filter_map(TieRecord::text) {
            text += &format!("{tie}.\n");
        }
        for attachment in &self.attachments {
            text += &format!("{}.\n", attachment.text());
        }
        for reason in self.other_reasons() {
            text += &format!("Not resolved: {reason}.\n");
        }
        if !self.written {
            text +=
                "No mesh is written: --keep-going writes them, with '_unproved' in their names.\n";
        } else if !self.resolved {
            text += "The meshes are written with '_unproved' in their names.\n";
        }
        text
    }
}

impl ResolutionDocument {
    /// Lists the reasons beside pairs for which the scene is not resolved.
    fn other_reasons(&self) -> Vec<String> {
        let mut reasons = Vec::new();
        for body in &self.self_overlaps {
            reasons.push(format!("{body} still crosses itself"));
        }
        reasons.extend(self.ties.iter().filter_map(TieRecord::torn_text).map(str::to_owned));
        for BrokenRecord { body, is_kept, .. } in &self.broken_limits {
            let state = if *is_kept { "the state" } else { "a better state" };
            reasons.push(format!("{state} breaks the limits of {body}"));
        }
        for BodyState { name, elements, .. } in &self.bodies {
            if elements.as_ref().is_some_and(|elements| !elements.is_whole()) {
                reasons.push(format!("elements of {name} do not follow their surface"));
            }
        }
        reasons
    }
}

impl PairState {
    /// Lists the pairs that overlapped, are tied, or are within the gap.
    fn list(removal: &Removal<'_>, after: &[PairReport]) -> Vec<Self> {
        let Removal { resolution, conditions, .. } = removal;
        let mut overlaps: BTreeMap<PairId, bool> = BTreeMap::new();
        for report in resolution.before.iter().filter(|report| report.overlaps) {
            overlaps.insert(report.pair, false);
        }
        for tie in &conditions.ties {
            overlaps.insert(PairId::new(tie.bodies[0], tie.bodies[1]), false);
        }
        for report in after {
            overlaps.insert(report.pair, report.overlaps);
        }

        let mut states = Vec::new();
        for (pair, overlaps) in overlaps {
            let state = Self::new(pair, overlaps, removal);
            // Others that are apart have nothing to tell.
            if state.status != PairStatus::Apart || state.depth_before.is_some() {
                states.push(state);
            }
        }
        states
    }

    fn new(pair: PairId, overlaps: bool, removal: &Removal<'_>) -> Self {
        let Removal { gap, resolution, scene, .. } = *removal;
        let [a, b] = pair.bodies().map(|id| scene.body(id).tree());

        // Bodies that overlap have no distance to bound.
        let mut bounds = None;
        if let (Some(a), Some(b), false) = (a, b, overlaps) {
            bounds = SeparationBounds::compute(a, b, gap, &mut Workspace::default());
        }
        let distance = if overlaps {
            Some(DistanceBracket { lower: 0.0, upper: 0.0 })
        } else {
            bounds.map(|bounds| DistanceBracket {
                lower: bounds.lower,
                upper: bounds.upper.max(bounds.lower),
            })
        };

        let is_near = distance.is_some_and(|distance| distance.lower < gap);
        // An overlap within the tolerance is left where no gap is asked for.
        let mut remaining = resolution.remaining.iter();
        let is_left = resolution.resolved && remaining.any(|left| left.pair == pair);
        let needs_no_gap = gap <= 0.0 || removal.is_tied(pair);
        let status = if overlaps && needs_no_gap && is_left {
            PairStatus::WithinTolerance
        } else if overlaps {
            PairStatus::Overlaps
        } else if removal.is_tied(pair) {
            PairStatus::Tied
        } else if is_near {
            PairStatus::Near
        } else {
            PairStatus::Apart
        };
        let depth_before = resolution.before.iter().find(|report| report.pair == pair);
        let [a, b] = scene.names(pair).map(str::to_owned);

        let is_fine = matches!(status, PairStatus::Apart | PairStatus::Tied);
        let proved = is_fine || status == PairStatus::WithinTolerance;
        let reason = (!is_fine).then(|| removal.reason(pair, overlaps));
        let depth_before = depth_before.and_then(PairReport::max_depth);
        Self { a, b, status, proved, distance, depth_before, reason }
    }

    fn contains(&self, name: &str) -> bool {
        self.a == name || self.b == name
    }

    fn text(&self, unit: Unit) -> String {
        let Self { a, b, distance, reason, .. } = self;
        let distance = distance.map_or(0.0, |distance| distance.lower);
        let state = if self.status == PairStatus::Overlaps {
            "overlaps".to_owned()
        } else {
            format!("{} {} apart", length(distance, unit), unit.symbol())
        };
        format!("{a} × {b}: {state}: {}", reason.as_deref().unwrap_or_default())
    }
}

impl Removal<'_> {
    fn is_tied(&self, pair: PairId) -> bool {
        let mut ties = self.conditions.ties.iter();
        ties.any(|tie| PairId::new(tie.bodies[0], tie.bodies[1]) == pair)
    }

    /// Returns the reason why a pair is not apart.
    fn reason(&self, pair: PairId, overlaps: bool) -> String {
        let Resolution { remaining, gap, .. } = self.resolution;
        if overlaps && let Some(left) = remaining.iter().find(|left| left.pair == pair) {
            let reason = obstacle_text(&left.obstacle, self.unit);
            if left.obstacle == Obstacle::Tied {
                let depth = bracket(left.depth, self.unit);
                return format!("{depth} {} deep: {reason}", self.unit.symbol());
            }
            // Surfaces of shared nodes whose squares are split along other diagonals.
            let is_of_tie = left.obstacle == Obstacle::Coincident && self.is_tied(pair);
            return if is_of_tie { format!("{reason}, or {IGNORE_TIED}") } else { reason };
        }
        match gap.short.iter().find(|short| short.pair == pair) {
            Some(short) => gap_obstacle_text(&short.obstacle, self.unit),
            None => "the file holds less than was found: its precision, or elements that would be \
                     inverted, cut the displacement"
                .to_owned(),
        }
    }
}

impl BrokenRecord {
    pub(super) fn new(broken: &BrokenLimit, params: &ResolveParams, scene: &Scene) -> Self {
        Self {
            body: scene.body(broken.body).name().to_owned(),
            volume_change: broken.volume_change,
            volume_change_limit: params.max_volume_change,
            max_displacement: broken.max_displacement,
            displacement_limit: broken.displacement_limit,
            strain: broken.strain,
            strain_limit: params.max_strain,
            flipped_faces: broken.flipped_faces,
            flat_corners: broken.flat_corners,
            new_self_crossings: broken.self_crossings,
            is_kept: params.keep_going,
        }
    }

    /// Writes the limits that are broken, with what is allowed.
    pub(super) fn text(&self, unit: Unit) -> String {
        let mut broken = Vec::new();
        let (share, limit) = (self.volume_change.abs(), self.volume_change_limit);
        if share > limit {
            let [share, limit] = [share, limit].map(|share| measure(100.0 * share));
            broken.push(format!("volume {share} % off, at most {limit} % allowed"));
        }
        let (longest, limit) = (self.max_displacement, self.displacement_limit);
        if longest > limit {
            let ([longest, limit], unit) = ([longest, limit].map(measure), unit.symbol());
            broken.push(format!("moved by {longest} {unit}, at most {limit} {unit} allowed"));
        }
        if self.strain > self.strain_limit {
            let [strain, limit] = [self.strain, self.strain_limit].map(|it| measure(100.0 * it));
            broken.push(format!("strained by {strain} %, at most {limit} % allowed"));
        }
        if self.flipped_faces > 0 {
            broken.push(format!("{} turned over", counted(self.flipped_faces, "face")));
        }
        if self.flat_corners > 0 {
            broken.push(format!("{} of elements flat", counted(self.flat_corners, "corner")));
        }
        if self.new_self_crossings > 0 {
            broken.push(counted(self.new_self_crossings, "new self-crossing"));
        }
        let leaves = if self.is_kept { "leaves" } else { "would leave" };
        format!("{} {leaves} its limits: {}", self.body, broken.join("; "))
    }
}

impl BodyState {
    fn new(change: &BodyChange, scene: &Scene, elements: Option<ElementsRecord>) -> Self {
        Self {
            name: scene.body(change.body).name().to_owned(),
            moved: change.moved,
            max_displacement: change.max_displacement,
            strain: change.strain,
            volume_ratio: change.volume_ratio,
            flipped_faces: change.flipped_faces,
            self_crossings: change.self_crossings,
            elements,
        }
    }
}

impl ElementsRecord {
    fn text(&self) -> String {
        let mut text = format!(
            "{} follow, least scaled Jacobian {:.3} -> {:.3} (element {})",
            counted(self.count, "element"),
            self.before.min_scaled_jacobian,
            self.after.min_scaled_jacobian,
            self.after.worst_element,
        );
        if let Some(element) = self.blocking_element {
            text += &format!(
                "; element {element} would be inverted or flat beyond {:.1} % of the displacement, \
                 which is cut there",
                100.0 * self.followed_share
            );
        }
        text
    }
}
