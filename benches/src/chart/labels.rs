//! Names beside curves, in places where nothing else is.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axes::{Drawn, Plot};

/// Size of the letters, their mean width, and the height of a line \[pixels\].
const FONT: u32 = 15;
const LETTER: i32 = 7;
const LINE: i32 = 15;

/// Distance of a name from its point, and of samples along a curve \[pixels\].
const AWAY: i32 = 13;
const SAMPLE: i32 = 5;

/// Places of names around a point, from the first to be tried: in widths of the name from the
/// point to its middle, and in lines.
const PLACES: [[i32; 2]; 8] =
    [[1, 0], [-1, 0], [1, -1], [1, 1], [-1, -1], [-1, 1], [0, -1], [0, 1]];

/// Pixels that are taken by curves and names.
#[derive(Clone, Debug, Default)]
pub(super) struct Labels {
    taken: Vec<[i32; 2]>,
}

/// Middle of a name and half of its extent \[pixels\].
#[derive(Clone, Copy, Debug)]
struct Frame {
    middle: [i32; 2],
    half: [i32; 2],
}

impl Labels {
    /// Keeps names off a curve.
    pub(super) fn avoid(&mut self, plot: &Plot<'_>, points: &[(f64, f64)]) {
        let mut last = None;
        for point in points {
            let (x, y) = plot.backend_coord(point);
            let [from_x, from_y] = last.unwrap_or([x, y]);
            let samples = 1 + (x - from_x).abs().max((y - from_y).abs()) / SAMPLE;
            for sample in 0..=samples {
                let along = |from: i32, to: i32| from + (to - from) * sample / samples;
                self.taken.push([along(from_x, x), along(from_y, y)]);
            }
            last = Some([x, y]);
        }
    }

    /// Draws the name of a curve beside one of its points, the last where there is room.
    pub(super) fn draw(
        &mut self,
        plot: &mut Plot<'_>,
        points: &[(f64, f64)],
        name: &str,
        color: RGBColor,
    ) -> Drawn {
        let width = LETTER * i32::try_from(name.chars().count())?;
        let half = [width / 2, LINE / 2];
        let mut best: Option<(usize, (f64, f64), Frame)> = None;
        for &point in points.iter().rev() {
            let (x, y) = plot.backend_coord(&point);
            for [right, down] in PLACES {
                let middle = [x + right * (half[0] + AWAY), y + down * LINE];
                let frame = Frame { middle, half };
                let cost = self.cost(plot, frame);
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, point, frame));
                }
            }
        }
        let Some((_, point, frame)) = best else { return Ok(()) };

        // The name takes its place.
        let [x, y] = frame.middle;
        for letter in (-frame.half[0]..=frame.half[0]).step_by(4) {
            self.taken.push([x + letter, y]);
        }
        let (at_x, at_y) = plot.backend_coord(&point);
        let centered = Pos::new(HPos::Center, VPos::Center);
        let style = ("sans-serif", FONT).into_font().color(&color).pos(centered);
        let text = Text::new(name.to_owned(), (x - at_x, y - at_y), style);
        plot.draw_series([EmptyElement::at(point) + text])?;
        Ok(())
    }

    /// Counts the samples that a name would cover; one that leaves the panel covers all.
    fn cost(&self, plot: &Plot<'_>, frame: Frame) -> usize {
        let (columns, rows) = plot.plotting_area().get_pixel_range();
        let [x, y] = frame.middle;
        let is_inside = columns.contains(&(x - frame.half[0]))
            && columns.contains(&(x + frame.half[0]))
            && rows.contains(&(y - frame.half[1]))
            && rows.contains(&(y + frame.half[1]));
        if is_inside {
            self.taken.iter().filter(|taken| frame.covers(**taken)).count()
        } else {
            self.taken.len() + 1
        }
    }
}

impl Frame {
    fn covers(self, [x, y]: [i32; 2]) -> bool {
        (x - self.middle[0]).abs() <= self.half[0] + 3
            && (y - self.middle[1]).abs() <= self.half[1] + 4
    }
}
