//! Posters of time over error by method: rows of panels over a legend with figures and a caption.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::curves::{
    Area, CAPTION_LINE, Curve, CurveStyle, Drawn, FRONT, Panel, caption, draw_caption,
    draw_heading, svg,
};

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
pub trait Charted {
    /// Returns the legend entry of the method.
    fn key(&self) -> MethodKey;

    /// Returns the time, which is drawn upward.
    fn time(&self) -> f64;
}

/// A quantity of measurements, with the unit in brackets.
#[derive(Clone, Copy, Debug)]
pub struct Quantity<T> {
    /// Label of an axis or a column.
    pub label: &'static str,
    /// Value; `None` for methods that have none.
    pub of: fn(&T) -> Option<f64>,
}

/// A column of panels: time over an error.
#[derive(Clone, Copy, Debug)]
pub struct ErrorAxis<T> {
    /// The error.
    pub error: Quantity<T>,
    /// Decimal logarithms of the ends of the axis.
    pub range: [f64; 2],
}

/// Measurements of a row of panels, or of the legend.
#[derive(Clone, Debug)]
pub struct Group<'a, T> {
    /// Title.
    pub title: &'a str,
    /// The measurements.
    pub rows: Vec<&'a T>,
}

/// Contents of a poster.
#[derive(Clone, Debug)]
pub struct Poster<'a, T> {
    /// Heading.
    pub heading: &'static str,
    /// Label of the vertical axes, with the unit in brackets.
    pub time_label: &'static str,
    /// Height of a row of panels.
    pub row_height: u32,
    /// Methods in the order of the legend.
    pub methods: &'a [MethodKey],
    /// Columns of panels.
    pub errors: &'a [ErrorAxis<T>],
    /// Columns of the legend.
    pub figures: &'a [Quantity<T>; 5],
    /// Rows of panels.
    pub groups: Vec<Group<'a, T>>,
    /// Number of the group whose figures are in the legend.
    pub legend_group: usize,
    /// Settings of the caption.
    pub settings: &'a [(&'static str, String)],
}

const WIDTH: u32 = 1500;
const HEADING: u32 = 44;

/// Top of the legend, height of its rows, and right edges of its columns.
const LEGEND_TOP: i32 = 24;
const LEGEND_ROW: i32 = 21;
const LEGEND_COLUMNS: [i32; 5] = [720, 900, 1080, 1250, 1440];

impl<T: Charted> Poster<'_, T> {
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
        for group in &self.groups {
            for (error, area) in self.errors.iter().zip(areas.by_ref()) {
                self.panel(group, error).draw(&area)?;
            }
        }
        Ok(())
    }

    fn panel(&self, group: &Group<'_, T>, axis: &ErrorAxis<T>) -> Panel {
        let mut curves = Vec::new();
        for method in self.methods {
            let rows = rows_of(group, method);
            let points = rows.iter().filter_map(|row| Some([(axis.error.of)(row)?, row.time()]));
            curves.push(Curve { style: method.style, points: points.collect() });
        }
        Panel {
            title: group.title.to_owned(),
            x_label: axis.error.label.to_owned(),
            y_label: self.time_label.to_owned(),
            x_range: axis.range,
            curves,
        }
    }

    /// Draws the names of the methods with their settings and the ranges of their figures.
    fn draw_legend(&self, area: &Area<'_>) -> Drawn {
        let Some(group) = self.groups.get(self.legend_group) else { return Ok(()) };
        let heads = self.figures.iter().map(|figure| figure.label.to_owned());
        draw_row(area, 0, [group.title, "settings, small marks to large"], heads)?;

        let mut row = 1;
        for method in self.methods {
            let rows = rows_of(group, method);
            let figures = self.figures.iter().map(|figure| range(&rows, figure.of));
            method.style.sample(area, [40, LEGEND_TOP + LEGEND_ROW * row + 8])?;
            draw_row(area, row, [method.name, method.settings], figures)?;
            row += 1;
        }

        // The key of the Pareto front.
        let y = LEGEND_TOP + LEGEND_ROW * row + 8;
        area.draw(&PathElement::new([(40, y), (70, y)], FRONT.stroke_width(9)))?;
        let front = "Pareto front: nothing is both quicker and more accurate";
        draw_row(area, row, [front, ""], std::iter::empty())
    }
}

fn rows_of<'a, T: Charted>(group: &Group<'a, T>, method: &MethodKey) -> Vec<&'a T> {
    group.rows.iter().copied().filter(|row| row.key().name == method.name).collect()
}

/// Draws a row of the legend, its figures aligned right.
fn draw_row(
    area: &Area<'_>,
    row: i32,
    [name, settings]: [&str; 2],
    figures: impl Iterator<Item = String>,
) -> Drawn {
    let y = LEGEND_TOP + LEGEND_ROW * row;
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    let to_right = text.clone().pos(Pos::new(HPos::Right, VPos::Top));
    area.draw_text(name, &text, (80, y))?;
    area.draw_text(settings, &text, (300, y))?;
    for (figure, right) in figures.zip(LEGEND_COLUMNS) {
        area.draw_text(&figure, &to_right, (right, y))?;
    }
    Ok(())
}

/// Formats the values of the first and of the last setting.
fn range<T>(rows: &[&T], of: fn(&T) -> Option<f64>) -> String {
    let value = |row: Option<&&T>| row.and_then(|row| of(row)).map(short);
    match [value(rows.first()), value(rows.last())] {
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
