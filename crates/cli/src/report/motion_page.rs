//! Report of a motion as one HTML file: the scene that moves, its chart and its table.

use std::error::Error;

use super::motion::{MotionDocument, rest_text};
use super::motion_chart::motion_chart;
use super::page::{page_end, page_start, section};
use super::table::escaped;
use super::viewer::Model;

/// Writes the page.
pub(crate) fn motion_page(
    title: &str,
    document: &MotionDocument,
    model: &Model,
) -> Result<String, Box<dyn Error>> {
    let mut page = page_start(title, &document.summary());
    for line in rest_text(&document.resting).lines() {
        page += &format!("<p class=\"note\">{}</p>\n", escaped(line));
    }
    page += &section("The motion", &model.to_html()?);

    // The chart is a document of its own elsewhere, and an element here.
    let chart = motion_chart(document)?;
    let element = chart.find("<svg").map_or("", |start| &chart[start..]);
    page += &section("Overlap over the frames", element);
    page += &section("Frame by frame", &document.table().to_html());
    Ok(page + &page_end())
}
