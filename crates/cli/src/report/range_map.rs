//! Map of a range of motion: a table with a row per cell, and a picture.

use std::error::Error;

use csv::{ReaderBuilder, StringRecord, WriterBuilder};
use musculo_collide::{Scene, TurnEnd};
use plotters::prelude::*;

use super::text::{bound, counted, fixed, tick};
use crate::failure::Failure;
use picture::viridis;

/// Names of the columns of the table.
const COLUMNS: [&str; 10] =
    ["first", "second", "state", "angle", "certain", "a", "b", "x", "y", "z"];

const SIZE: (u32, u32) = (900, 760);
const OVERLAP: RGBColor = RGBColor(0x55, 0x55, 0x55);
const FREE: RGBColor = RGBColor(0xf2, 0xf2, 0xf2);

/// Cells of a map, row by row.
#[derive(Debug)]
pub(crate) struct RangeMap {
    /// Angles of both turns before the last, in degrees.
    pub(crate) axes: [Vec<f64>; 2],
    /// Largest angle of the last turn, in degrees.
    pub(crate) to: f64,
    pub(crate) cells: Vec<MapCell>,
}

/// End of the last turn after two others.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MapCell {
    /// Angles of both turns before, in degrees.
    angles: [f64; 2],
    state: CellState,
    /// Names of the pair that overlaps or meets; empty where nothing is met.
    names: [String; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum CellState {
    /// A pair overlaps before the turn.
    Overlap,
    /// A pair meets at an angle in degrees and a place.
    Contact {
        angle: f64,
        certain: bool,
        at: [f64; 3],
    },
    Free,
}

impl MapCell {
    /// Describes the end of a turn; angles are in degrees.
    pub(crate) fn new(angles: [f64; 2], end: &TurnEnd, scene: &Scene) -> Self {
        let (state, pair) = match end {
            TurnEnd::Overlap(pair) => (CellState::Overlap, Some(*pair)),
            TurnEnd::Contact(contact) => {
                let (certain, at) = (contact.certain, contact.at.to_array());
                let angle = contact.angle.to_degrees();
                (CellState::Contact { angle, certain, at }, Some(contact.pair))
            }
            _ => (CellState::Free, None),
        };
        let names = pair.map(|pair| scene.names(pair).map(str::to_owned)).unwrap_or_default();
        Self { angles, state, names }
    }

    /// Writes the values of the columns.
    fn record(&self) -> [String; 10] {
        let [first, second] = self.angles.map(|angle| angle.to_string());
        let [a, b] = self.names.clone();
        let (mut angle, mut certain) = (String::new(), String::new());
        let mut at = [const { String::new() }; 3];
        let state = match self.state {
            CellState::Overlap => "overlap",
            CellState::Free => "free",
            CellState::Contact { angle: met, certain: is_certain, at: place } => {
                (angle, certain) = (met.to_string(), u8::from(is_certain).to_string());
                at = place.map(|x| x.to_string());
                "contact"
            }
        };
        let [x, y, z] = at;
        [first, second, state.to_owned(), angle, certain, a, b, x, y, z]
    }

    /// Reads the values of the columns.
    fn of_record(record: &StringRecord) -> Option<Self> {
        if record.len() != COLUMNS.len() {
            return None;
        }
        let number = |column: usize| record[column].parse::<f64>().ok();
        let state = match &record[2] {
            "overlap" => CellState::Overlap,
            "free" => CellState::Free,
            "contact" => CellState::Contact {
                angle: number(3)?,
                certain: &record[4] == "1",
                at: [number(7)?, number(8)?, number(9)?],
            },
            _ => return None,
        };
        let names = [5, 6].map(|column| record[column].to_owned());
        Some(Self { angles: [number(0)?, number(1)?], state, names })
    }

    /// Writes the cell as a line of the table.
    pub(crate) fn to_line(&self) -> Result<String, Failure> {
        let mut writer = WriterBuilder::new().from_writer(Vec::new());
        writer.write_record(self.record())?;
        Ok(String::from_utf8_lossy(&writer.into_inner()?).into_owned())
    }

    /// Reads the cell from a line of the table.
    pub(crate) fn parse(line: &str) -> Option<Self> {
        let mut reader = ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
        Self::of_record(&reader.records().next()?.ok()?)
    }
}

impl RangeMap {
    /// Writes a table with a row per cell.
    pub(crate) fn to_csv(&self) -> Result<String, Failure> {
        let mut table = COLUMNS.join(",") + "\n";
        for cell in &self.cells {
            table += &cell.to_line()?;
        }
        Ok(table)
    }

    /// Writes a summary.
    pub(crate) fn to_text(&self) -> String {
        let (mut overlaps, mut free) = (0, 0);
        let mut least: Option<(f64, &MapCell)> = None;
        for cell in &self.cells {
            match cell.state {
                CellState::Overlap => overlaps += 1,
                CellState::Free => free += 1,
                CellState::Contact { angle, .. } => {
                    if least.is_none_or(|(other, _)| angle.abs() < other.abs()) {
                        least = Some((angle, cell));
                    }
                }
            }
        }

        let count = self.cells.len();
        let mut text = format!(
            "{}: {} meet, {free} free to {}°, {overlaps} overlap before the turn\n",
            counted(count, "cell"),
            count - overlaps - free,
            fixed(self.to, 4)
        );
        if let Some((angle, MapCell { angles, names, .. })) = least {
            let [first, second] = angles.map(|angle| fixed(angle, 2));
            text += &format!(
                "least: {}° after {first}° and {second}°, {}\n",
                bound(angle, 4),
                names.join(" × ")
            );
        }
        text
    }

    /// Draws the map as SVG: the first turn upward, the second to the right, the angle of first
    /// contact in color.
    pub(crate) fn to_svg(&self) -> Result<String, Box<dyn Error>> {
        let mut svg = String::new();
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let (map, legend) = area.split_horizontally(SIZE.0 - 150);
        let [first, second] = self.axes.each_ref().map(|angles| cell_edges(angles));

        // Cells are centered on their angles.
        let (across, upward) = (range(&second), range(&first));
        let mut chart = ChartBuilder::on(&map)
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(56)
            .build_cartesian_2d(across, upward)?;
        let columns = self.axes[1].len();
        let mut cells = Vec::new();
        for (number, cell) in self.cells.iter().enumerate() {
            let (row, column) = (number / columns, number % columns);
            let corners = [(second[column], first[row]), (second[column + 1], first[row + 1])];
            cells.push(Rectangle::new(corners, self.color(cell).filled()));
        }
        chart.draw_series(cells)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc("second turn [°]")
            .y_desc("first turn [°]")
            .x_label_formatter(&|angle| tick(*angle))
            .y_label_formatter(&|angle| tick(*angle))
            .draw()?;
        self.draw_legend(&legend)?;

        area.present()?;
        drop((map, legend, chart, area));
        Ok(svg)
    }

    /// Draws the colors with their meaning.
    fn draw_legend(
        &self,
        area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    ) -> Result<(), Box<dyn Error>> {
        const STEPS: i32 = 32;
        const STEP: i32 = 12;
        let label = ("sans-serif", 14).into_font();
        area.draw(&Text::new("first contact [°]", (0, 20), label.clone()))?;
        for step in 0..STEPS {
            let color = angle_color(f64::from(step) / f64::from(STEPS - 1));
            let top = 44 + (STEPS - 1 - step) * STEP;
            area.draw(&Rectangle::new([(0, top), (26, top + STEP)], color.filled()))?;
        }
        for quarter in 0..=4 {
            let height = 44 + (4 - quarter) * STEPS * STEP / 4 - 7;
            let angle = tick(self.to * f64::from(quarter) / 4.0);
            area.draw(&Text::new(angle, (34, height), label.clone()))?;
        }
        for (row, (color, text)) in (0..).zip([(OVERLAP, "overlaps before"), (FREE, "free")]) {
            let top = 470 + 30 * row;
            area.draw(&Rectangle::new([(0, top), (26, top + 18)], color.filled()))?;
            area.draw(&Text::new(text, (34, top + 2), label.clone()))?;
        }
        Ok(())
    }

    fn color(&self, cell: &MapCell) -> RGBColor {
        match cell.state {
            CellState::Overlap => OVERLAP,
            CellState::Free => FREE,
            CellState::Contact { angle, .. } => angle_color(angle / self.to),
        }
    }
}

/// Returns the color of a share of the last turn.
fn angle_color(share: f64) -> RGBColor {
    let [r, g, b] = viridis(share).to_srgb();
    RGBColor(r, g, b)
}

/// Returns the edges of cells that are centered on angles, one more than there are angles.
fn cell_edges(angles: &[f64]) -> Vec<f64> {
    let mut edges = Vec::with_capacity(angles.len() + 1);
    if let [first, second, ..] = angles {
        edges.push(first - 0.5 * (second - first));
    }
    for pair in angles.windows(2) {
        edges.push(f64::midpoint(pair[0], pair[1]));
    }
    if let [.., second_last, last] = angles {
        edges.push(last + 0.5 * (last - second_last));
    }
    edges
}

/// Returns the range of edges, ascending or descending.
fn range(edges: &[f64]) -> std::ops::Range<f64> {
    let [first, .., last] = edges else { return 0.0..1.0 };
    *first..*last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_small_turns_are_told_apart() {
        let (axis, none) = (vec![0.0, 0.05, 0.1], [String::new(), String::new()]);
        let cell = MapCell { angles: [0.0; 2], state: CellState::Free, names: none };
        let axes = [axis.clone(), axis];
        let svg = RangeMap { axes, to: 0.3, cells: vec![cell; 9] }.to_svg().expect("a picture");
        for angle in ["0.02", "0.08", "0.075", "0.225"] {
            assert!(svg.contains(&format!("\n{angle}\n")), "{angle} in {svg}");
        }
    }
}
