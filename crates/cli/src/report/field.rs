//! What is told of a distance field: its grid, its error, its warnings.

use musculo_collide::distance_field::{
    DistanceField, FieldParams, FieldReport, FieldWarning, MeasuredError, NodeValues, Storage,
};
use serde::Serialize;

use super::text::{counted, grouped, measure};

/// A field as it was built or read, without the times.
#[derive(Debug, Serialize)]
pub(crate) struct FieldRecord {
    pub(crate) file: String,
    pub(crate) spacing: f64,
    pub(crate) origin: [f64; 3],
    pub(crate) dims: [usize; 3],
    pub(crate) least: f32,
    pub(crate) greatest: f32,
    pub(crate) storage: Storage,
    pub(crate) nodes: NodeValues,
    /// Only what was built here has the rest.
    pub(crate) built: Option<BuiltRecord>,
}

/// What a build found.
#[derive(Debug, Serialize)]
pub(crate) struct BuiltRecord {
    pub(crate) vertices: usize,
    pub(crate) faces: usize,
    pub(crate) params: FieldParams,
    pub(crate) error: Option<MeasuredError>,
    pub(crate) certain: Option<f64>,
    pub(crate) inside_volume: f64,
    pub(crate) peak_bytes: usize,
    pub(crate) warnings: Vec<FieldWarning>,
}

impl FieldRecord {
    pub(crate) fn new(file: String, field: &DistanceField, built: Option<BuiltRecord>) -> Self {
        let grid = field.grid();
        let (values, ends) = (field.values(), (f32::INFINITY, f32::NEG_INFINITY));
        let (least, greatest) =
            values.iter().fold(ends, |(lo, hi), &value| (lo.min(value), hi.max(value)));
        let (spacing, origin, dims) = (grid.spacing(), grid.origin().to_array(), grid.dims());
        let (storage, nodes) = (field.storage(), field.node_values());
        Self { file, spacing, origin, dims, least, greatest, storage, nodes, built }
    }
}

impl BuiltRecord {
    pub(crate) fn new(
        [vertices, faces]: [usize; 2],
        params: FieldParams,
        report: &FieldReport,
    ) -> Self {
        Self {
            vertices,
            faces,
            params,
            error: report.measured_error,
            certain: report.error_bound,
            inside_volume: report.inside_volume,
            peak_bytes: report.peak_bytes,
            warnings: report.warnings.clone(),
        }
    }
}

/// The whole report but for the times, which no two runs share. Lengths are in
/// the unit of the mesh.
pub(crate) fn field_table(record: &FieldRecord) -> String {
    let mut text = record.file.clone();
    if let Some(built) = &record.built {
        let [vertices, faces] = [(built.vertices, "vertices"), (built.faces, "faces")]
            .map(|(count, what)| format!("{} {what}", grouped(count)));
        text += &format!(": {vertices}, {faces}");
    }
    let [nx, ny, nz] = record.dims;
    let nodes = nx.saturating_mul(ny).saturating_mul(nz);
    let [x, y, z] = record.origin;
    text += &format!(
        "\n  grid       {nx} x {ny} x {nz}, {} nodes {} apart, from ({x:.4}, {y:.4}, {z:.4})\n",
        grouped(nodes),
        record.spacing
    );
    let (least, greatest) = (f64::from(record.least), f64::from(record.greatest));
    text += &format!("  distances  {} to {}\n", measure(least), measure(greatest));
    if let Storage::Quantized { step } = record.storage {
        text += &format!("  kept       in steps of {step}, 16 bits each\n");
    }
    if let Some(built) = &record.built {
        text += &built_lines(built);
    }
    text
}

fn built_lines(built: &BuiltRecord) -> String {
    let mut text = match &built.error {
        Some(MeasuredError { points, rms, max }) => format!(
            "  measured   error {} rms, {} worst, at {} within two spacings of the surface\n",
            measure(*rms),
            measure(*max),
            counted(*points, "point"),
        ),
        None => "  error      not measured\n".to_owned(),
    };
    if let Some(certain) = built.certain {
        text += &format!("  certain    at most {} off near the surface\n", measure(certain));
    }
    text += &format!("  inside     {} in volume\n", measure(built.inside_volume));
    if !built.warnings.is_empty() {
        text += "\nWarnings\n";
    }
    for warning in &built.warnings {
        text += &format!("  {}\n", words(warning));
    }
    text
}

fn words(warning: &FieldWarning) -> String {
    match *warning {
        FieldWarning::Inverted => {
            "the surface encloses a negative volume: its faces were taken the other way round"
                .to_owned()
        }
        FieldWarning::SpansFewCells { cells } => {
            format!("the surface spans {cells:.2} cells: another unit, or too coarse a grid?")
        }
        FieldWarning::ThinnerThanGrid { fraction, thickness } => format!(
            "{:.0} % of the surface bounds parts thinner than {}, of which nodes may miss the inside",
            100.0 * fraction,
            measure(thickness)
        ),
        FieldWarning::InteriorLost { fraction } => {
            format!("{:.0} % of the enclosed volume is not inside the field", 100.0 * fraction)
        }
        FieldWarning::Open { edges } => format!(
            "the surface is open, with {} of boundary: inside is where its winding number passes one half",
            counted(edges, "edge")
        ),
        ref other => format!("{other:?}"),
    }
}
