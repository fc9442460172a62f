//! Posters of time over error by method: rows of panels over a legend with figures and a caption.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use serde_json::Value;

use super::axes::{Area, Axis, Drawn};
use super::curves::{
    CAPTION_LINE, Curve, CurveStyle, FRONT, Panel, caption, draw_caption, picture,
};
use super::sheet::Sheet;

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

/// A figure of the rows: the sum of some columns.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Name, with the unit in brackets.
    pub label: &'static str,
    /// Columns that are added up.
    pub columns: &'static [&'static str],
}

/// A column of panels: time over an error.
#[derive(Clone, Copy, Debug)]
pub struct ErrorAxis {
    /// The error.
    pub error: Figure,
    /// Decimal logarithms of the ends of the axis.
    pub range: [f64; 2],
}

/// Layout of a poster of a table, whose rows are measurements of a `method` at one setting.
#[derive(Clone, Copy, Debug)]
pub struct Poster<'a> {
    /// Heading.
    pub heading: &'static str,
    /// Time on the vertical axes.
    pub time: Figure,
    /// Height of a row of panels.
    pub row_height: u32,
    /// Methods in the order of the legend.
    pub methods: &'a [MethodKey],
    /// Columns of panels.
    pub errors: [ErrorAxis; 3],
    /// Figures in the legend.
    pub figures: [Figure; 5],
    /// Column of the groups: a row of panels each.
    pub group_column: &'static str,
    /// Groups from the top down.
    pub groups: &'a [&'static str],
    /// Group whose figures are in the legend.
    pub legend_group: &'static str,
    /// The measurements.
    pub sheet: &'a Sheet,
}

impl Figure {
    /// Returns a figure.
    #[must_use]
    pub const fn new(label: &'static str, columns: &'static [&'static str]) -> Self {
        Self { label, columns }
    }

    /// Returns this error and a time of each row that has both, as points of a curve.
    #[must_use]
    pub fn with_times<'a>(
        &self,
        time: Self,
        rows: impl Iterator<Item = &'a Value>,
    ) -> Vec<[f64; 2]> {
        let mut points = Vec::new();
        for row in rows {
            if let [Some(error), Some(time)] = [self.of(row), time.of(row)] {
                points.push([error.max(0.0), time]);
            }
        }
        points
    }

    /// Returns the value in a row; `None` where a column has none.
    fn of(&self, row: &Value) -> Option<f64> {
        self.columns.iter().map(|column| row[*column].as_f64()).sum()
    }
}

const WIDTH: u32 = 1000;

/// Top of the legend, height of its rows and of its heads, and right edges of its columns.
const LEGEND_TOP: i32 = 24;
const LEGEND_ROW: i32 = 20;
const LEGEND_HEADS: i32 = 36;
const LEGEND_COLUMNS: [i32; 5] = [600, 695, 795, 895, 985];

impl Poster<'_> {
    /// Draws the poster as SVG.
    ///
    /// # Errors
    ///
    /// When it cannot be drawn.
    pub fn draw(&self) -> Result<String, Box<dyn std::error::Error>> {
        // Panels, legend and caption below each other.
        let panels = self.row_height * u32::try_from(self.groups.len())?;
        let legend_rows = i32::try_from(self.methods.len() + 2)?;
        let legend = u32::try_from(LEGEND_TOP + LEGEND_HEADS + LEGEND_ROW * legend_rows)?;
        let caption = caption(&self.sheet.settings, WIDTH);
        let foot = legend + CAPTION_LINE * u32::try_from(caption.len())? + 16;

        picture(self.heading, WIDTH, [panels, foot], |body, foot| {
            self.draw_panels(body)?;
            self.draw_legend(foot)?;
            draw_caption(foot, &caption, legend)
        })
    }

    fn draw_panels(&self, area: &Area<'_>) -> Drawn {
        // Curves have the numbers of the legend.
        let mut numbers = Vec::new();
        for number in 1..=self.methods.len() {
            numbers.push(number.to_string());
        }

        let mut areas = area.split_evenly((self.groups.len(), self.errors.len())).into_iter();
        for group in self.groups {
            for (axis, area) in self.errors.iter().zip(areas.by_ref()) {
                self.panel(group, axis).draw_named(&area, &numbers)?;
            }
        }
        Ok(())
    }

    /// Returns the panel of a group over one of the errors.
    fn panel(&self, group: &str, ErrorAxis { error, range }: &ErrorAxis) -> Panel {
        let mut curves = Vec::new();
        for MethodKey { name, style, .. } in self.methods {
            // Methods without this error have a curve without points.
            let points = error.with_times(self.time, self.rows_of(group, name));
            curves.push(Curve { style: *style, points });
        }
        Panel {
            title: group.to_owned(),
            x: Axis { zero: Some(range[0]), ..Axis::powers(error.label, *range) },
            y_label: self.time.label.to_owned(),
            curves,
            has_front: true,
        }
    }

    /// Returns the measurements of a method in a group.
    fn rows_of<'b>(&'b self, group: &'b str, method: &'b str) -> impl Iterator<Item = &'b Value> {
        let rows = self.sheet.rows_of(self.group_column, group);
        rows.filter(move |row| row["method"] == method)
    }

    /// Draws the names of the methods with their settings and the ranges of their figures.
    fn draw_legend(&self, area: &Area<'_>) -> Drawn {
        self.draw_heads(area)?;

        let mut y = LEGEND_TOP + LEGEND_HEADS;
        for (number, MethodKey { name, settings, style }) in (1..).zip(self.methods) {
            let rows: Vec<&Value> = self.rows_of(self.legend_group, name).collect();
            let figures = self.figures.map(|figure| range(&rows, figure));
            let name = format!("{number}  {name}");
            style.sample(area, [12, y + 8])?;
            draw_row(area, y, [&name, settings], &figures)?;
            y += LEGEND_ROW;
        }

        // The key of the Pareto front.
        area.draw(&PathElement::new([(12, y + 8), (42, y + 8)], FRONT.stroke_width(9)))?;
        let front = "Pareto front: nothing is both quicker and more accurate";
        draw_row(area, y, [front, ""], &[])
    }

    /// Draws the heads of the legend's columns, units below names.
    fn draw_heads(&self, area: &Area<'_>) -> Drawn {
        draw_row(area, LEGEND_TOP, [self.legend_group, "settings, small marks to large"], &[])?;
        let (mut names, mut units) = (Vec::new(), Vec::new());
        for figure in &self.figures {
            let (name, unit) = figure.label.split_once('[').unwrap_or((figure.label, ""));
            names.push(name.trim_end().to_owned());
            units.push(unit.trim_end_matches(']').to_owned());
        }
        draw_row(area, LEGEND_TOP, ["", ""], &names)?;
        draw_row(area, LEGEND_TOP + 15, ["", ""], &units)
    }
}

/// Draws a row of the legend, its figures aligned right.
fn draw_row(area: &Area<'_>, y: i32, heads: [&str; 2], figures: &[String]) -> Drawn {
    let text = ("sans-serif", 13).into_font().into_text_style(area);
    let to_right = text.clone().pos(Pos::new(HPos::Right, VPos::Top));
    area.draw_text(heads[0], &text, (50, y))?;
    area.draw_text(heads[1], &text, (245, y))?;
    for (figure, right) in figures.iter().zip(LEGEND_COLUMNS) {
        area.draw_text(figure, &to_right, (right, y))?;
    }
    Ok(())
}

/// Formats a figure at the first and at the last setting.
fn range(rows: &[&Value], figure: Figure) -> String {
    match [rows.first(), rows.last()].map(|row| figure.of(row?).map(short)) {
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
