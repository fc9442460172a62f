//! Open surfaces where others cut them: what is on which side.

use musculo_collide::{BodyId, PairReport, Region, Scene, SceneError, Side};
use serde::Serialize;

use super::text::{Align, TextTable, grouped, measure};
use crate::scene::Unit;

/// An open surface that another crosses.
#[derive(Debug, Serialize)]
pub(crate) struct DivisionRecord {
    /// The open surface.
    pub(crate) body: String,
    /// What cuts it.
    pub(crate) by: String,
    /// Connected parts of the former that the latter does not meet, largest first.
    pub(crate) regions: Vec<RegionRecord>,
}

/// A connected part of a cut surface.
#[derive(Debug, Serialize)]
pub(crate) struct RegionRecord {
    pub(crate) side: Side,
    pub(crate) faces: usize,
    pub(crate) area: f64,
}

/// Cuts every open surface by every body that crosses it.
pub(crate) fn divisions(
    scene: &mut Scene,
    reports: &[PairReport],
) -> Result<Vec<DivisionRecord>, SceneError> {
    let crossing = reports.iter().filter(|report| !report.crossing_faces.is_empty());
    let both = crossing.flat_map(|report| {
        let [a, b] = report.pair.bodies();
        [(a, b), (b, a)]
    });
    let is_open = |&(body, _): &(BodyId, BodyId)| scene.body(body).has_inside().is_err();
    let cuts: Vec<(BodyId, BodyId)> = both.filter(is_open).collect();
    let divide = |(body, by): (BodyId, BodyId)| {
        let regions = scene.segment(body, by)?.iter().map(RegionRecord::new).collect();
        let [body, by] = [body, by].map(|id| scene.body(id).name().to_owned());
        Ok(DivisionRecord { body, by, regions })
    };
    cuts.into_iter().map(divide).collect()
}

/// A line for each region.
pub(super) fn table(divisions: &[DivisionRecord], unit: Unit) -> String {
    let mut table = TextTable::new(&[
        ("OPEN", Align::Left),
        ("CUT BY", Align::Left),
        ("SIDE", Align::Left),
        ("FACES", Align::Right),
        (&format!("AREA {}^2", unit.symbol()), Align::Right),
    ]);
    for DivisionRecord { body, by, regions } in divisions {
        for RegionRecord { side, faces, area } in regions {
            let row = [body, by, word(*side), &grouped(*faces), &measure(*area)];
            table.row(row.map(str::to_owned).to_vec());
        }
    }
    table.render()
}

const fn word(side: Side) -> &'static str {
    match side {
        Side::Inside => "inside",
        Side::Outside => "outside",
        Side::Front => "in front",
        Side::Back => "behind",
        Side::Around => "round a border",
        Side::Apart => "apart",
    }
}

impl RegionRecord {
    fn new(region: &Region) -> Self {
        Self { side: region.side, faces: region.faces.len(), area: region.area }
    }
}
