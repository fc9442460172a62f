//! The report as one file that needs nothing else: style and pictures inside,
//! no scripts, nothing fetched.

use std::fmt::Write;
use std::io;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::document::{BodyRecord, Document, PairRecord};
use super::text::{grouped, length, measure};
use super::views::Sight;
use crate::picture::viridis;

const STYLE: &str = include_str!("report.css");

/// The whole page. `close_ups` are those of the overlapping pairs, the deepest
/// first.
pub(crate) fn html(
    title: &str,
    document: &Document,
    overview: &[Sight],
    close_ups: &[Sight],
) -> io::Result<String> {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{0}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n\
         <p class=\"lead\">{1}</p>\n",
        escaped(title),
        escaped(&document.summary()),
    );
    page += &warnings(document);
    page += &overview_section(overview, document)?;
    page += &pairs_section(document);
    page += &close_up_section(close_ups, document)?;
    page += &bodies_section(document);
    page += &format!(
        "<footer>musculo-collide {}</footer>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    );
    Ok(page)
}

fn warnings(document: &Document) -> String {
    let item = |text: &String| format!("<p class=\"warning\">{}</p>\n", escaped(text));
    document.warnings.iter().map(item).collect()
}

fn overview_section(overview: &[Sight], document: &Document) -> io::Result<String> {
    let mut section = "<section>\n<h2>Contact from three sides</h2>\n".to_owned();
    section += if document.overlapping() > 0 {
        "<p>Overlapping bodies are solid, the others glass. Parts inside another body are \
         coloured by their depth and shine through whatever hides them.</p>\n"
    } else {
        "<p>No bodies overlap.</p>\n"
    };
    section += "<div class=\"sights\">\n";
    for sight in overview {
        section += &figure(sight, &sight.title, document)?;
    }
    section += "</div>\n";
    if let Some(sight) = overview.first().filter(|_| document.overlapping() > 0) {
        section += &legend(sight.deepest, document);
    }
    section += "</section>\n";
    Ok(section)
}

fn close_up_section(close_ups: &[Sight], document: &Document) -> io::Result<String> {
    if close_ups.is_empty() {
        return Ok(String::new());
    }
    let mut section = "<section>\n<h2>Overlaps, one by one</h2>\n\
        <p>Seen from within the body that is entered, along the normal of the contact; what is \
        nearer is cut away. Each picture has a colour scale of its own.</p>\n\
        <div class=\"sights\">\n"
        .to_owned();
    for sight in close_ups {
        section += "<div>\n";
        section += &figure(sight, &sight.title, document)?;
        section += &legend(sight.deepest, document);
        section += "</div>\n";
    }
    section += "</div>\n</section>\n";
    Ok(section)
}

fn figure(sight: &Sight, caption: &str, document: &Document) -> io::Result<String> {
    let png = STANDARD.encode(sight.image.to_png()?);
    let (bar, share) = scale_bar(sight);
    let (caption, unit) = (escaped(caption), document.unit.symbol());
    let Sight { width, height, .. } = sight;
    Ok(format!(
        "<figure>\n<div class=\"picture\" style=\"max-width:{width}px\">\
         <img width=\"{width}\" height=\"{height}\" alt=\"{caption}\" src=\"data:image/png;base64,{png}\">\
         <div class=\"bar\" style=\"width:{share:.2}%\"><span>{bar} {unit}</span></div></div>\n\
         <figcaption>{caption}</figcaption>\n</figure>\n"
    ))
}

/// A round length of a tenth to a quarter of the picture's width, and its
/// share of the width in percent.
fn scale_bar(sight: &Sight) -> (String, f64) {
    let most = sight.span / 4.0;
    let ten = 10.0_f64.powf(most.log10().floor());
    let bar = [5.0, 2.0].into_iter().map(|n| n * ten).find(|bar| *bar <= most).unwrap_or(ten);
    (without_zeros(bar), 100.0 * bar / sight.span)
}

/// A round length without the zeros behind its last digit.
fn without_zeros(length: f64) -> String {
    let text = format!("{length:.9}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The colour scale from 0 to the deepest, with its numbers.
fn legend(deepest: f64, document: &Document) -> String {
    if deepest <= 0.0 {
        return "<p class=\"note\">Faces cross, but no vertex is inside.</p>\n".to_owned();
    }
    let mut stops = String::new();
    let mut ticks = String::new();
    for step in 0_u8..=16 {
        let t = f64::from(step) / 16.0;
        let [r, g, b] = viridis(t).to_srgb();
        let _ = write!(stops, "<stop offset=\"{t}\" stop-color=\"rgb({r},{g},{b})\"/>");
    }
    for step in 0_u8..=4 {
        let t = f64::from(step) / 4.0;
        let x = 10.0 + 300.0 * t;
        let number = length(t * deepest, document.unit);
        let _ = write!(ticks, "<text x=\"{x}\" y=\"34\" text-anchor=\"middle\">{number}</text>");
    }
    let unit = document.unit.symbol();
    let id = format!("scale{}", deepest.to_bits());
    format!(
        "<svg class=\"legend\" viewBox=\"-24 0 368 52\" role=\"img\" aria-label=\"depth from 0 to {}\">\
         <defs><linearGradient id=\"{id}\">{stops}</linearGradient></defs>\
         <rect x=\"10\" y=\"4\" width=\"300\" height=\"14\" fill=\"url(#{id})\"/>{ticks}\
         <text x=\"160\" y=\"49\" text-anchor=\"middle\">depth inside the other body, {unit}</text></svg>\n",
        length(deepest, document.unit),
    )
}

fn pairs_section(document: &Document) -> String {
    let unit = document.unit.symbol();
    let (overlapping, near): (Vec<_>, Vec<_>) =
        document.pairs_by_depth().into_iter().partition(|pair| pair.overlaps);
    let mut section = String::new();
    if !overlapping.is_empty() {
        section += "<section>\n<h2>Overlapping pairs</h2>\n";
        let titles = [
            "a",
            "b",
            &format!("depth, {unit}"),
            "of a in b",
            "of b in a",
            "crossing faces",
            &format!("contact area, {unit}²"),
            "patches",
        ];
        section += &rows(&titles, overlapping.iter().map(|pair| overlap_row(pair, document)));
        section += "</section>\n";
    }
    if !near.is_empty() {
        let _ =
            write!(section, "<section>\n<h2>Near pairs, within {} {unit}</h2>\n", document.reach);
        let titles = [
            "a",
            "b",
            &format!("distance, {unit}"),
            &format!("smallest gap of a vertex, {unit}"),
            &format!("area within reach, {unit}²"),
            "patches",
        ];
        section += &rows(&titles, near.iter().map(|pair| near_row(pair, document)));
        section += "</section>\n";
    }
    section + &refusals(document)
}

fn overlap_row(pair: &PairRecord, document: &Document) -> Vec<String> {
    let [a_in_b, b_in_a] = pair.inside();
    vec![
        pair.a.clone(),
        pair.b.clone(),
        pair.depth_text(document.unit),
        a_in_b,
        b_in_a,
        grouped(pair.crossing_face_pairs),
        measure(pair.contact_area()),
        grouped(pair.patches.len()),
    ]
}

fn near_row(pair: &PairRecord, document: &Document) -> Vec<String> {
    let or_dash = |gap: Option<f64>| gap.map_or("–".to_owned(), |gap| length(gap, document.unit));
    vec![
        pair.a.clone(),
        pair.b.clone(),
        or_dash(pair.distance),
        or_dash(pair.min_gap),
        measure(pair.contact_area()),
        grouped(pair.patches.len()),
    ]
}

fn refusals(document: &Document) -> String {
    let refusals = document.refusals();
    if refusals.is_empty() {
        return String::new();
    }
    let items: String =
        refusals.iter().map(|text| format!("<li>{}</li>\n", escaped(text))).collect();
    format!("<section>\n<h2>Not answered</h2>\n<ul>\n{items}</ul>\n</section>\n")
}

fn bodies_section(document: &Document) -> String {
    let unit = document.unit.symbol();
    let titles = [
        "body",
        "file",
        "kind",
        "vertices",
        "faces",
        "parts",
        &format!("volume, {unit}³"),
        &format!("area, {unit}²"),
        "defects",
    ];
    let body_rows = document.bodies.iter().map(body_row);
    format!(
        "<section>\n<h2>Meshes and their defects</h2>\n{}</section>\n",
        rows(&titles, body_rows)
    )
}

fn body_row(body: &BodyRecord) -> Vec<String> {
    let notes = body.notes();
    vec![
        body.name.clone(),
        body.file.clone(),
        body.kind_name().to_owned(),
        grouped(body.vertices),
        grouped(body.faces),
        grouped(body.components),
        body.volume.map_or("–".to_owned(), measure),
        measure(body.area),
        if notes.is_empty() { "none".to_owned() } else { notes.join("; ") },
    ]
}

/// A table; cells that begin like a number stand to the right.
fn rows(titles: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let titles: String =
        titles.iter().map(|title| format!("<th>{}</th>", escaped(title))).collect();
    let cell = |text: &String| {
        let is_number = text.chars().all(|c| c.is_ascii_digit() || ".,-–?".contains(c));
        let class = if is_number { " class=\"number\"" } else { "" };
        format!("<td{class}>{}</td>", escaped(text))
    };
    let row = |entries: Vec<String>| {
        format!("<tr>{}</tr>\n", entries.iter().map(cell).collect::<String>())
    };
    let body: String = rows.map(row).collect();
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr>{titles}</tr></thead>\n<tbody>\n{body}</tbody>\n</table></div>\n"
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
