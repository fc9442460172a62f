//! Map of the detectors and responses that hold together, scene by scene, with the scenes beside it.

use std::error::Error;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use serde::Serialize;

use crate::chart::axes::{Area, Drawn};
use crate::chart::curves::{CAPTION_LINE, caption, draw_caption, picture};
use crate::chart::sheet::{Settings, Sheet};
use crate::stability::drive::Drive;
use crate::stability::scenes::World;
use crate::stability::{Detector, Figures, Planted, Response, Run, Setting, Verdict, run_all};

const WIDTH: u32 = 1000;
const PANEL: u32 = 250;

/// Height of the key of colors.
const KEY: u32 = 28;

/// Places within a panel.
const LEFT: i32 = 178;
const TOP: i32 = 52;
const CELL: [i32; 2] = [113, 36];

/// Colors that differ in brightness too, for readers who see no red or green.
const HOLDS: RGBColor = RGBColor(0x1f, 0x5f, 0x8b);
const FAILS: RGBColor = RGBColor(0xf6, 0xcf, 0xa6);
const REFUSED: RGBColor = RGBColor(0xe4, 0xe4, 0xe4);
const FAILURE_TEXT: RGBColor = RGBColor(0x6b, 0x2a, 0x0c);
const BONE: RGBColor = RGBColor(0xb8, 0xb2, 0x9c);
const TISSUE: RGBColor = RGBColor(0xe6, 0xb4, 0xb0);

/// Share of steps from which on a cell says that surfaces took over.
const FALLBACK: f64 = 0.05;

/// Row of the table.
#[derive(Clone, Debug, Serialize)]
struct MapRow {
    scene: &'static str,
    detector: &'static str,
    response: &'static str,
    setting: &'static str,
    verdict: &'static str,
    #[serde(flatten)]
    figures: Figures,
}

/// Runs all scenes, draws the map and writes its numbers.
///
/// # Errors
///
/// When a file cannot be written.
pub(super) fn run(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let runs = run_all(&Planted::ALL, &Detector::ALL, &Setting::ALL);
    let mut rows = Vec::new();
    for run in &runs {
        rows.push(MapRow {
            scene: run.planted.name(),
            detector: run.detector.name(),
            response: run.response.name(),
            setting: run.setting.name,
            verdict: run.verdict().word(),
            figures: run.outcome.clone().unwrap_or_default(),
        });
    }
    let sheet = Sheet::new("stability-scenes", settings(), &rows)?;
    Ok(sheet.write(folder, Some(draw(&runs, &sheet.settings)?))?)
}

fn settings() -> Settings {
    vec![
        (
            "bodies",
            "equal masses on springs to their shape (k / m 2e5 1/s²), steps of 1 ms, contacts \
             detected up to 0.5 mm, overlap of 0.2 mm allowed; soft contacts 1.4e6 g/s²"
                .to_owned(),
        ),
        (
            "a cell",
            "the first of these that fails: thrown out of the scene; vertices out of the far \
             side; overlap; energy gained beyond 1e-6 of the fall; creep beyond 1e-4 mm/s; \
             moves beyond 5 µm per step at rest; acceleration of a slide off by 2 %; a muscle \
             not let go"
                .to_owned(),
        ),
        (
            "squares",
            "the same with steps of 2 ms, with soft bodies ten times as stiff, and (stack) with \
             a hundredfold mass on top: filled where it holds"
                .to_owned(),
        ),
        ("corner", "detected by surfaces in more than 5 % of the steps, as reported".to_owned()),
    ]
}

fn draw(runs: &[Run], settings: &Settings) -> Result<String, Box<dyn Error>> {
    let rows = u32::try_from(Planted::ALL.len())?;
    let lines = caption(settings, WIDTH);
    let foot = KEY + CAPTION_LINE * (u32::try_from(lines.len())? + 1);
    let heading = "Where detection and response hold together, over time";
    picture(heading, WIDTH, [rows * PANEL, foot], |body, foot| {
        let panels = body.split_evenly((Planted::ALL.len(), 1));
        for (planted, area) in Planted::ALL.into_iter().zip(&panels) {
            draw_panel(area, planted, runs)?;
        }
        draw_key(foot)?;
        draw_caption(foot, &lines, KEY)
    })
}

/// Draws the map of a scene, with the scene beside it.
fn draw_panel(area: &Area<'_>, planted: Planted, runs: &[Run]) -> Drawn {
    let title = ("sans-serif", 16).into_font().into_text_style(area);
    area.draw_text(planted.title(), &title, (20, 6))?;
    draw_scene(area, &planted.build()?)?;

    // Names of columns and rows.
    let small = ("sans-serif", 13).into_font().into_text_style(area);
    let centered = small.pos(Pos::new(HPos::Center, VPos::Center));
    let right = small.pos(Pos::new(HPos::Right, VPos::Center));
    for (column, response) in (0..).zip(Response::ALL) {
        let x = LEFT + column * CELL[0] + CELL[0] / 2;
        area.draw_text(response.name(), &centered, (x, TOP - 12))?;
    }

    // One row per detector; a cell holds all runs of its combination.
    for (row, detector) in (0..).zip(Detector::ALL) {
        let y = TOP + row * CELL[1] + CELL[1] / 2;
        area.draw_text(detector.name(), &right, (LEFT - 6, y))?;
        for (column, response) in (0..).zip(Response::ALL) {
            let of_cell: Vec<&Run> = runs
                .iter()
                .filter(|run| run.planted == planted && run.detector == detector)
                .filter(|run| run.response == response)
                .collect();
            draw_cell(area, [LEFT + column * CELL[0], TOP + row * CELL[1]], &of_cell)?;
        }
    }
    Ok(())
}

/// Draws what came of a combination: the first run in the middle, the others as squares.
fn draw_cell(area: &Area<'_>, [x, y]: [i32; 2], runs: &[&Run]) -> Drawn {
    let Some((base, others)) = runs.split_first() else { return Ok(()) };
    let verdict = base.verdict();
    let (fill, ink) = match verdict {
        Verdict::Holds => (HOLDS, WHITE),
        Verdict::Refused => (REFUSED, FAILURE_TEXT),
        _ => (FAILS, FAILURE_TEXT),
    };
    let [width, height] = CELL;
    let corners = [(x + 1, y + 1), (x + width - 1, y + height - 1)];
    area.draw(&Rectangle::new(corners, fill.filled()))?;

    // The word, and under it the figure that decides.
    let left = Pos::new(HPos::Left, VPos::Center);
    let word = ("sans-serif", 13).into_font().into_text_style(area).color(&ink).pos(left);
    let figure = base.outcome.as_ref().map_or(String::new(), |figures| verdict.figure(figures));
    let middle = if figure.is_empty() { height / 2 } else { 11 };
    let start = if verdict == Verdict::Holds { 26 } else { 6 };
    area.draw_text(verdict.word(), &word, (x + start, y + middle))?;
    if verdict == Verdict::Holds {
        let tick = [(x + 8, y + 18), (x + 13, y + 23), (x + 21, y + 12)];
        area.draw(&PathElement::new(tick, WHITE.stroke_width(2)))?;
    }
    let small = ("sans-serif", 11).into_font().into_text_style(area).color(&ink).pos(left);
    area.draw_text(&figure, &small, (x + 6, y + 25))?;

    // The other settings.
    for (number, run) in (0..).zip(others) {
        let corner = (x + width - 11, y + 4 + 10 * number);
        let square = [corner, (corner.0 + 7, corner.1 + 7)];
        let style = if run.verdict() == Verdict::Holds { ink.filled() } else { ink.into() };
        area.draw(&Rectangle::new(square, style))?;
    }

    // The corner marks runs in which surfaces took over.
    if base.outcome.as_ref().is_ok_and(|figures| figures.fallbacks > FALLBACK) {
        let triangle = vec![(x + 1, y + 1), (x + 10, y + 1), (x + 1, y + 10)];
        area.draw(&Polygon::new(triangle, ink.filled()))?;
    }
    Ok(())
}

/// Draws the outlines of the bodies, seen along y, with an arrow for each bone that moves.
fn draw_scene(area: &Area<'_>, world: &World) -> Drawn {
    const SIZE: f64 = 108.0;
    let mut outlines = Vec::new();
    let flat = |x: &DVec3| DVec2::new(x.x, -x.z);
    for body in world.scene.bodies() {
        let points: Vec<DVec2> = body.positions().iter().map(flat).collect();
        outlines.push((hull(points), if body.is_rigid() { BONE } else { TISSUE }));
    }

    // The soft bodies fill the middle; bones may be cut.
    let (mut low, mut high) = (DVec2::MAX, DVec2::MIN);
    for tissue in &world.tissues {
        for x in &world.start[tissue.particles.clone()] {
            (low, high) = (low.min(flat(x)), high.max(flat(x)));
        }
    }
    let (center, size) = (0.5 * (low + high), 1.7 * (high - low).max_element());
    let place = |p: DVec2| {
        let p = SIZE * ((p - center) / size + 0.5);
        (10 + rounded(p.x), TOP + 8 + rounded(p.y))
    };

    // Bones come first in the scene, so that soft bodies are drawn over them.
    for (outline, color) in outlines {
        let shown = clipped(outline, center - 0.5 * size, center + 0.5 * size);
        let points: Vec<(i32, i32)> = shown.into_iter().map(place).collect();
        if points.is_empty() {
            continue;
        }
        area.draw(&Polygon::new(points.clone(), color.filled()))?;
        area.draw(&PathElement::new(points, color.stroke_width(1)))?;
    }

    // Arrows begin in the middle of a bone, and show twice its way.
    for bone in &world.bones {
        let way = match bone.drive {
            Drive::Still => continue,
            Drive::To(way, _) | Drive::ToAndBack(way, _) => way,
        };
        let positions = world.scene.body(bone.id).positions();
        let middle = positions.iter().sum::<DVec3>() / crate::measure::as_f64(positions.len());
        let [(x, y), (_, end)] = [place(flat(&middle)), place(flat(&(middle + 2.0 * way)))];
        area.draw(&PathElement::new([(x, y), (x, end)], BLACK.stroke_width(2)))?;
        let head = [(x - 4, end - 5), (x, end), (x + 4, end - 5)];
        area.draw(&PathElement::new(head, BLACK.stroke_width(2)))?;
    }
    Ok(())
}

/// Draws what colors stand for.
fn draw_key(area: &Area<'_>) -> Drawn {
    let text = ("sans-serif", 14).into_font().into_text_style(area);
    let keys = [(HOLDS, "holds"), (FAILS, "fails: how, and by how much"), (REFUSED, "refused")];
    for (column, (color, name)) in (0..).zip(keys) {
        let x = 40 + 260 * column;
        area.draw(&Rectangle::new([(x, 4), (x + 30, 20)], color.filled()))?;
        area.draw_text(name, &text, (x + 38, 5))?;
    }
    Ok(())
}

/// Clips a convex outline to a box, side by side (Sutherland and Hodgman).
fn clipped(mut outline: Vec<DVec2>, low: DVec2, high: DVec2) -> Vec<DVec2> {
    let sides =
        [(DVec2::X, -low.x), (DVec2::NEG_X, high.x), (DVec2::Y, -low.y), (DVec2::NEG_Y, high.y)];
    for (normal, offset) in sides {
        let mut kept = Vec::new();
        for (k, &p) in outline.iter().enumerate() {
            let q = outline[(k + 1) % outline.len()];
            let [of_p, of_q] = [p, q].map(|x| normal.dot(x) + offset);

            // Corners within the side stay, and edges that cross it end on it.
            if of_p >= 0.0 {
                kept.push(p);
            }
            if (of_p < 0.0) != (of_q < 0.0) {
                kept.push(p.lerp(q, of_p / (of_p - of_q)));
            }
        }
        outline = kept;
    }
    outline
}

/// Returns the convex hull of points, counterclockwise.
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    // Andrew's monotone chain: one half of the hull from left to right, the other one back.
    points.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    let mut hull: Vec<DVec2> = Vec::new();
    for is_upper in [false, true] {
        let start = hull.len();
        for &p in &points {
            // Points that the way to the next one passes on the outside are no corners.
            while hull.len() >= start + 2 {
                let [a, b] = [hull[hull.len() - 2], hull[hull.len() - 1]];
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        if !is_upper {
            points.reverse();
        }
    }
    hull
}

#[expect(clippy::cast_possible_truncation, reason = "pixels")]
fn rounded(value: f64) -> i32 {
    value.round() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_square_has_its_corners() {
        let mut points = Vec::new();
        for (x, y) in [(0.0, 0.0), (2.0, 0.0), (1.0, 0.5), (2.0, 2.0), (0.0, 2.0), (1.0, 2.0)] {
            points.push(DVec2::new(x, y));
        }
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];
        assert_eq!(hull(points), corners.map(|(x, y)| DVec2::new(x, y)));
    }
}
