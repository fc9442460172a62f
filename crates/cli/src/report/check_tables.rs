//! Tables of a check, and its report as text.

use super::division;
use super::document::{BodyRecord, CheckDocument, PairRecord};
use super::table::{Table, left, right};
use super::text::{grouped, length, measure};

/// Table with a title.
pub(super) struct Section {
    pub(super) title: String,
    pub(super) table: Table,
}

/// Writes the report, without the times, which differ between runs.
pub(crate) fn check_text(document: &CheckDocument) -> String {
    let mut text = headline(document) + "\n" + &bodies(document).to_text();
    for Section { title, table } in pair_sections(document) {
        text += &format!("\n{title}\n{}", table.to_text());
    }
    text += &notes("Undefined", &document.refusals());
    text += &notes("Warnings", &document.warnings);
    text + &format!("\n{}\n", document.summary())
}

fn headline(document: &CheckDocument) -> String {
    let total = |count: fn(&BodyRecord) -> usize| document.bodies.iter().map(count).sum();
    let bodies = document.bodies.len();
    format!(
        "{} {}, {} vertices, {} faces; lengths in {}\n",
        grouped(bodies),
        if bodies == 1 { "body" } else { "bodies" },
        grouped(total(|body| body.inspection.vertices)),
        grouped(total(|body| body.inspection.faces)),
        document.unit.symbol(),
    )
}

fn notes(title: &str, notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    format!("\n{title}\n  {}\n", notes.join("\n  "))
}

/// Returns the table of meshes and their defects.
pub(super) fn bodies(document: &CheckDocument) -> Table {
    let unit = document.unit.symbol();
    let mut table = Table::new([
        left("body"),
        left("kind"),
        right("vertices"),
        right("faces"),
        right("parts"),
        right(format!("area [{unit}²]")),
        right(format!("volume [{unit}³]")),
        left("defects"),
    ]);
    for body in &document.bodies {
        table.row([
            body.name.clone(),
            body.kind_name().to_owned(),
            grouped(body.inspection.vertices),
            grouped(body.inspection.faces),
            grouped(body.inspection.components),
            measure(body.inspection.area),
            body.volume().map_or_else(dash, measure),
            body.notes(document.unit).join("\n"),
        ]);
    }
    table
}

/// Returns the tables of overlapping pairs, near pairs and divided surfaces, without
/// those that would be empty.
pub(super) fn pair_sections(document: &CheckDocument) -> Vec<Section> {
    let (overlapping, near): (Vec<_>, Vec<_>) =
        document.pairs_by_depth().into_iter().partition(|pair| pair.overlaps);

    let is_edges = |pair: &&PairRecord| pair.max_depth <= 0.0;
    let note = if overlapping.iter().any(is_edges) {
        " (edges: faces cross, but no vertex is inside)"
    } else {
        ""
    };
    let near_title = format!("Near pairs, within {} {}", document.margin, document.unit.symbol());
    let mut sections = vec![
        Section {
            title: format!("Overlapping pairs{note}"),
            table: overlapping_pairs(&overlapping, document),
        },
        Section { title: near_title, table: near_pairs(&near, document) },
        Section {
            title: "Divided open surfaces".to_owned(),
            table: division::table(&document.divisions, document.unit),
        },
    ];
    sections.retain(|section| !section.table.is_empty());
    sections
}

fn overlapping_pairs(pairs: &[&PairRecord], document: &CheckDocument) -> Table {
    let unit = document.unit.symbol();
    let mut table = Table::new([
        right(format!("depth [{unit}]")),
        left("a"),
        left("b"),
        right("a in b"),
        right("b in a"),
        right("crossings"),
        right(format!("area [{unit}²]")),
        right("patches"),
    ]);
    let inside = |count: Option<usize>| count.map_or_else(|| "?".to_owned(), grouped);
    for pair in pairs {
        table.row([
            pair.depth_text(document.unit),
            pair.a.clone(),
            pair.b.clone(),
            inside(pair.vertices_of_a_inside_b),
            inside(pair.vertices_of_b_inside_a),
            grouped(pair.crossing_face_pairs),
            measure(pair.contact_area()),
            grouped(pair.patches.len()),
        ]);
    }
    table
}

fn near_pairs(pairs: &[&PairRecord], document: &CheckDocument) -> Table {
    let unit = document.unit.symbol();
    let mut table = Table::new([
        right(format!("distance [{unit}]")),
        left("a"),
        left("b"),
        right(format!("gap of a vertex [{unit}]")),
        right(format!("area [{unit}²]")),
        right("patches"),
    ]);
    let gap = |gap: Option<f64>| gap.map_or_else(dash, |gap| length(gap, document.unit));
    for pair in pairs {
        table.row([
            gap(pair.distance),
            pair.a.clone(),
            pair.b.clone(),
            gap(pair.min_gap),
            measure(pair.contact_area()),
            grouped(pair.patches.len()),
        ]);
    }
    table
}

/// Returns the mark of an absent value.
pub(super) fn dash() -> String {
    "-".to_owned()
}
