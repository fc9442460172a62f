//! The report that a terminal shows: defects of the meshes first, then pairs.

use super::division;
use super::document::{BodyRecord, Document, PairRecord};
use super::text::{Align, TextTable, grouped, length, measure};

/// The whole report but for the times, which no two runs share.
pub(crate) fn table(document: &Document) -> String {
    let mut text = headline(document);
    text.push('\n');
    text += &bodies(document);
    let (overlapping, near): (Vec<_>, Vec<_>) =
        document.pairs_by_depth().into_iter().partition(|pair| pair.overlaps);
    if !overlapping.is_empty() {
        text += "\nOverlapping\n";
        text += &overlaps(&overlapping, document);
    }
    if !near.is_empty() {
        let unit = document.unit.symbol();
        text += &format!("\nNear, within {} {unit}\n", document.reach);
        text += &gaps(&near, document);
    }
    if !document.divisions.is_empty() {
        text += "\nDivided\n";
        text += &division::table(&document.divisions, document.unit);
    }
    text += &notes("Not answered", &document.refusals());
    text += &notes("Warnings", &document.warnings);
    text += &format!("\n{}\n", document.summary());
    text
}

fn headline(document: &Document) -> String {
    let total = |count: fn(&BodyRecord) -> usize| document.bodies.iter().map(count).sum();
    let bodies = document.bodies.len();
    format!(
        "{} {}, {} vertices, {} faces; lengths in {}\n",
        grouped(bodies),
        if bodies == 1 { "body" } else { "bodies" },
        grouped(total(|body| body.vertices)),
        grouped(total(|body| body.faces)),
        document.unit.symbol(),
    )
}

fn bodies(document: &Document) -> String {
    let unit = document.unit.symbol();
    let mut table = TextTable::new(&[
        ("BODY", Align::Left),
        ("KIND", Align::Left),
        ("VERTICES", Align::Right),
        ("FACES", Align::Right),
        (&format!("VOLUME {unit}^3"), Align::Right),
        ("DEFECTS", Align::Left),
    ]);
    for body in &document.bodies {
        let mut notes = body.notes().into_iter();
        table.row(vec![
            body.name.clone(),
            body.kind_name().to_owned(),
            grouped(body.vertices),
            grouped(body.faces),
            body.volume.map_or("-".to_owned(), measure),
            notes.next().unwrap_or_else(|| "none".to_owned()),
        ]);
        for note in notes {
            let mut row = vec![String::new(); 5];
            row.push(note);
            table.row(row);
        }
    }
    table.render()
}

fn overlaps(pairs: &[&PairRecord], document: &Document) -> String {
    let unit = document.unit.symbol();
    let mut table = TextTable::new(&[
        (&format!("DEPTH {unit}"), Align::Right),
        ("A", Align::Left),
        ("B", Align::Left),
        ("A IN B", Align::Right),
        ("B IN A", Align::Right),
        ("CROSSINGS", Align::Right),
        (&format!("AREA {unit}^2"), Align::Right),
        ("PATCHES", Align::Right),
    ]);
    for pair in pairs {
        let [a_in_b, b_in_a] = pair.inside();
        table.row(vec![
            pair.depth_text(document.unit),
            pair.a.clone(),
            pair.b.clone(),
            a_in_b,
            b_in_a,
            grouped(pair.crossing_face_pairs),
            measure(pair.contact_area()),
            grouped(pair.patches.len()),
        ]);
    }
    let mut text = table.render();
    if pairs.iter().any(|pair| pair.max_depth <= 0.0) {
        text += "  (edges: faces cross, but no vertex is inside)\n";
    }
    text
}

fn gaps(pairs: &[&PairRecord], document: &Document) -> String {
    let unit = document.unit.symbol();
    let mut table = TextTable::new(&[
        (&format!("DISTANCE {unit}"), Align::Right),
        ("A", Align::Left),
        ("B", Align::Left),
        ("OF A VERTEX", Align::Right),
        (&format!("AREA {unit}^2"), Align::Right),
        ("PATCHES", Align::Right),
    ]);
    let or_dash = |gap: Option<f64>| gap.map_or("-".to_owned(), |gap| length(gap, document.unit));
    for pair in pairs {
        table.row(vec![
            or_dash(pair.distance),
            pair.a.clone(),
            pair.b.clone(),
            or_dash(pair.min_gap),
            measure(pair.contact_area()),
            grouped(pair.patches.len()),
        ]);
    }
    table.render()
}

fn notes(title: &str, notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    format!("\n{title}\n  {}\n", notes.join("\n  "))
}
