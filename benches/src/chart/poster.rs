//! Posters of time over error by method: rows of panels over a legend with figures and a caption.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::curves::{
    Area, CAPTION_LINE, Curve, CurveStyle, Drawn, FRONT, Panel, caption, draw_caption,
    draw_heading, svg,
};
use super::sheet::Settings;

/// Legend entry of a method.
#[derive(Clone, Copy, Debug)]
pub struct MethodKey {
    /// Name of the method.
    pub name: &'static str,
    /// Its settings.
    pub settings: &'static str,
    /// Style of its curve.
    pub style: CurveStyle,
}

impl MethodKey {
    /// Returns an entry with filled marks.
    #[must_use]
    pub const fn new(name: &'static str, settings: &'static str, color: u32) -> Self {
        Self { name, settings, style: CurveStyle::new(color) }
    }

    /// Returns the entry with rings as marks.
    #[must_use]
    pub const fn hollow(self) -> Self {
        Self { style: self.style.hollow(), ..self }
    }
}

/// Measurement of one method at one setting.
#[derive(Clone, Debug)]
pub struct Mark {
    /// Title of its row of panels.
    pub group: &'static str,
    /// Name of the method.
    pub method: &'static str,
    /// Time, which is drawn upward.
    pub time: f64,
    /// Error per column of panels; `None` for methods that have none.
    pub errors: [Option<f64>; 3],
    /// Figures in the legend.
    pub figures: [Option<f64>; 5],
}

/// A column of panels: time over an error.
#[derive(Clone, Copy, Debug)]
pub struct ErrorAxis {
    /// Name of the error, with the unit in brackets.
    pub label: &'static str,
    /// Decimal logarithms of the ends of the axis.
    pub range: [f64; 2],
}

/// Contents of a poster.
#[derive(Clone, Debug)]
pub struct Poster<'a> {
    /// Heading.
    pub heading: &'static str,
    /// Label of the vertical axes, with the unit in brackets.
    pub time_label: &'static str,
    /// Height of a row of panels.
    pub row_height: u32,
    /// Methods in the order of the legend.
    pub methods: &'a [MethodKey],
    /// Columns of panels.
    pub errors: [ErrorAxis; 3],
    /// Names of the figures in the legend.
    pub figures: [&'static str; 5],
    /// Titles of the rows of panels.
    pub groups: &'a [&'static str],
    /// Title of the group whose figures are in the legend.
    pub legend_group: &'static str,
    /// The measurements.
    pub marks: Vec<Mark>,
    /// Settings of the caption.
    pub settings: &'a Settings,
}

const WIDTH: u32 = 1500;
const HEADING: u32 = 44;

/// Top of the legend, height of its rows, and right edges of its columns.
const LEGEND_TOP: i32 = 24;
const LEGEND_ROW: i32 = 21;
const LEGEND_COLUMNS: [i32; 5] = [720, 900, 1080, 1250, 1440];

impl Poster<'_> {
    /// Draws the poster as SVG.
    ///
    /// # Errors
    ///
    /// When it cannot be drawn.
    pub fn draw(&self) -> Result<String, Box<dyn std::error::Error>> {
        // Panels, legend and caption below each other.
        let panels = self.row_height * u32::try_from(self.groups.len())?;
        let legend_rows = i32::try_from(self.methods.len() + 3)?;
        let legend = u32::try_from(LEGEND_TOP + LEGEND_ROW * legend_rows)?;
        let caption = caption(self.settings);
        let foot = legend + CAPTION_LINE * u32::try_from(caption.len())? + 16;

        svg((WIDTH, HEADING + panels + foot), |area| {
            let (head, rest) = area.split_vertically(HEADING);
            let (body, foot) = rest.split_vertically(panels);
            draw_heading(&head, self.heading)?;
            self.draw_panels(&body)?;
            self.draw_legend(&foot)?;
            draw_caption(&foot, &caption, legend)
        })
    }

    fn draw_panels(&self, area: &Area<'_>) -> Drawn {
        let mut areas = area.split_evenly((self.groups.len(), self.errors.len())).into_iter();
        for group in self.groups {
            for (column, area) in (0..self.errors.len()).zip(areas.by_ref()) {
                self.panel(group, column).draw(&area)?;
            }
        }
        Ok(())
    }

    /// Returns the panel of a group over one of the errors.
    fn panel(&self, group: &str, column: usize) -> Panel {
        let mut curves = Vec::new();
        for MethodKey { name, style, .. } in self.methods {
            let mut points = Vec::new();
            for mark in self.marks_of(group, name) {
                points.extend(mark.errors[column].map(|error| [error, mark.time]));
            }
            curves.push(Curve { style: *style, points });
        }
        let ErrorAxis { label, range } = self.errors[column];
        Panel {
            title: group.to_owned(),
            x_label: label.to_owned(),
            y_label: self.time_label.to_owned(),
            x_range: range,
            curves,
        }
    }

    /// Returns the measurements of a method in a group.
    fn marks_of(&self, group: &str, method: &str) -> impl Iterator<Item = &Mark> {
        self.marks.iter().filter(move |mark| mark.group == group && mark.method == method)
    }

    /// Draws the names of the methods with their settings and the ranges of their figures.
    fn draw_legend(&self, area: &Area<'_>) -> Drawn {
        let heads = [self.legend_group, "settings, small marks to large"];
        draw_row(area, 0, heads, &self.figures.map(str::to_owned))?;

        let mut row = 1;
        for MethodKey { name, settings, style } in self.methods {
            let marks: Vec<&Mark> = self.marks_of(self.legend_group, name).collect();
            let figures = [0, 1, 2, 3, 4].map(|figure| range(&marks, figure));
            style.sample(area, [40, LEGEND_TOP + LEGEND_ROW * row + 8])?;
            draw_row(area, row, [name, settings], &figures)?;
            row += 1;
        }

        // The key of the Pareto front.
        let y = LEGEND_TOP + LEGEND_ROW * row + 8;
        area.draw(&PathElement::new([(40, y), (70, y)], FRONT.stroke_width(9)))?;
        let front = "Pareto front: nothing is both quicker and more accurate";
        draw_row(area, row, [front, ""], &[])
    }
}

/// Draws a row of the legend, its figures aligned right.
fn draw_row(area: &Area<'_>, row: i32, heads: [&str; 2], figures: &[String]) -> Drawn {
    let y = LEGEND_TOP + LEGEND_ROW * row;
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    let to_right = text.clone().pos(Pos::new(HPos::Right, VPos::Top));
    area.draw_text(heads[0], &text, (80, y))?;
    area.draw_text(heads[1], &text, (300, y))?;
    for (figure, right) in figures.iter().zip(LEGEND_COLUMNS) {
        area.draw_text(figure, &to_right, (right, y))?;
    }
    Ok(())
}

/// Formats a figure at the first and at the last setting.
fn range(marks: &[&Mark], figure: usize) -> String {
    let value = |mark: Option<&&Mark>| mark.and_then(|mark| mark.figures[figure]).map(short);
    match [value(marks.first()), value(marks.last())] {
        [Some(first), Some(last)] if first == last => first,
        [Some(first), Some(last)] => format!("{first} … {last}"),
        _ => "–".to_owned(),
    }
}

/// Formats two or three digits.
fn short(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        v if v < 1e-3 => format!("{v:.0e}"),
        v if v < 0.1 => format!("{v:.3}"),
        v if v < 10.0 => format!("{v:.2}"),
        v => format!("{v:.0}"),
    }
}
