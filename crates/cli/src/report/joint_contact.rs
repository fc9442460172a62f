//! Joint contact of pairs: records, tables, and maps on the meshes.

use mesh_io::{CellValues, Cells, Space, write_vtp_cells};
use musculo_collide::{Body, ContactMeasures, JointContact, PairId, Scene};
use serde::Serialize;

use super::overlap_files::{FileFolder, PointList};
use super::table::{Column, Table, dash, left, right};
use super::text::{measure, place, short};
use crate::failure::Failure;
use crate::output::Outputs;
use crate::scene::Unit;

/// Pair of bodies with the contact of each surface with the other.
#[derive(Debug)]
pub(crate) struct PairContact {
    pub(crate) pair: PairId,
    pub(crate) sides: [JointContact; 2],
}

/// Contact of one surface with another.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SurfaceContact {
    pub(crate) surface: String,
    pub(crate) against: String,
    #[serde(flatten)]
    pub(crate) total: ContactMeasures,
    /// The same for each separate region, by falling area.
    pub(crate) regions: Vec<ContactMeasures>,
}

/// Contact of both surfaces of a pair.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct JointContactRecord {
    pub(crate) of_a: SurfaceContact,
    pub(crate) of_b: SurfaceContact,
}

/// Joint contact of a pair, as it stands in the record of the pair.
#[derive(Debug, Serialize)]
pub(crate) struct PairJointContact {
    a: String,
    b: String,
    joint_contact: JointContactRecord,
}

impl PairJointContact {
    pub(crate) fn new(contact: &PairContact, scene: &Scene) -> Self {
        let [a, b] = scene.names(contact.pair).map(str::to_owned);
        Self { a, b, joint_contact: JointContactRecord::new(contact, scene) }
    }
}

impl JointContactRecord {
    pub(super) fn new(contact: &PairContact, scene: &Scene) -> Self {
        let ([a, b], [of_a, of_b]) = (scene.names(contact.pair), &contact.sides);
        Self { of_a: SurfaceContact::new([a, b], of_a), of_b: SurfaceContact::new([b, a], of_b) }
    }
}

impl SurfaceContact {
    fn new([surface, against]: [&str; 2], contact: &JointContact) -> Self {
        Self {
            surface: surface.to_owned(),
            against: against.to_owned(),
            total: contact.total,
            regions: contact.regions.clone(),
        }
    }
}

/// Returns the title of a table of contacts.
pub(super) fn joint_title(margin: f64, unit: Unit) -> String {
    let (margin, symbol) = (short(margin), unit.symbol());
    format!("Joint contact, at gaps up to {margin} {symbol}; gaps below 0 are depths")
}

/// Maximum number of regions per surface that a table lists.
const MAX_LISTED_REGIONS: usize = 4;

/// Table of contacts under construction.
#[derive(Debug)]
pub(super) struct ContactTable {
    table: Table,
    unit: Unit,
    has_pressure: bool,
}

impl ContactTable {
    /// Begins a table; `first` are the columns before those of the contact.
    pub(super) fn new(
        first: impl IntoIterator<Item = Column>,
        unit: Unit,
        has_pressure: bool,
    ) -> Self {
        let symbol = unit.symbol();
        let mut columns: Vec<Column> = first.into_iter().collect();
        columns.extend([
            left("surface"),
            left("against"),
            left("region"),
            right(format!("area [{symbol}²]")),
            right(format!("within [{symbol}²]")),
            right(format!("center [{symbol}]")),
            right(format!("mean gap [{symbol}]")),
            right(format!("min gap [{symbol}]")),
        ]);
        if has_pressure {
            columns.extend(["mean pressure", "max pressure", "force"].map(right));
        }
        Self { table: Table::new(columns), unit, has_pressure }
    }

    /// Adds the whole contact of a surface.
    pub(super) fn total(
        &mut self,
        first: impl IntoIterator<Item = String>,
        contact: &SurfaceContact,
    ) {
        let region = match contact.regions.len() {
            1 => "1".to_owned(),
            count => format!("all {count}"),
        };
        self.row(first, contact, &contact.total, region);
    }

    /// Adds the whole contact of a surface, and its largest regions where it has several.
    pub(super) fn with_regions(&mut self, contact: &SurfaceContact) {
        self.total([], contact);
        if contact.regions.len() > 1 {
            for (number, region) in contact.regions.iter().take(MAX_LISTED_REGIONS).enumerate() {
                self.row([], contact, region, (number + 1).to_string());
            }
        }
    }

    pub(super) fn finish(self) -> Table {
        self.table
    }

    fn row(
        &mut self,
        first: impl IntoIterator<Item = String>,
        contact: &SurfaceContact,
        measures: &ContactMeasures,
        region: String,
    ) {
        let ContactMeasures { area, area_lower, area_upper, center, .. } = *measures;
        let mut row: Vec<String> = first.into_iter().collect();
        row.extend([
            contact.surface.clone(),
            contact.against.clone(),
            region,
            measure(area),
            format!("{} to {}", measure(area_lower), measure(area_upper)),
        ]);

        // Cells at the border alone have no center in contact, and no gap.
        let has_area = area > 0.0;
        let or_dash = |text: String| if has_area { text } else { dash() };
        row.push(or_dash(place(center, self.unit)));
        row.push(or_dash(measure(measures.mean_gap)));
        row.push(or_dash(measure(measures.min_gap)));
        if self.has_pressure {
            let ContactMeasures { mean_pressure, max_pressure, force, .. } = *measures;
            row.extend([mean_pressure, max_pressure, force.length()].map(measure));
        }
        self.table.row(row);
    }
}

/// Writes the faces in contact of both surfaces of each pair into a folder, with the gap, the
/// pressure, the area in contact and the region of each. `suffix` ends the names of the files.
pub(crate) fn stage_contact_files(
    contacts: &[PairContact],
    suffix: &str,
    scene: &Scene,
    folder: &mut FileFolder,
    outputs: &mut Outputs,
) -> Result<(), Failure> {
    for PairContact { pair, sides } in contacts {
        let [a, b] = pair.bodies().map(|id| scene.body(id));
        for ([own, other], contact) in [[a, b], [b, a]].into_iter().zip(sides) {
            if contact.total.area > 0.0 {
                let stem = format!("{}_on_{}{suffix}", own.name(), other.name());
                folder.stage(&stem, contact_vtp(contact, own, folder.space()), outputs)?;
            }
        }
    }
    Ok(())
}

/// Writes the faces of a body in contact, with their values.
fn contact_vtp(contact: &JointContact, body: &Body, space: Option<Space>) -> String {
    // Vertices of these faces alone.
    let (mut points, mut cells) = (PointList::default(), Vec::new());
    let (mut faces, mut regions) = (Vec::new(), Vec::new());
    let (mut gaps, mut pressures, mut areas) = (Vec::new(), Vec::new(), Vec::new());
    for face in contact.faces.iter().filter(|face| face.area > 0.0) {
        cells.push(body.corners(face.face).map(|at| points.number(at, 0.0)).to_vec());
        faces.push(face.face);
        regions.push(face.region);
        gaps.push(face.mean_gap);
        pressures.push(face.mean_pressure);
        areas.push(face.area);
    }

    let values = [
        CellValues::Scalars("gap", &gaps),
        CellValues::Scalars("pressure", &pressures),
        CellValues::Scalars("contact_area", &areas),
        CellValues::Numbers("face", &faces),
        CellValues::Numbers("region", &regions),
    ];
    write_vtp_cells(&points.positions, Cells::Polygons(&cells), &[], &values, space)
}
