//! Chart of a motion: overlap above, free step below, over the frames.

use std::error::Error;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::motion::{FrameRecord, MotionDocument};

const SIZE: (u32, u32) = (900, 560);
const DEPTH: RGBColor = RGBColor(0xb2, 0x3a, 0x48);
const FREE: RGBColor = RGBColor(0x2a, 0x6f, 0x97);

/// Half of the chart: one curve over the frames that have a value.
struct Panel {
    title: String,
    max: f64,
    color: RGBColor,
    value: fn(&FrameRecord) -> Option<f64>,
}

/// Draws a motion as SVG.
pub(crate) fn motion_chart(document: &MotionDocument) -> Result<String, Box<dyn Error>> {
    let max_depth = document.frames.iter().map(FrameRecord::depth).fold(0.0, f64::max);
    let depth = Panel {
        title: format!("deepest overlap [{}]", document.unit.symbol()),
        max: if max_depth > 0.0 { 1.1 * max_depth } else { 1.0 },
        color: DEPTH,
        value: |frame| Some(frame.depth()),
    };
    let free = Panel {
        title: "free fraction of the step".to_owned(),
        max: 1.05,
        color: FREE,
        value: |frame| frame.step.as_ref().map(|step| step.free_step),
    };

    // Depths above, free steps below.
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let (upper, lower) = area.split_vertically(SIZE.1 / 2);
    depth.draw(&upper, document)?;
    free.draw(&lower, document)?;
    area.present()?;
    drop((area, upper, lower));
    Ok(svg)
}

impl Panel {
    fn draw(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        document: &MotionDocument,
    ) -> Result<(), Box<dyn Error>> {
        // Frames across, without lines between the labels.
        let last = document.frames.last().map_or(1, |frame| frame.frame);
        let mut chart = ChartBuilder::on(area)
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(60)
            .build_cartesian_2d(0..last, 0.0..self.max)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc("frame")
            .y_desc(&self.title)
            .draw()?;

        // One line through all points, each with a dot.
        let mut points = Vec::new();
        for frame in &document.frames {
            points.extend((self.value)(frame).map(|value| (frame.frame, value)));
        }
        let circles = points.iter().map(|point| Circle::new(*point, 2, self.color.filled()));
        chart.draw_series(LineSeries::new(points.clone(), self.color.stroke_width(2)))?;
        chart.draw_series(circles)?;
        Ok(())
    }
}
