//! Chart of a motion: depth and volume of overlap, and the free step, over the frames.

use std::error::Error;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::motion::{FrameRecord, MotionDocument};
use super::text::tick;

const SIZE: (u32, u32) = (900, 840);
const DEPTH: RGBColor = RGBColor(0xb2, 0x3a, 0x48);
const VOLUME: RGBColor = RGBColor(0x8a, 0x5a, 0x00);
const FREE: RGBColor = RGBColor(0x2a, 0x6f, 0x97);

/// Third of the chart: one curve over the frames that have a value.
struct Panel {
    title: String,
    max: f64,
    color: RGBColor,
    value: fn(&FrameRecord) -> Option<f64>,
}

/// Draws a motion as SVG.
pub(crate) fn motion_chart(document: &MotionDocument) -> Result<String, Box<dyn Error>> {
    let unit = document.unit.symbol();
    let depth = Panel {
        title: format!("deepest overlap [{unit}]"),
        max: room_above(document, FrameRecord::depth),
        color: DEPTH,
        value: |frame| Some(frame.depth()),
    };
    let volume = Panel {
        title: format!("volume of overlaps [{unit}³]"),
        max: room_above(document, |frame| frame.volume.unwrap_or_default()),
        color: VOLUME,
        value: |frame| frame.volume,
    };
    let free = Panel {
        title: "free fraction of the step".to_owned(),
        max: 1.05,
        color: FREE,
        value: |frame| frame.step.as_ref().map(|step| step.free_step),
    };

    // Overlap above, free steps below.
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let thirds = area.split_evenly((3, 1));
    for (panel, third) in [depth, volume, free].iter().zip(&thirds) {
        panel.draw(third, document)?;
    }
    area.present()?;
    drop((area, thirds));
    Ok(svg)
}

/// Returns the upper end of an axis with some room above the largest value.
fn room_above(document: &MotionDocument, value: fn(&FrameRecord) -> f64) -> f64 {
    let max = document.frames.iter().map(value).fold(0.0, f64::max);
    if max > 0.0 { 1.1 * max } else { 1.0 }
}

impl Panel {
    fn draw(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        document: &MotionDocument,
    ) -> Result<(), Box<dyn Error>> {
        // In units of a power of ten: lengths and volumes in meters are too small to have ticks.
        let unit = 10.0_f64.powf(self.max.log10().floor()).max(f64::MIN_POSITIVE);

        // Frames across, without lines between the labels.
        let last = document.frames.last().map_or(1, |frame| frame.frame);
        let mut chart = ChartBuilder::on(area)
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(60)
            .build_cartesian_2d(0..last, 0.0..self.max / unit)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc("frame")
            .y_desc(&self.title)
            .y_label_formatter(&|value| tick(value * unit))
            .draw()?;

        // One line through all points, each with a dot.
        let mut points = Vec::new();
        for frame in &document.frames {
            points.extend((self.value)(frame).map(|value| (frame.frame, value / unit)));
        }
        let circles = points.iter().map(|point| Circle::new(*point, 2, self.color.filled()));
        chart.draw_series(LineSeries::new(points.clone(), self.color.stroke_width(2)))?;
        chart.draw_series(circles)?;
        Ok(())
    }
}
