//! Panels of curves over logarithmic axes with their Pareto fronts, headings and captions.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axes::{Area, Axis, Drawn};
use super::labels::Labels;
use super::sheet::Settings;

/// Color of the Pareto front behind the curves.
pub const FRONT: RGBColor = RGBColor(0xf4, 0xd5, 0x6b);

/// Radii of a curve's first mark, and of its largest.
const MIN_MARK: i32 = 3;
const MAX_MARK: i32 = 10;

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
    /// Points `[x, y]`, both positive; `x` beyond the shown range are drawn at its borders.
    pub points: Vec<[f64; 2]>,
}

/// A diagram of curves over logarithmic axes.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Title.
    pub title: String,
    /// Horizontal axis; values beyond its range are drawn at its ends.
    pub x: Axis,
    /// Label of the vertical axis, with the unit in brackets. Its range is that of the curves.
    pub y_label: String,
    /// The curves.
    pub curves: Vec<Curve>,
    /// True for a Pareto front behind the curves.
    pub has_front: bool,
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

/// Place of a sign left of a mark.
const BEFORE_MARK: Pos = Pos { h_pos: HPos::Right, v_pos: VPos::Center };

impl Panel {
    /// Draws the panel over an area. Marks at the right border stand for all larger values.
    ///
    /// # Errors
    ///
    /// When it cannot be drawn.
    pub fn draw(&self, area: &Area<'_>) -> Drawn {
        self.draw_named(area, &[])
    }

    /// Draws the panel with names beside the first curves; an empty one is left out.
    ///
    /// # Errors
    ///
    /// When it cannot be drawn.
    pub fn draw_named(&self, area: &Area<'_>, names: &[String]) -> Drawn {
        // Places on logarithmic axes; values beyond the range are at its borders.
        let [left, right] = self.x.range;
        let place = |[x, y]: &[f64; 2]| (x.log10().clamp(left, right), y.log10());
        let mut all: Vec<(f64, f64)> = Vec::new();
        for curve in &self.curves {
            all.extend(curve.points.iter().map(place));
        }
        let (mut bottom, mut top) = all.first().map_or((0.0, 1.0), |(_, y)| (*y, *y));
        for (_, y) in &all {
            (bottom, top) = (bottom.min(*y), top.max(*y));
        }

        // Marks at the ends keep clear of the borders.
        let x = Axis { range: [left - 0.15, right + 0.15], ..self.x.clone() };
        let y = Axis::powers(&self.y_label, [bottom - 0.2, top + 0.2]);
        let mut plot = Axis::draw(area, &self.title, [x, y])?;

        // The front lies behind the curves.
        if self.has_front {
            plot.draw_series(LineSeries::new(pareto_front(&all), FRONT.stroke_width(9)))?;
        }

        // Marks grow along each curve, which shows its direction.
        for Curve { style, points } in &self.curves {
            let places: Vec<(f64, f64)> = points.iter().map(place).collect();
            plot.draw_series(LineSeries::new(places.clone(), style.color.stroke_width(2)))?;
            for (number, (point, [x, _])) in (0..).zip(places.into_iter().zip(points)) {
                let size = (MIN_MARK + number).min(MAX_MARK);
                plot.draw_series([Circle::new(point, size, style.fill().filled())])?;
                plot.draw_series([Circle::new(point, size, style.color.stroke_width(2))])?;
                if x.log10() > right {
                    let text = ("sans-serif", 14).into_font().color(&style.color);
                    let text = Text::new("≥", (-9, 0), text.pos(BEFORE_MARK));
                    plot.draw_series([EmptyElement::at(point) + text])?;
                }
            }
        }

        // Names keep clear of all curves, and of each other.
        let mut labels = Labels::default();
        for curve in &self.curves {
            let points: Vec<(f64, f64)> = curve.points.iter().map(place).collect();
            labels.avoid(&plot, &points);
        }
        for (curve, name) in self.curves.iter().zip(names).filter(|(_, name)| !name.is_empty()) {
            let points: Vec<(f64, f64)> = curve.points.iter().map(place).collect();
            labels.draw(&mut plot, &points, name, curve.style.color)?;
        }
        Ok(())
    }
}

/// Returns the points that no other is below and left of, from left to right.
fn pareto_front(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    // From left to right, each lower than all before it.
    let mut front = points.to_vec();
    front.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.total_cmp(&q.1)));
    let mut lowest = f64::INFINITY;
    front.retain(|&(_, y)| {
        let is_lower = y < lowest;
        lowest = lowest.min(y);
        is_lower
    });
    front
}

/// Height of a heading.
const HEADING: u32 = 44;

/// Draws a heading, and a body over a foot of the given heights, as SVG on white.
///
/// # Errors
///
/// When they cannot be drawn.
pub fn picture(
    heading: &str,
    width: u32,
    [body, foot]: [u32; 2],
    draw: impl FnOnce(&Area<'_>, &Area<'_>) -> Drawn,
) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    let area =
        SVGBackend::with_string(&mut text, (width, HEADING + body + foot)).into_drawing_area();
    area.fill(&WHITE)?;
    let centered = Pos::new(HPos::Center, VPos::Center);
    let style = ("sans-serif", 22).into_font().into_text_style(&area).pos(centered);
    area.draw_text(heading, &style, (i32::try_from(width / 2)?, 22))?;

    let (_, rest) = area.split_vertically(HEADING);
    let (upper, lower) = rest.split_vertically(body);
    draw(&upper, &lower)?;
    area.present()?;
    // The areas borrow the text.
    drop((area, rest, upper, lower));
    Ok(text)
}

/// Height of a line of a caption.
pub const CAPTION_LINE: u32 = 19;

/// Width of a letter of a caption, with room at the borders \[tenths of a pixel\].
const LETTER: u32 = 73;

/// Wraps settings to lines of a caption in a picture of some width \[pixels\].
#[must_use]
pub fn caption(settings: &Settings, width: u32) -> Vec<String> {
    let letters = (10 * width / LETTER) as usize;
    let mut lines = Vec::new();
    for (name, value) in settings {
        let mut line = format!("{name}:");
        for word in value.split_whitespace() {
            if line.chars().count() + 1 + word.chars().count() > letters {
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
    let line = cpu_info.lines().find(|line| line.starts_with("model name"));
    match line.and_then(|line| line.split_once(": ")) {
        Some((_, processor)) => format!("one thread of {processor}"),
        None => format!("one thread of {} {}", std::env::consts::ARCH, std::env::consts::OS),
    }
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
        let lines = caption(&vec![("setting", value.trim().to_owned())], 730);
        assert!(lines.len() > 2 && lines.iter().all(|line| line.len() <= 100));
        assert_eq!(lines.join(" ").matches("word").count(), 150);
    }
}
