//! Tables of a check, and its report as text.

use musculo_collide::{AreaBracket, JointContactParams, OverlapMeasures};

use super::division;
use super::document::{BodyRecord, CheckDocument};
use super::joint_contact::{ContactTable, joint_title};
use super::pair_record::PairRecord;
use super::table::{Table, dash, left, right};
use super::text::{grouped, measure, short};

/// Table with a title.
pub(super) struct Section {
    pub(super) title: String,
    pub(super) table: Table,
}

/// Writes the report, without the times, which differ between runs.
pub(crate) fn check_text(document: &CheckDocument) -> String {
    let mut text = headline(document);
    for line in document.coincidences() {
        text += &format!("{line}\n");
    }
    text += &format!("\n{}", bodies(document).to_text());
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

    let near_title =
        format!("Near pairs, within {} {}", short(document.margin), document.unit.symbol());
    let mut sections = vec![
        Section {
            title: "Overlapping pairs".to_owned(),
            table: overlapping_pairs(&overlapping, document),
        },
        Section { title: near_title, table: near_pairs(&near, document) },
        Section {
            title: "Divided open surfaces".to_owned(),
            table: division::table(&document.divisions, document.unit),
        },
    ];
    sections.extend(joint_section(document));
    sections.retain(|section| !section.table.is_empty());
    sections
}

fn overlapping_pairs(pairs: &[&PairRecord], document: &CheckDocument) -> Table {
    let unit = document.unit.symbol();
    let mut table = Table::new([
        right(format!("depth [{unit}]")),
        right(format!("volume [{unit}³]")),
        left("a"),
        left("b"),
        right(format!("area of a in b [{unit}²]")),
        right(format!("area of b in a [{unit}²]")),
        right("regions"),
        right("crossings"),
    ]);
    for pair in pairs {
        // What is undefined for a pair has no measures.
        let (mut total, mut regions) = (OverlapMeasures::default(), 0);
        if let Some(overlap) = &pair.overlap {
            (total, regions) = (overlap.total, overlap.regions.len());
        }
        table.row([
            pair.depth_text().unwrap_or_else(undefined),
            total.volume.map_or_else(undefined, measure),
            pair.a.clone(),
            pair.b.clone(),
            total.area_of_a_inside_b.map_or_else(undefined, measure),
            total.area_of_b_inside_a.map_or_else(undefined, measure),
            grouped(regions),
            grouped(pair.crossing_face_pairs),
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
        right(format!("area of a near b [{unit}²]")),
        right(format!("area of b near a [{unit}²]")),
    ]);
    let value = |value: Option<f64>| value.map_or_else(dash, measure);
    for pair in pairs {
        table.row([
            value(pair.distance),
            pair.a.clone(),
            pair.b.clone(),
            value(pair.min_gap),
            pair.near_area_of_a.map_or_else(dash, bracket),
            pair.near_area_of_b.map_or_else(dash, bracket),
        ]);
    }
    table
}

/// Returns the table of joint contact, where it is measured.
fn joint_section(document: &CheckDocument) -> Option<Section> {
    let JointContactParams { margin, foundation, .. } = document.joint_contact?;
    let mut table = ContactTable::new([], document.unit, foundation.is_some());
    for pair in document.pairs_by_depth() {
        if let Some(contact) = &pair.joint_contact {
            table.with_regions(&contact.of_a);
            table.with_regions(&contact.of_b);
        }
    }
    Some(Section { title: joint_title(margin, document.unit), table: table.finish() })
}

/// Writes an area that is known within a bracket.
fn bracket(AreaBracket { lower, upper }: AreaBracket) -> String {
    if upper > lower { format!("{} to {}", measure(lower), measure(upper)) } else { measure(lower) }
}

/// Returns the mark of a value that is undefined: the refusals have the reason.
fn undefined() -> String {
    "?".to_owned()
}
