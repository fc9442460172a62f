//! A motion in one picture: overlap above, free step below, over the frames.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::motion::{MotionDocument, StepRecord};
use crate::commands::Failure;

const SIZE: (u32, u32) = (900, 560);
const DEPTH: RGBColor = RGBColor(0xb2, 0x3a, 0x48);
const FREE: RGBColor = RGBColor(0x2a, 0x6f, 0x97);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Draws a motion as SVG.
pub(crate) fn motion_chart(document: &MotionDocument) -> Result<String, Failure> {
    let mut svg = String::new();
    draw(document, &mut svg).map_err(|problem| Failure::new(vec![problem.to_string()]))?;
    Ok(svg)
}

fn draw(document: &MotionDocument, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let (upper, lower) = area.split_vertically(SIZE.1 / 2);
    let depth = |step: &StepRecord| step.deepest.as_ref().map_or(0.0, |deepest| deepest.depth);
    let deepest = document.steps.iter().map(depth).fold(0.0, f64::max);
    let depth_axis = format!("deepest overlap [{}]", document.unit.symbol());
    let ceiling = if deepest > 0.0 { 1.1 * deepest } else { 1.0 };
    panel(&upper, document, &depth_axis, ceiling, DEPTH, depth)?;
    let free = |step: &StepRecord| step.largest_free_step_of_free_pairs;
    panel(&lower, document, "free share of the step", 1.05, FREE, free)?;
    area.present()?;
    Ok(())
}

fn panel(
    area: &Area<'_>,
    document: &MotionDocument,
    what: &str,
    ceiling: f64,
    colour: RGBColor,
    value: impl Fn(&StepRecord) -> f64,
) -> Result<(), Box<dyn std::error::Error>> {
    let last = document.steps.last().map_or(1, |step| step.frame);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(60)
        .build_cartesian_2d(0..last, 0.0..ceiling)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_desc("frame")
        .y_desc(what)
        .draw()?;
    let points = || document.steps.iter().map(|step| (step.frame, value(step)));
    chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?;
    chart.draw_series(points().map(|point| Circle::new(point, 2, colour.filled())))?;
    Ok(())
}
