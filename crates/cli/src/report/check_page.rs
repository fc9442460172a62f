//! Report of a check as one HTML file: style, pictures and a scene that turns inside, nothing
//! fetched.

use std::io;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;

use super::check_tables::{Section, bodies, pair_sections};
use super::document::CheckDocument;
use super::gallery::{ColorScale, Quantity, View};
use super::page::{page_end, page_start, section};
use super::table::escaped;
use super::text::{measure, short};
use super::viewer::Model;
use picture::viridis;

/// Pictures of a page.
#[derive(Debug)]
pub(crate) struct Pictures {
    /// The scene from three sides.
    pub(crate) overview: Vec<View>,
    /// Overlapping pairs, the deepest first.
    pub(crate) close_ups: Vec<View>,
    /// Surfaces in joint contact.
    pub(crate) joints: Vec<View>,
}

/// Writes the page.
pub(crate) fn check_page(
    title: &str,
    document: &CheckDocument,
    pictures: &Pictures,
    model: &Model,
) -> io::Result<String> {
    let Pictures { overview, close_ups, joints } = pictures;
    let mut page = page_start(title, &document.summary());
    for coincidence in document.coincidences() {
        page += &format!("<p class=\"warning\">{}</p>\n", escaped(&coincidence));
    }
    for warning in &document.warnings {
        page += &format!("<p class=\"warning\">{}</p>\n", escaped(warning));
    }

    page += &section("The scene", &model.to_html()?);
    page += &section("Contact from three sides", &overview_figures(overview, document)?);
    for Section { title, table } in pair_sections(document) {
        page += &section(&title, &table.to_html());
    }
    if !close_ups.is_empty() {
        page += &section("Overlaps, one by one", &close_up_figures(close_ups, document)?);
    }
    if !joints.is_empty() {
        page += &section("Joint contact, one by one", &joint_figures(joints, document)?);
    }
    let refusals = document.refusals();
    if !refusals.is_empty() {
        let items: String =
            refusals.iter().map(|text| format!("<li>{}</li>\n", escaped(text))).collect();
        page += &section("Undefined", &format!("<ul>\n{items}</ul>\n"));
    }
    page += &section("Meshes and their defects", &bodies(document).to_html());

    Ok(page + &page_end())
}

fn overview_figures(overview: &[View], document: &CheckDocument) -> io::Result<String> {
    let has_overlaps = document.overlapping() > 0;
    let mut html = if has_overlaps {
        "<p>Overlapping bodies are solid, the others glass. Parts inside another body, clipped where \
         the surfaces cross, are colored by their depth and shine through nearer surfaces.</p>\n"
            .to_owned()
    } else {
        "<p>No bodies overlap.</p>\n".to_owned()
    };
    html += "<div class=\"sights\">\n";
    for figure in figures(overview, document)? {
        html += &figure;
    }
    html += "</div>\n";
    if let Some(view) = overview.first().filter(|_| has_overlaps) {
        html += &legend(&view.scale, document);
    }
    Ok(html)
}

fn close_up_figures(close_ups: &[View], document: &CheckDocument) -> io::Result<String> {
    let mut html = "<p>Views from within the entered body, along the normal of the contact; \
        nearer geometry is cut away. Each picture has its own color scale.</p>\n\
        <div class=\"sights\">\n"
        .to_owned();
    html += &figures_with_scales(close_ups, document)?;
    Ok(html + "</div>\n")
}

fn joint_figures(joints: &[View], document: &CheckDocument) -> io::Result<String> {
    let mut html =
        "<p>Each surface from the side of the other one, which is left out. Each picture \
        has its own color scale.</p>\n\
        <div class=\"sights\">\n"
            .to_owned();
    html += &figures_with_scales(joints, document)?;
    Ok(html + "</div>\n")
}

fn figures_with_scales(views: &[View], document: &CheckDocument) -> io::Result<String> {
    let mut html = String::new();
    for (view, figure) in views.iter().zip(figures(views, document)?) {
        html += &format!("<div>\n{figure}{}</div>\n", legend(&view.scale, document));
    }
    Ok(html)
}

/// Encodes pictures, each with its scale bar and caption.
fn figures(views: &[View], document: &CheckDocument) -> io::Result<Vec<String>> {
    views.par_iter().map(|view| figure(view, document)).collect()
}

fn figure(view: &View, document: &CheckDocument) -> io::Result<String> {
    let png = STANDARD.encode(view.image.to_png()?);
    let bar = round_down(view.span / 4.0);
    let (bar_text, percent) = (short(bar), 100.0 * bar / view.span);
    let (caption, unit) = (escaped(&view.title), document.unit.symbol());
    let View { width, height, .. } = view;
    Ok(format!(
        "<figure>\n<div class=\"picture\" style=\"max-width:{width}px\">\
         <img width=\"{width}\" height=\"{height}\" alt=\"{caption}\" src=\"data:image/png;base64,{png}\">\
         <div class=\"bar\" style=\"width:{percent:.2}%\"><span>{bar_text} {unit}</span></div></div>\n\
         <figcaption>{caption}</figcaption>\n</figure>\n"
    ))
}

/// Returns 1, 2 or 5 times a power of ten, at or below a length.
fn round_down(length: f64) -> f64 {
    let power = 10.0_f64.powf(length.log10().floor());
    [5.0, 2.0].into_iter().map(|n| n * power).find(|round| *round <= length).unwrap_or(power)
}

/// Draws a color scale with its numbers.
fn legend(scale: &ColorScale, document: &CheckDocument) -> String {
    let ColorScale { quantity, from, to } = *scale;
    let unit = document.unit.symbol();
    let (name, title) = match quantity {
        Quantity::Depth => ("depth", format!("depth inside the other body [{unit}]")),
        Quantity::Gap => ("gap", format!("gap to the other surface [{unit}]")),
        Quantity::Pressure => ("pressure", "pressure, in the unit of the modulus".to_owned()),
    };
    if from.total_cmp(&to).is_eq() {
        return format!("<p class=\"note\">The {name} is {} or undefined.</p>\n", short(from));
    }

    let (mut stops, mut ticks) = (String::new(), String::new());
    for step in 0_u8..=16 {
        let t = f64::from(step) / 16.0;
        let [r, g, b] = viridis(t).to_srgb();
        stops += &format!("<stop offset=\"{t}\" stop-color=\"rgb({r},{g},{b})\"/>");
        if step % 4 == 0 {
            let (x, number) = (10.0 + 300.0 * t, measure(from + t * (to - from)));
            ticks += &format!("<text x=\"{x}\" y=\"34\" text-anchor=\"middle\">{number}</text>");
        }
    }

    let id = format!("{name}{}", to.to_bits());
    format!(
        "<svg class=\"legend\" viewBox=\"-24 0 368 52\" role=\"img\" aria-label=\"{name} from {} to {}\">\
         <defs><linearGradient id=\"{id}\">{stops}</linearGradient></defs>\
         <rect x=\"10\" y=\"4\" width=\"300\" height=\"14\" fill=\"url(#{id})\"/>{ticks}\
         <text x=\"160\" y=\"49\" text-anchor=\"middle\">{title}</text></svg>\n",
        measure(from),
        measure(to),
    )
}
