//! Report of a distance field: its grid, its error, its warnings.

use musculo_collide::distance_field::{
    DistanceField, FieldParams, FieldReport, FieldWarning, MeasuredError, NodeValues, Storage,
};
use serde::Serialize;

use super::text::{counted, grouped, measure};

/// Distance field that was built or read.
#[derive(Debug, Serialize)]
pub(crate) struct FieldRecord {
    pub(crate) file: String,
    pub(crate) spacing: f64,
    pub(crate) origin: [f64; 3],
    pub(crate) dims: [usize; 3],
    /// Smallest value at a node.
    pub(crate) min: f32,
    /// Largest value at a node.
    pub(crate) max: f32,
    pub(crate) storage: Storage,
    pub(crate) nodes: NodeValues,
    /// Absent for fields from files.
    pub(crate) built: Option<BuiltRecord>,
}

/// Build of a field.
#[derive(Debug, Serialize)]
pub(crate) struct BuiltRecord {
    pub(crate) vertices: usize,
    pub(crate) faces: usize,
    /// Number of pairs of faces that cross each other.
    pub(crate) self_crossings: usize,
    pub(crate) params: FieldParams,
    #[serde(flatten)]
    pub(crate) report: FieldReport,
}

impl FieldRecord {
    pub(crate) fn new(file: String, field: &DistanceField, built: Option<BuiltRecord>) -> Self {
        // The range of all nodes.
        let (mut min, mut max) = (f32::INFINITY, f32::NEG_INFINITY);
        for value in field.values() {
            (min, max) = (min.min(value), max.max(value));
        }

        let grid = field.grid();
        Self {
            file,
            spacing: grid.spacing(),
            origin: grid.origin().to_array(),
            dims: grid.dims(),
            min,
            max,
            storage: field.storage(),
            nodes: field.node_values(),
            built,
        }
    }

    /// Writes the report, with lengths in the unit of the mesh.
    pub(crate) fn to_text(&self) -> String {
        // The mesh, for a field that was built.
        let mut text = self.file.clone();
        if let Some(BuiltRecord { vertices, faces, .. }) = self.built {
            text += &format!(": {} vertices, {} faces", grouped(vertices), grouped(faces));
        }

        // The grid and its values.
        let [nx, ny, nz] = self.dims;
        let nodes = grouped(nx.saturating_mul(ny).saturating_mul(nz));
        let [x, y, z] = self.origin;
        let (min, max) = (measure(self.min.into()), measure(self.max.into()));
        text += &format!(
            "\n  grid       {nx} x {ny} x {nz}, {nodes} nodes, spacing {}, \
             from ({x:.4}, {y:.4}, {z:.4})\n  distances  {min} to {max}\n",
            self.spacing
        );

        // Rounding and accuracy.
        if let Storage::Quantized { step } = self.storage {
            text += &format!("  storage    16 bits per node, in steps of {step}\n");
        }
        if let Some(built) = &self.built {
            text += &report_text(built);
        }
        text
    }
}

fn report_text(BuiltRecord { report, self_crossings, .. }: &BuiltRecord) -> String {
    let mut text = error_text(report);

    // A sheet has no inside, whatever single nodes say.
    let is_sheet = report.warnings.contains(&FieldWarning::NoInside);
    text += &if is_sheet {
        "  inside     none: the surface is a sheet\n".to_owned()
    } else {
        format!("  inside     volume {}\n", measure(report.inside_volume))
    };

    if !report.warnings.is_empty() || *self_crossings > 0 {
        text += "\nWarnings\n";
    }
    if *self_crossings > 0 {
        let pairs = counted(*self_crossings, "pair");
        text += &format!(
            "  {pairs} of faces cross each other: distances inside are to all faces, also to those within the body\n"
        );
    }
    for warning in &report.warnings {
        // The orientation of a sheet has no meaning.
        if *warning != FieldWarning::Inverted || !is_sheet {
            text += &format!("  {warning}\n");
        }
    }
    text
}

/// Writes the measured errors and the proved bound, each by its name.
fn error_text(report: &FieldReport) -> String {
    let mut text = String::new();
    if let Some(error) = report.measured_error {
        text += &measured_text("measured", error, "within two spacings of the surface");
    }
    if let Some(error) = report.measured_deep_error {
        text += &measured_text("", error, "farther away, where it is expected to be largest");
    }
    if !text.is_empty() {
        text += "             measured at these points only: elsewhere it may be larger\n";

        // Around a hole, and by faces that disagree, no inside is defined.
        let is_undefined = |warning: &FieldWarning| {
            matches!(warning, FieldWarning::Open { .. } | FieldWarning::Misoriented { .. })
        };
        if report.warnings.iter().any(is_undefined) {
            text += "             of distances without their signs: the inside is not defined\n";
        }
    }
    if let Some(bound) = report.error_bound {
        text += &format!("  proved     error at most {} near the surface\n", measure(bound));
    }
    text
}

fn measured_text(title: &str, error: MeasuredError, place: &str) -> String {
    let points = counted(error.points, "point");
    let (rms, max) = (measure(error.rms), measure(error.max));
    format!("  {title:<10} error {rms} rms, {max} max, at {points} {place}\n")
}
