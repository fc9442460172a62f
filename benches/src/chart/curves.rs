//! Panels of curves over logarithmic axes with their Pareto fronts, headings and captions.

use std::error::Error;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::sheet::Settings;

/// A part of a picture.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Result of drawing.
pub type Drawn = Result<(), Box<dyn Error>>;

/// Color of the Pareto front behind the curves.
pub const FRONT: RGBColor = RGBColor(0xf4, 0xd5, 0x6b);

/// Color and marks of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurveStyle {
    /// Color of line and marks.
    pub color: RGBColor,
    /// True for rings as marks.
    pub is_hollow: bool,
}

/// Points of one method, with marks that grow from the first to the last.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Color and marks.
    pub style: CurveStyle,
    /// Points `[x, y]`, both positive; smaller `x` than shown are drawn at the left border.
    pub points: Vec<[f64; 2]>,
}

/// A diagram of curves.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Title.
    pub title: String,
    /// Label of the horizontal axis, with the unit in brackets.
    pub x_label: String,
    /// Label of the vertical axis, with the unit in brackets.
    pub y_label: String,
    /// Decimal logarithms of the ends of the horizontal axis; the lower end is labeled 0.
    pub x_range: [f64; 2],
    /// The curves.
    pub curves: Vec<Curve>,
}

impl CurveStyle {
    /// Returns a style with filled marks, of a color as in `0x1f_6f_b4`.
    #[must_use]
    pub const fn new(color: u32) -> Self {
        let [_, red, green, blue] = color.to_be_bytes();
        Self { color: RGBColor(red, green, blue), is_hollow: false }
    }

    /// Returns the style with rings as marks.
    #[must_use]
    pub const fn hollow(self) -> Self {
        Self { is_hollow: true, ..self }
    }

    /// Draws a short piece of line with a mark, for a legend.
    ///
    /// # Errors
    ///
    /// When it cannot be drawn.
    pub fn sample(self, area: &Area<'_>, [x, y]: [i32; 2]) -> Drawn {
        area.draw(&PathElement::new([(x, y), (x + 30, y)], self.color.stroke_width(2)))?;
        area.draw(&Circle::new((x + 15, y), 5, self.fill().filled()))?;
        area.draw(&Circle::new((x + 15, y), 5, self.color.stroke_width(2)))?;
        Ok(())
    }

    const fn fill(self) -> RGBColor {
        if self.is_hollow { WHITE } else { self.color }
    }
}

impl Panel {
    /// Draws the panel over an area.
    ///
    /// # Errors
    ///
    /// When it cannot be drawn.
    pub fn draw(&self, area: &Area<'_>) -> Drawn {
        // Places on logarithmic axes; values below the range are at the left border.
        let [left, right] = self.x_range;
        let place = |[x, y]: &[f64; 2]| (x.log10().clamp(left, right), y.log10());
        let all: Vec<(f64, f64)> =
            self.curves.iter().flat_map(|curve| curve.points.iter().map(place)).collect();
        let bottom = all.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
        let top = all.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        let (bottom, top) = if all.is_empty() { (0.0, 1.0) } else { (bottom, top) };

        // A mesh of whole powers of ten.
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 16))
            .margin(8)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(left - 0.15..right + 0.15, bottom - 0.2..top + 0.2)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(0xe4, 0xe4, 0xe4))
            .x_labels(8)
            .y_labels(8)
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .x_label_formatter(&|x| if *x <= left { "0".to_owned() } else { power(*x) })
            .y_label_formatter(&|y| power(*y))
            .draw()?;

        // The Pareto front behind all curves.
        chart.draw_series(LineSeries::new(pareto_front(&all), FRONT.stroke_width(9)))?;
        for Curve { style, points } in &self.curves {
            let points: Vec<(f64, f64)> = points.iter().map(place).collect();
            let line = LineSeries::new(points.clone(), style.color.stroke_width(2));
            chart.draw_series(line)?;
            for (size, point) in (3..).zip(points) {
                chart.draw_series([Circle::new(point, size, style.fill().filled())])?;
                chart.draw_series([Circle::new(point, size, style.color.stroke_width(2))])?;
            }
        }
        Ok(())
    }
}

/// Returns the points that no other is below and left of, from left to right.
fn pareto_front(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let dominates =
        |q: &(f64, f64), p: &(f64, f64)| q.0 <= p.0 && q.1 <= p.1 && (q.0 < p.0 || q.1 < p.1);
    let is_best = |p: &&(f64, f64)| !points.iter().any(|q| dominates(q, p));
    let mut best: Vec<(f64, f64)> = points.iter().filter(is_best).copied().collect();
    best.sort_by(|p, q| p.0.total_cmp(&q.0));
    best
}

/// Formats a whole power of ten; nothing between.
fn power(exponent: f64) -> String {
    let whole = exponent.round();
    if (exponent - whole).abs() > 1e-9 {
        return String::new();
    }
    if whole < -4.0 { format!("1e{whole}") } else { format!("{}", 10.0_f64.powf(whole)) }
}

/// Draws a picture of a size on white, as SVG.
///
/// # Errors
///
/// When it cannot be drawn.
pub fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Drawn,
) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
    area.fill(&WHITE)?;
    draw(&area)?;
    area.present()?;
    drop(area);
    Ok(text)
}

/// Draws a title in the middle of an area.
///
/// # Errors
///
/// When it cannot be drawn.
pub fn draw_heading(area: &Area<'_>, text: &str) -> Drawn {
    let (width, height) = area.dim_in_pixel();
    let centered = Pos::new(HPos::Center, VPos::Center);
    let style = ("sans-serif", 22).into_font().into_text_style(area).pos(centered);
    area.draw_text(text, &style, (i32::try_from(width / 2)?, i32::try_from(height / 2)?))?;
    Ok(())
}

/// Height of a line of a caption.
pub const CAPTION_LINE: u32 = 19;

/// Letters in a line of a caption.
const LETTERS: usize = 205;

/// Wraps settings to lines of a caption.
#[must_use]
pub fn caption(settings: &Settings) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, value) in settings {
        let mut line = format!("{name}:");
        for word in value.split_whitespace() {
            if line.chars().count() + 1 + word.chars().count() > LETTERS {
                lines.push(std::mem::replace(&mut line, "   ".to_owned()));
            }
            line.push(' ');
            line += word;
        }
        lines.push(line);
    }
    lines
}

/// Draws the lines of a caption, the first with its top at `y`.
///
/// # Errors
///
/// When they cannot be drawn.
pub fn draw_caption(area: &Area<'_>, lines: &[String], y: u32) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    for (line, words) in (0..).zip(lines) {
        area.draw_text(words, &text, (40, i32::try_from(y + CAPTION_LINE * line)?))?;
    }
    Ok(())
}

/// Returns the name of the processor, for a caption.
#[must_use]
pub fn machine() -> String {
    let cpu_info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let fields = cpu_info.lines().filter_map(|line| line.split_once(':'));
    let name = fields.into_iter().find(|(name, _)| name.trim() == "model name").map_or_else(
        || format!("{} {}", std::env::consts::ARCH, std::env::consts::OS),
        |(_, processor)| processor.trim().to_owned(),
    );
    format!("one thread of {name}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_point_dominates_the_front() {
        let points = [(1.0, 1.0), (0.5, 2.0), (0.5, 3.0), (2.0, 0.5), (2.0, 1.5)];
        assert_eq!(pareto_front(&points), [(0.5, 2.0), (1.0, 1.0), (2.0, 0.5)]);
    }

    #[test]
    fn captions_fit_their_lines_and_lose_no_word() {
        let value = "word ".repeat(150);
        let lines = caption(&vec![("setting", value.trim().to_owned())]);
        assert!(lines.len() > 2 && lines.iter().all(|line| line.len() <= LETTERS));
        assert_eq!(lines.join(" ").matches("word").count(), 150);
    }
}
