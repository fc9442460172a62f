//! What a build found, and what it cost.

/// Something a caller should know before relying on a field.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FieldWarning {
    /// The surface encloses a negative volume: its faces were taken the other
    /// way round.
    Inverted,
    /// The whole surface spans fewer than four cells along every axis: a unit
    /// mistake, or far too coarse a grid.
    SpansFewCells {
        /// Cells along its longest axis.
        cells: f64,
    },
    /// Part of the solid is thinner than 1.5 spacings, so nodes may miss its
    /// inside.
    ThinnerThanGrid {
        /// Fraction of the sampled area, `0..=1`.
        fraction: f64,
        /// The thickness in question, in the length unit.
        thickness: f64,
    },
    /// Voxels inside account for much less than the volume that the surface
    /// encloses: the flood leaked, or the solid is thinner than its voxels.
    InteriorLost {
        /// Fraction of the enclosed volume that is not inside, `0..=1`.
        fraction: f64,
    },
    /// The surface is not closed; inside is where its winding number passes one half.
    Open {
        /// Edges of its boundary.
        edges: usize,
    },
}

/// The field beside exact distances, at points within two spacings of the surface.
///
/// A measure, not a bound: what lies between the points may be further off. Where
/// that matters, [`FieldReport::error_bound`] holds everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeasuredError {
    /// Points compared.
    pub points: usize,
    /// Root mean square of value − exact, in the length unit.
    pub rms: f64,
    /// Largest magnitude of value − exact at these points, in the length unit.
    pub max: f64,
}

/// What a build found, and what it cost.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FieldReport {
    /// What to know before relying on the field.
    pub warnings: Vec<FieldWarning>,
    /// Errors of trilinear values at sample points; none when nothing was compared.
    pub measured_error: Option<MeasuredError>,
    /// Most that a trilinear value can be off at any point from which the surface
    /// is at most the band less √3 spacings away, in the length unit.
    ///
    /// Distances to a closed surface change no faster than the way, and all
    /// corners of such a point's cell are exact: its value is then within their
    /// mean distance from the point, at most √3/2 spacings, plus rounding, plus the
    /// eighth of a spacing that the nodes of a quasi-interpolation may give way. A
    /// spike between nodes comes close to that; smooth bones stay at a tenth or so,
    /// as [`Self::measured_error`] measures. None for the seed method, and for open
    /// surfaces, whose sign also turns where no surface is.
    pub error_bound: Option<f64>,
    /// Volume of the cells around inside nodes, in the cube of the length unit.
    pub inside_volume: f64,
    /// Most bytes that the build held at once, besides the surface.
    pub peak_bytes: usize,
}
