//! Panels of curves over logarithmic axes, with what nothing beats in both.

use std::error::Error;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::sheet::Cell;

/// A part of a picture.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Whether it could be drawn.
pub type Drawn = Result<(), Box<dyn Error>>;

/// Behind what nothing is both further left and lower than.
pub const FRONT: RGBColor = RGBColor(0xf4, 0xd5, 0x6b);

/// How a curve looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// Of line and marks.
    pub colour: RGBColor,
    /// Whether marks are rings.
    pub hollow: bool,
}

/// A method's points, with marks that grow from the first to the last.
#[derive(Clone, Debug)]
pub struct Curve {
    /// How it looks.
    pub look: Look,
    /// Values across and up, of which those up are above 0.
    pub points: Vec<[f64; 2]>,
}

/// A diagram.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What stands over it.
    pub title: String,
    /// What goes across, with the unit in brackets.
    pub across: String,
    /// What goes up, with the unit in brackets.
    pub up: String,
    /// Decimal logarithms of the ends across: what is less is drawn at the
    /// lower one, whose label is 0.
    pub shown: [f64; 2],
    /// What is shown.
    pub curves: Vec<Curve>,
}

impl Look {
    /// Filled marks.
    #[must_use]
    pub const fn new(red: u8, green: u8, blue: u8) -> Self {
        Self { colour: RGBColor(red, green, blue), hollow: false }
    }

    /// The same with rings for marks.
    #[must_use]
    pub const fn hollow(self) -> Self {
        Self { hollow: true, ..self }
    }

    /// A short piece of line with a mark, for a legend.
    ///
    /// # Errors
    ///
    /// When it cannot be drawn.
    pub fn sample(self, area: &Area<'_>, [x, y]: [i32; 2]) -> Drawn {
        area.draw(&PathElement::new([(x, y), (x + 30, y)], self.colour.stroke_width(2)))?;
        area.draw(&Circle::new((x + 15, y), 5, self.fill().filled()))?;
        area.draw(&Circle::new((x + 15, y), 5, self.colour.stroke_width(2)))?;
        Ok(())
    }

    const fn fill(self) -> RGBColor {
        if self.hollow { WHITE } else { self.colour }
    }
}

impl Panel {
    /// Draws it over an area.
    ///
    /// # Errors
    ///
    /// When it cannot be drawn.
    pub fn draw(&self, area: &Area<'_>) -> Drawn {
        let [low, high] = self.shown;
        let place = |[x, y]: &[f64; 2]| (x.log10().clamp(low, high), y.log10());
        let all: Vec<(f64, f64)> =
            self.curves.iter().flat_map(|curve| curve.points.iter().map(place)).collect();
        let least = all.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
        let most = all.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
        let (least, most) = if all.is_empty() { (0.0, 1.0) } else { (least, most) };
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 16))
            .margin(8)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(low - 0.15..high + 0.15, least - 0.2..most + 0.2)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(0xe4, 0xe4, 0xe4))
            .x_labels(8)
            .y_labels(8)
            .x_desc(&self.across)
            .y_desc(&self.up)
            .label_style(("sans-serif", 14))
            .axis_desc_style(("sans-serif", 15))
            .x_label_formatter(&|x| if *x <= low { "0".to_owned() } else { power(*x) })
            .y_label_formatter(&|y| power(*y))
            .draw()?;
        chart.draw_series(LineSeries::new(front(&all), FRONT.stroke_width(9)))?;
        for Curve { look, points } in &self.curves {
            let points: Vec<(f64, f64)> = points.iter().map(place).collect();
            let line = LineSeries::new(points.clone(), look.colour.stroke_width(2));
            chart.draw_series(line)?;
            for (size, point) in (3..).zip(points) {
                chart.draw_series([Circle::new(point, size, look.fill().filled())])?;
                chart.draw_series([Circle::new(point, size, look.colour.stroke_width(2))])?;
            }
        }
        Ok(())
    }
}

/// Points that none beats in both, from left to right.
fn front(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let beats =
        |q: &(f64, f64), p: &(f64, f64)| q.0 <= p.0 && q.1 <= p.1 && (q.0 < p.0 || q.1 < p.1);
    let is_best = |p: &&(f64, f64)| !points.iter().any(|q| beats(q, p));
    let mut best: Vec<(f64, f64)> = points.iter().filter(is_best).copied().collect();
    best.sort_by(|p, q| p.0.total_cmp(&q.0));
    best
}

/// A power of ten in digits, or as such where that is long; nothing between.
fn power(exponent: f64) -> String {
    let whole = exponent.round();
    if (exponent - whole).abs() > 1e-9 {
        return String::new();
    }
    if whole < -4.0 { format!("1e{whole}") } else { format!("{}", 10.0_f64.powf(whole)) }
}

/// A title in the middle of an area.
///
/// # Errors
///
/// When it cannot be drawn.
pub fn heading(area: &Area<'_>, text: &str) -> Drawn {
    let (width, height) = area.dim_in_pixel();
    let centred = Pos::new(HPos::Center, VPos::Center);
    let style = ("sans-serif", 22).into_font().into_text_style(area).pos(centred);
    area.draw_text(text, &style, (i32::try_from(width / 2)?, i32::try_from(height / 2)?))?;
    Ok(())
}

/// A line of a table: the last column but the first two ends at each right edge.
#[derive(Clone, Debug)]
pub struct Line {
    /// The method, with what its curve looks like.
    pub name: (Option<Look>, String),
    /// What its settings are.
    pub settings: String,
    /// What else is told.
    pub values: Vec<String>,
}

impl Line {
    /// Height of a line.
    pub const HEIGHT: i32 = 21;

    /// Draws it with its top at `y`; `right` are the right edges of the values.
    ///
    /// # Errors
    ///
    /// When it cannot be drawn.
    pub fn draw(&self, area: &Area<'_>, y: i32, right: &[i32]) -> Drawn {
        let text = ("sans-serif", 14).into_font().into_text_style(area);
        let to_right = text.clone().pos(Pos::new(HPos::Right, VPos::Top));
        let (look, name) = &self.name;
        if let Some(look) = look {
            look.sample(area, [40, y + 8])?;
        }
        area.draw_text(name, &text, (80, y))?;
        area.draw_text(&self.settings, &text, (300, y))?;
        for (value, &right) in self.values.iter().zip(right) {
            area.draw_text(value, &to_right, (right, y))?;
        }
        Ok(())
    }
}

/// Says what the broad line behind points means.
///
/// # Errors
///
/// When it cannot be drawn.
pub fn front_sample(area: &Area<'_>, y: i32) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    let line = PathElement::new([(40, y + 8), (70, y + 8)], FRONT.stroke_width(9));
    area.draw(&line)?;
    area.draw_text("nothing is both quicker and more accurate", &text, (80, y))?;
    Ok(())
}

/// Two digits or three.
#[must_use]
pub fn short(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        v if v < 1e-3 => format!("{v:.0e}"),
        v if v < 0.1 => format!("{v:.3}"),
        v if v < 10.0 => format!("{v:.2}"),
        v => format!("{v:.0}"),
    }
}

/// A value, or an entry left empty.
#[must_use]
pub fn number(value: Option<f64>) -> Cell {
    Cell::Number(value.unwrap_or(f64::NAN))
}

/// Height of a line of a caption.
pub const CAPTION_LINE: u32 = 19;

/// Letters in a line of a caption.
const LETTERS: usize = 205;

/// Settings as lines of a caption.
#[must_use]
pub fn caption(settings: &[(&'static str, String)]) -> Vec<String> {
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

/// Writes lines of a caption, the first with its top at `y`.
///
/// # Errors
///
/// When they cannot be drawn.
pub fn write_caption(area: &Area<'_>, lines: &[String], y: u32) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    for (line, words) in (0..).zip(lines) {
        area.draw_text(words, &text, (40, i32::try_from(y + CAPTION_LINE * line)?))?;
    }
    Ok(())
}

/// The processor, for a caption.
#[must_use]
pub fn machine() -> String {
    let of_line = |line: &str| {
        let (name, value) = line.split_once(':')?;
        (name.trim() == "model name").then(|| value.trim().to_owned())
    };
    let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let named = processor.lines().find_map(of_line);
    let named =
        named.unwrap_or_else(|| format!("{} {}", std::env::consts::ARCH, std::env::consts::OS));
    format!("one thread of {named}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 1.0), (0.5, 2.0), (0.5, 3.0), (2.0, 0.5), (2.0, 1.5)];
        assert_eq!(front(&points), [(0.5, 2.0), (1.0, 1.0), (2.0, 0.5)]);
    }

    #[test]
    fn captions_fit_their_lines_and_lose_no_word() {
        let value = "word ".repeat(150);
        let lines = caption(&[("setting", value.trim().to_owned())]);
        assert!(lines.len() > 2 && lines.iter().all(|line| line.len() <= LETTERS));
        assert_eq!(lines.join(" ").matches("word").count(), 150);
    }
}
