//! Report of a build: warnings, measured errors and a proved bound.

use std::fmt;

/// Property of a surface that makes its field unreliable.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FieldWarning {
    /// The surface encloses a negative volume: its faces were taken to be reversed.
    Inverted,
    /// The surface spans fewer than four cells along every axis: a mistaken unit, or too
    /// coarse a grid.
    SpansFewCells {
        /// Cells along its longest axis.
        cells: f64,
    },
    /// Part of the solid is thinner than 1.5 spacings, so that its inside may lie between
    /// nodes.
    ThinnerThanGrid {
        /// Fraction of the sampled area that bounds such parts, `0..=1`.
        fraction: f64,
        /// Thickness of 1.5 spacings, in the length unit.
        thickness: f64,
    },
    /// Inside voxels account for much less than the enclosed volume: the flood fill leaked,
    /// or the solid is thinner than its voxels.
    InteriorLost {
        /// Fraction of the enclosed volume that is not inside, `0..=1`.
        fraction: f64,
    },
    /// The surface is open; inside is where its winding number exceeds one half.
    Open {
        /// Number of edges with one face.
        edges: usize,
    },
    /// Neighboring faces have opposite orientations; inside is where the winding number exceeds
    /// one half.
    Misoriented {
        /// Number of directions of an edge along which more than one face runs.
        edges: usize,
    },
    /// The surface is open, and inside nodes make up less than half a spacing over its area: a
    /// sheet has no inside.
    NoInside,
}

impl fmt::Display for FieldWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Inverted => {
                f.write_str("the surface is inside out: the field takes its faces reversed")
            }
            Self::SpansFewCells { cells } => write!(
                f,
                "the surface spans {cells:.2} cells: check the unit, or use a smaller spacing"
            ),
            Self::ThinnerThanGrid { fraction, thickness } => write!(
                f,
                "{:.0} % of the surface bounds parts thinner than {thickness:.4}, where nodes may \
                 lose the inside: use a smaller spacing",
                100.0 * fraction
            ),
            Self::InteriorLost { fraction } => {
                write!(
                    f,
                    "{:.0} % of the enclosed volume is not inside the field",
                    100.0 * fraction
                )
            }
            Self::Open { edges } => write!(
                f,
                "the surface is open, with {edges} boundary edge{}: inside is where its winding \
                 number exceeds one half",
                plural(edges)
            ),
            Self::Misoriented { edges } => write!(
                f,
                "neighboring faces have opposite orientations, at {edges} misoriented edge{}: inside \
                 is where the winding number exceeds one half",
                plural(edges)
            ),
            Self::NoInside => {
                f.write_str("the surface is a sheet: no part of the field is reliably negative")
            }
        }
    }
}

/// Returns the ending of a noun that is counted.
fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// Measured error of a field: its difference from exact signed distances at sample points.
///
/// Magnitudes are compared where no inside is defined: around surfaces with holes, or whose
/// neighboring faces have opposite orientations.
///
/// Between the samples the error may be larger; [`FieldReport::error_bound`] is proved.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeasuredError {
    /// Number of samples.
    pub points: usize,
    /// Root mean square of the error, in the length unit.
    pub rms: f64,
    /// Largest magnitude of the error, in the length unit.
    pub max: f64,
}

/// Report of a build.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FieldReport {
    /// Properties of the surface that make the field unreliable.
    pub warnings: Vec<FieldWarning>,
    /// Measured error of trilinear values within two spacings of the surface; `None` where no
    /// sample was asked for.
    pub measured_error: Option<MeasuredError>,
    /// Measured error of trilinear values farther from the surface, at the places where it is
    /// expected to be largest: near the medial axis. `None` where no sample was asked for, or
    /// where all such places are beyond the truncation.
    pub measured_deep_error: Option<MeasuredError>,
    /// Proved bound on the error of a trilinear value, at any point whose distance from the
    /// surface is at most the band less √3 spacings, in the length unit. A distance beyond the
    /// truncation is compared as the truncation.
    ///
    /// The distance to a closed surface changes by at most the distance between two points,
    /// and all corners of such a point's cell are exact. Its value is then within their mean
    /// distance from the point, at most √3/2 spacings, plus rounding, plus the eighth of a
    /// spacing by which a quasi-interpolation corrects nodes. A spike between nodes comes
    /// close to that; smooth bones stay at a tenth, as [`Self::measured_error`] reports.
    ///
    /// `None` for the voxel method, and for open surfaces, whose sign also changes where no
    /// surface is.
    pub error_bound: Option<f64>,
    /// Volume of the cells around inside nodes, in the cube of the length unit. Meaningless where
    /// there is a [`FieldWarning::NoInside`].
    pub inside_volume: f64,
    /// Maximum number of bytes that the build held at once, without the surface.
    pub peak_bytes: usize,
}
