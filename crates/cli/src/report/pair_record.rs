//! Record of one pair of bodies, as the report of a check has it.

use musculo_collide::{
    AreaBracket, BodyId, Coincidence, Depth, NearVertex, NoInside, Overlap, OverlapMeasures,
    PairId, PairReport, Scene,
};
use serde::Serialize;

use super::joint_contact::JointContactRecord;
use super::text::measure;

/// Two bodies that overlap or are near each other.
#[derive(Debug, Serialize)]
pub(crate) struct PairRecord {
    pub(crate) a: String,
    pub(crate) b: String,
    pub(crate) overlaps: bool,
    /// Way in which both bodies are the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) coincidence: Option<Coincidence>,
    /// Measures of what both share; `None` where the surfaces share no area.
    pub(crate) overlap: Option<OverlapRecord>,
    /// Greatest depth of `a`'s surface inside `b`; `None` where nothing of it is inside, and where
    /// `b` has no inside.
    pub(crate) depth_of_a_in_b: Option<Depth>,
    /// Greatest depth of `b`'s surface inside `a`.
    pub(crate) depth_of_b_in_a: Option<Depth>,
    /// Area of `a`'s surface within the margin of `b`, for pairs that do not overlap.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) near_area_of_a: Option<AreaBracket>,
    /// Area of `b`'s surface within the margin of `a`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) near_area_of_b: Option<AreaBracket>,
    /// Joint contact, where it is measured and there is some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) joint_contact: Option<JointContactRecord>,
    /// Depth of the deepest vertex inside the other body, 0 without one.
    pub(crate) max_vertex_depth: f64,
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
    /// Properties that are undefined, with the reasons.
    pub(crate) refusals: Vec<String>,
    /// True if depths in one of both bodies are undefined: the overlap may be deeper than the other one shows.
    #[serde(skip)]
    pub(crate) may_be_deeper: bool,
    /// Depth that the rounding of coordinates alone makes.
    #[serde(skip)]
    rounding: f64,
}

/// Measures of an overlap.
#[derive(Debug, Serialize)]
pub(crate) struct OverlapRecord {
    #[serde(flatten)]
    pub(crate) total: OverlapMeasures,
    /// The same for each separate contact region, the largest volume first.
    pub(crate) regions: Vec<OverlapMeasures>,
    /// True if the surfaces touch without crossing, or coincide, somewhere.
    has_ties: bool,
}

/// Vertex of a body.
#[derive(Debug, Serialize)]
pub(crate) struct VertexRecord {
    pub(crate) body: String,
    pub(crate) vertex: u32,
    pub(crate) at: [f64; 3],
}

impl PairRecord {
    pub(crate) fn new(report: &PairReport, scene: &Scene) -> Self {
        let names = scene.names(report.pair);
        let overlap = report.overlap.as_ref();
        let [near_area_of_a, near_area_of_b] = match report.near_areas {
            Some([of_a, of_b]) => [Some(of_a), Some(of_b)],
            None => [None; 2],
        };
        Self {
            a: names[0].to_owned(),
            b: names[1].to_owned(),
            overlaps: report.overlaps,
            coincidence: report.coincidence,
            overlap: overlap.map(|overlap| OverlapRecord::new(&overlap.measures)),
            depth_of_a_in_b: overlap.and_then(|overlap| overlap.depth_of_a_in_b),
            depth_of_b_in_a: overlap.and_then(|overlap| overlap.depth_of_b_in_a),
            near_area_of_a,
            near_area_of_b,
            joint_contact: None,
            max_vertex_depth: report.max_vertex_depth,
            min_gap: report.min_gap,
            distance: report.distance,
            vertices_of_a_inside_b: report.a_against_b.inside_count.ok(),
            vertices_of_b_inside_a: report.b_against_a.inside_count.ok(),
            crossing_face_pairs: report.crossing_faces.len(),
            nearest_vertex: nearest_vertex(report, scene),
            refusals: refusals(report, scene),
            may_be_deeper: report.overlaps && has_undefined_depth(report),
            rounding: if report.overlaps { rounding(report.pair, scene) } else { 0.0 },
        }
    }

    /// Returns both names.
    pub(crate) fn title(&self) -> String {
        format!("{} × {}", self.a, self.b)
    }

    /// Returns the depth of the overlap as far as it is certain, of vertices where surfaces have
    /// none: 0 where nothing is inside, and where rounding alone makes it.
    pub(crate) fn depth(&self) -> f64 {
        let mut depth = self.deeper().map_or(self.max_vertex_depth, |depth| depth.lower);
        if self.may_be_deeper {
            depth = depth.max(self.max_vertex_depth);
        }
        self.above_rounding(depth)
    }

    fn above_rounding(&self, depth: f64) -> f64 {
        if depth > self.rounding { depth } else { 0.0 }
    }

    /// Writes the depth: a number where it is known as closely as asked, else a range, or what it is at least where
    /// it is undefined in one body.
    pub(crate) fn depth_text(&self) -> Option<String> {
        if self.may_be_deeper {
            let depth = self.depth();
            return (depth > 0.0).then(|| format!("≥ {}", measure(depth)));
        }
        let Depth { lower, upper, is_narrow, .. } = self.deeper()?;
        let [lower, upper] = [lower, upper].map(|depth| measure(self.above_rounding(depth)));
        Some(if is_narrow { lower } else { format!("{lower} to {upper}") })
    }

    /// Returns the larger of both depths.
    fn deeper(&self) -> Option<Depth> {
        let depths = [self.depth_of_a_in_b, self.depth_of_b_in_a].into_iter().flatten();
        depths.max_by(|p, q| p.lower.total_cmp(&q.lower))
    }

    /// Notes that a body crosses itself, where it is one of an overlapping pair.
    pub(crate) fn note_self_crossings(&mut self, body: &str) {
        if self.overlaps && (self.a == body || self.b == body) {
            self.refusals.push(format!(
                "'{body}' crosses itself: volumes and areas in it count a place as often as it is \
                 covered"
            ));
        }
    }

    /// Describes the way in which both bodies are the same.
    pub(crate) fn coincidence_text(&self) -> Option<String> {
        let way = match self.coincidence? {
            Coincidence::SameMesh => "are one mesh: they have the same vertices and faces",
            Coincidence::SameSurface => "are one surface, divided into other faces",
            _ => "coincide",
        };
        Some(format!("{} and {} {way}", self.a, self.b))
    }
}

impl OverlapRecord {
    fn new(overlap: &Overlap) -> Self {
        let Overlap { total, regions, has_ties, .. } = overlap;
        Self { total: *total, regions: regions.clone(), has_ties: *has_ties }
    }
}

/// Returns the depth that rounding alone can make where two surfaces coincide.
pub(super) fn rounding(pair: PairId, scene: &Scene) -> f64 {
    /// Rounding of a closest point, relative to the largest coordinate.
    const CLOSEST_POINT: f64 = 16.0 * f64::EPSILON;

    let [a, b] = pair.bodies().map(|id| scene.body(id).largest_coordinate());
    CLOSEST_POINT * a.max(b)
}

/// Returns true if depths are undefined in a body that has vertices of the other one inside, or in both.
fn has_undefined_depth(report: &PairReport) -> bool {
    let Some(overlap) = &report.overlap else { return true };
    let measures = &overlap.measures;
    let sides = [&report.b_against_a, &report.a_against_b];
    let is_sheet = |side: usize| sides[side].inside_count.is_err();
    let is_undefined = |side: usize| {
        measures.covers_twice[side] || (measures.no_inside[side].is_some() && !is_sheet(side))
    };
    is_undefined(0) || is_undefined(1) || (is_sheet(0) && is_sheet(1))
}

/// Names what is undefined for a pair, with the reasons.
fn refusals(report: &PairReport, scene: &Scene) -> Vec<String> {
    let mut refusals = Vec::new();
    let overlap = report.overlap.as_ref().map(|overlap| &overlap.measures);
    let vertices = [&report.b_against_a, &report.a_against_b];
    for (side, id) in report.pair.bodies().into_iter().enumerate() {
        // A body that has an inside by parity may lack winding numbers, which volumes need.
        let (name, tree) = (scene.body(id).name(), scene.body(id).tree());
        let by_parity = vertices[side].inside_count.err();
        let by_winding = tree.and_then(|tree| tree.has_winding_number().err());
        let by_winding = by_winding.filter(|_| report.overlaps);
        let other = scene.body(report.pair.bodies()[1 - side]).name();
        let surrounds = vertices[side].near.iter().any(|near| near.gap < 0.0);
        if let Some(reason) = by_parity.filter(|_| surrounds) {
            refusals.push(format!(
                "'{name}' surrounds '{other}', and its inside is undefined ({reason}): close it, or give it the kind \
                 'open' where it is a sheet"
            ));
        } else if let Some(reason) = by_parity {
            refusals.push(format!("the inside of '{name}' is undefined: {reason}"));
        } else if let Some(reason) = by_winding {
            refusals.push(no_measures(name, reason));
        }
        if overlap.is_some_and(|overlap| overlap.covers_twice[side]) {
            refusals.push(format!(
                "'{name}' covers a place more than once, or in part inside out: volumes and areas in it \
                 count a place as often as it is covered, and depths in it are undefined"
            ));
        }
    }
    refusals
}

fn no_measures(name: &str, reason: NoInside) -> String {
    format!("volumes, areas and depths in '{name}' are undefined: {reason}")
}

/// Finds the vertex of the smallest gap, of `a` where both bodies have one.
fn nearest_vertex(report: &PairReport, scene: &Scene) -> Option<VertexRecord> {
    let sides = [(report.pair.a, &report.a_against_b), (report.pair.b, &report.b_against_a)];
    let mut nearest: Option<(BodyId, NearVertex)> = None;
    for (id, side) in sides {
        for &near in &side.near {
            if nearest.is_none_or(|(_, nearest)| near.gap < nearest.gap) {
                nearest = Some((id, near));
            }
        }
    }

    let (id, near) = nearest?;
    let body = scene.body(id);
    let at = body.positions()[near.vertex as usize].to_array();
    Some(VertexRecord { body: body.name().to_owned(), vertex: near.vertex, at })
}
