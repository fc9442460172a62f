//! Axes of pictures: linear or logarithmic, with ticks and names.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// A part of a picture.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Result of drawing.
pub type Drawn = Result<(), Box<dyn Error>>;

/// Places on an axis: values, or decimal logarithms of values.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Name, with the unit in brackets.
    pub label: String,
    /// Ends of the axis.
    pub range: [f64; 2],
    /// Places with a label and a line.
    pub ticks: Vec<f64>,
    /// Text at a tick.
    pub text: fn(f64) -> String,
    /// Place of all values from 0 up to there.
    pub zero: Option<f64>,
}

/// Axes that are drawn, for series of points.
pub type Plot<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<Axis, Axis>>;

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, limit: (i32, i32)) -> i32 {
        RangedCoordf64::from(self.range()).map(place, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range[0]..self.range[1]
    }
}

impl ValueFormatter<f64> for Axis {
    fn format(place: &f64) -> String {
        place.to_string()
    }

    fn format_ext(&self, place: &f64) -> String {
        if self.zero.is_some_and(|zero| *place <= zero) {
            "0".to_owned()
        } else {
            (self.text)(*place)
        }
    }
}

impl Axis {
    /// Returns an axis with ticks at the multiples of a step.
    #[must_use]
    pub fn new(label: &str, range: [f64; 2], step: f64, text: fn(f64) -> String) -> Self {
        let mut ticks = Vec::new();
        let mut multiple = (range[0] / step).ceil();
        while multiple * step <= range[1] {
            ticks.push(multiple * step);
            multiple += 1.0;
        }
        Self { label: label.to_owned(), range, ticks, text, zero: None }
    }

    /// Returns an axis of decimal logarithms, with up to seven ticks at whole powers of ten.
    #[must_use]
    pub fn powers(label: &str, range: [f64; 2]) -> Self {
        let step = ((range[1] - range[0]) / 6.0).ceil();
        Self::new(label, range, step, power)
    }

    /// Draws a title, unless it is empty, and two axes with lines at their ticks.
    ///
    /// # Errors
    ///
    /// When they cannot be drawn.
    pub fn draw<'a>(
        area: &Area<'a>,
        title: &str,
        [x, y]: [Self; 2],
    ) -> Result<Plot<'a>, Box<dyn Error>> {
        // Without a title there is no room for one.
        let mut builder = ChartBuilder::on(area);
        if !title.is_empty() {
            builder.caption(title, ("sans-serif", 15));
        }
        let mut plot = builder
            .margin(7)
            .margin_right(14)
            .x_label_area_size(40)
            .y_label_area_size(56)
            .build_cartesian_2d(x.clone(), y.clone())?;
        plot.configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(0xe4, 0xe4, 0xe4))
            .x_desc(&x.label)
            .y_desc(&y.label)
            .label_style(("sans-serif", 13))
            .axis_desc_style(("sans-serif", 14))
            .draw()?;
        Ok(plot)
    }
}

/// Formats a power of ten by its exponent.
#[must_use]
pub fn power(exponent: f64) -> String {
    let value = 10.0_f64.powf(exponent);
    if !(-3.5..4.5).contains(&exponent) {
        format!("{value:.0e}")
    } else {
        format!("{}", (value * 1e4).round() / 1e4)
    }
}
