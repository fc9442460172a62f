//! Content of a check's report, without its times.
//!
//! Serialized as it stands, this is the JSON output: keys in the order of the fields,
//! bodies and pairs in the order of the scene, numbers with as many digits as distinguish
//! them.

use musculo_collide::surface::{Finding, Inspection};
use musculo_collide::{BodyKind, JointContactParams, Scene};
use serde::Serialize;

use super::division::DivisionRecord;
use super::inverted_part::InvertedPart;
use super::joint_contact::{JointContactRecord, PairContact};
use super::pair_record::PairRecord;
use super::self_crossing::SelfCrossings;
use super::text::{counted, measure, short};
use super::volume_record::VolumeRecord;
use crate::scene::Unit;

/// Checked scene.
#[derive(Debug, Serialize)]
pub(crate) struct CheckDocument {
    /// Unit of every length; areas and volumes are in its square and cube.
    pub(crate) unit: Unit,
    /// Largest distance of a near pair.
    pub(crate) margin: f64,
    /// Parameters of joint contact, where it is measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) joint_contact: Option<JointContactParams>,
    pub(crate) warnings: Vec<String>,
    pub(crate) bodies: Vec<BodyRecord>,
    /// Every pair that overlaps or is near.
    pub(crate) pairs: Vec<PairRecord>,
    /// Open surfaces that others cross.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) divisions: Vec<DivisionRecord>,
}

/// Mesh as it was read.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct BodyRecord {
    pub(crate) name: String,
    pub(crate) file: String,
    pub(crate) kind: BodyKind,
    /// Number of faces in the file with more than three corners.
    pub(crate) polygons_fanned: usize,
    /// Objects of the file that are one body, in words, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) joined: Option<String>,
    /// Content of the file behind the end that its header declares, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) unread: Option<String>,
    /// Elements of the file that are no part of its volume mesh, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) skipped: Option<String>,
    pub(crate) closed: bool,
    pub(crate) manifold: bool,
    pub(crate) oriented: bool,
    #[serde(flatten)]
    pub(crate) inspection: Inspection,
    /// Faces of the body that cross each other, where a check finds some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) self_crossings: Option<SelfCrossings>,
    /// Parts of the body whose faces look to the wrong side, where a check finds some.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) inverted_parts: Vec<InvertedPart>,
    /// Volume mesh behind the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) volume_mesh: Option<VolumeRecord>,
}

impl BodyRecord {
    /// Returns the kind as scene files write it.
    pub(crate) fn kind_name(&self) -> &'static str {
        match self.kind {
            BodyKind::Rigid => "rigid",
            BodyKind::Deformable => "deformable",
            BodyKind::Open => "open",
        }
    }

    /// Returns the enclosed volume of a closed surface.
    pub(crate) fn volume(&self) -> Option<f64> {
        self.closed.then_some(self.inspection.volume)
    }

    /// Describes the defects of the mesh, or else "none".
    pub(crate) fn notes(&self, unit: Unit) -> Vec<String> {
        let mut notes = Vec::new();
        for finding in &self.inspection.findings {
            notes.push(rounded(finding, unit).to_string());
        }
        notes.extend(self.self_crossings.iter().map(|crossings| crossings.text(unit)));
        notes.extend(InvertedPart::text(&self.inverted_parts, unit));
        if self.polygons_fanned > 0 {
            notes.push(counted(self.polygons_fanned, "polygon") + " split into triangles");
        }
        notes.extend(self.joined.clone());
        notes.extend(self.unread.clone());
        notes.extend(self.skipped.clone());
        notes.extend(self.volume_mesh.iter().filter_map(VolumeRecord::defect));
        if self.volume().is_some_and(|volume| volume < 0.0) {
            notes.push("inside out: its volume is negative".to_owned());
        }
        if notes.is_empty() {
            notes.push("none".to_owned());
        }
        notes
    }
}

/// Rounds the place of a defect to the decimals of the unit.
fn rounded(finding: &Finding, unit: Unit) -> Finding {
    let digits = 10.0_f64.powi(unit.decimals().try_into().unwrap_or(0));
    Finding { at: (finding.at * digits).round() / digits, ..*finding }
}

impl CheckDocument {
    /// Adds the joint contact of pairs.
    pub(crate) fn add_joint_contacts(
        &mut self,
        params: JointContactParams,
        contacts: &[PairContact],
        scene: &Scene,
    ) {
        self.joint_contact = Some(params);

        // Contacts are in the order of the pairs, so that none is searched from the first.
        let mut pairs = self.pairs.iter_mut();
        for contact in contacts {
            let record = JointContactRecord::new(contact, scene);
            let names = [&record.of_a.surface, &record.of_b.surface];
            let pair = pairs.find(|pair| [&pair.a, &pair.b] == names);
            debug_assert!(pair.is_some(), "a pair in contact is near");
            if let Some(pair) = pair {
                pair.joint_contact = Some(record);
            }
        }
    }

    /// Sorts overlapping pairs from deep to shallow, then near pairs from near to far.
    pub(crate) fn pairs_by_depth(&self) -> Vec<&PairRecord> {
        let distance = |pair: &PairRecord| pair.distance.unwrap_or(f64::INFINITY);
        let mut pairs: Vec<&PairRecord> = self.pairs.iter().collect();
        pairs.sort_by(|p, q| {
            let by_overlap = q.overlaps.cmp(&p.overlaps);
            let by_depth = q.depth().total_cmp(&p.depth());
            by_overlap.then(by_depth).then(distance(p).total_cmp(&distance(q)))
        });
        pairs
    }

    /// Names the pairs that are one mesh or one surface, the first few of them in words.
    pub(crate) fn coincidences(&self) -> Vec<String> {
        /// Pairs that are named: more would push the tables off the first screen.
        const MAX_NAMED: usize = 4;

        let mut named: Vec<String> =
            self.pairs.iter().filter_map(PairRecord::coincidence_text).collect();
        let count = named.len();
        if count > MAX_NAMED {
            named.truncate(MAX_NAMED);
            named.push(format!("and {} that coincide", counted(count - MAX_NAMED, "more pair")));
        }
        named
    }

    /// Returns the refusals of all pairs, each once.
    pub(crate) fn refusals(&self) -> Vec<String> {
        let mut refusals: Vec<String> =
            self.pairs.iter().flat_map(|pair| &pair.refusals).cloned().collect();
        refusals.sort();
        refusals.dedup();
        refusals
    }

    /// Returns the number of pairs that overlap.
    pub(crate) fn overlapping(&self) -> usize {
        self.pairs.iter().filter(|pair| pair.overlaps).count()
    }

    /// Describes the result in one sentence.
    pub(crate) fn summary(&self) -> String {
        let unit = self.unit.symbol();
        let near = counted(self.pairs.len() - self.overlapping(), "pair");
        let near = format!("{near} near (within {} {unit})", short(self.margin));
        if self.bodies.len() == 1 {
            return "The scene has one body: there are no pairs.".to_owned();
        }
        let Some(deepest) = self.pairs_by_depth().into_iter().find(|pair| pair.overlaps) else {
            return format!("No bodies overlap; {near}.");
        };
        let verb = if self.overlapping() == 1 { "overlaps" } else { "overlap" };
        let overlapping = format!("{} {verb}", counted(self.overlapping(), "pair"));
        let (title, depth) = (deepest.title(), measure(deepest.depth()));
        let at_least = if deepest.may_be_deeper { "at least " } else { "" };
        format!("{overlapping}, the deepest {title} by {at_least}{depth} {unit}; {near}.")
    }
}
