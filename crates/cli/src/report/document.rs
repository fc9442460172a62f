//! Everything that is reported of a check, except how long it took.
//!
//! Serialised as it stands, this is the JSON output: keys in the order of the
//! fields, bodies and pairs in the order of the scene, numbers with as many
//! digits as tell them apart.

use musculo_collide::surface::{Defect, Element, Finding, Inspection};
use musculo_collide::{BodyKind, ContactPatch, PairReport, VertexReport};
use serde::Serialize;

use super::division::DivisionRecord;
use super::text::{counted, length};
use crate::scene::{Bounds, Unit};

/// A checked scene.
#[derive(Debug, Serialize)]
pub(crate) struct Document {
    /// Of every length here; areas and volumes are in its square and cube.
    pub(crate) unit: Unit,
    /// How far apart surfaces still counted as near.
    pub(crate) reach: f64,
    pub(crate) warnings: Vec<String>,
    pub(crate) bodies: Vec<BodyRecord>,
    /// Every pair that overlaps or comes within reach.
    pub(crate) pairs: Vec<PairRecord>,
    /// Open surfaces that others cross.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) divisions: Vec<DivisionRecord>,
}

/// One mesh as it was read.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct BodyRecord {
    pub(crate) name: String,
    pub(crate) file: String,
    pub(crate) kind: BodyKind,
    pub(crate) vertices: usize,
    pub(crate) faces: usize,
    /// Faces of the file that had more than three corners.
    pub(crate) polygons_fanned: usize,
    pub(crate) closed: bool,
    pub(crate) manifold: bool,
    pub(crate) oriented: bool,
    pub(crate) components: usize,
    pub(crate) euler_number: i64,
    /// Only a closed surface has one.
    pub(crate) volume: Option<f64>,
    pub(crate) area: f64,
    pub(crate) bounds: Bounds,
    pub(crate) defects: Vec<DefectRecord>,
}

/// One kind of defect of a mesh.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct DefectRecord {
    pub(crate) defect: Defect,
    pub(crate) count: usize,
    pub(crate) first: Element,
    pub(crate) at: [f64; 3],
    /// The same in words.
    pub(crate) text: String,
}

/// Two bodies that overlap or come within reach.
#[derive(Debug, Serialize)]
pub(crate) struct PairRecord {
    pub(crate) a: String,
    pub(crate) b: String,
    pub(crate) overlaps: bool,
    /// Of the deepest vertex inside the other body; 0 where none is inside.
    pub(crate) max_depth: f64,
    /// Smallest signed distance of a vertex, negative inside.
    pub(crate) min_gap: Option<f64>,
    /// Between the surfaces, edges and faces included; 0 where they meet.
    pub(crate) distance: Option<f64>,
    /// `None` where nothing can be inside `b`; `refusals` says why.
    pub(crate) vertices_of_a_inside_b: Option<usize>,
    /// `None` where nothing can be inside `a`; `refusals` says why.
    pub(crate) vertices_of_b_inside_a: Option<usize>,
    /// Pairs of faces that properly cross.
    pub(crate) crossing_face_pairs: usize,
    /// The vertex of the smallest gap.
    pub(crate) nearest_vertex: Option<VertexRecord>,
    /// Connected parts of `a`'s surface in contact, largest first.
    pub(crate) patches: Vec<PatchRecord>,
    /// What could not be answered, and why.
    pub(crate) refusals: Vec<String>,
}

/// A vertex and the body it is of.
#[derive(Debug, Serialize)]
pub(crate) struct VertexRecord {
    pub(crate) body: String,
    pub(crate) vertex: u32,
    pub(crate) at: [f64; 3],
}

/// A connected part of a surface in contact.
#[derive(Debug, Serialize)]
pub(crate) struct PatchRecord {
    pub(crate) faces: usize,
    pub(crate) area: f64,
    pub(crate) min_gap: Option<f64>,
    pub(crate) centre: [f64; 3],
}

/// What a body record is made of, beside the inspection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodySource<'a> {
    pub(crate) body: &'a crate::scene::Body,
    pub(crate) bounds: Bounds,
    pub(crate) polygons_fanned: usize,
    pub(crate) unit: Unit,
}

impl BodyRecord {
    pub(crate) fn new(source: BodySource<'_>, inspection: &Inspection) -> Self {
        let BodySource { body, bounds, polygons_fanned, unit } = source;
        let (findings, decimals) = (inspection.findings.iter(), unit.decimals());
        Self {
            name: body.name.clone(),
            file: body.file.clone(),
            kind: body.kind,
            vertices: inspection.vertices,
            faces: inspection.faces,
            polygons_fanned,
            closed: inspection.closed(),
            manifold: inspection.manifold(),
            oriented: inspection.oriented(),
            components: inspection.components,
            euler_number: inspection.euler,
            volume: inspection.closed().then_some(inspection.volume),
            area: inspection.area,
            bounds,
            defects: findings.map(|finding| DefectRecord::new(finding, decimals)).collect(),
        }
    }
}

impl BodyRecord {
    /// As scene files write it.
    pub(crate) fn kind_name(&self) -> &'static str {
        match self.kind {
            BodyKind::Rigid => "rigid",
            BodyKind::Deformable => "deformable",
            BodyKind::Open => "open",
        }
    }

    /// Defects, and what else of the mesh is worth a line, in words.
    pub(crate) fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.defects.iter().map(|d| d.text.clone()).collect();
        if self.polygons_fanned > 0 {
            notes
                .push(format!("{} split into triangles", counted(self.polygons_fanned, "polygon")));
        }
        if self.volume.is_some_and(|volume| volume < 0.0) {
            notes.push("turned inside out: its volume is negative".to_owned());
        }
        notes
    }
}

impl DefectRecord {
    /// The words give the place to `decimals`, the record in full.
    fn new(finding: &Finding, decimals: usize) -> Self {
        let digits = (0..decimals).fold(1.0, |power, _| power * 10.0);
        let rounded = Finding { at: (finding.at * digits).round() / digits, ..*finding };
        Self {
            defect: finding.defect,
            count: finding.count,
            first: finding.first,
            at: finding.at.to_array(),
            text: rounded.to_string(),
        }
    }
}

impl PairRecord {
    pub(crate) fn new(report: &PairReport, scene: &musculo_collide::Scene) -> Self {
        let (a, b) = (scene.body(report.pair.a), scene.body(report.pair.b));
        let refusal = |inside: &VertexReport, body: &musculo_collide::Body| {
            let reason = inside.inside_count.err()?;
            Some(format!("what is inside '{}' is unknown: {reason}", body.name()))
        };
        let refusals = [refusal(&report.a_against_b, b), refusal(&report.b_against_a, a)];
        Self {
            a: a.name().to_owned(),
            b: b.name().to_owned(),
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

    /// Sum of the patches' areas.
    pub(crate) fn contact_area(&self) -> f64 {
        self.patches.iter().map(|patch| patch.area).fold(0.0, |sum, area| sum + area)
    }
}

impl PatchRecord {
    fn new(patch: &ContactPatch) -> Self {
        Self {
            faces: patch.faces.len(),
            area: patch.area,
            min_gap: patch.min_gap,
            centre: patch.center.to_array(),
        }
    }
}

fn nearest_vertex(report: &PairReport, scene: &musculo_collide::Scene) -> Option<VertexRecord> {
    let sides = [(report.pair.a, &report.a_against_b), (report.pair.b, &report.b_against_a)];
    let (id, near) = sides
        .into_iter()
        .flat_map(|(id, side)| side.near.iter().map(move |near| (id, near)))
        .min_by(|p, q| p.1.gap.total_cmp(&q.1.gap))?;
    let body = scene.body(id);
    let at = body.positions()[near.vertex as usize].to_array();
    Some(VertexRecord { body: body.name().to_owned(), vertex: near.vertex, at })
}

impl Document {
    /// Pairs in the order a person reads them: overlapping ones first, the
    /// deepest first; then near ones, the nearest first.
    pub(crate) fn pairs_by_depth(&self) -> Vec<&PairRecord> {
        let mut pairs: Vec<&PairRecord> = self.pairs.iter().collect();
        let nearness = |pair: &PairRecord| pair.distance.unwrap_or(f64::INFINITY);
        pairs.sort_by(|p, q| {
            q.overlaps
                .cmp(&p.overlaps)
                .then(q.max_depth.total_cmp(&p.max_depth))
                .then(nearness(p).total_cmp(&nearness(q)))
        });
        pairs
    }

    /// What could not be answered of any pair, each reason once.
    pub(crate) fn refusals(&self) -> Vec<String> {
        let mut refusals: Vec<String> =
            self.pairs.iter().flat_map(|pair| pair.refusals.iter().cloned()).collect();
        refusals.sort();
        refusals.dedup();
        refusals
    }

    /// How many pairs overlap.
    pub(crate) fn overlapping(&self) -> usize {
        self.pairs.iter().filter(|pair| pair.overlaps).count()
    }

    /// One sentence that says how it ended.
    pub(crate) fn summary(&self) -> String {
        let unit = self.unit.symbol();
        let near = self.pairs.len() - self.overlapping();
        let near = format!("{} near (within {} {unit})", counted(near, "pair"), self.reach);
        let deepest = self.pairs_by_depth().into_iter().find(|pair| pair.overlaps);
        match deepest {
            None => format!("No bodies overlap; {near}."),
            Some(pair) => {
                let overlap = if self.overlapping() == 1 { "overlaps" } else { "overlap" };
                format!(
                    "{} {overlap}, the deepest {} by {} {unit}; {near}.",
                    counted(self.overlapping(), "pair"),
                    pair.title(),
                    length(pair.max_depth, self.unit),
                )
            }
        }
    }
}

impl PairRecord {
    /// Both names.
    pub(crate) fn title(&self) -> String {
        format!("{} × {}", self.a, self.b)
    }

    /// The depth, or that there is none to tell: faces cross, but no vertex is
    /// inside.
    pub(crate) fn depth_text(&self, unit: Unit) -> String {
        let is_deep = self.max_depth > 0.0;
        if is_deep { length(self.max_depth, unit) } else { "edges".to_owned() }
    }

    /// Vertices inside either way: of a in b, of b in a.
    pub(crate) fn inside(&self) -> [String; 2] {
        [self.vertices_of_a_inside_b, self.vertices_of_b_inside_a]
            .map(|count| count.map_or("?".to_owned(), |count| count.to_string()))
    }
}
