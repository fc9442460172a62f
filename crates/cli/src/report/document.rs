//! Content of a check's report, without its times.
//!
//! Serialized as it stands, this is the JSON output: keys in the order of the fields,
//! bodies and pairs in the order of the scene, numbers with as many digits as distinguish
//! them.

use musculo_collide::surface::{Finding, Inspection};
use musculo_collide::{BodyKind, ContactPatch, NearVertex, PairReport, Scene, VertexReport};
use serde::Serialize;

use super::division::DivisionRecord;
use super::self_crossing::SelfCrossings;
use super::text::{counted, depth, length};
use crate::scene::Unit;

/// Checked scene.
#[derive(Debug, Serialize)]
pub(crate) struct CheckDocument {
    /// Unit of every length; areas and volumes are in its square and cube.
    pub(crate) unit: Unit,
    /// Largest distance of a near pair.
    pub(crate) margin: f64,
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
    /// Content of the file behind the end that its header declares, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) unread: Option<String>,
    pub(crate) closed: bool,
    pub(crate) manifold: bool,
    pub(crate) oriented: bool,
    #[serde(flatten)]
    pub(crate) inspection: Inspection,
    /// Faces of the body that cross each other, where a check finds some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) self_crossings: Option<SelfCrossings>,
}

/// Two bodies that overlap or are near each other.
#[derive(Debug, Serialize)]
pub(crate) struct PairRecord {
    pub(crate) a: String,
    pub(crate) b: String,
    pub(crate) overlaps: bool,
    /// Depth of the deepest vertex inside the other body, 0 without one.
    pub(crate) max_depth: f64,
    /// Smallest signed distance of a vertex, negative inside.
    pub(crate) min_gap: Option<f64>,
    /// Distance of the surfaces, edges and faces included; 0 where they meet.
    pub(crate) distance: Option<f64>,
    /// `None` where `b` has no inside; `refusals` has the reason.
    pub(crate) vertices_of_a_inside_b: Option<usize>,
    /// `None` where `a` has no inside; `refusals` has the reason.
    pub(crate) vertices_of_b_inside_a: Option<usize>,
    /// Number of pairs of faces that properly cross.
    pub(crate) crossing_face_pairs: usize,
    /// Vertex of the smallest gap.
    pub(crate) nearest_vertex: Option<VertexRecord>,
    /// Connected parts of `a`'s surface in contact, largest first.
    pub(crate) patches: Vec<PatchRecord>,
    /// Properties that are undefined, with the reasons.
    pub(crate) refusals: Vec<String>,
}

/// Vertex of a body.
#[derive(Debug, Serialize)]
pub(crate) struct VertexRecord {
    pub(crate) body: String,
    pub(crate) vertex: u32,
    pub(crate) at: [f64; 3],
}

/// Connected part of a surface in contact.
#[derive(Debug, Serialize)]
pub(crate) struct PatchRecord {
    pub(crate) faces: usize,
    pub(crate) area: f64,
    pub(crate) min_gap: Option<f64>,
    pub(crate) center: [f64; 3],
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
        if self.polygons_fanned > 0 {
            notes.push(counted(self.polygons_fanned, "polygon") + " split into triangles");
        }
        notes.extend(self.unread.clone());
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

impl PairRecord {
    pub(crate) fn new(report: &PairReport, scene: &Scene) -> Self {
        let (a, b) = (scene.body(report.pair.a).name(), scene.body(report.pair.b).name());
        let refusals = [refusal(&report.a_against_b, b), refusal(&report.b_against_a, a)];
        Self {
            a: a.to_owned(),
            b: b.to_owned(),
            overlaps: report.overlaps,
            max_depth: report.max_depth,
            min_gap: report.min_gap,
            distance: report.distance,
            vertices_of_a_inside_b: report.a_against_b.inside_count.ok(),
            vertices_of_b_inside_a: report.b_against_a.inside_count.ok(),
            crossing_face_pairs: report.crossing_faces.len(),
            nearest_vertex: nearest_vertex(report, scene),
            patches: report.patches.iter().map(PatchRecord::new).collect(),
            refusals: refusals.into_iter().flatten().collect(),
        }
    }

    /// Returns the sum of the patches' areas.
    pub(crate) fn contact_area(&self) -> f64 {
        self.patches.iter().map(|patch| patch.area).fold(0.0, |sum, area| sum + area)
    }

    /// Returns both names.
    pub(crate) fn title(&self) -> String {
        format!("{} × {}", self.a, self.b)
    }

    /// Writes the depth, or "edges" where faces cross and no vertex is inside.
    pub(crate) fn depth_text(&self, unit: Unit) -> String {
        depth(self.max_depth, unit)
    }
}

fn refusal(inside: &VertexReport, name: &str) -> Option<String> {
    let reason = inside.inside_count.err()?;
    Some(format!("the inside of '{name}' is undefined: {reason}"))
}

impl PatchRecord {
    fn new(patch: &ContactPatch) -> Self {
        Self {
            faces: patch.faces.len(),
            area: patch.area,
            min_gap: patch.min_gap,
            center: patch.center.to_array(),
        }
    }
}

/// Finds the vertex of the smallest gap, of `a` where both bodies have one.
fn nearest_vertex(report: &PairReport, scene: &Scene) -> Option<VertexRecord> {
    let nearest = |side: &VertexReport| -> Option<NearVertex> {
        side.near.iter().copied().min_by(|p, q| p.gap.total_cmp(&q.gap))
    };
    let (of_a, of_b) = (nearest(&report.a_against_b), nearest(&report.b_against_a));
    let gap = |near: Option<NearVertex>| near.map_or(f64::INFINITY, |near| near.gap);
    let (id, near) =
        if gap(of_a) <= gap(of_b) { (report.pair.a, of_a?) } else { (report.pair.b, of_b?) };

    let body = scene.body(id);
    let at = body.positions()[near.vertex as usize].to_array();
    Some(VertexRecord { body: body.name().to_owned(), vertex: near.vertex, at })
}

impl CheckDocument {
    /// Sorts overlapping pairs from deep to shallow, then near pairs from near to far.
    pub(crate) fn pairs_by_depth(&self) -> Vec<&PairRecord> {
        let distance = |pair: &PairRecord| pair.distance.unwrap_or(f64::INFINITY);
        let mut pairs: Vec<&PairRecord> = self.pairs.iter().collect();
        pairs.sort_by(|p, q| {
            let by_overlap = q.overlaps.cmp(&p.overlaps);
            let by_depth = q.max_depth.total_cmp(&p.max_depth);
            by_overlap.then(by_depth).then(distance(p).total_cmp(&distance(q)))
        });
        pairs
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
        let near = format!("{near} near (within {} {unit})", self.margin);
        let Some(deepest) = self.pairs_by_depth().into_iter().find(|pair| pair.overlaps) else {
            return format!("No bodies overlap; {near}.");
        };
        let verb = if self.overlapping() == 1 { "overlaps" } else { "overlap" };
        let overlapping = format!("{} {verb}", counted(self.overlapping(), "pair"));
        if deepest.max_depth <= 0.0 {
            return format!("{overlapping}, by edges only: no vertex is inside; {near}.");
        }
        let (title, depth) = (deepest.title(), length(deepest.max_depth, self.unit));
        format!("{overlapping}, the deepest {title} by {depth} {unit}; {near}.")
    }
}
