//! Divisions of open surfaces by bodies that cross them.

use musculo_collide::{BodyId, PairReport, Scene, SceneError, Side};
use serde::Serialize;

use super::table::{Table, left, right};
use super::text::{counted, grouped, measure};
use crate::scene::Unit;

/// Open surface that another body crosses.
#[derive(Debug, Serialize)]
pub(crate) struct DivisionRecord {
    /// Open surface.
    body: String,
    /// Body that cuts it.
    by: String,
    /// Connected parts of the surface that do not meet the other body, largest first.
    regions: Vec<RegionRecord>,
}

/// Connected part of a cut surface.
#[derive(Debug, Serialize)]
struct RegionRecord {
    side: Side,
    faces: usize,
    area: f64,
}

/// Cuts every open surface by every body that crosses it.
pub(crate) fn divisions(
    scene: &mut Scene,
    reports: &[PairReport],
) -> Result<Vec<DivisionRecord>, SceneError> {
    // Only a surface that another crosses is divided, and only an open one into sides.
    let mut divisions = Vec::new();
    for report in reports {
        if report.crossing_faces.is_empty() {
            continue;
        }
        let [a, b] = report.pair.bodies();
        for (body, by) in [(a, b), (b, a)] {
            if scene.body(body).has_inside().is_err() {
                divisions.push(divide(scene, body, by)?);
            }
        }
    }
    Ok(divisions)
}

fn divide(scene: &mut Scene, body: BodyId, by: BodyId) -> Result<DivisionRecord, SceneError> {
    // Regions are largest first.
    let mut regions = Vec::new();
    for region in scene.segment(body, by)? {
        let (side, faces, area) = (region.side, region.faces.len(), region.area);
        regions.push(RegionRecord { side, faces, area });
    }

    let [body, by] = [body, by].map(|id| scene.body(id).name().to_owned());
    Ok(DivisionRecord { body, by, regions })
}

/// Number of regions of one division that have rows of their own: surfaces that are not welded have as many as faces.
const MAX_ROWS: usize = 12;

/// Returns a table with one row per region, and one for all that are small where there are many.
pub(super) fn table(divisions: &[DivisionRecord], unit: Unit) -> Table {
    let mut table = Table::new([
        left("open"),
        left("cut by"),
        left("side"),
        right("faces"),
        right(format!("area [{}²]", unit.symbol())),
    ]);

    // The names stand on each row, so that rows can be sorted and searched.
    for DivisionRecord { body, by, regions } in divisions {
        let (large, smaller) = regions.split_at(regions.len().min(MAX_ROWS));
        for RegionRecord { side, faces, area } in large {
            let side = side_name(*side).to_owned();
            table.row([body.clone(), by.clone(), side, grouped(*faces), measure(*area)]);
        }
        if !smaller.is_empty() {
            let count = counted(smaller.len(), "smaller region");
            let faces = smaller.iter().map(|region| region.faces).sum();
            let area = smaller.iter().map(|region| region.area).sum();
            table.row([body.clone(), by.clone(), count, grouped(faces), measure(area)]);
        }
    }
    table
}

const fn side_name(side: Side) -> &'static str {
    match side {
        Side::Inside => "inside",
        Side::Outside => "outside",
        Side::Front => "in front",
        Side::Back => "behind",
        Side::Around => "around a border",
        Side::Apart => "apart",
    }
}
